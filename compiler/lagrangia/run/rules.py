"""How scenes are run, as rows of one table: of the rows of a moment the first that holds decides.

Which method goes on in a run is decided in C (runtime/choice/choice.c); here stands what is decided before: whether a scene is
taken apart or solved in one piece, what sweeps and FMUs begin with, and what is worth a C compiler. Those who ask measure, rows
compare. Limits stand above the table, with what they were measured on.
"""

from collections.abc import Callable, Mapping
from enum import Enum

from lagrangia.base.records import dataclass
from lagrangia.run.choice import figure
from lagrangia.run.runtime import Solver

Facts = Mapping[str, float]


class Moment(Enum):
    """When a row is asked."""

    ISLANDS = "a scene has islands"
    LINEAR = "a scene is linear"
    SWEEP = "a sweep looks at motions between rows"
    FMU = "an FMU is written"
    BINARY = "an FMU for this machine gets its binary"
    UPGRADE = "it runs on its tapes"


class Code(Enum):
    """What evaluates a scene."""

    TAPE = "tape"
    NATIVE = "native"


# Ratio of the fastest rates of islands from which steps of their own pay: each island has a cost of its own a row.
_UNLIKE = 4.0
# Radians of the fastest motion beyond those that set-up and rows of exponentials are worth. On few coordinates, 501 rows: even at
# some 130 radians at a tolerance of 1e-8; time events ask for parts of intervals, which cost more.
_RADIANS, _RADIANS_WITH_EVENTS = 130, 1500
# Runs over its experiment that an FMU is made for.
FMU_RUNS = 100
# Coordinates; beyond, rows of exponentials are summed up as series and cost like steps.
MOST_LINEAR = 100


@dataclass(frozen=True)
class Row:
    """A rule: what must hold of what was measured, what it takes, and why, with names of facts in braces; `limit` is one."""

    name: str
    moment: Moment
    takes: Solver | Code
    holds: Callable[[Facts], object]
    why: str
    limit: Callable[[Facts], float] = lambda _: 0.0


@dataclass(frozen=True)
class Taken:
    """What a row took, and its reason with its numbers."""

    takes: Solver | Code
    rule: str
    why: str


def _radians(facts: Facts) -> float:
    return facts["own"] + (_RADIANS_WITH_EVENTS if facts["has_events"] else _RADIANS)


def _always(_: Facts) -> bool:
    return True


RULES = (
    Row("unknown islands", Moment.ISLANDS, Solver.AUTO, lambda f: not f["is_known"], "how fast its islands are is not known"),
    Row("resting islands", Moment.ISLANDS, Solver.ISLANDS, lambda f: 0 < f["resting"] < f["islands"],
        "{resting} of {islands} groups of coordinates that do not interact rest"),
    Row("unlike islands", Moment.ISLANDS, Solver.ISLANDS, lambda f: f["fastest"] > _UNLIKE * f["slowest"],
        "of {islands} groups of coordinates that do not interact the fastest is {ratio} times as fast as the slowest, "
        "more than {limit}",
        lambda _: _UNLIKE),
    Row("like islands", Moment.ISLANDS, Solver.AUTO, _always, "its islands are alike"),

    Row("many coordinates", Moment.LINEAR, Solver.AUTO, lambda f: f["coordinates"] > MOST_LINEAR,
        "exponentials of {coordinates} coordinates, more than {limit}, cost like steps", lambda _: MOST_LINEAR),
    Row("many radians", Moment.LINEAR, Solver.LINEAR, lambda f: f["radians"] > _radians(f),
        "steps for {radians} radians of the fastest motion cost more than exponentials, which are worth {limit}", _radians),
    Row("few radians", Moment.LINEAR, Solver.AUTO, _always,
        "steps for {radians} radians of the fastest motion cost less than exponentials, which are worth {limit}", _radians),

    Row("looks between rows", Moment.SWEEP, Solver.STEPWISE, lambda f: f["has_islands"] or f["has_long_steps"],
        "what is measured between rows asks for steps as short as the motion is quick"),
    Row("rows", Moment.SWEEP, Solver.AUTO, _always, "as in a single run"),

    Row("linear FMU", Moment.FMU, Solver.LINEAR, lambda f: f["is_linear"],
        "communication steps and tolerances are the importer's choice: exponentials serve all"),
    Row("FMU", Moment.FMU, Solver.AUTO, _always, "as `lag simulate`, in one piece: islands have no place in an FMU yet"),

    Row("no library for FMUs", Moment.BINARY, Code.NATIVE, lambda f: not f["is_shipped"],
        "no library for FMUs came with the package"),
    Row("tapes alone", Moment.BINARY, Code.TAPE, lambda f: not f["has_compiler"], "there is no C compiler"),
    Row("long runs", Moment.BINARY, Code.NATIVE, lambda f: f["saved"] > f["compiling"],
        "native code saves {saved} s in a hundred runs over its experiment, more than {limit} s of compiling",
        lambda f: f["compiling"]),
    Row("short runs", Moment.BINARY, Code.TAPE, _always,
        "native code would save {saved} s in a hundred runs over its experiment, less than {limit} s of compiling",
        lambda f: f["compiling"]),

    Row("compiled before", Moment.UPGRADE, Code.NATIVE, lambda f: f["is_built"], "its native code is there"),
    Row("compiled beside", Moment.UPGRADE, Code.NATIVE, lambda f: f["looks"] and f["spent"] + f["saved"] > f["compiling"],
        "tapes have cost {spent} s, and will cost {saved} s more than native code: more than {limit} s of compiling",
        lambda f: f["compiling"]),
    Row("still the tape", Moment.UPGRADE, Code.TAPE, _always, "the run will be over before compiling pays"),
)  # fmt: skip


def decide(moment: Moment, facts: Facts) -> Taken:
    """What the first row that holds takes; the last of each moment always does."""
    from string import Formatter

    row = next(row for row in RULES if row.moment is moment and row.holds(facts))
    numbers = {**facts, "limit": row.limit(facts)}
    shown = {name: figure(float(numbers[name])) for _, name, _, _ in Formatter().parse(row.why) if name}
    return Taken(row.takes, row.name, row.why.format_map(shown))


def solver_by(moment: Moment, facts: Facts) -> Solver:
    """The solver that is taken, of a moment whose rows take solvers."""
    taken = decide(moment, facts).takes
    assert isinstance(taken, Solver)
    return taken
