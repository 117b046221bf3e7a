"""Frequency response: y(i omega)/u(i omega) of small motion, from the matrices of the linearisation.

    (-omega^2 M + i omega C + K) x = (F0 + i omega F1 - omega^2 F2) u,   y = Cz (x, i omega x) + D w
"""

import csv
from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.records import dataclass
from lagrangia.base.result_files import Target
from lagrangia.study.linearization import Linearization

Matrix = NDArray[np.float64]
_USUAL_RANGE = (0.1, 100.0)  # Hz, of a scene that does not oscillate
_MARGIN = 10.0
_AROUND_PEAK = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
_LEAST_DAMPING = 1e-5
_MOST_PEAKS = 60
_OPPOSITE = 1e-12
_REACH, _LOOKS = 3.0, 12  # damping ratios beside a natural frequency, where its peak is looked for, at so many places a side
_SAME = 1e-3  # of a frequency: two peaks are one


@dataclass(frozen=True)
class Response:
    """`values` (frequencies, outputs, inputs), complex, in SI units of output over input; frequencies in Hz."""

    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: tuple[str, ...]  # of outputs, then of inputs
    frequencies: Matrix
    values: NDArray[np.complex128]
    linearization: Linearization

    @property
    def magnitude(self) -> Matrix:
        """(frequencies, outputs, inputs)."""
        return np.abs(self.values)

    @property
    def phase(self) -> Matrix:
        """Degrees, without jumps along the frequencies."""
        angle = np.angle(self.values)
        angle = np.where(angle > np.pi - _OPPOSITE, angle - 2 * np.pi, angle)  # what is opposed to the input lags by 180 degrees
        return np.asarray(np.degrees(np.unwrap(angle, axis=0)))

    @cached_property
    def resonances(self) -> Mapping[tuple[int, int], tuple[float, ...]]:
        """Hz, by the places of output and input: the peaks of magnitude beside natural frequencies, in the range looked at."""
        low, high = float(self.frequencies.min(initial=np.inf)), float(self.frequencies.max(initial=0.0))
        sizes_at = cache(lambda f: np.abs(transfer(self.linearization, 2 * np.pi * f)))
        found: dict[tuple[int, int], list[float]] = {(i, j): [] for _, _, i, j in self.pairs()}
        for near, width in _vibrations(self.linearization):
            for (i, j), peaks in found.items():
                peak = _peak(sizes_at, (i, j), near, width)
                if peak is not None and low <= peak <= high and all(abs(peak - x) > _SAME * peak for x in peaks):
                    peaks.append(peak)
        return {pair: tuple(sorted(peaks)) for pair, peaks in found.items()}

    def of(self, output: str, input: str | None = None) -> NDArray[np.complex128]:
        """(frequencies,) of one pair; the first input by default."""
        return np.asarray(self.values[:, self.outputs.index(output), 0 if input is None else self.inputs.index(input)])

    def pairs(self) -> list[tuple[str, str, int, int]]:
        """Output, input, and their places."""
        return [(y, u, i, j) for j, u in enumerate(self.inputs) for i, y in enumerate(self.outputs)]

    def unit(self, output: int, input: int) -> str:
        """That of a pair, by its places."""
        return ratio_unit(self.units[output], self.units[len(self.outputs) + input])

    def to_csv(self, path: "str | Path") -> Path:
        """Frequency, and magnitude, phase, real and imaginary part of each pair. Raises LagError L0004."""
        path = Path(path)
        header = ["frequency"]
        columns: list[Matrix] = [self.frequencies]
        phase = self.phase
        for y, u, i, j in self.pairs():
            header += [f"{what}({y}/{u})" for what in ("magnitude", "phase_deg", "real", "imag")]
            value = self.values[:, i, j]
            columns += [np.abs(value), phase[:, i, j], value.real, value.imag]
        with Target(path) as target:
            writer = csv.writer(target.stream, lineterminator="\n")
            writer.writerow(header)
            writer.writerows([repr(float(x)) for x in row] for row in zip(*columns, strict=True))
        return path

    def plot(self, path: Any = None) -> Any:
        """The Bode plot; returns the matplotlib Figure."""
        from lagrangia.study.pictures import Curves, draw_bode

        labels = tuple(tuple(f"{y} [{self.unit(i, j)}]" for j in range(len(self.inputs))) for i, y in enumerate(self.outputs))
        curves = Curves(self.name, self.inputs, labels, self.frequencies, self.magnitude, self.phase, self.resonances)
        return draw_bode(curves, path)


def ratio_unit(upper: str, lower: str) -> str:
    """m/N; rad/(N.m); 1 of equal units."""
    if upper == lower:
        return "1"
    simple = lower and not any(letter in lower for letter in "./")
    return f"{upper or '1'}/{lower}" if simple else f"{upper or '1'}/({lower})" if lower not in ("", "1") else upper or "1"


def find_response(linear: Linearization, frequencies: Sequence[float] | None, span: tuple[float, float] | None, points: int,
                  units: tuple[str, ...]) -> Response:
    """At the frequencies given (Hz), or at points evenly spread over the logarithm of `span`, denser around resonances."""
    chosen = np.array(frequencies, dtype=float) if frequencies is not None else _grid(linear, span, points)
    values = np.array([transfer(linear, 2 * np.pi * f) for f in chosen])
    shape = (chosen.size, len(linear.outputs), len(linear.excitations))
    return Response(linear.name, linear.excitations, linear.outputs, units, chosen, values.reshape(shape), linear)


def transfer(linear: Linearization, omega: float) -> NDArray[np.complex128]:
    """(outputs, excitations) at one angular frequency, rad/s. Infinite exactly at an undamped resonance."""
    s, t = 1j * omega, linear.tangent
    w = np.zeros((len(linear.inputs), len(linear.excitations)), dtype=complex)
    for row, (order, k) in enumerate(linear.input_orders):
        w[row, k] = s**order
    force = sum(F * s**k for k, F in enumerate(linear.F))
    try:
        if t.W.shape[1] == t.M.shape[0] == len(linear.coordinates) and not (linear.has_signals or linear.free_rates):
            x = np.linalg.solve(s * s * t.M + s * t.C + t.K, force)
            z = np.vstack([x, s * x])
        else:
            z = np.linalg.solve(s * np.eye(linear.A.shape[0]) - linear.A, linear.B @ w)
    except np.linalg.LinAlgError:
        return np.full((len(linear.outputs), len(linear.excitations)), np.inf, dtype=complex)
    return np.asarray(linear.output @ z + linear.D @ w)


def _vibrations(linear: Linearization) -> list[tuple[float, float]]:
    """Natural frequencies, Hz, and damping ratios of those that are damped little enough for a peak."""
    s = linear.eigenvalues
    oscillating = s[s.imag > 1e-6 * float(np.abs(s).max(initial=0.0))][:_MOST_PEAKS]
    ratios = [(abs(x) / (2 * np.pi), max(-x.real / abs(x), _LEAST_DAMPING)) for x in oscillating]
    return [(f, zeta) for f, zeta in ratios if 2 * zeta**2 < 1]


def _peak(sizes_at: Callable[[float], Matrix], pair: tuple[int, int], near: float, width: float) -> float | None:
    """Where it is largest within some widths, if not at their ends; looked for twice, the second time closely."""
    for reach in (_REACH * width, _REACH * width / _LOOKS):
        around = np.geomspace(near / (1 + reach), near * (1 + reach), 2 * _LOOKS + 1)
        best = int(np.argmax(np.nan_to_num([sizes_at(float(f))[pair] for f in around], nan=np.inf)))
        if best in (0, 2 * _LOOKS):
            return None
        near = float(around[best])
    return near


def _grid(linear: Linearization, span: tuple[float, float] | None, points: int) -> Matrix:
    s = linear.eigenvalues
    largest = float(np.abs(s).max(initial=0.0))
    oscillating = s[(s.imag > 1e-6 * largest)]
    hertz = np.abs(oscillating) / (2 * np.pi)
    low, high = span or ((float(hertz.min()) / _MARGIN, float(hertz.max()) * _MARGIN) if hertz.size else _USUAL_RANGE)
    grid = list(np.geomspace(low, high, points))
    for x in oscillating[:_MOST_PEAKS]:
        damping = max(-x.real / abs(x), _LEAST_DAMPING)
        centre = abs(x) / (2 * np.pi) * np.sqrt(max(1 - 2 * damping**2, 1e-3))
        is_damped = -x.real / abs(x) > _LEAST_DAMPING
        grid += [centre * (1 + side * part * damping) for part in _AROUND_PEAK for side in (-1, 1) if part or is_damped]
    return np.unique(np.clip(grid, low, high))
