"""The normal form: equal expressions have equal ones, and the way back changes nothing."""

import random

import pytest
import sympy as sp
from sympy import cos, pi, sin, sqrt

from lagrangia.algebra.normal_form import Ring, TooLarge
from lagrangia.algebra.with_sympy import exact

a, b, x, y, L = sp.symbols("a b x y L", real=True)
k = sp.Symbol("k", nonnegative=True)

IDENTITIES = [
    (sin(a) ** 2 + cos(a) ** 2, 1),
    (cos(a) * cos(a + b) + sin(a) * sin(a + b), cos(b)),
    ((L * cos(a) + x) ** 2 + (L * sin(a)) ** 2, L**2 + 2 * L * x * cos(a) + x**2),
    (sin(a + pi / 2), cos(a)),
    (sin(2 * a), 2 * sin(a) * cos(a)),
    (cos(a - pi / 3), cos(a) / 2 + sqrt(3) * sin(a) / 2),
    (sqrt(x**2 + y**2) ** 3, (x**2 + y**2) * sqrt(x**2 + y**2)),
    (1 / (x + y) * (x + y) ** 2, x + y),
    (sin(a) ** 3, 3 * sin(a) / 4 - sin(3 * a) / 4),
    (sqrt(k**2), k),
    ((1 + sqrt(3)) ** 2, 4 + 2 * sqrt(3)),
    ((sqrt(2) * x + y) ** 3 * cos(a) ** 2 / (2 * sqrt(2)), (x + sqrt(2) * y / 2) ** 3 * (1 + cos(2 * a)) / 2),
    (1 / (1 / (sqrt(2) * x)) ** 2, 2 * x**2),
]


@pytest.mark.parametrize(("left", "right"), IDENTITIES, ids=str)
def test_equal_expressions_have_one_normal_form(left: sp.Expr, right: sp.Expr) -> None:
    ring = Ring(10**4)
    difference = sp.sympify(left) - right
    if difference.has(pi, sqrt(3)):  # a shift by pi/3 stays a shift
        assert abs(float(difference.subs({a: 0.7}))) < 1e-14
    else:
        assert ring.is_zero(difference)


def test_what_differs_does_not_vanish() -> None:
    ring = Ring(10**4)
    assert not ring.is_zero(sin(a) ** 2 - cos(a) ** 2)
    assert not ring.is_zero(sqrt(x**2) - x)


def test_random_expressions_keep_their_values() -> None:
    """Sums, products, powers, roots and waves of depth four, at random points."""
    source = random.Random(3)

    def grow(depth: int) -> sp.Expr:
        if depth == 0:
            return source.choice([a, b, x, L, k, sp.Rational(source.randint(-4, 4), 3)])
        one, other = grow(depth - 1), grow(depth - 1)
        return source.choice([one + other, one * other, one - other, one**2, sin(a + source.randint(-2, 2) * b + pi / 4) * one,
                              cos(source.randint(1, 3) * a) * other, sqrt(one**2 + 1), other / (1 + one**2), sp.Abs(one),
                              sp.tan(x / 9)])

    for _ in range(120):
        whole = grow(4)
        tidy = Ring(10**6).tidy(whole)
        point = {s: source.uniform(0.3, 1.1) for s in (a, b, x, L, k)}
        wanted, found = complex(whole.subs(point)), complex(sp.sympify(tidy).subs(point))
        assert abs(found - wanted) <= 1e-9 * max(1.0, abs(wanted)), whole


def test_the_work_is_bounded() -> None:
    with pytest.raises(TooLarge):
        Ring(1000).series((a + b + x + y + L + k + 1) ** 12)


def test_numbers_are_those_that_were_meant() -> None:
    assert exact(0.1) == sp.Rational(1, 10)
    assert exact(1 / 3) == sp.Rational(1, 3)
    assert exact(5 * 3.141592653589793 / 180) == pi / 36
    assert exact(90 * 3.141592653589793 / 180) == pi / 2
    assert exact(36.35 * 0.001) == sp.Rational("0.03635")
    assert abs(float(exact(0.2226683901658858)) - 0.2226683901658858) < 1e-16
    assert exact(-2.0) == -2
