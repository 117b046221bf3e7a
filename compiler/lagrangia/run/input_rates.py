"""Rates of inputs that move places: those of a table that tells none, and those of splines."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from lagrangia.base.checked_values import a_text, numbers
from lagrangia.base.diagnostics import fail
from lagrangia.base.table_data import Beyond
from lagrangia.run.lookup import made_table
from lagrangia.run.scene import Scene


def slopes(times: Sequence[float], values: Sequence[float], smoothness: str = "cubic") -> Sequence[float]:
    """Rates of an input at its times, for der(y) beside y in a table of inputs: of the spline with two continuous derivatives, or
    of cubic pieces that do not overshoot ("monotone"). Raises LagError L0703."""
    times, values, smoothness = numbers("times", times), numbers("values", values), a_text("smoothness", smoothness)
    if smoothness not in ("cubic", "monotone"):
        fail("L0703", f"an input is 'cubic' or 'monotone' between its rows, not '{smoothness}'")
    if len(times) != len(values) or len(times) < 2 or any(b <= a for a, b in pairwise(times)):
        fail("L0703", "slopes are those of two rows and more, at times that rise")
    return list(made_table("inputs", tuple(map(float, times)), tuple(map(float, values)), smoothness, Beyond.HOLD).slopes)


def complete_rates(scene: Scene, times: Sequence[float], columns: Mapping[str, Any]) -> dict[str, Any]:
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
