"""table(x, "road.csv", column = "z", ...): which column of which file is meant, and what it says between rows and beyond them."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from lagrangia.base.diagnostics import LagError, Report, Span, fail, nearest, suggest
from lagrangia.base.records import dataclass
from lagrangia.base.table_data import DEGREES, Beyond, TableData
from lagrangia.language.tree import Call, Flat, Number, String
from lagrangia.language.units import Dimension, parse_unit
from lagrangia.run.columns import Columns, read_columns
from lagrangia.run.lookup import made_table

T = TypeVar("T")
_BEYOND = {beyond.name.lower(): beyond for beyond in Beyond}
_OPTIONS = ("column", "smoothness", "beyond")
PLANE = "plane"  # what a table in two variables has in the place of its smoothness


@dataclass(frozen=True)
class Lookup:
    """A column of a file as a function of the first one. The path is relative to the text that names it."""

    path: str
    column: str | int | None  # by name, or by number from 1; None: the second of two
    smoothness: str
    beyond: Beyond


@dataclass(frozen=True, eq=False)
class ReadTable:
    """The table in SI units, with the dimensions of argument and value; None where the file says no unit."""

    data: TableData
    argument: Dimension | None
    value: Dimension | None


@dataclass(frozen=True, eq=False)
class ReadPlane:
    """z[i][j] at x[i] and y[j], in SI units, with the dimensions of x, y and z; None where the file says no unit."""

    name: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    z: tuple[tuple[float, ...], ...]
    dimensions: tuple[Dimension | None, ...]


def lookup_of(call: Call[Any]) -> Lookup:
    """What table(x, "file", ...) asks for. Raises LagError L0215."""
    file = call.arguments[1]
    if not isinstance(file, String):
        fail("L0215", "a table has a file, or points in two arrays", call.span,
             'write: table(x, "road.csv", column = "z") or table(x, {x1, x2, ...}, {y1, y2, ...})')
    column, smoothness, beyond = options_of(call)
    folder = os.path.dirname(file.span.source.name)
    return Lookup(os.path.normpath(os.path.join(folder, file.value)), column, smoothness, beyond)


def plane_of(call: Call[Any]) -> Lookup:
    """What table2(x, y, "file") asks for. Raises LagError L0215."""
    file = call.arguments[2]
    if not isinstance(file, String):
        fail("L0215", "a table in two variables has a file, or points in three arrays", call.span,
             'write: table2(x, y, "map.csv", column = "z") or table2(x, y, {x1, x2}, {y1, y2}, {{z11, z12}, {z21, z22}})')
    if other := next((name for name, _ in call.named if name != "column"), None):
        fail("L0901" if other in _OPTIONS else "L0215", f"not supported yet: '{other}' of a table in two variables", call.span,
             "it is straight along both in each cell, and held beyond the ends")
    column = _column(call.named[0][1]) if call.named else None
    return Lookup(os.path.normpath(os.path.join(os.path.dirname(file.span.source.name), file.value)), column, PLANE, Beyond.HOLD)


def options_of(call: Call[Any]) -> tuple[str | int | None, str, Beyond]:
    """column, smoothness and beyond of a call. Raises LagError L0215."""
    given: dict[str, Flat] = {}
    for name, value in call.named:
        if name == "column" and len(call.arguments) != 2:
            fail("L0215", "points in two arrays have no columns", value.span, "a column is one of a file")
        if name not in _OPTIONS:
            fail("L0215", f"table has no option '{name}'", value.span, *filter(None, [suggest(name, _OPTIONS)]))
        if name in given:
            fail("L0215", f"'{name}' is given twice", value.span)
        given[name] = value
    smoothness = _choice(given, "smoothness", tuple(DEGREES), "linear")
    beyond = _BEYOND[_choice(given, "beyond", tuple(_BEYOND), "hold")]
    if smoothness == "steps" and beyond is Beyond.LINEAR:
        fail("L0215", "steps have no slope with which they could go on", given["beyond"].span, 'write: beyond = "hold"')
    return _column(given.get("column")), smoothness, beyond


def _choice(given: Mapping[str, Flat], name: str, known: tuple[str, ...], usual: str) -> str:
    value = given.get(name)
    if value is None:
        return usual
    if not isinstance(value, String) or value.value not in known:
        listed = ", ".join(f'"{word}"' for word in known)
        near = nearest(value.value, known) if isinstance(value, String) else None
        fail("L0215", f"{name} is one of {listed}", value.span, *([f"did you mean '{near}'?"] if near else []))
    return value.value


def _column(value: Flat | None) -> str | int | None:
    if value is None:
        return None
    if isinstance(value, String):
        return value.value
    if isinstance(value, Number) and value.value.is_integer() and value.unit is None:
        return int(value.value)
    fail("L0215", "a column is a name in quotes, or a number from 1", value.span)


def read_tables(asked: Mapping[Lookup, Span]) -> dict[Lookup, ReadTable]:
    """All tables in one variable that a model asks for, each file read once. Raises LagError L0703."""
    return _read_all({lookup: span for lookup, span in asked.items() if lookup.smoothness != PLANE}, _read)


def read_planes(asked: Mapping[Lookup, Span]) -> dict[Lookup, ReadPlane]:
    """Those in two variables, likewise."""
    return _read_all({lookup: span for lookup, span in asked.items() if lookup.smoothness == PLANE}, _read_plane)


def _read_all(asked: Mapping[Lookup, Span], read: Callable[[Lookup, Columns, Span], T]) -> dict[Lookup, T]:
    files: dict[str, Columns] = {}
    found, report = dict[Lookup, T](), Report()
    for lookup, span in asked.items():
        try:
            if lookup.path not in files:
                files[lookup.path] = read_columns(Path(lookup.path), span)
            found[lookup] = read(lookup, files[lookup.path], span)
        except LagError as error:
            report.add(error.diagnostics)
    report.raise_errors()
    return found


def _read_plane(lookup: Lookup, columns: Columns, span: Span) -> ReadPlane:
    """A row for each point of the grid: x, y and what is asked for, in any order."""
    is_third = lookup.column is None and len(columns.names) == 3
    place = 2 if is_third else columns.place(lookup.column) if lookup.column is not None else None
    if place is None:
        known = ", ".join(name or str(k) for k, name in enumerate(columns.names, 1))
        fail("L0703", f"'{lookup.path}' has no column for the values of a table in two variables", span,
             f"its columns are: {known}"[:300], 'the first two are x and y; of more than one behind them, say column = "..."')
    (x, y, z), dimensions = zip(*(_in_si(columns, k, lookup.path, span) for k in (0, 1, place)), strict=True)
    points = {(float(a), float(b)): float(c) for a, b, c in zip(x, y, z, strict=True)}
    xs, ys = sorted({a for a, _ in points}), sorted({b for _, b in points})
    missing = next(((a, b) for a in xs for b in ys if (a, b) not in points), None)
    if missing or len(points) < len(x) or len(xs) < 2 or len(ys) < 2:
        what = f"nothing at {missing[0]:g}, {missing[1]:g}" if missing else "a point twice" if len(points) < len(x) else "no grid"
        fail("L0703", f"'{lookup.path}' has {what}: a table in two variables has a row for each x with each y, once", span)
    grid = tuple(tuple(points[a, b] for b in ys) for a in xs)
    return ReadPlane(os.path.basename(lookup.path), tuple(xs), tuple(ys), grid, dimensions)


def _read(lookup: Lookup, columns: Columns, span: Span) -> ReadTable:
    place = columns.place(lookup.column)
    if place is None:
        known = ", ".join(name or str(k) for k, name in enumerate(columns.names, 1))
        near = nearest(lookup.column, columns.names) if isinstance(lookup.column, str) else None
        what = f"no column {lookup.column!r}" if lookup.column is not None else f"{len(columns.names)} columns"
        fail("L0703", f"'{lookup.path}' has {what}", span, f"its columns are: {known}"[:300],
             *([f"did you mean '{near}'?"] if near else []),
             *(['say which one: column = "..."'] if lookup.column is None else []))
    (x, argument), (y, value) = (_in_si(columns, k, lookup.path, span) for k in (0, place))
    falls = next((k for k in range(1, len(x)) if not x[k] > x[k - 1]), None) if not bool((x[1:] > x[:-1]).all()) else None
    if falls is not None or len(x) < 2:
        where = f": {x[falls]:g} follows {x[falls - 1]:g}" if falls is not None else ""
        fail("L0703", f"the first column of '{lookup.path}' must rise, in two rows or more{where}", span,
             "it is what the table is asked for: the time, a place")
    if lookup.beyond is Beyond.PERIODIC and lookup.smoothness != "steps" and y[0] != y[-1]:
        fail("L0703", f"the last row of '{lookup.path}' is not the first one again: {y[-1]:g} is not {y[0]:g}", span,
             "what comes again ends where it begins; add a row at the period")
    return ReadTable(made_table(os.path.basename(lookup.path), x, y, lookup.smoothness, lookup.beyond), argument, value)


def _in_si(columns: Columns, place: int, path: str, span: Span) -> tuple[Any, Dimension | None]:
    text, values = columns.units[place], columns.values[place]
    if not text:
        return values, None
    try:
        unit = parse_unit("1" if text == "-" else text)
    except ValueError as error:
        fail("L0301", f"{error}, in the line of names of '{path}'", span)
    return values * unit.factor + unit.offset, unit.dimension
