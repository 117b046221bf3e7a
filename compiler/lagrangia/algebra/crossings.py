"""Where what follows from time and parameters alone crosses levels. It may be one of several lines, as a limit, a distance or a
branch says: each of them may be the one that crosses."""

from collections.abc import Callable, Sequence

import casadi as ca

from lagrangia.algebra.duals import Scalar, minus
from lagrangia.algebra.instants import Instants
from lagrangia.algebra.modes import Mode
from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, symbol, symbols_in
from lagrangia.base.records import dataclass

_MOST_LINES = 64  # independent choices multiply
Test = Callable[[ca.SX], bool]
Line = tuple[ca.SX, ca.SX | None]  # a + b t, and s of what it may have besides: s floor(c + d t)
Events = tuple[list[ca.SX], list[int]]  # arguments and their kinds: see Mode


@dataclass(frozen=True)
class Crossing:
    """Where a + b t, or a + b t + s floor(c + d t), crosses levels; or where one of several such lines does; or a wave 0."""

    number: int  # of all that says the same
    value: ca.SX  # in time, parameters and inputs alone
    in_pieces: ca.SX | None  # the same in pieces of these inputs, where there are any
    lines: Sequence[Line]
    jumps: Sequence[ca.SX] = ()  # c + d t
    phases: Sequence[ca.SX] = ()  # whole numbers where waves are 0
    is_straight: bool = False  # it is a + b t itself

    @property
    def steps(self) -> bool:
        """Whether whole numbers are among its events."""
        return bool(self.jumps or self.phases)

    def events(self, levels: Sequence[Scalar]) -> Events:
        """With a step, straight + s n is the level for some integer n: at each crossing, and at other times."""
        found = [(x, 1) for x in (*self.jumps, *self.phases)]
        found += [(minus(straight, level), 0) if step is None else (as_expression((level - straight) / step), 1)
                  for straight, step in self.lines for level in levels]
        return [x for x, _ in found], [kind for _, kind in found]


def find_crossing(value: ca.SX, time: ca.SX, modes: Sequence[Mode], numbering: Numbering, is_straight: Test, jumps: Test,
                  may_wave: bool) -> Crossing | None:
    """Of a value in which these modes stand; `may_wave`: its lines may be sines, parabolas and such, of which only crossings of 0
    are known. None where crossings cannot be computed, or there are none."""
    number, places = numbering.number(value), [mode.symbol for mode in modes if mode.of_input is not None and mode.column == 0]
    pieces, modes = [mode for mode in modes if mode.of_input is not None], [mode for mode in modes if mode.of_input is None]
    floors = [mode for mode in modes if not mode.is_relation]
    if not modes and not pieces and ca.depends_on(value, time) and is_straight(value):
        return Crossing(number, value, None, [(value, None)], is_straight=True)
    if len(floors) > 1 or any(mode.is_filled_in or mode.value.op() != ca.OP_FLOOR for mode in floors):
        return None
    floor = floors[0].symbol if floors else None
    lines, phases = list[Line](), list[ca.SX]()
    instants = Instants(time, numbering, is_straight, jumps, lambda x: _phases_of(x, time, numbering), places)
    for x in _lines_of(value, [mode.symbol for mode in modes if mode.is_relation], numbering) or [value]:
        line = _line(x, time, floor)
        if not is_straight(line[0]):
            found = instants.of(x, ca.SX(0)) if may_wave and floor is None else None
            if found is None:
                return None
            lines, phases = [*lines, *((root, None) for root in found[0])], phases + found[1]
            continue
        if line[1] is not None and ca.depends_on(line[1], ca.vertcat(time, floor)):
            return None
        lines += [line] if ca.depends_on(x, time) or line[1] is not None else []
    if not lines and not phases:
        return None
    known = _with(value, modes, [mode.in_time for mode in modes])
    by_inputs = _with(_with(value, modes, [mode.value for mode in modes]), pieces, [mode.value for mode in pieces])
    in_pieces = known if symbols_in(known) != symbols_in(by_inputs) else None
    return Crossing(number, by_inputs, in_pieces, lines, floors[0].arguments if floors else (), phases)


def _with(value: ca.SX, modes: Sequence[Mode], values: Sequence[ca.SX]) -> ca.SX:
    return as_expression(ca.substitute([value], [mode.symbol for mode in modes], list(values))[0] if modes else value)


def _line(x: ca.SX, time: ca.SX, floor: ca.SX | None) -> Line:
    """What it is besides a multiple of a floor."""
    step = None if floor is None else ca.jacobian(x, floor)
    return (x if floor is None else ca.substitute(x, floor, ca.SX(0))), (None if step is None or step.is_zero() else step)


def _lines_of(value: ca.SX, choices: Sequence[ca.SX], numbering: Numbering) -> list[ca.SX]:
    """What a value is for all that its choices, symbols that are 0 or 1, may say; each once. Nothing: too many."""
    found: dict[int, ca.SX] = {}

    def choose(line: ca.SX, open_choices: Sequence[ca.SX]) -> bool:
        known = symbols_in(line)
        left = [x for x in open_choices if x.__hash__() in known]
        if not left:
            found.setdefault(numbering.number(line), line)
            return len(found) <= _MOST_LINES
        *others, last = left  # the outermost: with it others go
        return all(choose(ca.substitute(line, last, ca.SX(truth)), others) for truth in (0, 1))

    return list(found.values()) if choose(value, choices) else []


def _phases_of(value: ca.SX, time: ca.SX, numbering: Numbering) -> list[ca.SX]:
    """Of c + A sin(x) or c + A cos(x), where time stands in x alone: what is a whole number where it is 0; nothing of all else.
    Of |c| > |A| they tell where it comes nearest."""
    wave, waves = symbol("wave"), dict[int, tuple[int, Expression]]()

    def made(op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        if op not in (ca.OP_SIN, ca.OP_COS) or not ca.depends_on(operands[0], time):
            return None
        waves[numbering.of(op, numbers)] = op, operands[0]
        return as_expression(wave)

    (of_wave,) = rebuilt([value], numbering, made)
    size = ca.jacobian(of_wave, wave)
    if len(waves) != 1 or ca.depends_on(of_wave, time) or size.is_zero() or ca.depends_on(size, wave):
        return []
    ((op, x),) = waves.values()
    share = ca.fmax(ca.fmin(-ca.substitute(of_wave, wave, ca.SX(0)) / size, 1), -1)
    first, second = (ca.asin(share), ca.pi - ca.asin(share)) if op == ca.OP_SIN else (ca.acos(share), -ca.acos(share))
    return [as_expression((x - place) / (2 * ca.pi)) for place in (first, second)]
