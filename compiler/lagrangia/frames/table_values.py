"""table(...) in expressions: of a file, of points with options, and of points alone, which may depend on parameters."""

from itertools import pairwise
from math import isnan
from typing import Any

from lagrangia.algebra.duals import Algebra, Dual, NotATimeError, Scalar, looked_up, nested_lines
from lagrangia.base.diagnostics import Span, fail
from lagrangia.base.table_data import Beyond, TableData
from lagrangia.language.lookups import options_of
from lagrangia.language.tree import Call, Flat
from lagrangia.run.lookup import made_table

_MOST_CELLS = 1000  # of a table in two variables, whose cells are written out
_OTHERWISE = "model.functions() of the Python interface has M, h and the accelerations of any scene"


def table_value(algebra: Algebra, x: Scalar, table: TableData, node: Call[Flat]) -> Scalar:
    """What a table of numbers is at x. Raises LagError L0217, L0712, L0901."""
    _require_short(algebra, table.n, node.span)
    try:
        found = looked_up(algebra, x, table)
    except NotATimeError:
        what = "of more than 2000 points" if table.beyond is not Beyond.ERROR else 'with beyond = "error"'
        fail("L0901", f"not supported yet: a table {what} along anything but a + b*time", node.arguments[0].span,
             "what it is asked for elsewhere is found piece by piece, each with a condition of its own",
             "take fewer points, with smoothness = \"cubic\"" if table.n > 2000 else 'write: beyond = "hold"')
    if isinstance(found, float) and isnan(found):
        fail("L0217", f"the table '{table.name}' says nothing here", node.span)
    return found


def table_of_points(node: Call[Flat], xs: Any, ys: Any) -> TableData:
    """Of points with options, which are numbers. Raises LagError L0303, L0901."""
    _require_points(xs, ys, node.span)
    if not all(isinstance(v, float | int) for v in (*xs, *ys)):
        fail("L0901", "not supported yet: points that depend on parameters in a table with options", node.span,
             "write numbers, or leave smoothness and beyond out")
    _, smoothness, beyond = options_of(node)
    if beyond is Beyond.PERIODIC and smoothness != "steps" and ys[0] != ys[-1]:
        fail("L0303", "what comes again ends where it begins: the last value is not the first one", node.span)
    return made_table("points", xs, ys, smoothness, beyond)


def lines_value(algebra: Algebra, x: Scalar, xs: Any, ys: Any, span: Span) -> Scalar:
    """table(x, xs, ys): straight lines between the points, held beyond the ends. Raises LagError L0303, L0712."""
    _require_points(xs, ys, span)
    _require_short(algebra, len(xs), span)
    moves = any(isinstance(v, Dual) for v in (*xs, *ys))
    return (nested_lines(algebra, x, xs, ys) if moves else algebra.lines(x, xs, ys))[0]


def plane_value(algebra: Algebra, x: Scalar, y: Scalar, xs: Any, ys: Any, zs: Any, span: Span) -> Scalar:
    """table2(x, y, xs, ys, zs), zs[i][j] at xs[i] and ys[j]: straight along both in each cell, held beyond the ends. Raises
    LagError L0303, L0712, L0901."""
    is_plane = isinstance(zs, tuple) and all(isinstance(row, tuple) for row in zs)
    if not is_plane or not isinstance(xs, tuple) or len(zs) != len(xs):
        fail("L0303", "table2(x, y, {x1, x2, ...}, {y1, y2, ...}, {{z11, z12, ...}, {z21, ...}, ...}) has a row for each x, and "
             "in it a number for each y", span)
    if len(xs) * len(ys if isinstance(ys, tuple) else ()) > _MOST_CELLS:
        fail("L0901", f"not supported yet: a table in two variables of more than {_MOST_CELLS} points", span, "take fewer")
    return lines_value(algebra, x, xs, tuple(lines_value(algebra, y, ys, row, span) for row in zs), span)


def _require_points(xs: Any, ys: Any, span: Span) -> None:
    if not isinstance(xs, tuple) or not isinstance(ys, tuple) or len(xs) != len(ys) or len(xs) < 2:
        fail("L0303", "table(x, {x1, x2, ...}, {y1, y2, ...}) needs two arrays of equal size, at least 2", span)
    if any(isinstance(a, float | int) and isinstance(b, float | int) and b <= a for a, b in pairwise(xs)):
        fail("L0303", "the x of a table must rise", span)


def _require_short(algebra: Algebra, n: int, span: Span) -> None:
    if n > algebra.most_points:
        fail("L0712", f"a table of {n} points is too long to be written out", span, f"at most {algebra.most_points}", _OTHERWISE)
