"""-u NAME=FILE, -u NAME=FILE:cubic: inputs as columns of files, and all of them as one table.

What is smooth has a column of its rate beside its own, der(NAME): between two rows it is the cubic with these values and rates.
"""

import os
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangia.base.cutting import cut_pair
from lagrangia.base.diagnostics import fail
from lagrangia.language.units import Unit, parse_unit

if TYPE_CHECKING:
    from lagrangia.run.columns import Columns

_KINDS = (".csv", ".txt", ".dat", ".parquet", ".mat")
_SMOOTHNESS = ("linear", "steps", "cubic", "monotone")
Table = tuple[Sequence[float], Mapping[str, Sequence[float]]]  # times, values by the names of inputs


def path_of(named: str) -> str:
    """The file of FILE:cubic."""
    return _parted(named)[0]


def _parted(named: str) -> tuple[str, str]:
    path, sign, smoothness = named.rpartition(":")
    return (path, smoothness) if sign and smoothness in _SMOOTHNESS else (named, "linear")


def named_tables(given: Sequence[str]) -> dict[str, str]:
    """Files by the inputs that they are given for. Raises LagError L0712 where one is given twice."""
    found: dict[str, str] = {}
    for text in given:
        name, sign, path = cut_pair(text)
        if sign and Path(path_of(path)).suffix.lower() in _KINDS and not os.path.isfile(text):
            if name in found:
                fail("L0712", f"'{name}' is given twice", None, f"by -u {name}={found[name]} and by -u {text}")
            found[name] = path
    return found


def read_input(name: str, unit: str | None, named: str, is_moving: bool) -> Table:
    """The column of that name over the first one, or the second of two, in its `unit`, or as it stands where that is None;
    `is_moving`: its rates matter. Raises LagError L0301, L0703, L0901."""
    from lagrangia.run.columns import read_columns
    from lagrangia.run.input_rates import slopes

    path, smoothness = _parted(named)
    columns = read_columns(Path(path))
    place = columns.place(name) if name in columns.names else columns.place(None)
    if place is None or place == 0:
        known = ", ".join(label or str(k) for k, label in enumerate(columns.names, 1))
        fail("L0703", f"'{path}' has no column '{name}', and {len(columns.names)} columns", None,
             f"its columns are: {known}"[:300])
    times, values = _in_unit(columns, 0, "s", path), _in_unit(columns, place, unit, path)
    if any(b < a for a, b in pairwise(times)):
        fail("L0703", f"the first column of '{path}' must not fall: it is the time")
    if smoothness == "steps":
        return [t for t in times for _ in (0, 1)][1:], {name: [x for x in values for _ in (0, 1)][:-1]}
    if smoothness == "linear":
        return times, {name: values}
    if not is_moving:
        fail("L0901", f"not supported yet: the input '{name}', which moves no places, as a smooth table", None,
             f"write table(time, \"{path}\", smoothness = \"{smoothness}\") in its place, or leave :{smoothness} away")
    return times, {name: values, f"der({name})": slopes(times, values, smoothness)}


def _in_unit(columns: "Columns", place: int, wanted: str | None, path: str) -> list[float]:
    """In the unit that is wanted, SI where that is none; as it stands where no unit is written, or None is wanted."""
    values, text = columns.values[place], columns.units[place]
    if text and wanted is not None:
        try:
            unit = parse_unit("1" if text == "-" else text)
        except ValueError as error:
            fail("L0301", f"{error}, in the line of names of '{path}'")
        own = parse_unit(wanted) if wanted else Unit(1.0, unit.dimension)
        if unit.dimension != own.dimension:
            fail("L0301", f"column {place + 1} of '{path}' is in {text}, and {wanted} is wanted")
        values = values * unit.factor + unit.offset
        if (own.factor, own.offset) != (1.0, 0.0):
            values = (values - own.offset) / own.factor
    return list(map(float, values))


def together(tables: Sequence[Table]) -> Table:
    """One table of them all, with all their times: each is as it was between its own, and held beyond its ends. Raises LagError
    L0901 where one that jumps is not alone."""
    import numpy as np

    if len(tables) == 1:
        return tables[0]
    for times, columns in tables:
        if any(a == b for a, b in pairwise(times)):
            fail("L0901", f"not supported yet: a table that jumps beside others ({', '.join(columns)})", None,
                 "put the inputs as columns into one file")
    whole = np.unique(np.concatenate([np.asarray(times, float) for times, _ in tables]))
    smooth = [times for times, columns in tables if any(name.startswith("der(") for name in columns)]
    ends = [x for times in smooth for x in (times[0], times[-1]) if whole[0] < x < whole[-1]]  # where rates jump, to 0 or from it
    whole = np.sort(np.concatenate([whole, np.unique(ends)])) if ends else whole
    found: dict[str, Any] = {}
    for times, columns in tables:
        for name in (name for name in columns if not name.startswith("der(")):
            rates = columns.get(f"der({name})")
            if rates is None:
                found[name] = np.interp(whole, times, columns[name]).tolist()
            else:
                found[name], found[f"der({name})"] = _refined(times, columns[name], rates, whole)
    return whole.tolist(), found


def _refined(times: Sequence[float], values: Sequence[float], rates: Sequence[float], at: Any) -> tuple[list[float], list[float]]:
    """Values and rates at more times; of two that are equal those before, then those after."""
    import numpy as np

    from lagrangia.base.table_data import curvature

    x, y, s = (np.asarray(column, float) for column in (times, values, rates))
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    h, w = x[k + 1] - x[k], np.clip(at, x[0], x[-1]) - x[k]
    rise = (y[k + 1] - y[k]) / h
    c, d = curvature(h, rise, s[k], s[k + 1])
    is_second = np.append([False], np.diff(at) == 0)
    is_first = np.append(np.diff(at) == 0, [False])
    is_outside = (at < x[0]) | (at > x[-1]) | ((at == x[0]) & is_first) | ((at == x[-1]) & is_second)
    return (y[k] + w * (s[k] + w * (c + w * d))).tolist(), np.where(is_outside, 0.0, s[k] + w * (2 * c + w * 3 * d)).tolist()
