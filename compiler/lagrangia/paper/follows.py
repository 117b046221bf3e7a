"""Whether an equation follows from Lagrange's equations and the constraints: by value, at random points.

It is linear in accelerations and multipliers, g = r . a + s . lambda + w. It follows where factors c and d of parameters and of
the state make it of the scene's M a + J^T lambda + h - f and of the constraints' second derivative K a + gamma:

    M^T c + K^T d = r,    J c = s,    c . (h - f) + d . gamma = w.
"""

import random
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.diagnostics import fail
from lagrangia.paper.book import Book
from lagrangia.paper.rest_points import Begin

_POINTS, _TRIES, _STEPS = 20, 200, 30
_BESIDE, _CLOSED = 1e-9, 1e-13
_NEAR = 0.1  # of the start: rad, or of the reach; of parameters and rates of supports: their share


class Follows:
    """One equation beside those of a scene, as functions of numbers for their symbols."""

    def __init__(self, book: Book, mine: Expr, scene: Sequence[Expr]) -> None:
        e = book.equations
        self.book = book
        self.n, self.m = e.n, len(e.rows)
        rates = e.scene.rates
        once = [e.ring.along(row, rates) for row in e.rows]
        twice = [e.ring.along(x, rates) if i < e.scene.holonomic else x for i, x in enumerate(once)]
        open_ = [*e.scene.a, *e.multipliers]
        none = dict.fromkeys(open_, sp.S.Zero)
        self._rows = [*(sp.sympify(x).diff(y) for x in (mine, *scene, *twice) for y in open_),
                      *(sp.sympify(x).xreplace(none) for x in (mine, *scene, *twice))]
        self.closing = [*e.rows[: e.scene.holonomic]], [*once[: e.scene.holonomic], *e.rows[e.scene.holonomic :]]
        whole = (*self._rows, *(x for group in self.closing for x in group))
        self.symbols = sorted({y for x in whole for y in x.free_symbols}, key=str)
        self._function = sp.lambdify(self.symbols, self._rows, "math")

    def points(self) -> Iterator[list[float]]:
        """Numbers about 1 for all symbols: of scenes without constraints."""
        chance = random.Random(3)
        return ([chance.uniform(0.3, 1.4) for _ in self.symbols] for _ in range(_POINTS))

    def shares(self, at: Sequence[float]) -> Sequence[float] | None:
        """The factors c, each by the size of its equation; None where it does not follow. Raises LagError L0706, L0912."""
        n, m = self.n, self.m
        try:
            found = np.array(self._function(*at), dtype=float)
        except (ValueError, ZeroDivisionError, OverflowError):
            fail("L0706", "--check: the equation has no value where coordinates and parameters are about 1", None,
                 "roots of what may be negative, quotients by what may be 0")
        slopes, rest = found[: -(1 + n + m)].reshape(1 + n + m, n + m), found[-(1 + n + m) :]
        factors, *_ = np.linalg.lstsq(slopes[1:].T, slopes[0], rcond=None)
        if np.linalg.matrix_rank(slopes[1:]) < n + m:
            fail("L0912", "not supported yet: --check of a scene with a coordinate that moves no mass, or with constraints that "
                 "repeat each other", self.book.equations.scene.kinematics.graph.model.span)
        largest = np.abs(factors).max()
        near = np.abs(slopes[0]) + largest * np.abs(slopes[1:]).sum(axis=0)
        is_made = bool(np.all(np.abs(slopes[1:].T @ factors - slopes[0]) <= _BESIDE * near))
        is_left = abs(rest[0] - factors @ rest[1:]) <= _BESIDE * (abs(rest[0]) + largest * np.abs(rest[1:]).sum())
        return list(factors[:n] * np.abs(slopes[1 : n + 1]).max(axis=1)) if is_made and is_left else None


def closed_points(book: Book, system: Follows, begin: Begin) -> Iterator[list[float]]:
    """States near the start in which the constraints hold. Raises LagError L0606 where they cannot be closed there."""
    e = book.equations
    chance, found = random.Random(3), 0
    q = list(e.scene.q)
    positions, velocities = (_Closing(system.symbols, rows, unknowns) for rows, unknowns in
                             zip(system.closing, (q, list(e.scene.v)), strict=True))
    values = {p.symbol: book.values[p.name] for p in e.scene.parameters}
    given = {x: 0.0 for g in e.scene.given for x in g.moving}
    given |= {g.symbol: _at_first(g.value, values, e.scene.t) for g in e.scene.given if g.symbol in given}
    for _ in range(_TRIES):
        at = {x: chance.uniform(0.3, 1.4) for x in system.symbols}
        at |= {x: values[x] for x in system.symbols if x in values}
        at |= {x: x0 + chance.uniform(-_NEAR, _NEAR) * (abs(x0) or 1) for x, x0 in given.items() if x in at}
        at |= {x: float(x0) + chance.uniform(-_NEAR, _NEAR) * float(size)
               for x, x0, size in zip(q, begin.q, begin.reach, strict=True) if x in at}
        if positions.close(at) and velocities.close(at):
            yield [at[x] for x in system.symbols]
            found += 1
        if found == _POINTS:
            return
    fail("L0606", "--check: no positions near the start keep the constraints", book.equations.scene.kinematics.graph.model.span)


def _at_first(value: Expr, values: Mapping[Expr, float], t: Expr) -> float:
    """A given function at t = 0; 0 where that is no number."""
    found = value.xreplace(values).subs(t, 0)
    return float(found) if found.is_number and found.is_real else 0.0


class _Closing:
    """Newton's method for rows of some unknowns, least squares in each step."""

    def __init__(self, symbols: Sequence[Expr], rows: Sequence[Expr], unknowns: Sequence[Expr]) -> None:
        self.symbols, self.unknowns = symbols, [x for x in unknowns if x in symbols]
        self.count = len(rows)
        self.function = sp.lambdify(symbols, [*rows, *(x.diff(y) for x in rows for y in self.unknowns)], "math")

    def close(self, at: dict[Expr, float]) -> bool:
        """Whether the rows come to vanish; the unknowns in `at` are moved there."""
        for _ in range(_STEPS):
            found = np.array(self.function(*(at[x] for x in self.symbols)), dtype=float)
            gaps, slopes = found[: self.count], found[self.count :].reshape(self.count, len(self.unknowns))
            if not np.any(np.abs(gaps) > _CLOSED):
                return True
            step, *_ = np.linalg.lstsq(slopes, gaps, rcond=None)
            at.update({x: at[x] - float(dx) for x, dx in zip(self.unknowns, step, strict=True)})
        return False
