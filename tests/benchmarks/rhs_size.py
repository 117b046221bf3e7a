"""Size: nodes of the accelerations and time of one right-hand side against the number of links of a chain, or of bars of a rope
that is hung at both ends.

    python tests/benchmarks/rhs_size.py [--rope] [--largest N]

Ours is compiled up to 100 links and a tape above; the row says which. Beside a chain Pinocchio's ABA and MuJoCo's forward where
they are installed (pip install pin mujoco); they are called from Python, which adds about 0.3 us.
"""

import argparse
import ctypes
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lagrangia.bench.clock import Clock, shortest, state

CHAIN = Path(__file__).resolve().parents[2] / "models" / "examples" / "chain.lag"
ROPE = Path(__file__).resolve().parent / "scenes" / "rope.lag"
SIZES = (2, 5, 10, 20, 50, 100, 300, 1000, 3000, 10000)
LARGEST_NATIVE = 100


def ours(file: Path, n: int, clock: Clock) -> tuple[float, int, str, float]:
    """Seconds an evaluation, nodes, how it runs, seconds from text to scene."""
    from lagrangia.compile.pipeline import compile_file
    from lagrangia.native.c_code import usual_rhs
    from lagrangia.run.engines import load_engine
    from lagrangia.run.scene import Scene

    begin = time.perf_counter()
    scene: Scene = compile_file(file, None, {"n": n}).scene
    compiled = time.perf_counter() - begin
    engine = load_engine(scene, native=n <= LARGEST_NATIVE)
    assert engine is not None, "this benchmark needs a C compiler"
    tape = usual_rhs(scene.tapes)
    function = getattr(engine.model.struct, "rhs" if tape is scene.tapes["rhs"] else "regular")
    outputs = [np.zeros(max(1, size)) for size in tape.out_sizes]
    interpreter = ctypes.cast(engine.runtime.library.lag_tape_run, ctypes.c_void_p)
    seconds = clock.seconds(function, interpreter, state(scene), outputs, tape.n_work, 200 if n <= 1000 else 20)
    return seconds, scene.notes["acceleration_nodes"], engine.how, compiled


def pinocchio(n: int) -> float | None:
    try:
        import pinocchio as pin
    except ImportError:
        return None
    model, parent = pin.Model(), 0
    for k in range(n):
        place = pin.SE3(np.eye(3), np.array([0.5 if k else 0.0, 0, 0]))
        parent = model.addJoint(parent, pin.JointModelRZ(), place, f"hinge{k}")
        model.appendBodyToJoint(parent, pin.Inertia(1.0, np.array([0.25, 0, 0]), np.eye(3) * 0.5**2 / 12), pin.SE3.Identity())
    data, q, v = model.createData(), np.full(n, 0.3), np.full(n, 0.2)
    return shortest(lambda: pin.aba(model, data, q, v, np.zeros(n)))


def mujoco(n: int) -> float | None:
    try:
        import mujoco as mj
    except ImportError:
        return None
    link = "<body pos='{x} 0 0'><joint axis='0 0 1'/><inertial pos='0.25 0 0' mass='1' diaginertia='0.02 0.02 0.0208'/>"
    body = "".join(link.format(x=0.5 if k else 0) for k in range(n)) + "</body>" * n
    model = mj.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    data = mj.MjData(model)
    data.qpos[:], data.qvel[:] = 0.3, 0.2
    return shortest(lambda: mj.mj_forward(model, data))


def table(file: Path, largest: int) -> Iterator[str]:
    clock = Clock()
    head = f"{'links':>6} {'nodes':>8} {'a link':>7} {'compile':>9} {'how':>7} {'rhs':>11} {'a link':>9}"
    yield f"{head} {'Pinocchio':>11} {'MuJoCo':>11}"
    for n in (size for size in SIZES if size <= largest):
        seconds, nodes, how, compiled = ours(file, n, clock)
        peers = [peer(n) if n <= 300 and file == CHAIN else None for peer in (pinocchio, mujoco)]
        told = " ".join(f"{x * 1e6:9.2f}us" if x is not None else f"{'-':>11}" for x in peers)
        yield (f"{n:6} {nodes:8} {nodes / n:7.1f} {compiled:8.2f}s {how:>7} "
               f"{seconds * 1e6:9.3f}us {seconds / n * 1e9:7.1f}ns {told}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rope", action="store_true", help="bars of a rope hung at both ends")
    parser.add_argument("--largest", type=int, help="10000, of a rope 1000")
    options = parser.parse_args()
    for line in table(ROPE if options.rope else CHAIN, options.largest or (1000 if options.rope else 10000)):
        print(line, flush=True)


if __name__ == "__main__":
    main()
