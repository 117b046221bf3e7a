"""The right-hand side of scenes as compiled, beside one written by hand in C with only what the scene needs, both at -O2.

    python tests/benchmarks/hand_written.py

Both give the same: the accelerations alone, and these with the powers that dampers take out and sources put in, which the energy
account needs. Any parameter may change from run to run in both, but for those that are compiled in. All results are compared.
"""

import ctypes
from array import array
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import lagrangia as lag
from lagrangia.bench.clock import Clock, state
from lagrangia.native.build import build
from lagrangia.native.tapes import Op
from lagrangia.run.engines import load_engine
from lagrangia.run.interpret import evaluate
from lagrangia.run.scene import Scene

HERE = Path(__file__).resolve().parent / "hand_written"
EXAMPLES = HERE.parents[2] / "models" / "examples"
PARAMETERS = {
    "suspended_bar": ("m", "L", "a", "k1", "k2", "c1", "c2"), "disc_and_block": ("m", "I", "r", "k1", "k2"),
    "cart_pole": ("M", "m", "L", "ks", "cs", "kp", "cp"), "double_pendulum": ("upper.m", "upper.L", "lower.m", "lower.L"),
    "quarter_car": ("m1", "m2", "k1", "k2", "c1", "speed"),
}
T = 0.53  # on the bump of the quarter car
ROUNDS = 12


def without_powers(scene: Scene) -> Scene:
    """The scene whose right-hand side stores no powers: the C compiler leaves away what only they need."""
    tape = scene.tapes["rhs"]
    kept = [tape.code[k : k + 4] for k in range(0, len(tape.code), 4) if tape.code[k] != Op.OUTPUT or tape.code[k + 1] != 1]
    return replace(scene, tapes={**scene.tapes, "rhs": replace(tape, code=array("i", [x for part in kept for x in part]))})


def compare(name: str, clock: Clock, has_powers: bool) -> tuple[float, float, float]:
    """Seconds of ours and of the one by hand, and the largest difference of the results, relative."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    scene = model.scene if has_powers else without_powers(model.scene)
    engine = load_engine(scene, native=True)
    assert engine is not None, "this benchmark needs a C compiler"
    values = model.parameter_values()
    inputs = state(scene)
    inputs[0][0] = T
    if "modes" in scene.tapes:
        inputs[4] = np.array([*evaluate(scene.tapes["modes"], [T], values)[0], 0.0])
    library = ctypes.CDLL(str(build(name, [HERE / f"{name}.c"], include=[HERE])))
    constants = np.zeros(16)
    places = [model.parameter_names.index(parameter) for parameter in PARAMETERS[name]]
    library.prepare(np.array(values[places]).ctypes.data_as(ctypes.c_void_p), constants.ctypes.data_as(ctypes.c_void_p))
    outputs, by_hand = ([np.zeros(max(2, size)) for size in scene.tapes["rhs"].out_sizes] for _ in range(2))
    function = type(engine.model.struct.rhs)()
    function.code = ctypes.cast(library.with_powers if has_powers else library.accelerations, ctypes.c_void_p).value
    rounds = [(clock.seconds(engine.model.struct.rhs, None, inputs, outputs, engine.model.struct.rhs.n_work, 50),
               clock.seconds(function, None, [*inputs[:5], constants], by_hand, 0, 50)) for _ in range(ROUNDS)]
    gap = max(_gap(ours, hand) for ours, hand in zip(outputs[: 1 + has_powers], by_hand, strict=False))
    return min(ours for ours, _ in rounds), min(hand for _, hand in rounds), gap


def _gap(ours: np.ndarray, hand: np.ndarray) -> float:
    return float(np.abs(ours - hand).max() / max(np.abs(hand).max(), 1e-300))


def table(write: Callable[[str], None]) -> list[float]:
    """A line a scene: accelerations alone, and with powers. Gives the ratios."""
    clock, ratios = Clock(), []
    write(f"{'':16} {'accelerations':^24} {'and powers':^24}")
    write(f"{'scene':16} {'ours':>8} {'by hand':>8} {'ratio':>6} {'ours':>8} {'by hand':>8} {'ratio':>6}")
    for name in PARAMETERS:
        line = f"{name:16}"
        for has_powers in (False, True):
            ours, hand, gap = compare(name, clock, has_powers)
            assert gap < 1e-9, f"{name}: the two are not the same scene"
            ratios.append(ours / hand)
            line += f" {ours * 1e9:6.1f}ns {hand * 1e9:6.1f}ns {ratios[-1]:6.2f}"
        write(line)
    return ratios


if __name__ == "__main__":
    table(print)
