"""A compiled scene as plain data: all that a run needs, and nothing that needs CasADi or Lark to be read."""

import base64
import json
import math
from array import array
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from lagrangia.base.records import dataclass
from lagrangia.base.table_data import Beyond, TableData
from lagrangia.native.tapes import Tape

ALL_REACTIONS = "*.reaction"  # among outputs that are asked for: the reactions of all joints

# The last columns of each row, in J.
ENERGY_NAMES = ("energy.kinetic", "energy.potential", "energy.total", "energy.dissipated", "energy.work")


@dataclass(frozen=True)
class Parameter:
    """A scalar parameter. `value` is None when it follows from other parameters; `place` is where it is declared; `compiled` is
    the only value that the functions hold for, None where it is open."""

    name: str
    unit: str
    value: float | None
    minimum: float | None
    maximum: float | None
    description: str
    place: str
    compiled: float | None = None
    locked: str = ""  # "final" or "protected": why it cannot be set
    is_stated: bool = True  # False for an input whose declaration says no value: it is 0


@dataclass(frozen=True)
class Column:
    """A quantity of the results."""

    name: str
    unit: str
    display_unit: str
    description: str


@dataclass(frozen=True)
class Scene:
    """A compiled scene: names, units, tapes and all else that a run and its results need."""

    name: str
    description: str
    coordinates: tuple[Column, ...]
    rates: tuple[Column, ...]
    outputs: tuple[Column, ...]
    parameters: tuple[Parameter, ...]
    inputs: tuple[Parameter, ...]
    structural: Mapping[str, float | bool | str]
    aliases: Mapping[str, int]  # other names of q (0 .. n-1) and v (n .. 2n-1)
    start: float
    stop: float
    tolerance: float
    interval: float | None
    sizes: Mapping[str, int]  # integers of LagModel
    coordinate_kind: tuple[int, ...]
    fixed: tuple[int, ...]
    event_kind: tuple[int, ...]
    initial_places: tuple[tuple[str, str], ...]  # what is wrong when an initial equation misses, and its line
    notes: Mapping[str, Any]  # figures for --stats
    patterns: Mapping[str, tuple[int, ...]]  # lists of places of LagModel
    refused: Mapping[str, str]  # solvers that cannot run this scene, and why
    tapes: Mapping[str, Tape]
    islands: "tuple[tuple[tuple[int, ...], Scene], ...]"  # coordinates that do not interact with others, and their scenes
    unevenness: Tape | None  # of p: 0 where the formulas hold; None where they hold for all masses
    tables: tuple[TableData, ...]  # shared by the islands
    lost: Mapping[str, tuple[int, str]]  # place among the starts of LagModel's n_lost coordinates, then their rates, and the unit

    @property
    def pieces(self) -> list[tuple[int, int, int, int]]:
        """Of each input that stands where functions of time do: its place among them, those of its rates (-1: they do not
        matter), the first of its modes."""
        places = self.patterns.get("pieces", ())
        return [(places[k], places[k + 1], places[k + 2], places[k + 3]) for k in range(0, len(places), 4)]

    @property
    def n(self) -> int:
        """The number of coordinates."""
        return len(self.coordinates)

    @property
    def start_units(self) -> dict[str, str]:
        """Of everything that a start value can be given for."""
        units = {c.name: c.unit for c in (*self.coordinates, *self.rates)}
        units |= {alias: self.rates[slot - self.n].unit for alias, slot in self.aliases.items()}
        return units | {name: unit for name, (_, unit) in self.lost.items()} | dict.fromkeys(self.attitudes, "1")

    @property
    def signals(self) -> Mapping[str, str]:
        """First-order states by the coordinates whose rates they are."""
        found: Mapping[str, str] = self.notes["signals"]
        return found

    @property
    def kept(self) -> tuple[str, ...]:
        """Of `signals`, the coordinates of discrete variables, which change at events alone."""
        return tuple(self.notes.get("kept", ()))

    @property
    def discrete(self) -> tuple[str, ...]:
        """The names of discrete variables, without those that are no one's but their events' (changes.py)."""
        return tuple(self.signals[name] for name in self.kept if name not in self.inner)

    @property
    def inner(self) -> frozenset[str]:
        """The coordinates of discrete variables that are no one's but their events', and these."""
        found = self.notes.get("inner", ())
        return frozenset((*found, *(self.signals[name] for name in found)))

    @property
    def hidden(self) -> frozenset[str]:
        """Columns of rows that no table has: the coordinates whose rates are first-order states, on which nothing depends, parts
        of attitudes, and discrete variables that are no one's."""
        return frozenset((*self.signals, *(f"der({name})" for name in self.signals), *self.turned, *self.inner))

    @property
    def flowing(self) -> Mapping[str, str]:
        """`signals` without discrete variables."""
        return {name: state for name, state in self.signals.items() if name not in self.kept}

    @property
    def turned(self) -> tuple[str, ...]:
        """Coordinates of attitudes, which say nothing without the references that they are against."""
        return tuple(part for parts in self.attitudes.values() for part in parts)

    @property
    def attitudes(self) -> Mapping[str, tuple[str, ...]]:
        """The three coordinates of each attitude, by its name."""
        found: Mapping[str, tuple[str, ...]] = self.notes.get("attitudes", {})
        return found

    @property
    def told_positions(self) -> tuple[Column, ...]:
        """The coordinates, with a quaternion in the place of the three of an attitude."""
        outputs = {column.name: column for column in self.outputs}
        firsts = {parts[0]: name for name, parts in self.attitudes.items()}
        found: list[Column] = []
        for column in self.coordinates:
            if column.name in firsts:
                found += [outputs[f"{firsts[column.name]}[{k}]"] for k in range(1, 5)]
            elif column.name not in self.turned:
                found.append(column)
        return tuple(found)

    @property
    def own_outputs(self) -> tuple[Column, ...]:
        """The outputs without the quaternions of attitudes, which are the first of them."""
        return self.outputs[4 * len(self.attitudes) :]

    @property
    def told(self) -> tuple[str, ...]:
        """The names of the coordinates, for people: those of an attitude are one."""
        parts = {part: name for name, of in self.attitudes.items() for part in of}
        return tuple(dict.fromkeys(parts.get(c.name, c.name) for c in self.coordinates if c.name not in self.signals))

    @property
    def moving(self) -> tuple[Column, ...]:
        """What tells where the mechanism is: positions without those whose rates are first-order states."""
        return tuple(c for c in self.told_positions if c.name not in self.signals)

    @property
    def limits(self) -> tuple[list[float], list[float]]:
        """The least and the largest values of all parameters."""
        return ([-math.inf if p.minimum is None else p.minimum for p in self.parameters],
                [math.inf if p.maximum is None else p.maximum for p in self.parameters])

    def slot(self, name: str) -> int | None:
        """Place in (q, v) of a coordinate, a rate or another name of one."""
        for k, column in enumerate((*self.coordinates, *self.rates)):
            if column.name == name:
                return k
        return self.aliases.get(name)


_PACKED = ("tapes", "unevenness", "islands", "tables")


def to_json(scene: Scene) -> str:
    """As text that can be kept."""
    plain = {name: getattr(scene, name) for name in Scene.__dataclass_fields__ if name not in _PACKED}
    for name in ("coordinates", "rates", "outputs", "parameters", "inputs"):
        plain[name] = [vars(item) for item in plain[name]]
    plain["tapes"] = {name: _pack(tape) for name, tape in scene.tapes.items()}
    plain["islands"] = [(list(places), to_json(replace(island, tables=()))) for places, island in scene.islands]
    plain["tables"] = [_pack_table(table) for table in scene.tables]
    plain["unevenness"] = _pack(scene.unevenness) if scene.unevenness is not None else None
    return json.dumps(plain, separators=(",", ":"))


def from_json(text: str | bytes) -> Scene:
    """Raises ValueError, KeyError or TypeError when the text is no scene."""
    plain = json.loads(text)
    kinds = {"coordinates": Column, "rates": Column, "outputs": Column, "parameters": Parameter, "inputs": Parameter}
    for name, kind in kinds.items():
        plain[name] = tuple(kind(**item) for item in plain[name])
    for name in ("coordinate_kind", "fixed", "event_kind"):
        plain[name] = tuple(plain[name])
    plain["initial_places"] = tuple((what, excerpt) for what, excerpt in plain["initial_places"])
    plain["patterns"] = {name: tuple(places) for name, places in plain["patterns"].items()}
    plain["tapes"] = {name: _unpack(tape) for name, tape in plain["tapes"].items()}
    plain["tables"] = tuple(map(_unpack_table, plain["tables"]))
    plain["islands"] = tuple((tuple(places), replace(from_json(island), tables=plain["tables"]))
                             for places, island in plain["islands"])
    plain["unevenness"] = _unpack(plain["unevenness"]) if plain["unevenness"] is not None else None
    plain["lost"] = {name: (place, unit) for name, (place, unit) in plain["lost"].items()}
    return Scene(**plain)


_OF_TABLES = ("x", "y", "slopes")


def _pack_table(table: TableData) -> dict[str, Any]:
    return {**{name: getattr(table, name) for name in TableData.__dataclass_fields__},
            **{name: _text_of(getattr(table, name)) for name in _OF_TABLES}}


def _unpack_table(plain: dict[str, Any]) -> TableData:
    return TableData(**{**plain, "beyond": Beyond(plain["beyond"]), **{name: _doubles_of(plain[name]) for name in _OF_TABLES}})


def _text_of(values: Any) -> str:
    return base64.b64encode(bytes(memoryview(values).cast("B"))).decode() if len(values) else ""


def _doubles_of(text: str) -> "array[float]":
    found: array[float] = array("d")
    found.frombytes(base64.b64decode(text))
    return found


def _pack(tape: Tape) -> dict[str, Any]:
    return {"in": list(tape.in_sizes), "out": list(tape.out_sizes), "work": tape.n_work,
            "code": base64.b64encode(bytes(memoryview(tape.code).cast("B"))).decode(),
            "constants": base64.b64encode(bytes(memoryview(tape.constants).cast("B"))).decode()}


def _unpack(plain: dict[str, Any]) -> Tape:
    code: array[int] = array("i")
    constants: array[float] = array("d")
    code.frombytes(base64.b64decode(plain["code"]))
    constants.frombytes(base64.b64decode(plain["constants"]))
    return Tape(plain["in"], plain["out"], plain["work"], code, constants)
