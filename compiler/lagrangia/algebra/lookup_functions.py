"""Pieces of a table as CasADi has them, for whoever evaluates expressions without the run time.

The place and the coefficients of the polynomial that holds at x are constant between knots: their derivatives are zero.
"""

from functools import cached_property, reduce
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import TINY
from lagrangia.algebra.scalars import apply, apply_to_one, as_expression
from lagrangia.base.records import dataclass
from lagrangia.base.table_data import Beyond, TableData

MOST_WRITTEN = 64  # knots of a table that is written out, as sums; others are looked up


@dataclass(frozen=True, eq=False)
class TableUse:
    """A table of a + b t: `number` among the tables of the scene."""

    table: TableData
    number: int
    argument: ca.SX

    @cached_property
    def pieces(self) -> list[ca.SX]:
        """Place and coefficients at the argument."""
        return pieces_at(self.table, self.argument)

    @cached_property
    def written_pieces(self) -> list[ca.SX]:
        """The same without a call, for tapes."""
        return pieces_at(self.table, self.argument, self.table.n)


def pieces_at(table: TableData, x: ca.SX, most_written: int = MOST_WRITTEN) -> list[ca.SX]:
    """Place and coefficients, as expressions of x; of a table with more knots they are looked up by a call."""
    moved = ca.floor((x - table.knot(0)) / table.period) * table.period if table.beyond is Beyond.PERIODIC else ca.SX(0)
    if table.n <= most_written:
        found = written(table, [apply(ca.OP_LT, x - moved, at) for at in table.knots()])
    else:
        found = ca.vertsplit(_function(table)(x - moved))
    place, *coefficients = found
    return [place + moved, *coefficients]


def written(table: TableData, less: list[Any]) -> list[Any]:
    """Place and coefficients as sums over the pieces, by conditions that x is less than each knot."""
    where = [less[0], *(b - a for a, b in pairwise(less)), apply_to_one(ca.OP_NOT, less[-1])]
    columns = zip(*(table.piece_number(k) for k in range(table.n + 1)), strict=True)
    return [in_force(where, column) for column in columns]


def in_force(where: list[Any], column: Any) -> Any:
    """What stands in the column where a condition holds. No choice is in another one: what is made of them grows with the column,
    not with its square."""
    pieces = [apply(ca.OP_IF_ELSE_ZERO, here, x) for here, x in zip(where, column, strict=True) if not _is_nothing(x)]
    return reduce(lambda a, b: a + b, pieces, as_expression(0.0))


def _is_nothing(x: Any) -> bool:
    return isinstance(x, float | int) and x == 0


def _function(table: TableData) -> ca.Function:
    """x -> the piece. A call stays a call in expressions of it. CasADi (3.8) takes what is left in its memory for derivatives of
    calls that have none by structure: these have one, of TINY."""
    x, n = ca.MX.sym("x"), table.n
    knots = np.asarray(table.knots(), float)
    rows = np.array([table.piece_number(k) for k in range(n + 1)])
    k = ca.if_else(x < knots[0], 0, ca.if_else(x >= knots[-1], n, ca.low(ca.DM(knots), x) + 1))
    columns = [ca.MX(ca.DM(column)).get_nz(False, k) for column in rows.T]
    return ca.Function("piece", [x], [ca.vertcat(*columns) + TINY * x], {"never_inline": True})
