"""Peers on the scenes of space.py: MuJoCo, by RK4 with fixed steps, and Exudyn's tree on the arm, with Dormand-Prince 5(4).

MuJoCo's loops are closed by soft constraints, as stiff as it takes; it has no tolerance: steps follow from one by the method's
order. All begin where our run begins, in what was prepared.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from lagrangia.view.trajectory import Trajectory

Array = np.ndarray
Case = tuple[Callable[[], Any], Callable[[], float]]  # a run, and how far it ended from what is known
_HARD = 'solref="1e-9 1" solimp="0.9999 0.9999 1e-6"'  # MuJoCo makes the time two steps


def tree(bodies: str, gravity: tuple[float, float, float] = (0, 0, -9.81), equality: str = "") -> str:
    return f"""<mujoco><compiler angle="radian"/><size memory="64M"/><option integrator="RK4" gravity="{_row(gravity)}"
      tolerance="1e-14" iterations="200"><flag contact="disable"/></option><worldbody>{bodies}</worldbody>
      <equality>{equality}</equality></mujoco>"""


def mujoco(xml: str, q: Sequence[float], v: Sequence[float], stop: float, steps: float, error: Callable[[Any], float]) -> Case:
    """`steps` a second; `error` of MuJoCo's data at the end."""
    import mujoco as mj

    mj.set_mju_user_warning(lambda _: None)
    model = mj.MjModel.from_xml_string(xml)
    data, count = mj.MjData(model), max(1, round(stop * steps))
    model.opt.timestep = stop / count

    def run() -> None:
        mj.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = q, v
        mj.mj_step(model, data, nstep=count)

    def far() -> float:
        mj.mj_kinematics(model, data)
        return error(data)

    return run, far


def _row(numbers: Sequence[float]) -> str:
    return " ".join(map(repr, map(float, numbers)))


def _body(joint: str, place: Sequence[float], mass: float, inertia: Sequence[float], centre: Sequence[float],
          more: str = "") -> str:
    """Not closed: what it carries comes behind it."""
    return f"""<body pos="{_row(place)}"><joint {joint}/>{more}
      <inertial pos="{_row(centre)}" mass="{mass!r}" diaginertia="{_row(inertia)}"/>"""


# -------------------------------------------------------------------- scenes


def top(steps: float, centre: Array) -> Case:
    xml = tree(_body('type="ball"', (0, 0, 0), 0.5, (0.002, 0.002, 0.001), (0, 0, 0.1)) + "</body>")
    return mujoco(xml, [np.cos(0.25), np.sin(0.25), 0, 0], [0, 0, 200], 2, steps,
                  lambda data: float(np.abs(data.xipos[1] - centre).max() / 0.1))


def bars(steps: float, n: int, inertia: Sequence[float], known: Array) -> Case:
    m = L = 1 / n
    bodies = "".join(_body('type="ball"', (L if k else 0, 0, 0), m, inertia, (L / 2, 0, 0)) for k in range(n))
    spin, half = np.array([10.0, 0, 0]), 0.6 / n
    rate = spin - Rotation.from_rotvec([0, 0, -1.2 / n]).apply(spin)
    return mujoco(tree(bodies + "</body>" * n), [np.cos(half), 0, 0, np.sin(half)] * n, [*spin, *np.tile(rate, n - 1)], 1, steps,
                  lambda data: float(np.abs(2 * data.xipos[n] - data.xpos[n] - known).max()))


Link = tuple[float, Array, Array, Array, Array]  # mass, centre, inertia about it, turn and way to the next hinge


def arm_links(numbers: Mapping[str, float]) -> list[Link]:
    """Of PUMA 560 by the parameters of our scene, in the axes of each hinge, which turns about z."""
    links = []
    for k in range(1, 7):
        turn = Rotation.from_rotvec([numbers[f"alpha[{k}]"], 0, 0]).as_matrix()
        ahead = np.array([numbers[f"a[{k}]"], 0.0, numbers[f"d[{k}]"]])
        centre, moments = ([numbers[f"{name}[{k},{i}]"] for i in (1, 2, 3)] for name in ("r", "I"))
        links.append((numbers[f"m[{k}]"], ahead + turn @ centre, turn @ np.diag(moments) @ turn.T, turn, ahead))
    return links


def arm(links: Sequence[Link], tolerance: float, q: Sequence[float], v: Sequence[float], known: Array) -> Case:
    """Exudyn's tree. MuJoCo takes no inertia that breaks the triangle inequality, as three of the links have, nor the first one,
    which has no mass."""
    import exudyn
    from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree

    masses, centres, inertias, turns, ahead = map(list, zip(*links, strict=True))
    exudyn.config.printToConsole = False
    system = exudyn.SystemContainer().AddSystem()
    node = system.AddNode(NodeGenericODE2(referenceCoordinates=[0.0] * 6, initialCoordinates=list(q),
                                          initialCoordinates_t=list(v), numberOfODE2Coordinates=6))
    system.AddObject(ObjectKinematicTree(
        nodeNumber=node, gravity=[0.0, 0.0, -9.81], jointTypes=[exudyn.JointType.RevoluteZ] * 6,
        linkParents=list(range(-1, 5)), linkMasses=masses,
        jointTransformations=exudyn.Matrix3DList([np.eye(3), *turns[:-1]]),
        jointOffsets=exudyn.Vector3DList([[0.0] * 3, *map(list, ahead[:-1])]),
        linkInertiasCOM=exudyn.Matrix3DList(inertias), linkCOMs=exudyn.Vector3DList([list(centre) for centre in centres])))
    system.Assemble()
    settings = exudyn.SimulationSettings()
    time, now = settings.timeIntegration, exudyn.ConfigurationType
    time.numberOfSteps, time.verboseMode, time.endTime, time.automaticStepSize, time.minimumStepSize = 1, 0, 2, True, 1e-14
    time.relativeTolerance = time.absoluteTolerance = tolerance
    settings.solution.file.write = settings.show.computationTime = False

    def run() -> None:
        if not system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.DOPRI5):
            raise ArithmeticError("Exudyn gave up")

    return run, lambda: float(np.abs(system.systemData.GetODE2Coordinates(configuration=now.Current) - known).max())


def bricard(steps: float, start: Trajectory, known: float) -> Case:
    ways = ((1, 0, 0), (0, -1, 0), (0, 0, 1), (-1, 0, 0), (0, 1, 0))
    axes, bodies, place = ((0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1)), "", (0.0, 0.0, 0.0)
    ends = '<site name="{0}1" pos="{1} 0 {2}"/><site name="{0}2" pos="{3} 0 {2}"/>'
    for k, (way, axis) in enumerate(zip(ways, axes, strict=True)):
        more = '<site name="far1" pos="-0.5 1 0"/><site name="far2" pos="0.5 1 0"/>' if k == 4 else ""
        inertia = [(1.01 - 0.99 * x * x) / 12 for x in way]
        bodies += _body(f'type="hinge" axis="{_row(axis)}"', place, 1.0, inertia, [x / 2 for x in way], more=more)
        place = way
    xml = tree(ends.format("near", -0.5, 1, 0.5) + bodies + "</body>" * 5, (0, -9.81, 0),
               "".join(f'<connect site1="near{k}" site2="far{k}" {_HARD}/>' for k in (1, 2)))
    return mujoco(xml, [start[f"p{k}.phi"][0] for k in range(5)], [start[f"p{k}.w"][0] for k in range(5)], 2, steps,
                  lambda data: abs(float(data.qpos[0]) - known))


def rssr(steps: float, start: Trajectory, known: float) -> Case:
    crank = _body('type="hinge" axis="0 0 1"', (0, 0, 0), 1.0, (0.001, 0.02, 0.02), (0.15, 0, 0))
    rod = _body('type="ball"', (0.3, 0, 0), 2.0, (0.002, 0.2, 0.2), (0.55, 0, 0), more='<site name="far" pos="1.1 0 0"/>')
    rocker = _body('type="hinge" axis="0 1 0"', (0.9, 0.5, 0.2), 1.5, (0.001, 0.05, 0.05), (0.3, 0, 0),
                   more='<site name="near" pos="0.6 0 0"/>')
    xml = tree(f"{crank}{rod}</body></body>{rocker}</body>", equality=f'<connect site1="far" site2="near" {_HARD}/>')
    q = [start["turning.phi"][0], *(start[f"ball.S[{k}]"][0] for k in range(1, 5)), start["rocking.phi"][0]]
    v = [start["turning.w"][0], *(start[f"der(ball.S)[{k}]"][0] for k in (1, 2, 3)), start["rocking.w"][0]]
    return mujoco(xml, q, v, 2, steps, lambda data: abs(float(data.qpos[0]) - known))
