"""MuJoCo: scenes of the suite written by hand in MJCF, with the same coordinates, integrated by RK4 with fixed steps.

It has no tolerance: steps a second follow from the tolerance by the method's order. Its constraints are springs, so that closed
loops have no comparable motion, and it has no prescribed motion.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from lagrangia.bench.peers import Prepared, Solver, Unsuitable
from lagrangia.bench.problem import Problem

_STEPS = 5.0  # a second, at tolerance 1
_POINT = 'diaginertia="1e-14 1e-14 1e-14"'


def prepare(xml: str, problem: Problem, tolerance: float) -> Prepared:
    import mujoco

    mujoco.set_mju_user_warning(lambda _: None)  # it would write a file of its own; the errors say enough
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    gap = (problem.times[-1] - problem.experiment.start) / len(problem.times)
    count = max(1, round(gap * _STEPS * tolerance**-0.25))
    model.opt.timestep = gap / count
    found = np.empty((len(problem.times), problem.n))

    def begin() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = problem.start[: problem.n], problem.start[problem.n :]

    def run(_: Any) -> Any:
        for row in found:
            mujoco.mj_step(model, data, nstep=count)
            row[:] = data.qpos
        return found

    return Prepared(run, np.copy, begin)


def solver(case: str) -> Solver:
    def prepare_case(problem: Problem, tolerance: float) -> Prepared:
        if case not in SCENES:
            raise Unsuitable("MuJoCo cannot represent it with rigid constraints and prescribed motion")
        return prepare(SCENES[case](), problem, tolerance)

    return Solver("mujoco", "mujoco", prepare_case)


# -------------------------------------------------------------------- scenes


def _xml(bodies: str, tendons: str = "", gravity: float = -9.81) -> str:
    return f"""<mujoco><compiler angle="radian" autolimits="true"/><size memory="64M"/>
      <option integrator="RK4" gravity="0 {gravity} 0"><flag contact="disable"/></option>
      <worldbody><site name="origin"/>{bodies}</worldbody><tendon>{tendons}</tendon></mujoco>"""


def chain(links: list[tuple[float, float]]) -> str:
    """Uniform bars (mass, length) hinged end to end; each hinge has the angle to the bar before."""
    text, closing, x = "", "", 0.0
    for m, L in links:
        inertia = m * L**2 / 12
        text += f"""<body pos="{x} 0 0"><joint type="hinge" axis="0 0 1"/>
          <inertial pos="{L / 2} 0 0" mass="{m}" diaginertia="{inertia} {inertia} {inertia}"/>"""
        closing, x = closing + "</body>", L
    return _xml(text + closing)


def pendulum() -> str:
    return _xml(f'<body><joint type="hinge" axis="0 0 1"/><inertial pos="0 -1 0" mass="1" {_POINT}/></body>')


def spring_pendulum(k: float) -> str:
    bob = f"""<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="1" {_POINT}/><site name="bob"/></body>"""
    return _xml(bob, f'<spatial stiffness="{k}" springlength="1"><site site="origin"/><site site="bob"/></spatial>')


def masses(weights: list[float], walls: list[tuple[float, float]], couplings: list[tuple[float, float]]) -> str:
    """Masses on a line: stiffness and damping of each to the ground, and of each to the next."""
    bodies = "".join(
        f"""<body><joint name="s{k}" type="slide" axis="1 0 0" stiffness="{wall[0]}" damping="{wall[1]}"/>
          <inertial pos="0 0 0" mass="{m}" {_POINT}/></body>"""
        for k, (m, wall) in enumerate(zip(weights, walls, strict=True)))
    tendons = "".join(
        f"""<fixed stiffness="{c[0]}" damping="{c[1]}" springlength="0"><joint joint="s{k}" coef="-1"/>
          <joint joint="s{k + 1}" coef="1"/></fixed>"""
        for k, c in enumerate(couplings))
    return _xml(bodies, tendons, gravity=0.0)


def row(n: int) -> str:
    """Unit masses between two walls."""
    return masses([1.0] * n, [(1.0, 0.0), *[(0.0, 0.0)] * (n - 2), (1.0, 0.0)], [(1.0, 0.0)] * (n - 1))


SCENES: Mapping[str, Callable[[], str]] = {
    "linear 2": partial(masses, [2.0, 1.0], [(3.0, 0.3), (1.0, 0.0)], [(2.0, 0.1)]),
    "linear 200": partial(row, 200),
    "pendulum": pendulum,
    "double pendulum": partial(chain, [(1.0, 1.0), (0.5, 0.7)]),
    **{f"chain {n}": partial(chain, [(1.0, 0.5)] * n) for n in (5, 20, 100)},
    "spring pendulum": partial(spring_pendulum, 3 * 9.81),
    "stiff spring pendulum": partial(spring_pendulum, 1e6),
}
