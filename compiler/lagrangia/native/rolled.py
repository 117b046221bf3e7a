"""Accelerations of neighbours that are computed alike -> loops over several coordinates at a time.

A scene without products of jets, a row of springs for instance, has one statement a node in each order of its series. Where the
accelerations of coordinates that follow each other have one form, and ask for jets that follow each other, a loop takes the place
of their statements. What two neighbours share is computed for both; the operations, and so the digits, are the same.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from itertools import islice

from lagrangia.base.records import dataclass

_JET = re.compile(r"J\((\d+)\)\[[0k]\]")
_CONSTANT = re.compile(r"c\[(\d+)\]")
_LANES = re.compile(r"\b[jcy]\d+\b")  # what has a number for each coordinate
_WIDTH = 4  # most numbers that LagLanes of runtime/numbers/lanes.h hold
_SHORTEST, _MOST_STATEMENTS = 8, 16  # coordinates in a loop; statements of one acceleration


@dataclass(frozen=True)
class Loop:
    """The accelerations of `count` coordinates from `first` on: y0, y1, ... are computed one after another, the last of them is
    the acceleration. j0, j1, ... are jets: a slot, which for the next coordinate is one or none further; c0, c1, ... constants:
    one number a coordinate."""

    first: int
    count: int
    statements: tuple[str, ...]
    jets: tuple[tuple[int, int], ...]  # slot of the first coordinate, step
    constants: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class _Form:
    """One acceleration. Those alike have the same statements."""

    statements: tuple[str, ...]
    jets: tuple[int, ...]
    constants: tuple[int, ...]


@dataclass
class Constants:
    """The places of numbers in the vector c, so that those of a loop follow each other."""

    order: list[int] = field(default_factory=list)  # numbers as they were counted before
    places: dict[int, int] = field(default_factory=dict)  # of each, the first

    def place(self, number: int) -> int:
        """Where a number stands in the vector, at its end if it is new."""
        return self.row((number,))

    def row(self, numbers: Sequence[int]) -> int:
        """Where they follow each other: in a row that is there, in one at the end that goes on, or in a new one."""
        begin = self.places.get(numbers[0], len(self.order))
        there = self.order[begin : begin + len(numbers)]
        if tuple(there) != tuple(numbers[: len(there)]):
            begin, there = len(self.order), []
        for number in numbers[len(there) :]:
            self.places.setdefault(number, len(self.order))
            self.order.append(number)
        return begin

    def written(self, values: Sequence[str]) -> list[str]:
        """C that fills the vector. Values may ask for numbers before them, which are kept in variables."""
        asked: set[int] = set()
        pending = list(self.order)
        while pending:
            new = {int(number) for number in _CONSTANT.findall(values[pending.pop()])} - asked
            asked |= new
            pending += new
        texts = [_CONSTANT.sub(r"g\1", text) for text in values]
        lines = [f"const double g{number} = {texts[number]};" for number in sorted(asked)]
        return lines + [f"c[{k}] = {f'g{n}' if n in asked else texts[n]};" for k, n in enumerate(self.order)]

    def renamed(self, text: str) -> str:
        """C text with its numbers read from the vector."""
        return _CONSTANT.sub(lambda match: f"c[{self.place(int(match[1]))}]", text)


def find_loops(accelerations: Sequence[int], statements: Mapping[int, str]) -> list[Loop]:
    """`accelerations` are the slots of one coordinate after another, `statements` what is assigned to the slots that are no jets
    of the state."""
    forms = [_form(slot, statements) for slot in accelerations]
    loops, first = [], 0
    while first < len(forms):
        count = _alike(forms, first)
        rounded = count - count % _WIDTH
        form = forms[first]
        if form is not None and rounded >= _SHORTEST:
            along = [f for f in forms[first : first + rounded] if f is not None]
            loops.append(Loop(first, rounded, form.statements,
                              tuple((slot, along[1].jets[k] - slot) for k, slot in enumerate(form.jets)),
                              tuple(tuple(f.constants[k] for f in along) for k in range(len(form.constants)))))
        first += max(1, count)
    return loops


def needed(wanted: Iterable[int], statements: Mapping[int, str]) -> Iterator[int]:
    """The slots that are computed for those wanted, each once."""
    pending = list(wanted)
    found: set[int] = set()
    while pending:
        slot = pending.pop()
        if slot in statements and slot not in found:
            found.add(slot)
            pending += [int(other) for other in _JET.findall(statements[slot])]
            yield slot


def write_loop(loop: Loop, constants: Constants, jet: Callable[[int], str], result: str) -> list[str]:
    """C for the loop. `jet` writes the address of a jet's coefficient, `result` is that of what comes next of the first rate."""
    values = [f"j{k}" for k in range(len(loop.jets))] + [f"c{k}" for k in range(len(loop.constants))]
    lines = [f"for (int i = 0; i < {loop.count}; i += LAG_LANES) {{", f"    LagLanes {', '.join([*values, 'next'])};"]
    for k, (slot, step) in enumerate(loop.jets):
        lines.append(f"    memcpy(&j{k}, {jet(slot)} + i, sizeof j{k});" if step else f"    j{k} = LAG_LANES_OF(*({jet(slot)}));")
    for k, numbers in enumerate(loop.constants):
        is_one = len(set(numbers)) == 1
        place = constants.place(numbers[0]) if is_one else constants.row(numbers)
        lines.append(f"    c{k} = LAG_LANES_OF(c[{place}]);" if is_one else f"    memcpy(&c{k}, c + {place} + i, sizeof c{k});")
    wide = [text if _LANES.search(text) else f"LAG_LANES_OF({text})" for text in loop.statements]
    lines += [f"    const LagLanes y{k} = {text};" for k, text in enumerate(wide)]
    lines += [f"    next = y{len(loop.statements) - 1} * (1.0 / (k + 1));", f"    memcpy({result} + i, &next, sizeof next);", "}"]
    return lines


def _form(slot: int, statements: Mapping[int, str]) -> _Form | None:
    """None for a jet of the state, and for too many statements: an acceleration of a long chain asks for all before."""
    if not 0 < len(list(islice(needed([slot], statements), _MOST_STATEMENTS + 1))) <= _MOST_STATEMENTS:
        return None
    names: dict[int, str] = {}
    constants: dict[int, str] = {}
    jets: list[int] = []
    found: list[str] = []

    def name(slot: int) -> str:
        if slot not in names:
            if slot not in statements:
                names[slot] = f"j{len(jets)}"
                jets.append(slot)
            else:
                text = _JET.sub(lambda match: name(int(match[1])), statements[slot])
                text = _CONSTANT.sub(lambda match: constants.setdefault(int(match[1]), f"c{len(constants)}"), text)
                names[slot] = f"y{len(found)}"
                found.append(text)
        return names[slot]

    name(slot)
    return _Form(tuple(found), tuple(jets), tuple(constants))


def _alike(forms: Sequence[_Form | None], first: int) -> int:
    """How many from `first` on are computed alike, their jets following each other."""
    form = forms[first]
    if form is None:
        return 1
    steps: tuple[int, ...] | None = None
    for k in range(first + 1, len(forms)):
        other = forms[k]
        if other is None or other.statements != form.statements:
            return k - first
        moved = tuple(b - a for a, b in zip(form.jets, other.jets, strict=True))
        steps = moved if steps is None else steps
        if any(step not in (0, 1) for step in steps) or moved != tuple(step * (k - first) for step in steps):
            return max(1, k - first)
    return len(forms) - first
