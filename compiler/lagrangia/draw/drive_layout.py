"""The parts of a drive train -> rows and columns.

Shafts stand on columns, each on one. A part lies in a row, in the cell between a column and the next one, and reaches from there
to the shafts of its ends; to further ones and to a housing by lines in rows of their own below it. Nothing else lies in the cells
that it takes, and where a row meets a column one shaft alone has lines: so lines of two shafts may cross, but never lie on each
other.
"""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from lagrangia.draw.drive_parts import Part

_FARTHEST = 24  # rows in which room is looked for, above and below
_CROSSED = 4.0  # a crossing is as bad as so many rows
_ASIDE = 0.5  # as bad as half a row: a source on the right, a sensor on the left
_PASSING = -1  # for a shaft: what goes past


@dataclass(frozen=True)
class Lead:
    """A line from the symbol of a part to a shaft: in which row, over which cells (begin <= cell < end), to which column."""

    shaft: int
    row: int
    begin: int
    end: int
    column: int
    is_dashed: bool = False

    @property
    def side(self) -> int:
        """Of its column on which it lies: -1 left, 1 right."""
        return 1 if self.column == self.begin else -1


@dataclass(frozen=True)
class Place:
    """Where a part lies: the cell of its symbol, and whether its left flange is on the right; the lines from its ends, and from
    below it. `back`: the one from its right end, below it, to what is on its left."""

    row: int
    cell: int
    is_mirrored: bool
    straight: tuple[Lead, ...]
    below: tuple[Lead, ...]
    back: Lead | None = None

    @property
    def leads(self) -> tuple[Lead, ...]:
        """All of them."""
        return (*self.straight, *self.below, *([self.back] if self.back is not None else []))


@dataclass
class Layout:
    """Columns of shafts, places of parts by their order. Rows go down and may be negative."""

    columns: dict[int, int]
    places: dict[int, Place] = field(default_factory=dict)
    rows: dict[int, tuple[int, int]] = field(default_factory=dict)  # of shafts: the first and the last
    meets: dict[tuple[int, int], int] = field(default_factory=dict)  # (column, row): the shaft that a line meets there
    _cells: set[tuple[int, int]] = field(default_factory=set)
    _passed: dict[tuple[int, int], int] = field(default_factory=dict)  # (column, row): of how many shafts lines go down there
    _deepest: dict[int, int] = field(default_factory=dict)  # of a column and the cell behind it

    def put(self, k: int, wanted: int, choices: Sequence[Place]) -> None:
        """Sets part `k` where it is best: near a row, with few crossings. `choices` are in row 0, the best first."""
        best, least = None, float("inf")
        for distance in range(_FARTHEST):
            if distance >= least:
                break
            for shift in dict.fromkeys((wanted + distance, wanted - distance)):
                for j, choice in enumerate(choices):
                    cost = distance + _ASIDE * j + _CROSSED * self._crossings(choice, shift, least)
                    if cost < least:
                        best, least = moved(choice, shift), cost
        self._take(k, best or moved(choices[0], 1 + max(self._deepest.get(c, -1) for c in _touched(choices[0]))))

    def _crossings(self, place: Place, shift: int, enough: float) -> float:
        """How many there would be; infinite where something lies there."""
        found = 0
        for lead in place.leads:
            row = lead.row + shift
            for column in range(lead.begin, lead.end):
                if (column, row) in self._cells:
                    return float("inf")
            for column in range(lead.begin, lead.end + 1):
                is_end = column == lead.column
                if not is_end and column in (lead.begin, lead.end):
                    continue  # where its symbol stands
                if self.meets.get((column, row), lead.shaft if is_end else None) != (lead.shaft if is_end else None):
                    return float("inf")
                low, high = self.rows.get(lead.shaft, (row, row)) if is_end else (row, row)
                own = is_end and low <= row <= high and lead.shaft in self.rows
                found += self._passed.get((column, row), 0) - own
            if _CROSSED * found > enough:
                break
            found += sum(1 for point in self._new(lead, row) if self.meets.get(point, lead.shaft) != lead.shaft)
        return found

    def _new(self, lead: Lead, row: int) -> Iterator[tuple[int, int]]:
        """Where a shaft has no line as yet, on its way to a row."""
        low, high = self.rows.get(lead.shaft, (row, row - 1))
        yield from ((lead.column, r) for r in (*range(row, low), *range(high + 1, row + 1)))

    def _take(self, k: int, place: Place) -> None:
        self.places[k] = place
        for lead in place.leads:
            for column in range(lead.begin, lead.end):
                self._cells.add((column, lead.row))
            for column in range(lead.begin + 1, lead.end):
                self.meets[column, lead.row] = _PASSING
            for column in range(lead.begin, lead.end + 1):
                self._deepest[column] = max(lead.row, self._deepest.get(column, lead.row))
            self.meets[lead.column, lead.row] = lead.shaft
            for point in self._new(lead, lead.row):
                self._passed[point] = self._passed.get(point, 0) + 1
                self._deepest[point[0]] = max(point[1], self._deepest.get(point[0], point[1]))
            low, high = self.rows.get(lead.shaft, (lead.row, lead.row))
            self.rows[lead.shaft] = min(low, lead.row), max(high, lead.row)

    def passed(self) -> set[int]:
        """The columns over which parts reach."""
        return {column for (column, _), shaft in self.meets.items() if shaft == _PASSING}

    def bottom(self) -> int:
        """The first row below all."""
        return 1 + max(self._deepest.values(), default=-1)


def moved(place: Place, rows: int) -> Place:
    """So many rows further down."""
    def lower(lead: Lead) -> Lead:
        return Lead(lead.shaft, lead.row + rows, lead.begin, lead.end, lead.column, lead.is_dashed)

    straight, below = tuple(map(lower, place.straight)), tuple(map(lower, place.below))
    return Place(place.row + rows, place.cell, place.is_mirrored, straight, below, lower(place.back) if place.back else None)


def _touched(place: Place) -> set[int]:
    return {column for lead in place.leads for column in range(lead.begin, lead.end + 1)}


def lay_out(parts: Sequence[Part]) -> Layout:
    """Parts along the shaft, in depth: what hangs on a shaft, and what hangs on that."""
    layout = Layout(columns_of(parts))
    on: dict[int, list[int]] = {}
    for k, part in enumerate(parts):
        for shaft in part.shafts:
            on.setdefault(shaft, []).append(k)
    for shafts in on.values():
        shafts.sort(key=lambda k: parts[k].right is None)
    reached: set[int] = set()
    for first in _first_shafts(parts):
        if first in reached:
            continue
        reached.add(first)
        begin, waiting = layout.bottom(), [first]
        while waiting:
            shaft = waiting.pop()
            row = layout.rows.get(shaft, (begin, begin))[0]
            new = []
            for k in on[shaft]:
                if k not in layout.places:
                    layout.put(k, row, _choices(parts[k], layout.columns))
                    new += [s for s in parts[k].shafts if s not in reached]
                    reached.update(parts[k].shafts)
            waiting += reversed(list(dict.fromkeys(new)))
    return layout


def _first_shafts(parts: Sequence[Part]) -> Iterator[int]:
    """Where a drawing begins: shafts on which nothing stands on the left, and then all others."""
    right = {shaft for part in parts if part.right is not None for shaft in part.ends if shaft != part.left}
    yield from (part.left for part in parts if part.right is not None and part.left not in right)
    yield from (shaft for part in parts for shaft in part.shafts)


def _choices(part: Part, columns: Mapping[int, int]) -> list[Place]:
    """Places of a part in row 0, the best first."""
    if part.right is None:
        at = columns[part.left]
        cells = (at, at - 1) if part.kind.endswith("Sensor") else (at - 1, at)
        return [Place(0, c, c < at, (Lead(part.left, 0, c, c + 1, at),), _below(part, c, columns)) for c in cells]
    low, high = sorted(((columns[part.left], part.left), (columns[part.right], part.right)))
    is_mirrored = columns[part.right] < columns[part.left]
    cell = low[0]
    first = Lead(low[1], 0, cell, cell + 1, cell)
    if low[0] == high[0]:  # both ends on one shaft
        below = _below(part, cell, columns)
        back = Lead(high[1], 1 + len(below), cell, cell + 1, cell)
        return [Place(0, cell, is_mirrored, (first,), below, back)]
    return [Place(0, cell, is_mirrored, (first, Lead(high[1], 0, cell, high[0], high[0])), _below(part, cell, columns))]


def _below(part: Part, cell: int, columns: Mapping[int, int]) -> tuple[Lead, ...]:
    shafts = [(shaft, False) for shaft in part.further] + ([(part.housing, True)] if part.housing is not None else [])
    found = []
    for row, (shaft, is_dashed) in enumerate(shafts, 1):
        at = columns[shaft]
        found.append(Lead(shaft, row, min(cell, at), max(cell + 1, at), at, is_dashed))
    return tuple(found)


# -------------------------------------------------------------------- columns


def columns_of(parts: Sequence[Part]) -> dict[int, int]:
    """Of all shafts: from left to right by the longest way, no further left than need be; what leads back is turned round."""
    edges = dict.fromkeys((part.left, other) for part in parts if part.right is not None for other in part.ends[1:]
                          if other != part.left)
    after: dict[int, list[int]] = {shaft: [] for part in parts for shaft in part.ends}
    for a, b in edges:
        after[a].append(b)
    begins = [*_first_shafts(parts)]
    forward = _without_circles(after, [shaft for shaft in begins if shaft in after])
    before: dict[int, list[int]] = {shaft: [] for shaft in forward}
    for a, others in forward.items():
        for b in others:
            before[b].append(a)
    order = _in_order(forward, before)
    columns = dict.fromkeys(forward, 0)
    for shaft in order:
        for other in forward[shaft]:
            columns[other] = max(columns[other], columns[shaft] + 1)
    for shaft in reversed(order):
        if len(forward[shaft]) >= max(1, len(before[shaft])):
            columns[shaft] = min(columns[other] for other in forward[shaft]) - 1
    tied = {shaft for part in parts if part.right is not None for shaft in part.ends}
    for part in parts:  # housings that hold nothing else
        if part.housing is not None and part.housing not in tied:
            tied.add(part.housing)
            columns[part.housing] = columns[part.left] + 1
    return columns


def _without_circles(after: Mapping[int, Sequence[int]], begins: Sequence[int]) -> dict[int, list[int]]:
    """The same, with those that lead back to where a search in depth came from turned round."""
    forward: dict[int, list[int]] = {shaft: [] for shaft in after}
    state: dict[int, bool] = {}  # True: on the way
    for begin in begins:
        if begin in state:
            continue
        state[begin] = True
        way = [(begin, iter(after[begin]))]
        while way:
            shaft, others = way[-1]
            other = next(others, None)
            if other is None:
                state[shaft] = False
                way.pop()
            elif state.get(other, False):
                forward[other].append(shaft)
            else:
                forward[shaft].append(other)
                if other not in state:
                    state[other] = True
                    way.append((other, iter(after[other])))
    return {shaft: list(dict.fromkeys(others)) for shaft, others in forward.items()}


def _in_order(forward: Mapping[int, Sequence[int]], before: Mapping[int, Sequence[int]]) -> list[int]:
    missing = {shaft: len(others) for shaft, others in before.items()}
    ready = deque(shaft for shaft, count in missing.items() if not count)
    order = []
    while ready:
        order.append(shaft := ready.popleft())
        for other in forward[shaft]:
            missing[other] -= 1
            if not missing[other]:
                ready.append(other)
    return order
