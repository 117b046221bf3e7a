"""Time to an error of scenes in space whose motion is known: a fast top, a swinging robot arm, 20 bars on ball joints, Bricard's
six-bar, a spatial four-bar. Beside them what is installed of the peers in the Python that runs this: heyoka and SciPy on
equations written by hand, Pinocchio's ABA under SciPy and SUNDIALS (space_equations.py), Exudyn (space_exudyn.py) and MuJoCo
(space_peers.py). Processor time, the shortest of some runs, ours prepared and compiled as heyoka's are; below, for each scene and
decade of error, ours by the fastest peer's of those that take the scene as it is, and of those by hand.

    python tests/benchmarks/space.py [--repeat N] [--only top,arm,chain,bricard,rssr]
"""

import sys
import time
from argparse import ArgumentParser, BooleanOptionalAction, Namespace
from collections.abc import Callable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks import space_equations as equations
from benchmarks import space_exudyn as exudyn
from benchmarks import space_peers as peers
from lagrangia.bench.measure import Point
from lagrangia.bench.table import ERRORS, by_solver, seconds_at
from lagrangia.model import Model
from whole.test_space_cases import EXAMPLES, FOLDER, REFERENCES, chain, rod_start

TOLERANCES = tuple(10.0**-k for k in range(1, 14))
OPTIONS = Namespace(native=True, longest=2.0)
US = "lagrangia"
HAND = "by hand"  # ends the names of those whose equations are
Run = tuple[str, str, Callable[[float], peers.Case]]  # who, the package that it needs, its run at a tolerance


def shortest(run: Callable[[], Any], repeat: int) -> float:
    """s of processor time."""
    best = np.inf
    for turn in range(repeat):
        begin = time.process_time()
        run()
        best = min(best, time.process_time() - begin)
        if best > OPTIONS.longest / 20 and turn > 1:
            break
    return best


def measured(runs: Iterator[Run], repeat: int) -> Iterator[Point]:
    for who, package, make in runs:
        if any(find_spec(name) is None for name in package.split()):
            print(f"  {who}: not installed")
            continue
        for tolerance in TOLERANCES:
            try:
                run, error = make(tolerance)
                point = Point(who, tolerance, shortest(run, repeat), error())
            except (ArithmeticError, RuntimeError, ValueError) as failure:
                print(f"  {who} at {tolerance:.0e}: {str(failure).strip().splitlines()[-1][:90]}")
                continue
            yield point
            if point.seconds > OPTIONS.longest:
                break


def ours(model: Model, stop: float, error: Callable[[Any], float], who: str = US, **more: Any) -> Run:
    values = [list(more.get(name, {}).values()) for name in ("initial", "parameters")]

    def make(tolerance: float) -> peers.Case:
        model.native = OPTIONS.native
        asked: dict[str, Any] = {"at": [0, stop], "tolerance": tolerance}
        again = model.prepare(**more, **asked)
        return lambda: again(*values), lambda: error(model.simulate(**more, **asked))

    return who, "lagrangia", make


def steps(pace: float, order: int) -> Callable[[float], int]:
    """Steps of a method of that order; `pace` at tolerance 1."""
    return lambda tolerance: max(1, round(pace * tolerance ** (-1 / order)))


def by_hand(name: str, problem: Callable[[], equations.Equations]) -> Iterator[Run]:
    once = cache(problem)
    derivative = cache(lambda: equations.compiled(once()))
    yield f"heyoka, {name} {HAND}", "heyoka", lambda tolerance: equations.by_heyoka(once(), tolerance)
    yield f"SciPy, {name} {HAND}", "heyoka", lambda tolerance: equations.by_scipy(derivative(), once(), "DOP853", tolerance)


def by_pinocchio(make: Callable[[], tuple[Any, equations.Equations]]) -> Iterator[Run]:
    for method in ("DOP853", "LSODA"):
        yield (f"Pinocchio, SciPy {method}", "pinocchio",
               lambda tolerance, method=method: equations.by_scipy(*make(), method, tolerance))
    yield "Pinocchio, CVODE", "pinocchio sksundae", lambda tolerance: equations.by_cvode(*make(), tolerance)


def top() -> Iterator[Run]:
    centre = np.array(REFERENCES["top"]["fast"][-1]["centre"])
    model, mujoco, alpha = Model(FOLDER / "cases.lag", model="HeavyTop"), steps(250, 4), steps(600, 2)
    hinges = Model(Path(__file__).parent / "scenes" / "top_of_hinges.lag")

    def error(run: Any) -> float:
        return float(np.abs(run["top.center.r"][-1] - centre).max() / 0.1)

    yield ours(model, 2, error)
    yield ours(hinges, 2, error, f"{US}, three hinges")
    yield from by_hand("quaternion", lambda: equations.top(centre))
    yield from by_hand("Euler angles", lambda: equations.top_in_angles(centre))
    yield "MuJoCo", "mujoco", lambda tolerance: peers.top(mujoco(tolerance), centre)
    yield "Exudyn", "exudyn", lambda tolerance: exudyn.top(alpha(tolerance), centre)
    yield "Exudyn, DOPRI5", "exudyn", lambda tolerance: exudyn.top_of_hinges(tolerance, centre)


def arm() -> Iterator[Run]:
    known = np.array(REFERENCES["robot_arm_swing"][-1]["q"])
    start, rates = [0, np.pi / 4, np.pi, 0.3, np.pi / 4, 0], [0.5, 0, 0, 0, 0, 0]
    initial = {f"joint[{k}].phi": x for k, x in enumerate(start, 1)} | {"joint[1].w": 0.5}
    model = Model(EXAMPLES / "robot_arm.lag")
    yield ours(model, 2, lambda run: max(abs(run[f"joint[{k}].phi"][-1] - known[k - 1]) for k in range(1, 7)), initial=initial)
    values = dict(zip(model.parameter_names, model.parameter_values(), strict=True))
    links = peers.arm_links(values)
    yield from by_pinocchio(lambda: equations.arm(links, start + rates, known))
    yield "Exudyn, DOPRI5", "exudyn", lambda tolerance: peers.arm(links, tolerance, start, rates, known)


def bars() -> Iterator[Run]:
    n, mujoco, alpha = 20, steps(60, 4), steps(100, 2)
    m = L = 1 / n
    inertia = (m * 0.01**2 / 2, *[m * L**2 / 12 + m * 0.01**2 / 4] * 2)
    known = np.array(REFERENCES["hanging_20"][-1]["end"])
    model = chain([(m, L, inertia, 1)] * n, [Rotation.from_rotvec([0, 0, 1.2 * k / n]) for k in range(1, n + 1)],
                  np.array([[10, 0, 0]] * n))
    yield ours(model, 1, lambda run: np.abs([run[f"tip[{k}]"][-1] - known[k - 1] for k in (1, 2, 3)]).max())
    yield from by_pinocchio(lambda: equations.bars(n, inertia, known))
    yield "MuJoCo", "mujoco", lambda tolerance: peers.bars(mujoco(tolerance), n, inertia, known)
    yield "Exudyn", "exudyn", lambda tolerance: exudyn.bars(alpha(tolerance), n, inertia, known)


def bricard() -> Iterator[Run]:
    model, known, mujoco, alpha = Model(FOLDER / "bricard.lag"), 2.89332820598129336, steps(20, 4), steps(100, 2)
    yield ours(model, 2, lambda run: abs(run["p0.phi"][-1] - known))
    yield from by_hand("one coordinate", lambda: equations.bricard(known))
    begin = model.simulate(at=[0])
    yield "MuJoCo", "mujoco", lambda tolerance: peers.bricard(mujoco(tolerance), begin, known)
    yield "Exudyn", "exudyn", lambda tolerance: exudyn.bricard(alpha(tolerance), known)


def rssr() -> Iterator[Run]:
    model, known, values = Model(FOLDER / "cases.lag", model="Rssr"), REFERENCES["rssr"][-1]["theta"], rod_start()
    mujoco, alpha = steps(20, 4), steps(100, 2)
    yield ours(model, 2, lambda run: abs(run["turning.phi"][-1] - known), parameters=values)
    yield from by_hand("one coordinate", lambda: equations.rssr(known))
    begin = model.simulate(at=[0], parameters=values)
    yield "MuJoCo", "mujoco", lambda tolerance: peers.rssr(mujoco(tolerance), begin, known)
    yield "Exudyn", "exudyn", lambda tolerance: exudyn.rssr(alpha(tolerance), known)


SCENES = {"top": top, "arm": arm, "chain": bars, "bricard": bricard, "rssr": rssr}


def compare(points: list[Point]) -> Iterator[str]:
    """For each decade of error ours, and the fastest peer's time and their ratio: of peers that take the scene, and by hand."""
    groups = by_solver(points)
    for error in ERRORS:
        times = {who: seconds for who, group in groups.items() if (seconds := seconds_at(group, error)) is not None}
        mine = min((times.pop(who) for who in list(times) if who.startswith(US)), default=None)
        if mine is None:
            continue
        line = f"  {error:.0e} {1e3 * mine:9.3g} ms"
        for by_hand in (False, True):
            group = {who: seconds for who, seconds in times.items() if who.endswith(HAND) == by_hand}
            if group:
                best = min(group, key=group.__getitem__)
                line += f"  | {1e3 * group[best]:9.3g} ms  {mine / group[best]:.2f}  {best}"
        yield line


def main() -> None:
    parser = ArgumentParser(description="time to an error of scenes in space")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--only", default=",".join(SCENES))
    parser.add_argument("--longest", type=float, default=2.0, help="s of a run beyond which a peer is asked for no more digits")
    parser.add_argument("--native", action=BooleanOptionalAction, default=True, help="ours compiled, not on tapes")
    options = parser.parse_args(namespace=OPTIONS)
    for name in options.only.split(","):
        print(name)
        points = list(measured(SCENES[name](), options.repeat))
        for who, group in by_solver(points).items():
            print(f"  {who:31}" + "  ".join(f"{1e3 * point.seconds:.3g} ms to {point.error:.0e}" for point in group))
        print(*compare(points), sep="\n", flush=True)


if __name__ == "__main__":
    main()
