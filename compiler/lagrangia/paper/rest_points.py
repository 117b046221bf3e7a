"""Where equations are linearised: a position of rest in closed form where there is one, else in numbers.

    R(q) + J(q)^T lambda = 0,   Phi(q) = 0        (R: the forces at rest, without what drives the scene)

Angles are tried at quarter turns, the other unknowns then follow from linear equations.
"""

from collections.abc import Callable, Mapping
from itertools import product as combinations
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lagrangia.algebra.with_sympy import Expr, exact, slope
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.dynamics.equilibrium import Rest, StaticEquations, find_rest, onto_constraints, starts
from lagrangia.paper.equations import Equations

Vector = NDArray[np.float64]
_MOST_ANGLES, _MOST_STARTS = 5, 40
_TRIED = (sp.S.Zero, -sp.pi / 2, sp.pi / 2, sp.pi)
_NEAR, _SMALL = 1e-7, 1e-9


@dataclass(frozen=True)
class Begin:
    """Where the search begins: coordinates, their natural sizes, which go round, which the model starts itself."""

    q: Vector
    reach: Vector
    is_angle: NDArray[np.bool_]
    is_preferred: tuple[bool, ...]


@dataclass(frozen=True)
class Point:
    """Coordinates and multipliers. `is_numeric`: found with the parameters' values."""

    q: tuple[Expr, ...]
    multipliers: tuple[Expr, ...]
    is_numeric: bool


@dataclass(frozen=True)
class Statics:
    """`forces` (n,) at rest without multipliers, `rows` (holonomic), `J` (m, n): all without what drives the scene."""

    equations: Equations
    forces: tuple[Expr, ...]
    rows: tuple[Expr, ...]
    J: tuple[tuple[Expr, ...], ...]

    @property
    def balance(self) -> tuple[Expr, ...]:
        """R + J^T lambda."""
        lam = self.equations.multipliers
        return tuple(r + sum((x * row[k] for x, row in zip(lam, self.J, strict=True)), sp.S.Zero)
                     for k, r in enumerate(self.forces))

    @property
    def span(self) -> Any:
        """Where the model stands."""
        return self.equations.scene.kinematics.graph.model.span


def point_of_rest(s: Statics, numbers: Mapping[Expr, float], begin: Callable[[], Begin]) -> Point:
    """Raises LagError L0713 where nothing rests."""
    if s.J:
        return _held_point(s, numbers, begin())
    turning = _turning(s)
    found: list[tuple[Expr, ...]] = []
    if len(turning) <= _MOST_ANGLES:
        for angles in _promising(s, turning, numbers):
            point = _completed(s, dict(zip(turning, angles, strict=True)))
            if point is not None:
                found.append(point)
                if _is_stable(s, point, numbers):
                    return Point(point, (), False)
    if found:
        return Point(found[0], (), False)
    return Point(_rounded(_found(s, numbers, begin()).q), (), True)


def _found(s: Statics, numbers: Mapping[Expr, float], begin: Begin) -> Rest:
    rest = find_rest(_numeric(s, numbers, begin), begin.q)
    if rest is None:
        hints = [] if s.J else ["give a point: --about NAME=VALUE,..."]
        fail("L0713", "no equilibrium was found to linearise about", s.span, "sought from the start values, loads that depend on "
             "time left away", *hints)
    return rest


def _rounded(values: Vector) -> tuple[Expr, ...]:
    size = max(1.0, float(np.abs(values).max(initial=0.0)))
    return tuple(exact(x) if abs(x) > 1e-12 * size else sp.S.Zero for x in map(float, values))


def _turning(s: Statics) -> list[Expr]:
    """Coordinates that stand in sines and cosines."""
    waves = {w for x in (*s.balance, *s.rows) for w in x.atoms(sp.sin, sp.cos)}
    inside = {y for w in waves for y in w.free_symbols}
    return [x for x in s.equations.scene.q if x in inside]


# -------------------------------------------------------------------- without constraints


def _promising(s: Statics, turning: list[Expr], numbers: Mapping[Expr, float]) -> list[tuple[Expr, ...]]:
    """Those quarter turns at which the forces vanish with the parameters' values, as far as numbers can tell."""
    q = s.equations.scene.q
    others = [x for x in q if x not in turning]
    values = [f.subs(list(numbers.items())) for f in s.forces]
    if any(f.has(sp.zoo, sp.nan, sp.oo, -sp.oo) for f in values):
        fail("L0713", "the forces have no finite value with the parameters as they are", s.span, "look at what is divided by")
    force = sp.lambdify([turning, others], values, "numpy")
    slopes = sp.lambdify([turning, others], [[s.equations.ring.tidy(slope(f, x)) for x in others] for f in values], "numpy")
    nothing, found = np.zeros(len(others)), []
    for angles in combinations(_TRIED, repeat=len(turning)):
        at = [float(x) for x in angles]
        try:
            with np.errstate(all="ignore"):
                f, A = np.array(force(at, nothing), float), np.array(slopes(at, nothing), float).reshape(len(q), len(others))
                is_finite = np.isfinite(f).all() and np.isfinite(A).all()
                x = np.linalg.lstsq(A, -f, rcond=None)[0] if others and is_finite else nothing
                left = float(np.abs(np.array(force(at, x), dtype=float)).max(initial=0.0))
        except (TypeError, ZeroDivisionError):
            is_finite = False
        if not is_finite or left <= 1e-6 * max(1.0, float(np.abs(f).max(initial=0.0))):
            found.append(angles)  # where there are no numbers SymPy is asked
    return found


def _completed(s: Statics, angles: Mapping[Expr, Expr]) -> tuple[Expr, ...] | None:
    e = s.equations
    others = [x for x in e.scene.q if x not in angles]
    left = [e.ring.tidy(put(f, angles)) for f in s.forces]
    values: dict[Expr, Expr] = {}
    if others:
        A = sp.Matrix([[slope(f, x) for x in others] for f in left])
        if any(entry.free_symbols & set(e.scene.q) for entry in A):
            return None
        free = [x for k, x in enumerate(others) if any(A[:, k])]
        values = dict.fromkeys((x for x in others if x not in free), sp.S.Zero)
        solved = sp.solve([f for f in left if f.free_symbols & set(free)], free, dict=True) if free else [{}]
        if not solved or not isinstance(solved[0], dict):
            return None
        values |= {x: solved[0].get(x, sp.S.Zero).subs(dict.fromkeys(free, 0)) for x in free}
    whole = {**angles, **values}
    return tuple(whole[x] for x in e.scene.q) if all(_vanishes(e, put(f, whole)) for f in left) else None


def _vanishes(e: Equations, x: Expr) -> bool:
    return e.ring.is_zero(sp.together(x)) or sp.simplify(x) == 0


def _is_stable(s: Statics, point: tuple[Expr, ...], numbers: Mapping[Expr, float]) -> bool:
    q = s.equations.scene.q
    here = list(zip(q, point, strict=True))
    K = sp.Matrix([[slope(f, x).subs(here).subs(list(numbers.items())) for x in q] for f in s.forces])
    if any(not entry.is_number for entry in K):
        return False
    return all(float(sp.re(x)) >= -_SMALL for x in sp.Matrix((K + K.T) / 2).evalf().eigenvals(multiple=True))


# -------------------------------------------------------------------- with constraints


def _numeric(s: Statics, numbers: Mapping[Expr, float], begin: Begin) -> StaticEquations:
    q, lam = list(s.equations.scene.q), list(s.equations.multipliers)
    known = {x: sp.Float(value, 17) for x, value in numbers.items()}
    R, rows = ([x.xreplace(known) for x in group] for group in (s.forces, s.rows))
    J = [[x.xreplace(known) for x in row] for row in s.J]
    K = [[s.equations.ring.slope(x, y).xreplace(known) for y in q] for x in s.balance]
    n, m, holonomic = len(q), len(lam), len(rows)
    forces, places, held, stiff = (sp.lambdify([q, lam], x, "numpy") for x in (R, rows, J, K))

    def static(x: Vector) -> tuple[Vector, Vector, float]:
        return np.array(forces(x, np.zeros(m)), float).ravel(), np.array(places(x, np.zeros(m)), float).reshape(holonomic), 0.0

    def stiffness(x: Vector, multipliers: Vector) -> tuple[Vector, Vector, Vector]:
        pushed = multipliers if multipliers.size else np.zeros(m)
        table = np.array(held(x, pushed), float).reshape(m, n)
        return np.array(stiff(x, pushed), float).reshape(n, n), table[:holonomic], table

    return StaticEquations(static, stiffness, begin.reach, begin.is_angle)


def _held_point(s: Statics, numbers: Mapping[Expr, float], begin: Begin) -> Point:
    rest = _found(s, numbers, begin)
    return _recognised(s, rest.q, numbers) or Point(_rounded(rest.q), _rounded(rest.multipliers), True)


def _recognised(s: Statics, q: Vector, numbers: Mapping[Expr, float]) -> Point | None:
    """The closed form of a point found in numbers, where its angles are quarter turns and the rest is linear."""
    e, turning = s.equations, _turning(s)
    quarters = [round(2 * float(x) / np.pi) for x in q]
    angles = {x: quarters[k] * sp.pi / 2 for k, x in enumerate(e.scene.q) if x in turning}
    if any(abs(q[k] - quarters[k] * np.pi / 2) > _NEAR for k, x in enumerate(e.scene.q) if x in turning):
        return None
    unknowns = [x for x in e.scene.q if x not in angles] + list(e.multipliers)
    left = [e.ring.tidy(put(x, angles)) for x in (*s.rows, *s.balance)]
    if any(x.diff(y).free_symbols & set(unknowns) for x in left for y in unknowns):
        return None
    solved = sp.solve([x for x in left if x != 0], unknowns, dict=True)
    if len(solved) != 1:
        return None
    free = dict.fromkeys(unknowns, sp.S.Zero)
    whole = angles | {x: solved[0].get(x, sp.S.Zero).subs(free) for x in unknowns}
    if not all(_vanishes(e, put(x, whole)) for x in left):
        return None
    found = tuple(whole[x] for x in e.scene.q)
    again = [float(x.subs(list(numbers.items()))) for x in found]
    return Point(found, tuple(whole[x] for x in e.multipliers), False) if np.allclose(again, q, atol=1e-6) else None


def point_given(s: Statics, given: Mapping[str, float], numbers: Mapping[Expr, float], begin: Callable[[], Begin]) -> Point:
    """The coordinates given, the others 0; where constraints hold, the others as near to the start as they allow.

    Raises LagError L0713 where no position has these coordinates, L0912 where constraints hold and nothing rests there.
    """
    names = s.equations.scene.names
    if not s.J:
        return Point(tuple(exact(given.get(name, 0.0)) for name in names), (), False)
    first = begin()
    q = np.array([given.get(name, x) for name, x in zip(names, first.q, strict=True)])
    equations = _numeric(s, numbers, first)
    is_free = np.array([name not in given for name in names])
    guesses = (np.where(is_free, x, q) for x in starts(equations, q, _MOST_STARTS))
    places = (x for x in (onto_constraints(equations, guess, is_free) for guess in guesses) if x is not None)
    is_possible = False
    for place in places:
        is_possible = True
        R, _, _ = equations.static(place)
        _, _, rows = equations.stiffness(place, np.zeros(0))
        lam = -np.linalg.pinv(rows.T, rcond=_SMALL) @ R
        if np.abs(R + rows.T @ lam).max(initial=0.0) <= 1e-8 * max(1.0, float(np.abs(R).max(initial=0.0))):
            return Point(_rounded(place), _rounded(lam), True)
    if is_possible:
        fail("L0912", "not supported yet: the linear form of a scene with constraints about a point that is no equilibrium",
             s.span, "leave --about away: the equilibrium is found")
    fail("L0713", "the constraints cannot hold at the point that --about gives", s.span,
         "give fewer coordinates: the others follow from the constraints")


def put(x: Expr, values: Mapping[Expr, Expr]) -> Expr:
    """An expression with values for some symbols."""
    return x.xreplace(dict(values)) if values else x
