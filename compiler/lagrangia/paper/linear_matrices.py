"""Small motion about a point: the matrices from the exact derivatives of the equations, with multipliers and without.

    M q'' + C q' + K q + J^T lambda = f(t),   J q = e(t)

All are deviations from the point (q0, lambda0); K holds the stiffness that lambda0 gives to curved constraints, f and e what
loads and given displacements do. With q = N x + X e, J N = 0, J X = 1, the multipliers go:

    N^T M N x'' + N^T C N x' + N^T K N x = N^T (f - M X e'' - C X e' - K X e)
"""

from collections.abc import Callable, Iterable, Mapping

import numpy as np
import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact, slope, with_signs
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.paper.equations import Equations
from lagrangia.paper.rest_points import Begin, Point, Statics, point_given, point_of_rest, put
from lagrangia.paper.symbolic import Given, SymbolicScene
from lagrangia.study.linearization import pivots

Table = tuple[tuple[Expr, ...], ...]
_NOTHING = 1e-12
_SUPPORTS = ("coordinate", "support")


@dataclass(frozen=True)
class Reduced:
    """Without multipliers: `independent` are the coordinates x that are left, `follow` all coordinates as they follow."""

    independent: tuple[int, ...]
    follow: tuple[Expr, ...]  # in the symbols of q and of what is given
    M: Table
    C: Table
    K: Table
    load: tuple[Expr, ...]


@dataclass(frozen=True)
class Linear:
    """At the point: M, C, K (n x n), the load (n,), with the constant part that is left where it is no equilibrium, J (m x n) of
    the coordinates (holonomic rows) or their rates, and e (m,). `resting`: where given displacements stand."""

    point: tuple[Expr, ...]
    multipliers: tuple[Expr, ...]
    is_numeric: bool  # found with the parameters' values, which are put in
    is_equilibrium: bool
    M: Table
    C: Table
    K: Table
    load: tuple[Expr, ...]
    J: Table
    pushed: tuple[Expr, ...]
    resting: Mapping[Expr, Expr]
    varies: bool  # whether coefficients change with time but for the standstill
    reduced: Reduced | None


def linearize(e: Equations, numbers: Mapping[Expr, float], begin: Callable[[], Begin], given: Mapping[str, float] | None = None
              ) -> Linear:
    """About `given` (coordinates by name), or else about an equilibrium.

    `numbers` are the parameters' values: of several equilibria a stable one is taken, and one that no formula gives is found by
    Newton's method from where `begin` says. Given loads are zero there, given displacements what they are without their part in
    time. Raises LagError L0912 for what is not supported yet, L0713 without equilibrium.
    """
    s = _Small(e)
    statics = s.statics()
    point = point_of_rest(statics, numbers, begin) if given is None else point_given(statics, given, numbers, begin)
    values = {x: exact(v) for x, v in numbers.items()} if point.is_numeric else {}
    return _Linearizer(s, statics, point, values, numbers).linear(begin)


class _Small:
    """The equations with what is given told apart: supports by their symbols, loads and inputs by theirs."""

    def __init__(self, e: Equations) -> None:
        self.e, self.scene = e, e.scene
        self.supports = [g for g in self.scene.given if g.what in _SUPPORTS and g.value.has(self.scene.t)]
        self.resting = {g.symbol: _mean(g.value, self.scene) for g in self.supports}
        self.still = dict.fromkeys((x for g in self.supports for x in g.moving[1:]), sp.S.Zero)
        parts = (*e.h, *e.f, *e.rows, *(x for table in (e.M, e.J) for row in table for x in row))
        for g in self.supports:
            first = slope(g.value, self.scene.t)
            if not first.has(self.scene.t) and not any(x.has(g.symbol) for x in parts):
                self.still[g.rate] = first  # a frame that turns steadily keeps turning
        self.loads = [*self.scene.inputs.values(),
                      *(x for g in self.scene.given if g.value.has(self.scene.t) and g not in self.supports for x in g.moving)]
        self.force = tuple(e.ring.tidy(h - f) for h, f in zip(e.h, e.f, strict=True))
        self._require_autonomous(parts)

    def _require_autonomous(self, parts: tuple[Expr, ...]) -> None:
        span = self.scene.kinematics.graph.model.span
        if any(put(x, dict.fromkeys(self.loads, sp.S.Zero)).has(self.scene.t) for x in parts):
            fail("L0912", "not supported yet: the linear form of a scene in whose equations time stands by itself", span,
                 "give what moves a frame or variable of its own: shift(world, {0.1*sin(time), 0})")
        for row in self.e.rows[self.scene.holonomic :]:
            if self.at_rest(row) != 0:
                fail("L0713", "nothing can rest here: a constraint prescribes a speed", span)

    def quiet(self, x: Expr) -> Expr:
        """Supports at rest; steady ones as they turn."""
        return self.e.ring.tidy(put(x, self.resting | self.still)) if self.supports else x

    def at_rest(self, x: Expr) -> Expr:
        """Without rates and loads, too."""
        return self.e.ring.tidy(put(self.quiet(x), dict.fromkeys((*self.scene.v, *self.loads), sp.S.Zero)))

    def statics(self) -> Statics:
        rows = tuple(self.at_rest(x) for x in self.e.rows[: self.scene.holonomic])
        J = tuple(tuple(self.at_rest(x) for x in row) for row in self.e.J)
        return Statics(self.e, tuple(map(self.at_rest, self.force)), rows, J)


def _mean(value: Expr, scene: SymbolicScene) -> Expr:
    """Where a support stands: the part of its motion that does not depend on time."""
    return sp.expand(value).as_independent(scene.t, as_Add=True)[0]


class _Linearizer:
    def __init__(self, s: _Small, statics: Statics, point: Point, values: Mapping[Expr, Expr], numbers: Mapping[Expr, float]
                 ) -> None:
        self.s, self.e, self.scene, self.statics, self.point = s, s.e, s.scene, statics, point
        self.numbers = numbers
        self.here = {**dict(zip(self.scene.q, point.q, strict=True)), **values}
        self.here |= dict(zip(self.e.multipliers, point.multipliers, strict=True))

    def at(self, x: Expr) -> Expr:
        """At the point, at rest; loads stay."""
        still = dict.fromkeys(self.scene.v, sp.S.Zero)
        x = put(self.e.ring.tidy(self.s.quiet(x)), self.here | still)
        return self.e.ring.tidy(_evaluated(x, self.point.is_numeric))

    def linear(self, begin: Callable[[], Begin]) -> Linear:
        e, scene, at = self.e, self.scene, self.at
        balance = self.statics.balance
        M = self._table((at(x) for x in row) for row in e.M)
        C = self._table((at(e.ring.slope(x, v)) for v in scene.v) for x in self.s.force)
        K = self._table((at(e.ring.slope(x, q)) for q in scene.q) for x in balance)
        J = self._table((at(x) for x in row) for row in e.J)
        bends = any(self._jumps(x) for rows in (e.M, e.J, [[e.ring.slope(x, q) for q in scene.q] for x in balance])
                    for row in rows for x in row)
        if bends or any(x.has(sp.nan, sp.zoo, sp.oo) for row in (*M, *C, *K, *J) for x in row):
            fail("L0713", "the forces have no slope at the point to linearise about", self.statics.span,
                 "give another: --about NAME=VALUE,...")
        is_still = all(e.ring.is_zero(put(x, self.here)) or self._is_small(put(x, self.here)) for x in balance)
        rest = [at(x) for x in balance]
        (pushed,) = self._table([[e.ring.tidy(-self._moved(row)) for row in e.rows]])
        held = [f + sum((lam * row[k] for lam, row in zip(e.multipliers, e.J, strict=True)), sp.S.Zero)
                for k, f in enumerate(self.s.force)]
        (load,) = self._table([[e.ring.tidy(-at(x) - self._moved(x) + (r if is_still else 0))
                                for x, r in zip(held, rest, strict=True)]])
        reduced = self._reduced(M, C, K, load, J, pushed, begin) if J and scene.holonomic == len(J) else None
        return Linear(self.point.q, self.point.multipliers, self.point.is_numeric, is_still, M, C, K, load, J, pushed,
                      self.s.resting, self._varies(held), reduced)

    def _jumps(self, x: Expr) -> bool:
        """Whether a sign of places makes a coefficient jump at the point: s/|s| and sgn s at s = 0, but not s sgn s."""
        x = with_signs(self.s.at_rest(x))
        zero = {u: sp.Dummy() for u in x.atoms(sp.sign) if put(u.args[0], self.here) == 0}
        if not zero:
            return False
        here = put(x.xreplace(zero), self.here)
        return any(sp.simplify(here.diff(y)) != 0 for y in zero.values())

    def _varies(self, held: list[Expr]) -> bool:
        """Whether supports that do not turn steadily, loads or inputs stand in coefficients at the point."""
        supports = [x for g in self.s.supports for x in g.moving]
        driven = {*self.s.loads, *(x for x in supports if self.s.still.get(x, 0) == 0)}
        here = self.here | dict.fromkeys(self.scene.v, sp.S.Zero)
        tables = [row for table in (self.e.M, self.e.J) for row in table]
        for x in (x for x in held if x.free_symbols & driven):
            tables.append(tuple(self.e.ring.slope(x, y) for y in (*self.scene.q, *self.scene.v)))
        return any(put(x, here).free_symbols & driven for row in tables for x in row if x.free_symbols & driven)

    def _moved(self, x: Expr) -> Expr:
        """What supports do, to first order: dx/dg g + dx/dg' g' + dx/dg'' g'', g the deviation."""
        pairs = [(y, y - self.s.still[y] if y in self.s.still else y) for g in self.s.supports for y in g.moving]
        quiet = dict.fromkeys(self.s.loads, sp.S.Zero)
        slope = self.e.ring.slope
        return sum((self.at(slope(x, y).xreplace(quiet)) * deviation for y, deviation in pairs if x.has(y)), sp.S.Zero)

    def _is_small(self, x: Expr) -> bool:
        value = sp.N(x.subs(list(self.numbers.items())))
        return bool(value.is_number and abs(complex(value)) < 1e-9)

    # ------------------------------------------------------------ without multipliers

    def _reduced(self, M: Table, C: Table, K: Table, load: tuple[Expr, ...], J: Table, pushed: tuple[Expr, ...],
                 begin: Callable[[], Begin]) -> Reduced | None:
        """None where no closed form of a few terms solves the constraints."""
        first, tidy = begin(), self.e.ring.tidy
        table = np.array([[float(x.subs(list(self.numbers.items()))) for x in row] for row in J])
        columns = pivots(table, first.reach * np.where(first.is_preferred, 0.1, 1.0))
        rows = pivots(table[:, columns].T, np.ones(len(J)))
        n, free = len(self.scene.q), [k for k in range(len(self.scene.q)) if k not in columns]
        if len(rows) != len(columns) or not free:
            return None
        inverse = sp.Matrix([[J[i][k] for k in columns] for i in rows]).inv() if columns else sp.zeros(0)
        inverse = inverse.applyfunc(lambda x: tidy(sp.cancel(x)))
        N, X = sp.zeros(n, len(free)), sp.zeros(n, 1)
        for place, k in enumerate(free):
            N[k, place] = 1
        across = -inverse * sp.Matrix([[J[i][k] for k in free] for i in rows])
        shift = inverse * sp.Matrix([pushed[i] for i in rows])
        for place, k in enumerate(columns):
            N[k, :], X[k] = across[place, :], shift[place]
        rates = [self.scene.time_rate(x) for x in X]
        second = [self.scene.time_rate(x) for x in rates]
        right = sp.Matrix(load) - sp.Matrix(M) * sp.Matrix(second) - sp.Matrix(C) * sp.Matrix(rates) - sp.Matrix(K) * X

        def small(A: sp.MatrixBase) -> Table:
            return self._table((self.e.ring.tidy(x) for x in row) for row in (N.T * A * N).tolist())

        follow = N * sp.Matrix([self.scene.q[k] for k in free]) + X
        (loads,) = self._table([map(tidy, N.T * right)])
        (all_,) = self._table([map(tidy, follow)])
        return Reduced(tuple(free), all_, small(sp.Matrix(M)), small(sp.Matrix(C)), small(sp.Matrix(K)), loads)

    def _table(self, rows: Iterable[Iterable[Expr]]) -> Table:
        """Of numbers what rounding has left, against the largest, goes."""
        table = tuple(tuple(row) for row in rows)
        if not self.point.is_numeric:
            return table
        parts = [[[term.as_coeff_Mul() for term in sp.Add.make_args(x)] for x in row] for row in table]
        least = _NOTHING * max((abs(float(c)) for row in parts for terms in row for c, _ in terms), default=0.0)
        return tuple(tuple(sp.Add(*(sp.Rational(f"{float(c):.13g}") * rest for c, rest in terms if abs(float(c)) > least))
                           for terms in row) for row in parts)


def _evaluated(x: Expr, wholly: bool) -> Expr:
    """Sines and cosines of numbers as numbers, but for fractions of pi, which are exact already; `wholly` all else, too."""
    kinds = (sp.Function, sp.Pow) if wholly else (sp.sin, sp.cos)
    return x.xreplace({f: exact(float(f)) for f in x.atoms(*kinds) if f.is_number and f.is_real and f.is_finite})


__all__ = ["Begin", "Given", "Linear", "Reduced", "linearize"]
