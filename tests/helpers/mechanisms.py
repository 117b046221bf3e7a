"""Mechanisms of one degree of freedom on paper: every position written as a function of one angle, by hand.

With the weighted positions X_i(phi) of the kinetic energy T = sum w_i X_i'^2/2, a potential V and a generalised force Q:

    M(phi) phi'' + M'(phi) phi'^2/2 + V'(phi) = Q,      M = sum_i w_i (dX_i/dphi)^2

Nothing here knows of Lagrangia.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from helpers.reference import Array, integrate

g = 9.81
phi = sp.Symbol("phi", real=True)
Point = tuple[sp.Expr, sp.Expr]


@dataclass
class Mechanism:
    """Bodies whose places are functions of `phi`, and what acts on them."""

    gravity: float = g
    force: float = 0.0  # on phi
    potential: sp.Expr = field(default_factory=lambda: sp.Integer(0))
    weighted: list[tuple[float, sp.Expr]] = field(default_factory=list)

    def point(self, m: float, place: Point) -> None:
        self.weighted += [(m, place[0]), (m, place[1])]
        self.potential += m * self.gravity * place[1]

    def bar(self, m: float, a: Point, b: Point) -> None:
        """Uniform, from a to b: I = m L^2/12."""
        self.point(m, middle(a, b))
        self.turning(m / 12, a, b)

    def turning(self, weight: float, a: Point, b: Point) -> None:
        """The inertia I = weight L^2 of a body on which a and b are L apart: L theta' = |(b - a)'|."""
        self.weighted += [(weight, b[0] - a[0]), (weight, b[1] - a[1])]

    def motion(self, times: Array, start: float, rate: float = 0.0) -> tuple[Array, Array]:
        """phi and phi' at the times."""
        weights = np.array([w for w, _ in self.weighted])
        slopes = _slopes([X for _, X in self.weighted], self.potential)

        def acceleration(t: float, q: Array, v: Array) -> Array:
            first, second, slope = slopes(q[0])
            X1, X2 = np.array(first, dtype=float), np.array(second, dtype=float)
            return np.array([(self.force - slope - weights @ (X1 * X2) * v[0] ** 2) / (weights @ X1**2)])

        q, v = integrate(acceleration, [start], [rate], times)
        return q[0], v[0]


def _slopes(places: Sequence[sp.Expr], potential: sp.Expr) -> Callable[[float], tuple[list[float], list[float], float]]:
    """phi -> X', X'', V', differentiated step by step: written out, the positions of a long mechanism would be endless."""
    program, results = sp.cse([*places, potential])
    slope_of: dict[sp.Symbol, sp.Symbol] = {}

    def slope(expression: sp.Expr) -> sp.Expr:
        inner = [s for s in expression.free_symbols if s in slope_of]
        return sp.diff(expression, phi) + sum(sp.diff(expression, s) * slope_of[s] for s in inner)

    def extend(steps: Sequence[tuple[sp.Symbol, sp.Expr]]) -> None:
        for symbol, expression in steps:
            program.append((sp.Symbol(f"d{symbol.name}"), slope(expression)))
            slope_of[symbol] = program[-1][0]

    n = len(program)
    extend(program[:n])
    *first, force = map(slope, results)
    extend(program[n:])
    second = list(map(slope, first))
    return sp.lambdify(phi, [first, second, force], cse=lambda expressions: (program, expressions))


def polar(r: float, angle: sp.Expr, origin: Sequence[sp.Expr | float] = (0, 0)) -> Point:
    return origin[0] + r * sp.cos(angle), origin[1] + r * sp.sin(angle)


def middle(a: Point, b: Point) -> Point:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2


def meet(a: Sequence[sp.Expr | float], r_a: float, b: Sequence[sp.Expr | float], r_b: float) -> Point:
    """Where circles about a and b meet: the point to the left of the way from a to b."""
    x, y = b[0] - a[0], b[1] - a[1]
    square = x**2 + y**2
    along = (r_a**2 - r_b**2 + square) / (2 * square)
    across = sp.sqrt(r_a**2 / square - along**2)
    return a[0] + along * x - across * y, a[1] + along * y + across * x


def four_bar(masses: Sequence[float], lengths: Sequence[float], gravity: float = g) -> tuple[Mechanism, Point]:
    """Crank, coupler and rocker between the bearings (0, 0) and (ground, 0), and the end of the coupler.

    lengths: crank, coupler, rocker, ground; phi is the crank's angle.
    """
    crank, coupler, rocker, ground = lengths
    a = polar(crank, phi)
    b = meet(a, coupler, (ground, 0), rocker)
    mechanism = Mechanism(gravity)
    for m, begin, end in zip(masses, ((0, 0), a, (ground, 0)), (a, b, b), strict=True):
        mechanism.bar(m, begin, end)
    return mechanism, b


def at(expressions: Mapping[str, sp.Expr], angles: Array) -> dict[str, Array]:
    """Functions of phi in numbers."""
    return {name: sp.lambdify(phi, expression)(angles) * np.ones_like(angles) for name, expression in expressions.items()}
