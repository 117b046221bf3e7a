"""Inputs as functions of time, as runtime/model/inputs.c has them: for who looks at a run from outside.

Linear between the rows of their table and held outside; those that stand where functions of time do are polynomials ("pieces"):
cubic where their first rates are in the table, of one row alone a parabola.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from lagrangia.base.diagnostics import fail
from lagrangia.run.lookup import made_table

if TYPE_CHECKING:
    import numpy as np

    from lagrangia.run.request import Values
    from lagrangia.run.scene import Scene

PIECE = 5  # numbers of a piece: its place in time, and four coefficients


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
        return [float(self.times[left]), float(self.rows[left, y]), float(a), float((3 * rise - 2 * a - b) / h),
                float((a + b - 2 * rise) / (h * h))]


def slopes(times: Sequence[float], values: Sequence[float], smoothness: str = "cubic") -> Sequence[float]:
    """Rates of an input at its times, for der(y) beside y in a table of inputs: of the spline with two continuous derivatives, or
    of cubic pieces that do not overshoot ("monotone"). Raises LagError L0703."""
    if smoothness not in ("cubic", "monotone"):
        fail("L0703", f"an input is 'cubic' or 'monotone' between its rows, not '{smoothness}'")
    if len(times) != len(values) or len(times) < 2 or any(b <= a for a, b in pairwise(times)):
        fail("L0703", "slopes are those of two rows and more, at times that rise")
    from lagrangia.base.table_data import Beyond

    return list(made_table("inputs", tuple(map(float, times)), tuple(map(float, values)), smoothness, Beyond.HOLD).slopes)


def complete_rates(scene: "Scene", times: Sequence[float], columns: Mapping[str, Any]) -> dict[str, Any]:
    """The columns with those of rates that nobody gave: 0 of one row; else NaN, which says that pieces are straight.

    Raises LagError L0703 for a place that jumps, and for second rates in a table of many rows."""
    found, names = dict(columns), [item.name for item in scene.inputs]
    if len(times) < 2:
        return found
    for y, rate, second, _ in scene.pieces:
        if rate < 0:
            continue
        name = names[y]
        if names[second] in found:
            fail("L0703", f"a table of '{name}' tells its rate, {names[rate]}, and nothing of {names[second]}", None,
                 "between two rows it is the cubic with these values and rates")
        rows = [*zip(times, found.get(name, ()), strict=False)]
        jump = next((t for (t, x), (later, z) in pairwise(rows) if t == later and x != z), None)
        if jump is not None:
            fail("L0703", f"the input '{name}' moves places, and jumps at t = {jump:g}: what it moves would have no speed", None,
                 "let it go over within some time")
        found.setdefault(names[rate], [float("nan")] * len(times))
    return found
