"""Accelerations of one form in loops: which are found, where their numbers lie, and that no digit changes."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native import series_code as taylor
from lagrangia.native.build import find_compiler
from lagrangia.native.rolled import Constants, Loop, find_loops, needed, write_loop

# A row whose ends are free, each part with numbers of its own; what else acts on it.
ROW = """model Row
  parameter Integer n = 29; parameter Length a = 1;
  World world(gravity = {0, 0});
  Block mass[n](m = {1 + 0.1*sin(j) for j in 1:n}, each base = world, s(start = {a*sin(0.3*j) for j in 1:n}));
  Spring spring[n - 1](k = {50 + j for j in 1:n - 1}, stretch = {mass[j + 1].s - mass[j].s for j in 1:n - 1});
  %s
end Row;"""
PARTS = {
    "springs": "",
    "a wall": "Spring wall(k = 20, stretch = mass[11].s);",
    "second neighbours": "Spring far[n - 2](each k = 7, stretch = {mass[j + 2].s - mass[j].s for j in 1:n - 2});",
    "lengths": "Spring long[n - 1](each k = 3, stretch = {mass[j + 1].s - mass[j].s - 0.1*j*a for j in 1:n - 1});",
}


def chain(count: int) -> tuple[list[int], dict[int, str]]:
    """Accelerations of masses between springs: jets 1 .. count are positions."""
    statements, accelerations = {}, []
    for i in range(1, count + 1):
        left, right = 1000 + 10 * i, 1001 + 10 * i
        statements[left] = f"c[{2 * i}] * J({i - 1})[k]"
        statements[right] = f"J({left})[k] - c[{2 * i + 1}] * J({i})[k]"
        accelerations.append(right)
    return accelerations, statements


def test_like_neighbours_are_one_loop() -> None:
    (loop,) = find_loops(*chain(14))
    assert (loop.first, loop.count, loop.jets) == (0, 12, ((0, 1), (1, 1)))
    assert loop.statements == ("c0 * j0", "y0 - c1 * j1")
    assert loop.constants[0] == tuple(range(2, 26, 2))


def test_what_is_left_over_is_computed_one_by_one() -> None:
    accelerations, statements = chain(14)
    assert set(needed(accelerations[12:], statements)) == {1130, 1131, 1140, 1141}


def test_another_form_another_jet_or_too_few_end_a_loop() -> None:
    accelerations, statements = chain(30)
    statements[1101] += " + J(40)[k]"  # the tenth
    statements[1200] = "c[40] * J(3)[k]"  # the twentieth
    found = [(loop.first, loop.count) for loop in find_loops(accelerations, statements)]
    assert found == [(0, 8), (10, 8), (20, 8)]
    assert find_loops(*chain(7)) == []


def test_long_recursions_have_no_loops() -> None:
    """As the accelerations of a chain's links, each of which asks for the one before."""
    statements = {1001: "J(1)[k]"} | {1000 + i: f"J({999 + i})[k] + J({i})[k]" for i in range(2, 100)}
    assert find_loops(list(statements), statements) == []


def test_numbers_that_follow_each_other_are_kept_once() -> None:
    constants = Constants()
    assert constants.row([4, 6, 8, 10]) == 0
    assert constants.row([6, 8, 10, 12]) == 1  # goes on
    assert constants.row([4, 6]) == 0
    assert constants.row([8, 6]) == 5
    assert constants.row([10, 12, 14]) == 7  # others stand behind those that are there
    assert constants.renamed("c[6] * J(1)[k] + c[99]") == "c[1] * J(1)[k] + c[10]"
    assert constants.order == [4, 6, 8, 10, 12, 8, 6, 10, 12, 14, 99]


def test_numbers_may_ask_for_others() -> None:
    values = ["in[0][1]", "2.0 * c[0]", "c[1] + in[0][2]", "in[0][3]", "c[3] * c[3]"]
    assert Constants([2, 0, 2]).written(values) == [
        "const double g0 = in[0][1];", "const double g1 = 2.0 * g0;",
        "c[0] = g1 + in[0][2];", "c[1] = g0;", "c[2] = g1 + in[0][2];"]


def test_one_number_for_all_is_read_once() -> None:
    loop = Loop(0, 8, ("c0 * j0 + j1",), ((3, 1), (9, 0)), ((5,) * 8,))
    text = "\n".join(write_loop(loop, Constants(), lambda slot: f"at({slot})", "to"))
    assert "c0 = LAG_LANES_OF(c[0]);" in text and "j1 = LAG_LANES_OF(*(at(9)));" in text
    assert "memcpy(&j0, at(3) + i, sizeof j0);" in text


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("part", PARTS)
def test_loops_change_no_digit(part: str, scene: Callable[[str], lag.Model], monkeypatch: pytest.MonkeyPatch) -> None:
    loops: list[Loop] = []

    def finding(*arguments: object) -> list[Loop]:
        found = find_loops(*arguments)  # type: ignore[arg-type]
        loops.extend(found)
        return found

    def rows(native: bool = True) -> np.ndarray:
        model = scene(ROW % PARTS[part])
        model.native = native
        return model.simulate(stop=1, interval=0.05, tolerance=1e-9, solver="taylor").rows

    monkeypatch.setattr(taylor, "find_loops", finding)
    rolled = rows()
    assert sum(loop.count for loop in loops) >= 2 * 12  # of order 0 and of the others
    monkeypatch.setattr(taylor, "find_loops", lambda *_: [])
    np.testing.assert_array_equal(rolled, rows())
    np.testing.assert_array_equal(rolled, rows(native=False))
