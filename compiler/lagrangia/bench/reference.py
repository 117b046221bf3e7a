"""The true motion of a benchmark, by a method that none of the solvers measured uses: extrapolation in extended precision.

Gragg's midpoint rule with 2, 4, ..., 2 K substeps and Richardson extrapolation in h^2, which gives order 2 K; the equations are
compiled with `long double` (64 bits of mantissa on x86), where C and NumPy agree on it. Its own error is the difference between
two runs whose tolerances differ by ten. Where rounding in the equations keeps the tolerance out of reach, it is relaxed.
A scene too stiff for it gets Radau IIA of order 5 (SciPy's) at tight tolerances instead, with some 12 digits; one with corners
in its forces (contacts, absolute values), which mislead estimates of high order, SciPy's Dormand-Prince 8(5,3).
Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.9.
"""

import ctypes
import math
import time
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from lagrangia.algebra.with_casadi import CORNERS, uses
from lagrangia.base.records import dataclass
from lagrangia.bench.peers import prepare_scipy
from lagrangia.bench.problem import Piece, Problem
from lagrangia.native.build import build

if TYPE_CHECKING:
    from numpy.typing import NDArray

_TOLERANCES = (1e-10, 1e-11, 1e-12, 1e-13)  # of SciPy's methods
_COLUMNS = 10  # order 20
_SMALLEST_STEP = 1e-12  # of the piece
_HIGHEST_NOISE = 1e-11  # of the state: what is larger is no rounding, nor a step so short over a jump of the force
_LARGEST_AT_FULL_SPEED = 20_000  # instructions; compiling more with -O1 takes minutes
_PROBE = """#include <float.h>
#ifdef _WIN32
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
extern const int digits;
const int digits = LDBL_MANT_DIG;
"""
_EXPORT = "#define GCC_HASCLASSVISIBILITY\n"  # so that CasADi marks what is seen from outside


class NoReference(Exception):
    """The motion cannot be continued, or it takes too long to compute it."""


class TooLong(NoReference):
    """Explicit steps would take longer than the budget: the scene is stiff, or the time long."""


@dataclass(frozen=True)
class Reference:
    """Positions that solvers are measured by."""

    positions: "NDArray[Any]"  # (len(times), n)
    error: float  # its own, estimated, measured like the errors of solvers
    how: str


def find_reference(problem: Problem, seconds: float = 60.0) -> Reference:
    """Raises NoReference, CompilerError."""
    if any(uses(piece.slope, CORNERS) for piece in problem.pieces):
        return _by_scipy("DOP853", problem, seconds, "its forces have corners")
    try:
        return _by_extrapolation(problem, seconds)
    except TooLong as reason:
        return _by_scipy("Radau", problem, seconds, str(reason))


def _by_scipy(method: str, problem: Problem, seconds: float, reason: str) -> Reference:
    if find_spec("scipy") is None:
        raise NoReference(reason)
    found: list[NDArray[Any]] = []
    begin = time.perf_counter()
    for tolerance in _TOLERANCES:
        prepared = prepare_scipy(method, problem, tolerance, 2 * seconds)
        if found and (time.perf_counter() - begin) * 3 > seconds:  # a tenth of the tolerance takes 1.6 to 3 times as long
            break
        try:
            found.append(prepared.read(prepared.run(prepared.begin())))
        except TimeoutError:  # friction that sticks: no step is short enough
            break
    if len(found) < 2:
        raise NoReference(f"it takes too long by SciPy's {method}, too, and no other can be had: {reason}")
    how = f"SciPy's {method} at tolerance {_TOLERANCES[len(found) - 1]:.0e}, as {reason}"
    return Reference(found[-1], max(problem.error(found[-2], found[-1]), 1e-15), how)


def _by_extrapolation(problem: Problem, seconds: float) -> Reference:
    real, digits = _real()
    begin = time.perf_counter()
    clock = _Clock(begin, seconds, problem.experiment.start, problem.experiment.stop)
    tolerance = 100 * float(np.finfo(real).eps)
    while True:
        try:
            tight, loose = (_solve(problem, real, accuracy, clock) for accuracy in (tolerance, 10 * tolerance))
        except _Noise:
            tolerance *= 10
            continue  # until noise is no larger than the tolerance
        how = f"extrapolation of order {2 * _COLUMNS} with {digits} bits of mantissa, tolerance {tolerance:.0e}"
        return Reference(tight, max(problem.error(loose, tight), float(np.finfo(real).eps)), how)


def _real() -> tuple[Any, int]:
    """NumPy's type and its bits: long double where the C compiler means the same by it."""
    digits = ctypes.c_int.in_dll(ctypes.CDLL(str(build("digits", _PROBE))), "digits").value
    own = np.finfo(np.longdouble).nmant + 1
    return (np.longdouble, digits) if digits == 64 and own in (63, 64) else (np.float64, 53)


@dataclass(frozen=True)
class _Clock:
    """Looks ahead from a tenth of the budget on."""

    begin: float
    budget: float  # s
    start: float
    stop: float

    def check(self, t: float) -> None:
        elapsed = time.perf_counter() - self.begin
        share = (t - self.start) / (self.stop - self.start)
        if elapsed > self.budget or (elapsed > self.budget / 10 and elapsed > share * self.budget):
            raise TooLong("it takes too long: the scene is stiff, or the time long")


def _solve(problem: Problem, real: Any, tolerance: float, clock: _Clock) -> "NDArray[Any]":
    y = problem.start.astype(real)
    portions = []
    for piece in problem.pieces:
        states = _Extrapolation(piece, real, y.size, tolerance, clock).run(y)
        portions.append(states)
        y = states[-1]
    return problem.collect(portions)


class _Noise(Exception):
    """Shorter steps have no smaller errors: they are rounding. Or the shortest still meets a jump of the force."""


class _Slope:
    """A compiled slope: `self(t, y)` returns dy/dt, which the next call overwrites."""

    def __init__(self, function: ca.Function, real: Any, size: int) -> None:
        name = "long double" if real is np.longdouble else "double"
        generator = ca.CodeGenerator("slope.c", {"casadi_real": name, "casadi_int": "long long int"})
        generator.add_include("tgmath.h")
        generator.add(function)
        level = "-O1" if function.n_instructions() < _LARGEST_AT_FULL_SPEED else "-O0"
        self.function = ctypes.CDLL(str(build("slope", _EXPORT + generator.dump(), level=level)))[function.name()]
        self.t, self.y, self.dy = np.zeros(1, real), np.zeros(size, real), np.zeros(size, real)
        self.work = np.zeros(max(1, function.sz_w()), real)
        pointers = ctypes.c_void_p * max(2, function.sz_arg(), function.sz_res())
        self.arguments = (pointers(self.t.ctypes.data, self.y.ctypes.data), pointers(self.dy.ctypes.data), None,
                          ctypes.c_void_p(self.work.ctypes.data), 0)

    def __call__(self, t: Any, y: "NDArray[Any]") -> "NDArray[Any]":
        self.t[0] = t
        self.y[:] = y
        self.function(*self.arguments)
        return self.dy


class _Extrapolation:
    def __init__(self, piece: Piece, real: Any, size: int, tolerance: float, clock: _Clock) -> None:
        self.piece, self.real, self.tolerance, self.clock = piece, real, tolerance, clock
        self.slope = _Slope(piece.slope, real, size)
        self.half = size // 2

    def run(self, y: "NDArray[Any]") -> "NDArray[Any]":
        """States on the piece's grid, (rows, 2 n)."""
        rows = []
        t, h = self.real(self.piece.begin), self.real(self.piece.end - self.piece.begin) / 8
        smallest = _SMALLEST_STEP * (self.piece.end - self.piece.begin)
        rejected = math.inf
        for target in map(self.real, self.piece.grid):
            while t < target:
                self.clock.check(float(t))
                step = min(h, target - t)
                found, error = self._step(t, y, step)
                if np.isfinite(error) and error <= 1:
                    t, y = (target, found) if step == target - t else (t + step, found)
                    rejected = math.inf
                elif error > rejected / 2 and error * self.tolerance < _HIGHEST_NOISE:
                    raise _Noise
                else:
                    rejected = error
                factor = float(0.9 * error ** (-1 / (2 * _COLUMNS - 1))) if np.isfinite(error) and error > 0 else 0.2
                if error == 0:
                    factor = 4.0
                if step == h or factor < 1:
                    h = step * self.real(min(4.0, max(0.1, factor)))
                if h < smallest:
                    if error * self.tolerance < _HIGHEST_NOISE:
                        raise _Noise
                    raise NoReference(f"it cannot be continued beyond t = {float(t):.9g}")
            rows.append(y)
        return np.array(rows)

    def _step(self, t: Any, y: "NDArray[Any]", h: Any) -> tuple["NDArray[Any]", Any]:
        """The state a step later, and the error in units of the tolerance."""
        begin = self.slope(t, y).copy()
        before: list[NDArray[Any]] = []
        error = self.real(np.inf)
        for j in range(1, _COLUMNS + 1):
            row = [self._midpoint(t, y, begin, h, 2 * j)]
            for m, older in enumerate(before):
                ratio = (self.real(j) / (j - m - 1)) ** 2
                row.append(row[m] + (row[m] - older) / (ratio - 1))
            if j == _COLUMNS:
                error = self._error(row[-1] - row[-2], y, row[-1])
            before = row
        return before[-1], error

    def _error(self, difference: "NDArray[Any]", y: "NDArray[Any]", new: "NDArray[Any]") -> Any:
        """By the largest position and the largest rate, as each solver's result is measured by the largest of its kind."""
        worst = self.real(0)
        for part in (slice(0, self.half), slice(self.half, None)):
            scale = max(np.abs(y[part]).max(), np.abs(new[part]).max(), self.real(1e-3))
            worst = np.maximum(worst, np.abs(difference[part]).max() / scale)  # keeps NaN
        return worst / self.tolerance

    def _midpoint(self, t: Any, y: "NDArray[Any]", begin: "NDArray[Any]", h: Any, count: int) -> "NDArray[Any]":
        step = h / count
        old: NDArray[Any] = y
        new: NDArray[Any] = y + step * begin
        for k in range(1, count):
            old, new = new, old + 2 * step * self.slope(t + k * step, new)
        return new
