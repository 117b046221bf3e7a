"""Where coordinates are singular: places of one angle at which a motion of the coordinates moves nothing that has mass.

There det M = 0, whatever the other coordinates are: at sin theta = 0 of Euler's angles zxz, at cos theta = 0 of zyx, and between
hinges whose axes meet without mass in between.
"""

import math
import random
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from lagrangia.algebra.with_sympy import Expr
from lagrangia.paper.book import Book, bold, equal
from lagrangia.paper.document import Block, Inline, paragraph, say
from lagrangia.paper.layout import Apply, Node, Product, Words
from lagrangia.paper.linear_matrices import Linear

_MOST_COORDINATES = 12
_NOTHING, _NEAR = 1e-10, 0.3
_WAVES = {"sin": (0.0, np.pi), "cos": (np.pi / 2, -np.pi / 2)}


def singular_places(book: Book) -> list[Block]:
    """The places, in a sentence; nothing where there are none, or where M is singular everywhere."""
    q = book.equations.scene.q
    waves = {wave for row in book.equations.M for x in row for wave in x.atoms(sp.sin, sp.cos)}
    angles = [x for x in q if any(wave.has(x) for wave in waves)]
    is_singular = _tested(book) if angles else None
    if is_singular is None:
        return []
    where: list[Inline] = []
    for angle in angles:
        for wave, zeros in _WAVES.items():
            if all(is_singular({angle: zero}) for zero in zeros):
                where += [", " if where else "", equal(Apply(wave, book.names[angle]), book.sum(sp.S.Zero))]
    return [paragraph(say("These coordinates are singular where {0}: there {1}, and the equations give no accelerations.",
                          where, _no_determinant(book)))] if where else []


def singular_point(book: Book, linear: Linear) -> list[Block]:
    """Whether the point of small motion is such a place, in a sentence; nothing where M is singular everywhere."""
    is_singular = _tested(book)
    if is_singular is None or not is_singular(dict(zip(book.equations.scene.q, linear.point, strict=True))):
        return []
    return [paragraph(say("At this point {0}: the coordinates are singular there, and do not tell all small motions.",
                          _no_determinant(book)))]


def _tested(book: Book) -> Callable[[Mapping[Expr, Expr | float]], bool] | None:
    """Whether M n = 0 and J n = 0 for some n at a place, all else as given or taken at random; None where that is so anywhere."""
    e, chance = book.equations, random.Random(5)
    rows = [list(row) for row in (*e.M, *e.J)]
    if e.n > _MOST_COORDINATES or any(x.atoms(AppliedUndef) for row in rows for x in row):
        return None
    free = sorted({x for row in rows for y in row for x in y.free_symbols} | {p.symbol for p in e.scene.parameters}, key=str)
    values = {p.symbol: book.values.get(p.name, math.nan) for p in e.scene.parameters}
    at = {x: values[x] if math.isfinite(values.get(x, math.nan)) else chance.uniform(_NEAR, 2) for x in free}
    function = sp.lambdify(free, rows, "numpy")

    def scaled(place: Mapping[Expr, Expr | float], sizes: Any) -> Any:
        here = at | {x: float(sp.sympify(y).subs(at)) for x, y in place.items() if x in at}
        with np.errstate(all="ignore"):
            table = np.array(function(*map(np.float64, here.values())), float) / sizes
        table[: e.n] /= sizes[:, None]
        return table

    def is_singular(place: Mapping[Expr, Expr | float]) -> bool:
        table = scaled(place, sizes)
        known = table[np.all(np.isfinite(table), axis=1)]  # constraints may have no slope there
        return bool(np.all(np.isfinite(table[: e.n])) and np.linalg.matrix_rank(known, _NOTHING * np.abs(known).max()) < e.n)

    sizes = np.sqrt(np.abs(np.diagonal(scaled({}, np.ones(e.n)))))
    return None if not np.all(sizes > 0) or is_singular({}) else is_singular


def _no_determinant(book: Book) -> Node:
    return equal(Product((Words("det"), bold("M"))), book.sum(sp.S.Zero))
