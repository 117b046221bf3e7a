"""A drive train -> a page: its parts along a shaft, from flange to flange, as a sketch of them has it.

What stands between two shafts lies in one row from the left one to the right one; what is beside it, in the next free row below.
Dots are shafts that branch; dashed lines lead to housings. Long trains go on in a further line, as words do.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lagrangia.draw.drive_layout import Layout, Lead, lay_out
from lagrangia.draw.drive_parts import Part, parts_of
from lagrangia.draw.drive_symbols import HIGHEST, LENGTH, Vector, symbol_of
from lagrangia.draw.page import FONT, MARGIN, Label, Page, View, Words, bounds_of, build_page, stacked
from lagrangia.draw.strokes import HINGES, RAILS, RODS, Shape, Stroke
from lagrangia.language.flat import FlatModel

WIDEST = 170.0  # mm
_COLUMN = LENGTH + 2.4  # mm, from a shaft to the next one: lines of others pass beside the ends of symbols
_TRACK = 2.2  # mm, between two shafts on one column
_LANE = 2.2  # mm, between lines that go on below
_FOOT = 1.0  # mm, between lines down from one symbol
_WORDS = 0.75 * FONT  # mm, of the middle of words above a symbol
_DOT = 0.55  # mm
_ROOM = 2.0  # mm, between two names, and between two rows
_IN_AN_ICON = 4  # parts


@dataclass(frozen=True)
class Wire:
    """A line of a shaft on the page, (n, 2), mm."""

    shaft: int
    points: Vector
    is_dashed: bool = False


@dataclass(frozen=True)
class Sketch:
    """A drive train in millimetres: the two ends of each symbol, left flange first (of parts with one flange: it, and where there
    is nothing), where lines leave it below, the lines of shafts, and dots on them."""

    parts: Sequence[Part]
    ends: Sequence[tuple[Vector, Vector]]
    feet: Sequence[tuple[Vector, ...]]
    wires: Sequence[Wire]
    dots: Sequence[tuple[int, Vector]]


@dataclass
class _Band:
    """A line of the page: its columns and what is there, in millimetres."""

    first: int  # column
    last: int
    cells: dict[int, float] = field(default_factory=dict)  # the middles of cells
    tracks: dict[int, float] = field(default_factory=dict)  # by shafts
    heights: dict[int, float] = field(default_factory=dict)  # of rows
    meets: dict[int, dict[int, int]] = field(default_factory=dict)  # by shafts: in rows, how many lines


def with_train(page: Page, flat: FlatModel, names: Mapping[str, str]) -> Page:
    """The picture of a scene with its drive train below, as far as it has these."""
    train = draw_train(flat, names)
    if train is None:
        return page
    return stacked(page, train) if page.paths or page.labels else train


def names_elsewhere(flat: FlatModel, names: Mapping[str, str]) -> dict[str, str]:
    """The symbols for what is not named in the drive train."""
    told = {name for part in (parts_of(flat) if names else ()) for name in (part.name, part.of)}
    return {name: symbol for name, symbol in names.items() if name not in told}


def icon_of_train(flat: FlatModel) -> Page | None:
    """The first parts of a drive train, without names; None where a scene has no components with flanges."""
    parts = parts_of(flat)[:_IN_AN_ICON]
    return replace(_drawn(parts, [Words(()) for _ in parts], flat), labels=()) if parts else None


def draw_train(flat: FlatModel, names: Mapping[str, str]) -> Page | None:
    """The page of a drive train; None where a scene has no components with flanges."""
    parts = parts_of(flat)
    return _drawn(parts, [_words(part, names) for part in parts], flat) if parts else None


def _drawn(parts: Sequence[Part], words: Sequence[Words], flat: FlatModel) -> Page:
    sketch = sketch_of(parts, [word.width for word in words])
    strokes, labels = list(_lines(sketch)), []
    for part, (a, b), word in zip(parts, sketch.ends, words, strict=True):
        symbol, height = symbol_of(part.kind, a, b, part.right is None)
        strokes += symbol
        labels.append(((a + b) / 2 + np.array([0.0, height + _WORDS]), word))
    low, high = bounds_of(strokes)
    halves = [np.array([word.width / 2, FONT / 2]) for _, word in labels]
    low = np.min([low, *(at - half for (at, _), half in zip(labels, halves, strict=True))], axis=0)
    high = np.max([high, *(at + half for (at, _), half in zip(labels, halves, strict=True))], axis=0)
    width, height = high - low + 2 * MARGIN
    view = View(1.0, low - MARGIN, float(width), float(height))
    page = build_page([(Shape(strokes), None)], view, flat.description or flat.name)
    placed = ((word, view.points(at)) for at, word in labels)
    return replace(page, labels=tuple(Label(word, (float(at[0]), float(at[1]))) for word, at in placed))


def _words(part: Part, names: Mapping[str, str]) -> Words:
    name = names.get(part.name, part.name)
    return Words(((f"{name} ({names.get(part.of, part.of)})" if part.of else name, False, False),))


def _lines(sketch: Sketch) -> Iterator[Stroke]:
    for wire in sketch.wires:
        yield Stroke(wire.points, RAILS if wire.is_dashed else RODS, "dashed" if wire.is_dashed else "thick")
    yield from (Stroke(dot[None], HINGES, "thin", "black", True, _DOT) for _, dot in sketch.dots)


# -------------------------------------------------------------------- millimetres


def sketch_of(parts: Sequence[Part], widths: Sequence[float]) -> Sketch:
    """Parts, whose names are so wide (mm), and their shafts on a page; y upwards."""
    layout = lay_out(parts)
    cells: dict[int, float] = {}
    for k, place in layout.places.items():
        cells[place.cell] = max(cells.get(place.cell, _COLUMN), widths[k] + _ROOM)
    count = Counter(shaft for part in parts for shaft in part.shafts)
    return _Sketcher(parts, layout, cells, {shaft for shaft, n in count.items() if n > 1}).sketch()


class _Sketcher:
    def __init__(self, parts: Sequence[Part], layout: Layout, cells: Mapping[int, float], shafts: set[int]) -> None:
        self.parts, self.layout, self.widths = parts, layout, cells
        self.shafts = shafts  # on which more than one thing lies
        self.bands = self._folded()
        self.band_of = {cell: band for band in self.bands for cell in range(band.first, band.last)}
        for k in layout.places:
            for lead in layout.places[k].leads:
                rows = self.band_of[layout.places[k].cell].meets.setdefault(lead.shaft, {})
                rows[lead.row] = rows.get(lead.row, 0) + 1

    def sketch(self) -> Sketch:
        """All bands, one below the other."""
        self._set_tracks()
        self._set_heights()
        n = len(self.parts)
        ends = [self._ends(k) for k in range(n)]
        feet = [self._feet(k) for k in range(n)]
        wires = [wire for k in range(n) for wire in self._leads(k, ends[k], feet[k])]
        wires += [wire for band in self.bands for wire in self._shafts(band)]
        wires += [wire for a, b in zip(self.bands, self.bands[1:], strict=False) for wire in self._links(a, b)]
        return Sketch(self.parts, ends, feet, wires, [dot for band in self.bands for dot in self._dots(band)])

    def _folded(self) -> list[_Band]:
        """Cut into lines at columns over which no part reaches, where few shafts go on."""
        leads = [lead for place in self.layout.places.values() for lead in place.leads]
        first, last = min(lead.begin for lead in leads), max(lead.end for lead in leads)
        passed, crowd = self.layout.passed(), Counter(self.layout.columns.values())
        bands = []
        while first < last:
            width, best, narrow = 0.0, last, True
            for column in range(first + 1, last + 1):
                width += self.widths.get(column - 1, _COLUMN)
                if width > WIDEST and best < last:
                    break
                if column == last or (column not in passed and (narrow or crowd[column] <= crowd[best])):
                    best, narrow = column, width < WIDEST / 2
            bands.append(_Band(first, best))
            first = best
        return bands

    def _set_tracks(self) -> None:
        """Where shafts stand: beside each other where they would meet on a column."""
        for band in self.bands:
            standing: dict[int, list[int]] = {}
            for shaft in band.meets:
                standing.setdefault(self.layout.columns[shaft], []).append(shaft)
            x = 0.0
            for column in range(band.first, band.last + 1):
                free: list[int] = []  # the last row of each track
                is_cut = column in (band.first, band.last)  # lines that go on lead away from here
                for shaft in sorted(standing.get(column, []), key=lambda s: (min(band.meets[s]), s)):
                    low, high = min(band.meets[shaft]), max(band.meets[shaft])
                    track = next((t for t, end in enumerate(free) if end < low and not is_cut), len(free))
                    free[track : track + 1] = [high]
                    band.tracks[shaft] = x + track * _TRACK
                x += max(0, len(free) - 1) * _TRACK
                band.cells[column] = x + self.widths.get(column, _COLUMN) / 2
                x += self.widths.get(column, _COLUMN)

    def _set_heights(self) -> None:
        """Rows from the top down, as high as what is in them."""
        y = 0.0
        for band in self.bands:
            symbols = {place.row for place in self.layout.places.values() if self.band_of[place.cell] is band}
            for row in sorted({r for rows in band.meets.values() for r in rows} | symbols):
                above = HIGHEST + FONT + _WORDS / 2 if row in symbols else _ROOM
                y -= above
                band.heights[row] = y
                y -= HIGHEST if row in symbols else _ROOM
            y -= _LANE * (1 + len(self._going_on(band)))

    def _going_on(self, band: _Band) -> list[int]:
        """Shafts at the end of a band that the next one has as well."""
        following = next((b for b in self.bands if b.first == band.last), None)
        if following is None:
            return []
        return sorted((s for s in band.meets if s in following.meets), key=lambda s: band.tracks[s])

    def _ends(self, k: int) -> tuple[Vector, Vector]:
        place = self.layout.places[k]
        band = self.band_of[place.cell]
        middle = np.array([band.cells[place.cell], band.heights[place.row]])
        half = np.array([LENGTH / 2, 0.0])
        return (middle + half, middle - half) if place.is_mirrored else (middle - half, middle + half)

    def _feet(self, k: int) -> tuple[Vector, ...]:
        """Where lines leave a symbol below: those to the right on the right, the upper ones outside, so that none meet."""
        place = self.layout.places[k]
        a, b = self._ends(k)
        sides = [1 if lead.begin == place.cell and lead.column != lead.begin else -1 for lead in place.below]
        found = []
        for j, side in enumerate(sides):
            later = sum(1 for other in sides[j + 1 :] if other == side)
            aside = side * (later + 0.5) * _FOOT if len(sides) > 1 else 0.0
            found.append((a + b) / 2 + np.array([aside, 0.0]))
        return tuple(found)

    def _leads(self, k: int, ends: tuple[Vector, Vector], feet: tuple[Vector, ...]) -> Iterator[Wire]:
        place = self.layout.places[k]
        band = self.band_of[place.cell]
        left, right = sorted(ends, key=lambda end: float(end[0]))

        def meeting(lead: Lead) -> Vector:
            return np.array([band.tracks[lead.shaft], band.heights[lead.row]])

        for lead in place.straight:
            if lead.shaft in self.shafts:
                yield Wire(lead.shaft, np.array([left if lead.side == 1 else right, meeting(lead)]))
        pairs = [*zip(feet, place.below, strict=True), *([(right, place.back)] if place.back is not None else [])]
        for foot, lead in pairs:
            if lead.shaft in self.shafts:
                at = meeting(lead)
                yield Wire(lead.shaft, np.array([foot, [foot[0], at[1]], at]), lead.is_dashed)

    def _shafts(self, band: _Band) -> Iterator[Wire]:
        for shaft, rows in band.meets.items():
            if len(rows) > 1 and shaft in self.shafts:
                x = band.tracks[shaft]
                yield Wire(shaft, np.array([[x, band.heights[min(rows)]], [x, band.heights[max(rows)]]]))

    def _links(self, a: _Band, b: _Band) -> Iterator[Wire]:
        """From the end of a line to the beginning of the next one."""
        bottom = min(a.heights.values()) - HIGHEST
        for lane, shaft in enumerate(self._going_on(a)):
            y = bottom - _LANE * (lane + 0.5)
            x, into = a.tracks[shaft], b.tracks[shaft]
            begin, end = a.heights[max(a.meets[shaft])], b.heights[min(b.meets[shaft])]
            yield Wire(shaft, np.array([[x, begin], [x, y], [into, y], [into, end]]))

    def _dots(self, band: _Band) -> Iterator[tuple[int, Vector]]:
        """Where more than two lines of a shaft meet."""
        following, before = self._going_on(band), next((b for b in self.bands if b.last == band.first), None)
        for shaft, rows in band.meets.items():
            low, high = min(rows), max(rows)
            for row, count in rows.items():
                more = (row > low) + (row < high) + (row == high and shaft in following)
                more += row == low and before is not None and shaft in before.meets
                if count + more > 2:
                    yield shaft, np.array([band.tracks[shaft], band.heights[row]])
