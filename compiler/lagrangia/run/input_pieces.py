"""Inputs as functions of time, as runtime/model/inputs.c has them: for who looks at a run from outside.

Linear between the rows of their table and held outside; those that stand where functions of time do are polynomials ("pieces"):
cubic where their first rates are in the table, of one row alone a parabola.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrangia.base.table_data import curvature
from lagrangia.run.interpret import evaluate

if TYPE_CHECKING:
    import numpy as np

    from lagrangia.run.request import Values
    from lagrangia.run.scene import Scene


def held_at_first(scene: "Scene", parameters: Sequence[float]) -> list[float]:
    """What is held before any instant."""
    tape = scene.tapes.get("held_first")
    return evaluate(tape, parameters)[0] if tape is not None else []


class InputTable:
    """Of a run that begins at `start`."""

    def __init__(self, scene: "Scene", values: "Values", start: float) -> None:
        import numpy as np

        count = len(scene.inputs)
        times = np.asarray(values.input_times, dtype=float)
        self.times = np.array([start]) if times.size == 1 else times
        self.rows = np.asarray(values.input_values, dtype=float).reshape(self.times.size, count)
        self.pieces = scene.pieces

    def at(self, t: "np.ndarray") -> "np.ndarray":
        """All inputs at times, (inputs, times). At a jump, those before it."""
        import numpy as np

        found = np.array([np.interp(t, self.times, column) for column in self.rows.T]).reshape(-1, t.size)
        if self.pieces:
            left = np.searchsorted(self.times, t) - 1
            for k, moment in enumerate(t):
                self._fill(found[:, k], float(moment), int(left[k]))
        return found

    def _fill(self, u: "np.ndarray", t: float, left: int) -> None:
        for y, rate, second, _ in self.pieces:
            place, a, b, c, d = self._piece(left, y, rate, second)
            x = t - place
            u[y] = a + x * (b + x * (c + x * d))
            if rate >= 0:
                u[rate], u[second] = b + x * (2 * c + x * 3 * d), 2 * c + 6 * x * d

    def pieces_within(self, middle: float) -> list[tuple[int, list[float]]]:
        """The first mode of each piece, and its numbers, at a time that is no row's."""
        import numpy as np

        left = int(np.searchsorted(self.times, middle)) - 1
        return [(first, self._piece(left, y, rate, second)) for y, rate, second, first in self.pieces]

    def _piece(self, left: int, y: int, rate: int, second: int) -> list[float]:
        import numpy as np

        last = self.times.size - 1
        if not 0 <= left < last:
            row = 0 if left < 0 else last
            known = self.rows[row, [rate, second]] if last == 0 and rate >= 0 else np.zeros(2)
            b, c = np.where(np.isfinite(known), known, 0.0)
            return [float(self.times[row]), float(self.rows[row, y]), float(b), float(c) / 2, 0.0]
        h = self.times[left + 1] - self.times[left]
        rise = (self.rows[left + 1, y] - self.rows[left, y]) / h
        a, b = self.rows[[left, left + 1], rate] if rate >= 0 else (np.nan, np.nan)
        if not np.isfinite(a + b):
            return [float(self.times[left]), float(self.rows[left, y]), float(rise), 0.0, 0.0]
        return [float(self.times[left]), float(self.rows[left, y]), float(a), *map(float, curvature(h, rise, a, b))]
