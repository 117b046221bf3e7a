"""-u NAME=FILE: inputs as columns of files, and all of them as one table."""

import os
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from lagrangia.base.diagnostics import fail
from lagrangia.language.units import parse_unit
from lagrangia.run.columns import Columns, read_columns

_KINDS = (".csv", ".txt", ".dat", ".parquet", ".mat")
Table = tuple[Sequence[float], Mapping[str, Sequence[float]]]  # times, values by the names of inputs


def named_tables(given: Sequence[str]) -> dict[str, str]:
    """Files by the inputs that they are given for. Raises LagError L0712 where one is given twice."""
    found: dict[str, str] = {}
    for text in given:
        name, sign, path = text.partition("=")
        if sign and Path(path).suffix.lower() in _KINDS and not os.path.isfile(text):
            if name in found:
                fail("L0712", f"'{name}' is given twice", None, f"by -u {name}={found[name]} and by -u {text}")
            found[name] = path
    return found


def read_input(name: str, unit: str, path: str) -> Table:
    """The column of that name over the first one, or the second of two, in SI units. Raises LagError L0301, L0703."""
    columns = read_columns(Path(path))
    place = columns.place(name) if name in columns.names else columns.place(None)
    if place is None or place == 0:
        known = ", ".join(label or str(k) for k, label in enumerate(columns.names, 1))
        fail("L0703", f"'{path}' has no column '{name}', and {len(columns.names)} columns", None,
             f"its columns are: {known}"[:300])
    times = _in_si(columns, 0, "s", path)
    if any(b < a for a, b in pairwise(times)):
        fail("L0703", f"the first column of '{path}' must not fall: it is the time")
    return times, {name: _in_si(columns, place, unit, path)}


def _in_si(columns: Columns, place: int, wanted: str, path: str) -> list[float]:
    """As it stands where no unit is written."""
    values, text = columns.values[place], columns.units[place]
    if text:
        try:
            unit = parse_unit("1" if text == "-" else text)
        except ValueError as error:
            fail("L0301", f"{error}, in the line of names of '{path}'")
        if wanted and unit.dimension != parse_unit(wanted).dimension:
            fail("L0301", f"column {place + 1} of '{path}' is in {text}, and {wanted} is wanted")
        values = values * unit.factor + unit.offset
    return list(map(float, values))


def together(tables: Sequence[Table]) -> Table:
    """One table of them all, with all their times: each is linear between its own, and held beyond its ends. Raises LagError
    L0901 where one that jumps is not alone."""
    import numpy as np

    if len(tables) == 1:
        return tables[0]
    for times, columns in tables:
        if any(a == b for a, b in pairwise(times)):
            fail("L0901", f"not supported yet: a table that jumps beside others ({', '.join(columns)})", None,
                 "put the inputs as columns into one file")
    whole = np.unique(np.concatenate([np.asarray(times, float) for times, _ in tables]))
    found: dict[str, Any] = {name: np.interp(whole, times, values).tolist()
                             for times, columns in tables for name, values in columns.items()}
    return whole.tolist(), found
