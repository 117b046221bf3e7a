"""The right-hand side of scenes as compiled, beside one written by hand in C with only what the scene needs, both at -O2.

    python tests/benchmarks/hand_written.py

Ours reckons the powers of the energy account as well, and any parameter may change from run to run in both. The accelerations are
compared first.
"""

import ctypes
from pathlib import Path

import numpy as np
from rhs_clock import Clock, state

import lagrangia as lag
from lagrangia.engines import load_engine
from lagrangia.interpret import evaluate
from lagrangia.native import build

HERE = Path(__file__).resolve().parent / "hand_written"
EXAMPLES = HERE.parents[2] / "models" / "examples"
PARAMETERS = {
    "suspended_bar": ("m", "L", "a", "k1", "k2", "c1", "c2"), "disc_and_block": ("m", "I", "r", "k1", "k2"),
    "cart_pole": ("M", "m", "L", "ks", "cs", "kp", "cp"), "double_pendulum": ("upper.m", "upper.L", "lower.m", "lower.L"),
    "quarter_car": ("m1", "m2", "k1", "k2", "c1", "speed"),
}
T = 0.53  # on the bump of the quarter car


def compare(name: str, clock: Clock) -> tuple[float, float, float]:
    """Seconds of ours and of the one by hand, and the largest difference of the accelerations, relative."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    scene, engine = model.scene, load_engine(model.scene, native=True)
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
    function.code = ctypes.cast(library.rhs, ctypes.c_void_p).value
    rounds = [(clock.seconds(engine.model.struct.rhs, None, inputs, outputs, engine.model.struct.rhs.n_work, 50),
               clock.seconds(function, None, [*inputs[:5], constants], by_hand, 0, 50)) for _ in range(8)]
    n = scene.n
    gap = float(np.abs(outputs[0][:n] - by_hand[0][:n]).max() / np.abs(by_hand[0][:n]).max())
    return min(ours for ours, _ in rounds), min(hand for _, hand in rounds), gap


def main() -> None:
    clock = Clock()
    print(f"{'scene':16} {'ours':>8} {'by hand':>8} {'ratio':>6} {'difference':>11}")
    for name in PARAMETERS:
        ours, hand, gap = compare(name, clock)
        print(f"{name:16} {ours * 1e9:6.1f}ns {hand * 1e9:6.1f}ns {ours / hand:6.2f} {gap:11.1e}", flush=True)
        assert gap < 1e-9, "the two are not the same scene"


if __name__ == "__main__":
    main()
