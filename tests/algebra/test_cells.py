"""Elements of columns that go into other columns without having been looked up."""

import casadi as ca
import pytest

from lagrangia.algebra.scalars import Cell, Expression, cells, column, scalars_in, symbol

a, b, z = ca.SX.sym("a", 12), ca.SX.sym("b", 3, 4), symbol("z")


def are_same(found: ca.SX, expected: list[ca.SX]) -> bool:
    return found.shape == (len(expected), 1) and found.is_dense() and all(
        ca.is_equal(found[k], x) for k, x in enumerate(expected))


def test_columns_are_made_of_what_others_hold() -> None:
    own, others = cells(a), cells(b)
    assert are_same(column(*own[2:11]), [a[k] for k in range(2, 11)])
    mixed = [own[3], others[0], z, own[3], 2.5, others[11], own[0], others[4]]
    assert are_same(column(*mixed), [a[3], b[0], z, a[3], ca.SX(2.5), b[11], a[0], b[4]])
    assert are_same(column(*others[:11], *own[:11]), [*b.elements()[:11], *a.elements()[:11]])
    assert are_same(column(*own[:7], others[9]), [*a.elements()[:7], b.elements()[9]])
    assert {type(x) for x in (*own, *others)} == {Cell}  # nobody looked
    assert are_same(column(1.0, 0.0, -0.0, *range(6)), [ca.SX(x) for x in (1.0, 0.0, -0.0, *range(6))])


@pytest.mark.parametrize("asked", [1, 12])
def test_what_is_done_with_one_alone_is_done_with_the_element(asked: int) -> None:
    own = cells(a)
    for k in range(asked):
        assert ca.is_equal(own[k] * z + own[-1], a[k] * z + a[11], 3)
    assert type(own[0]) is Expression and own[0].element_hash() == a[0].element_hash()
    assert are_same(column(*own), a.elements())


def test_zeros_are_numbers() -> None:
    found = scalars_in(ca.vertcat(a[:4], 0, -0.0, a[5], 1, 0, a[6]))
    assert [x if isinstance(x, float) else None for x in found] == [None] * 4 + [0.0, 0.0, None, None, 0.0, None]
    assert are_same(column(*found[:4], *found[6:8], found[9]), [*a[:4].elements(), a[5], ca.SX(1), a[6]])
