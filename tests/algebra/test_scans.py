"""Recursions that are stamped out are what they are step by step."""

import casadi as ca
import pytest

from lagrangia.algebra import scans
from lagrangia.algebra.duals import Scalar, plus, times
from lagrangia.algebra.scalars import symbol
from lagrangia.algebra.scans import scan


def step(state: list[Scalar], inputs: list[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
    """Of a sum and a product; results that are computed, taken from the inputs, and numbers."""
    total, product = state
    x, y = inputs
    total, product = plus(total, times(x, y)), times(product, x)
    return [total, product], [plus(total, product), y, 2.0, times(total, 0.0)]


def many(kind: str, count: int) -> list[list[Scalar]]:
    ys = {"alike": lambda k: symbol(f"y{k}"), "numbers": lambda k: 0.5, "all different": float,
          "of two kinds": lambda k: 3.0 if k > count//2 else symbol(f"y{k}")}[kind]
    return [[symbol(f"x{k}"), ys(k)] for k in range(count)]


@pytest.mark.parametrize("kind", ["alike", "numbers", "of two kinds", "all different"])
@pytest.mark.parametrize("begin", [0.0, 1.0, None])
def test_what_is_stamped_out_is_the_same(kind: str, begin: float | None, monkeypatch: pytest.MonkeyPatch) -> None:
    inputs = many(kind, 100)
    start: list[Scalar] = [symbol("s") if begin is None else begin, symbol("p")]
    made = scan(step, start, inputs)
    monkeypatch.setattr(scans, "_FEWEST", 1000)
    plain = scan(step, start, inputs)
    for found, exact in zip((made[0], *made[1]), (plain[0], *plain[1]), strict=True):
        assert [isinstance(x, ca.SX) for x in found] == [isinstance(x, ca.SX) for x in exact]
        for x, y in zip(found, exact, strict=True):
            assert ca.is_equal(ca.SX(x), ca.SX(y), 300)


def test_few_calls_are_made_for_many(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = 0

    def counted(state: list[Scalar], inputs: list[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        nonlocal calls
        calls += 1
        return step(state, inputs)

    scan(counted, [0.0, symbol("p")], many("alike", 500))
    assert calls <= 3
