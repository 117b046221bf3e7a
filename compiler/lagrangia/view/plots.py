"""What a picture of runs shows: quantities over time, one against another, spectra, sections -> panels of lines."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import field, replace
from itertools import pairwise
from typing import TYPE_CHECKING

from lagrangia.base.cutting import unquoted
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.run.scene import Column
from lagrangia.view.sections import find_section
from lagrangia.view.spectra import find_spectrum

if TYPE_CHECKING:
    import numpy as np

_DEGREE = 180.0 / math.pi
_FEW = 400  # points of a measurement that are drawn each
_MOST_MARKS = 500  # events that are marked: more would be a bar
TIME, PLANE, FREQUENCY = "time", "plane", "frequency"


@dataclass(frozen=True)
class Pair:
    """`y` against `x`, to the right; over time where there is no x."""

    x: str
    y: str

    @property
    def names(self) -> tuple[str, ...]:
        """Of the quantities, x first."""
        return (self.x, self.y) if self.x else (self.y,)


@dataclass(frozen=True)
class Wanted:
    """What a picture shows. `section`: a quantity and the value through which it rises, in SI units."""

    pairs: tuple[Pair, ...] = ()
    spectra: tuple[str, ...] = ()
    section: tuple[str, float] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """All quantities, each once."""
        own = [name for pair in self.pairs for name in pair.names]
        return tuple(dict.fromkeys([*own, *self.spectra, *([self.section[0]] if self.section else [])]))


@dataclass(frozen=True)
class Series:
    """A run, a measurement or a small motion: `values` gives a quantity in SI units, (rows,), None where there is none of it."""

    label: str
    time: "np.ndarray"
    values: "Callable[[str], np.ndarray | None]"
    is_measured: bool = False
    is_linear: bool = False
    events: "np.ndarray | None" = None  # times that are marked, s


@dataclass(frozen=True)
class Line:
    """`x` and `y` as they are shown; `kind`: line, dashed, or dots. `rank`: of what is shown together, by colour."""

    x: "np.ndarray"
    y: "np.ndarray"
    label: str
    rank: int
    kind: str = "line"


@dataclass(frozen=True)
class Panel:
    """Axes: those over `axis` time share it."""

    axis: str
    x_label: str
    y_label: str
    lines: list[Line] = field(default_factory=list)
    marks: Sequence[float] = ()  # times of events, s

    @property
    def is_wide(self) -> bool:
        """Over time or frequency: such panels share that axis."""
        return self.axis in (TIME, FREQUENCY)

    @property
    def largest(self) -> float:
        """The largest amplitude of a spectrum; 0 elsewhere."""
        return max((float(line.y.max()) for line in self.lines), default=0.0) if self.axis == FREQUENCY else 0.0


@dataclass(frozen=True)
class Picture:
    """The panels, and words about what could not be shown."""

    panels: tuple[Panel, ...]
    notes: tuple[str, ...] = ()


def read_pair(text: str) -> Pair:
    """`y`, or `x:y`; x' is der(x). Raises LagError L0706."""
    cuts = [0, *(found.end() for found in re.finditer(r":(?![^\[]*\])", unquoted(text))), len(text) + 1]
    parts = [_rate(text[begin:end - 1].strip()) for begin, end in pairwise(cuts)]
    if len(parts) > 2 or not all(parts):
        fail("L0706", f"'{text}' names no curve", None, "a quantity over time, or two with a colon between: theta:theta'")
    return Pair("", parts[0]) if len(parts) == 1 else Pair(parts[0], parts[1])


def _rate(name: str) -> str:
    bare = name[:len(unquoted(name).rstrip("'"))]
    for _ in range(len(name) - len(bare)):
        bare = f"der({bare})"
    return bare


def build_picture(series: Sequence[Series], wanted: Wanted, column_of: Callable[[str], Column]) -> Picture:
    """Quantities over time by their units, then pairs, spectra and the section; the first series is the run itself.

    Raises LagError L0706 where rows make no spectrum or section.
    """
    over_time = [pair.y for pair in wanted.pairs if not pair.x] if wanted.section is None else []
    marks = series[0].events if over_time and series[0].events is not None else ()
    panels, notes = [], []
    if len(marks) > _MOST_MARKS:
        notes, marks = [f"{len(marks)} events are not marked: they would be a bar"], ()
    for unit, names in _by_unit(over_time, column_of).items():
        panels.append(replace(_panel(series, TIME, "time [s]", unit, names, column_of), marks=tuple(marks)))
    plane = [pair for pair in wanted.pairs if pair.x]
    if wanted.section is None:
        panels += [_phase(series, pair, column_of) for pair in plane]
    for unit, names in _by_unit(wanted.spectra, column_of).items():
        panels.append(_panel(series, FREQUENCY, "frequency [Hz]", unit, names, column_of))
    if wanted.section is not None:
        for pair in plane:
            panel, told = _section(series, pair, wanted.section, column_of)
            panels.append(panel)
            notes += told
    return Picture(tuple(panels), tuple(dict.fromkeys(notes)))


def shown_unit(column: Column) -> str:
    """As axes have it."""
    return column.display_unit or column.unit


def scaled(column: Column, values: "np.ndarray") -> "np.ndarray":
    """In the unit that is shown: angles in degrees where they are declared so."""
    return values * (_DEGREE if shown_unit(column).startswith("deg") else 1.0)


def titled(column: Column) -> str:
    """Name and unit."""
    unit = shown_unit(column)
    return f"{column.name} [{unit}]" if unit and unit != "1" else column.name


def _by_unit(names: Sequence[str], column_of: Callable[[str], Column]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name in names:
        found.setdefault(shown_unit(column_of(name)), []).append(name)
    return found


def _panel(series: Sequence[Series], axis: str, x_label: str, unit: str, names: Sequence[str],
           column_of: Callable[[str], Column]) -> Panel:
    what = names[0] if len(names) == 1 else "amplitude" if axis == FREQUENCY else ""
    what = f"amplitude of {what}" if axis == FREQUENCY and len(names) == 1 else what
    panel = Panel(axis, x_label, f"{what} [{unit}]" if unit and unit != "1" else what)
    for rank, name in enumerate(names):
        for k, item in enumerate(series):
            if (values := item.values(name)) is None:
                continue
            x, y = item.time, scaled(column_of(name), values)
            if axis == FREQUENCY:
                spectrum = find_spectrum(name, x, y)
                x, y = spectrum.frequencies, spectrum.amplitude
            label = _label(name if len(names) > 1 or len(series) == 1 else "", item.label if len(series) > 1 else "")
            panel.lines.append(Line(x, y, label, rank + len(names) * k, _kind(item, axis == FREQUENCY)))
    return panel


def _label(name: str, of: str) -> str:
    return f"{name}, {of}" if name and of else name or of


def _kind(item: Series, is_curve: bool = False) -> str:
    return "dashed" if item.is_linear else "dots" if item.is_measured and len(item.time) <= _FEW and not is_curve else "line"


def _phase(series: Sequence[Series], pair: Pair, column_of: Callable[[str], Column]) -> Panel:
    x_column, y_column = column_of(pair.x), column_of(pair.y)
    panel = Panel(PLANE, titled(x_column), titled(y_column))
    for k, item in enumerate(series):
        x, y = item.values(pair.x), item.values(pair.y)
        if x is not None and y is not None:
            panel.lines.append(Line(scaled(x_column, x), scaled(y_column, y), item.label, k, _kind(item)))
    return panel


def _section(series: Sequence[Series], pair: Pair, cut: tuple[str, float],
             column_of: Callable[[str], Column]) -> tuple[Panel, list[str]]:
    x_column, y_column, column = column_of(pair.x), column_of(pair.y), column_of(cut[0])
    level = f"{scaled(column, cut[1]):g} {shown_unit(column)}".strip()  # type: ignore[arg-type]
    panel = Panel(PLANE, f"{titled(x_column)}, where {cut[0]} rises through {level}", titled(y_column))
    notes = []
    for k, item in enumerate(series):
        crossing, x, y = item.values(cut[0]), item.values(pair.x), item.values(pair.y)
        if crossing is None or x is None or y is None:
            continue
        found = find_section(item.time, crossing, cut[1], [x, y])
        panel.lines.append(Line(scaled(x_column, found.values[0]), scaled(y_column, found.values[1]), item.label, k, "points"))
        of = f" of {item.label}" if len(series) > 1 else ""
        if found.coarse:
            notes.append(f"{found.coarse} crossing{'s' if found.coarse > 1 else ''} of the section{of} left out: rows are too "
                         "far apart there, or the motion jumps; a smaller --interval tells")
        if not len(found.times):
            notes.append(f"the section{of} is empty: '{cut[0]}' nowhere rises through {level}")
    return panel, notes
