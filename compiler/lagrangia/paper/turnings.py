"""Attitudes by their unit quaternions, for people: Q' = Q (0, w)/2, and what small turns about turned axes change (G. Hamel).

For rates w that are no derivatives of coordinates Lagrange's equations become Euler's, d/dt dT/dw + w x dT/dw = d(T - V)/da + M,
where a are small turns about the axes of w (Hamel 1904). In the scene's lists of coordinates three places stand for them.
"""

from collections.abc import Collection, Iterable, Sequence

import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.records import dataclass
from lagrangia.frames.quaternions import conjugate, quaternion_product

_RATES, _PARTS = ("w", "omega", "Omega"), ("Q", "q", "quaternion")


@dataclass(frozen=True)
class Turning:
    """An attitude. `parts`: of its unit quaternion, real part first; `first`: the place among the coordinates of the first of its
    three rates; `told` and `quaternion`: the names of rates and parts, before an index."""

    name: str
    parts: tuple[Expr, ...]
    first: int
    told: tuple[str, ...]
    quaternion: tuple[str, ...]

    @property
    def places(self) -> range:
        """Of its rates, among those of the scene."""
        return range(self.first, self.first + 3)

    def directions(self, axis: int) -> list[tuple[Expr, Expr]]:
        """(part, what it changes by): of a small turn about one of the turned axes."""
        return self.paced([sp.Integer(k == axis) for k in range(3)])

    def paced(self, w: Sequence[Expr]) -> list[tuple[Expr, Expr]]:
        """(part, its rate) at an angular velocity along the turned axes."""
        changes = quaternion_product(self.parts, (0.0, *(x / 2 for x in w)))
        return [(part, sp.sympify(change)) for part, change in zip(self.parts, changes, strict=True)]

    def crossed(self, w: Sequence[Expr], p: Sequence[Expr]) -> tuple[Expr, ...]:
        """w x p of all rates and momenta of a scene, at its own places."""
        w, p = ([x[k] for k in self.places] for x in (w, p))
        return tuple(w[i] * p[j] - w[j] * p[i] for i, j in ((1, 2), (2, 0), (0, 1)))

    def outward(self, along: Sequence[Expr]) -> tuple[Expr, ...]:
        """Components along the turned axes -> along those that these are turned against."""
        turned = quaternion_product(self.parts, (sp.S.Zero, *along))
        return tuple(sp.sympify(x) for x in quaternion_product(turned, conjugate(self.parts))[1:])


def turnings_of(attitudes: Iterable[str], positions: Sequence[str], taken: Collection[str]) -> tuple[Turning, ...]:
    """Of each attitude: tip.w1, tip.w2, tip.w3 and tip.Q1 to tip.Q4 of tip.S, if no quantity is called so."""
    found = []
    for name in attitudes:
        owner = name.rpartition(".")[0]
        before = f"{owner}." if owner else ""
        rates, quaternion = _names(before, _RATES, 3, taken), _names(before, _PARTS, 4, taken)
        parts = tuple(sp.Symbol(x, real=True) for x in quaternion)
        found.append(Turning(name, parts, positions.index(f"{name}.s[1]"), rates, quaternion))
    return tuple(found)


def _names(before: str, letters: Sequence[str], count: int, taken: Collection[str]) -> tuple[str, ...]:
    choices = [tuple(f"{before}{letter}{k}" for k in range(1, count + 1)) for letter in letters]
    return next((names for names in choices if not set(names) & set(taken)), choices[-1])
