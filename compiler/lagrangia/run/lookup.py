"""Points -> TableData: knots that lie evenly are told by two numbers, and slopes of smooth tables come from the run time."""

import ctypes as c
from collections.abc import Sequence
from typing import Any

from lagrangia.base.diagnostics import fail
from lagrangia.base.table_data import DEGREES, Beyond, TableData
from lagrangia.run.library import find_runtime
from lagrangia.run.model_mirror import TableMirror

_EVEN = 4.0  # units in the last place of the largest knot by which knots that lie evenly may be rounded
_SMOOTH = {"cubic": 0, "monotone": 1}  # LAG_SMOOTH_... of table.h


def made_table(name: str, x: Sequence[float], y: Sequence[float], smoothness: str, beyond: Beyond) -> TableData:
    """`x` rises; two points or more. Raises LagError L0704 where slopes are needed and there is no run time."""
    import numpy as np

    knots, values = np.ascontiguousarray(x, float), np.ascontiguousarray(y, float)
    n, empty = len(knots), np.empty(0)
    pitch = float((knots[-1] - knots[0]) / (n - 1))
    largest = max(abs(float(knots[0])), abs(float(knots[-1])))
    is_even = bool((np.abs(knots - (knots[0] + pitch * np.arange(n))) <= _EVEN * np.spacing(largest)).all())
    degree = DEGREES[smoothness]
    made = TableData(name, degree, beyond, float(knots[0]), pitch, empty if is_even else knots, values, empty)
    if degree < 3:
        return made
    return TableData(name, degree, beyond, made.start, made.pitch, made.x, made.y, _slopes(made, smoothness))


def _slopes(table: TableData, smoothness: str) -> Any:
    import numpy as np

    runtime = find_runtime()
    if runtime is None:
        fail("L0704", f'smoothness = "{smoothness}" needs the run time, and there is neither one nor a C compiler', None,
             "pip install ziglang brings one")
    found, work = np.empty(table.n), np.empty(4 * table.n)
    runtime.library.lag_table_slopes(c.byref(TableMirror.of(table)), _SMOOTH[smoothness], *(_address(x) for x in (found, work)))
    return found


def _address(values: Any) -> Any:
    return values.ctypes.data_as(c.POINTER(c.c_double))
