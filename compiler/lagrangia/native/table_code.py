"""Tables of a scene -> C: arrays of numbers, and the LagTable that runtime/model/table.h describes."""

import hashlib
from collections.abc import Sequence
from typing import Any

from lagrangia.base.table_data import TableData

MOST_WRITTEN = 200_000  # numbers: compilers take a second for them
_A_LINE = 8


def are_long(tables: Sequence[TableData]) -> bool:
    """Whether they are too long for a source."""
    return sum(len(values) for table in tables for values in _vectors(table).values()) > MOST_WRITTEN


def write_tables(tables: Sequence[TableData]) -> list[str]:
    """The text of `tables`; of those that are too long only what tells them from others."""
    if not tables:
        return []
    lines = ['#include "model/table.h"', ""]
    if are_long(tables):
        content = b"".join(bytes(memoryview(x).cast("B")) for table in tables for x in _vectors(table).values())
        return [*lines, f'#error "too long for a source: tables {hashlib.sha256(content).hexdigest()}"',
                "static const LagTable tables[1];"]
    rows = []
    for k, table in enumerate(tables):
        vectors = _vectors(table)
        for name, values in vectors.items():
            lines += _doubles(f"table_{k}_{name}", values)
        places = [f"table_{k}_{name}" if name in vectors else "0" for name in ("x", "y", "slopes")]
        numbers = (table.n, table.degree, int(table.beyond), repr(table.start), repr(table.pitch))
        rows.append(f"    {{{', '.join(map(str, (*numbers, *places)))}}},")
    return [*lines, "static const LagTable tables[] = {", *rows, "};"]


def _vectors(table: TableData) -> dict[str, Any]:
    return {name: values for name in ("x", "y", "slopes") if len(values := getattr(table, name))}


def _doubles(name: str, values: Sequence[float]) -> list[str]:
    numbers = [repr(float(x)) for x in values]
    lines = [f"    {', '.join(numbers[k : k + _A_LINE])}," for k in range(0, len(numbers), _A_LINE)]
    return [f"static const double {name}[] = {{", *lines, "};"]
