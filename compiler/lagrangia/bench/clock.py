"""The time of one right-hand side, called from a loop in C."""

import ctypes
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lagrangia.base.folders import data_folder
from lagrangia.native.build import build
from lagrangia.run.interpret import evaluate
from lagrangia.run.scene import Scene

CLOCK = """
#define _POSIX_C_SOURCE 199309L
#include <time.h>
#include "model/tape.h"

LAG_API double clock_calls(const LagFunction *f, void (*tape)(const LagTape *, const double *const *, double *const *, double *),
                           const double *const *in, double *const *out, double *w, int calls);

/* Seconds a call. */
double clock_calls(const LagFunction *f, void (*tape)(const LagTape *, const double *const *, double *const *, double *),
                   const double *const *in, double *const *out, double *w, int calls)
{
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (int k = 0; k < calls; ++k) {
        if (f->code)
            f->code(in, out, w);
        else
            tape(f->tape, in, out, w);
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    return ((double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec)) / calls;
}
"""
Vector = ctypes.POINTER(ctypes.c_double)


class Clock:
    """Times a function of a model and keeps what it computed. The shortest of many times counts: others only add to it.

    `tape_run` is the interpreter, for a function that is a tape.
    """

    def __init__(self) -> None:
        self.library = ctypes.CDLL(str(build("clock", CLOCK, include=[data_folder("runtime")])))
        self.library.clock_calls.restype = ctypes.c_double

    def seconds(self, function: ctypes.Structure, tape_run: Any, inputs: Sequence[np.ndarray], outputs: Sequence[np.ndarray],
                n_work: int, repeats: int = 200) -> float:
        """Of a call; `outputs` holds the results afterwards."""
        work = np.zeros(max(1, n_work))
        pointers = [(Vector * len(x))(*(y.ctypes.data_as(Vector) for y in x)) for x in (inputs, outputs)]
        run = ctypes.cast(tape_run, ctypes.c_void_p) if tape_run is not None else None

        def once(calls: int) -> float:
            return float(self.library.clock_calls(ctypes.byref(function), run, *pointers, work.ctypes.data_as(Vector), calls))

        calls = max(1, int(1e-4 / max(once(3), 1e-9)))
        return min(once(calls) for _ in range(repeats))


def hoisted(scene: Scene) -> list[float]:
    """c of a scene, what depends on its parameters alone, as they are declared."""
    given = [parameter.value if parameter.value is not None else 0.0 for parameter in scene.parameters]
    mask = [float(parameter.value is not None) for parameter in scene.parameters]
    (p,) = evaluate(scene.tapes["parameters"], given, mask)
    (c,) = evaluate(scene.tapes["hoist"], p)
    return list(c)


def state(scene: Scene, seed: int = 0) -> list[np.ndarray]:
    """t, q, v, u, d and c of a scene at a general place, its parameters as declared."""
    random = np.random.default_rng(seed)
    c = hoisted(scene)
    _, n, _, u, d, _ = scene.tapes["rhs"].in_sizes
    modes = np.zeros(d)
    modes[[*scene.patterns.get("attitudes", ())][1::2]] = 1.0  # references that turn nothing
    parts: list[Any] = [[0.3], random.uniform(0.1, 1, n), random.uniform(0.1, 1, n), np.zeros(u), modes, c]
    return [np.array([*part, 0.0]) for part in parts]  # never empty


def shortest(call: Callable[[], object], seconds: float = 0.3) -> float:
    """Seconds of the shortest of many calls: what others do on the machine only adds."""
    found, end = float("inf"), time.perf_counter() + seconds
    while time.perf_counter() < end:
        begin = time.perf_counter()
        for _ in range(20):
            call()
        found = min(found, (time.perf_counter() - begin) / 20)
    return found
