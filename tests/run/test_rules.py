"""The table of how scenes are run: each moment has a row for everything, each row can be told, each limit is one."""

from string import Formatter
from typing import Any

import pytest

from lagrangia.run.rules import MOST_LINEAR, RULES, Code, Moment, decide
from lagrangia.run.runtime import Solver

KNOWN: dict[Moment, dict[str, Any]] = {
    Moment.ISLANDS: {"is_known": 1, "islands": 2, "resting": 0, "fastest": 3.0, "slowest": 1.0, "ratio": 3.0},
    Moment.LINEAR: {"coordinates": 2, "radians": 100.0, "own": 20.0, "has_events": False},
    Moment.SWEEP: {"has_islands": False, "has_long_steps": False},
    Moment.FMU: {"is_linear": False},
    Moment.BINARY: {"is_shipped": True, "has_compiler": True, "saved": 0.2, "compiling": 0.6},
    Moment.UPGRADE: {"is_built": False, "looks": True, "spent": 0.1, "saved": 0.2, "compiling": 0.6},
}


@pytest.mark.parametrize("moment", Moment)
def test_a_row_is_there_for_everything(moment: Moment) -> None:
    rows = [row for row in RULES if row.moment is moment]
    assert rows[-1].holds({})
    for row in rows:
        row.holds(KNOWN[moment])
        row.limit(KNOWN[moment])
        assert {name for _, name, _, _ in Formatter().parse(row.why) if name} <= {*KNOWN[moment], "limit"}


@pytest.mark.parametrize(
    ("moment", "changed", "takes", "rule"),
    [
        (Moment.ISLANDS, {}, Solver.AUTO, "like islands"),
        (Moment.ISLANDS, {"fastest": 4.0}, Solver.AUTO, "like islands"),
        (Moment.ISLANDS, {"fastest": 4.1, "ratio": 4.1}, Solver.ISLANDS, "unlike islands"),
        (Moment.ISLANDS, {"resting": 1}, Solver.ISLANDS, "resting islands"),
        (Moment.ISLANDS, {"resting": 2, "fastest": 0.0, "slowest": 0.0}, Solver.AUTO, "like islands"),
        (Moment.ISLANDS, {"is_known": 0, "resting": 1}, Solver.AUTO, "unknown islands"),
        (Moment.LINEAR, {"radians": 150.0}, Solver.AUTO, "few radians"),
        (Moment.LINEAR, {"radians": 150.1}, Solver.LINEAR, "many radians"),
        (Moment.LINEAR, {"radians": 1520.0, "has_events": True}, Solver.AUTO, "few radians"),
        (Moment.LINEAR, {"radians": 1e9, "coordinates": MOST_LINEAR + 1}, Solver.AUTO, "many coordinates"),
        (Moment.SWEEP, {}, Solver.AUTO, "rows"),
        (Moment.SWEEP, {"has_islands": True}, Solver.STEPWISE, "looks between rows"),
        (Moment.SWEEP, {"has_long_steps": True}, Solver.STEPWISE, "looks between rows"),
        (Moment.FMU, {}, Solver.AUTO, "FMU"),
        (Moment.FMU, {"is_linear": True}, Solver.LINEAR, "linear FMU"),
        (Moment.BINARY, {}, Code.TAPE, "short runs"),
        (Moment.BINARY, {"saved": 0.7}, Code.NATIVE, "long runs"),
        (Moment.BINARY, {"saved": 0.7, "has_compiler": False}, Code.TAPE, "tapes alone"),
        (Moment.BINARY, {"is_shipped": False}, Code.NATIVE, "no library for FMUs"),
        (Moment.UPGRADE, {}, Code.TAPE, "still the tape"),
        (Moment.UPGRADE, {"saved": 0.51}, Code.NATIVE, "compiled beside"),
        (Moment.UPGRADE, {"saved": 0.51, "looks": False}, Code.TAPE, "still the tape"),
        (Moment.UPGRADE, {"spent": 0.61, "saved": 0.0}, Code.NATIVE, "compiled beside"),
        (Moment.UPGRADE, {"is_built": True}, Code.NATIVE, "compiled before"),
    ],
)
def test_the_first_row_that_holds_decides(moment: Moment, changed: dict[str, Any], takes: Solver | Code, rule: str) -> None:
    taken = decide(moment, KNOWN[moment] | changed)
    assert (taken.takes, taken.rule) == (takes, rule)


def test_reasons_have_their_numbers() -> None:
    taken = decide(Moment.ISLANDS, KNOWN[Moment.ISLANDS] | {"fastest": 62.0, "ratio": 62.0})
    assert taken.why == ("of 2 groups of coordinates that do not interact the fastest is 62 times as fast as the slowest, "
                         "more than 4")
