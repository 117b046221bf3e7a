"""What the model descriptions of both versions of the standard have in common: elements, units, who is to be named."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from html import escape
from math import isclose

from lagrangia.base.records import dataclass
from lagrangia.fmu.factors import CONSTANT, DEPENDENT
from lagrangia.fmu.variable import Variable
from lagrangia.fmu.variables import FmuModel
from lagrangia.language.units import parse_unit

LOG_CATEGORIES = {"logStatusError": "calls that failed", "logStatusDiscard": "values that could not be computed",
                  "logStatusWarning": "doubtful calls"}
_QUANTITIES = {"rad": "Angle", "rad/s": "AngularVelocity", "rad/s2": "AngularAcceleration", "m": "Length", "m/s": "Velocity",
               "m/s2": "Acceleration", "kg": "Mass", "kg.m2": "Inertia", "N": "Force", "N.m": "Torque", "N/m": "Stiffness",
               "N.s/m": "Damping", "N.m/rad": "TorsionStiffness", "N.m.s/rad": "TorsionDamping", "J": "Energy", "W": "Power",
               "s": "Time", "Hz": "Frequency"}
_NOT_STRUCTURED = re.compile(r"""[^ -~]|[`"]""")
_IN_ATTRIBUTES = str.maketrans({'"': "&quot;", "\n": "&#10;", "\t": "&#9;"})
_BASES = ("kg", "m", "s", "A", "K", "mol", "cd")
_MOST_DEPENDENCIES = 1_000_000  # numbers in one list of dependencies, above which it is left out: "depends on all"


@dataclass(frozen=True)
class About:
    """What is said of the FMU as a whole. `date` as 2026-01-31T12:00:00Z."""

    token: str
    identifier: str
    kinds: tuple[str, ...]  # of "me", "cs"
    sources: tuple[str, ...]
    tool: str
    date: str
    info: Mapping[str, str] = field(default_factory=dict)  # author, version, copyright, license


def element(name: str, attributes: Mapping[str, object], *content: str, indent: int = 1) -> str:
    """One XML element; attributes that are None are left out."""
    shown = "".join(f" {key}={_attribute(value)}" for key, value in attributes.items() if value is not None)
    space = "  " * indent
    inside = [text for text in content if text]
    if not inside:
        return f"{space}<{name}{shown}/>"
    return "\n".join([f"{space}<{name}{shown}>", *inside, f"{space}</{name}>"])


def _attribute(value: object) -> str:
    if isinstance(value, bool):
        return '"true"' if value else '"false"'
    if isinstance(value, float):
        return f'"{value!r}"'
    text = "".join(c for c in str(value) if c >= " " or c in "\t\n")
    return f'"{escape(text, quote=False).translate(_IN_ATTRIBUTES)}"'


def experiment(model: FmuModel) -> dict[str, object]:
    """Start, stop, tolerance and step of the default experiment, times in s."""
    scene = model.scene
    step = scene.interval if scene.interval else (scene.stop - scene.start) / 500
    return {"startTime": float(scene.start), "stopTime": float(scene.stop), "tolerance": float(scene.tolerance),
            "stepSize": float(step) if step > 0 else None}


def unit_of(variable: Variable) -> str | None:
    """None for numbers without one."""
    return variable.unit if variable.unit not in ("", "1") else None


def display_unit_of(variable: Variable) -> str | None:
    """Its display unit, where it has one beside its unit."""
    has_one = unit_of(variable) and variable.display_unit not in ("", "1", variable.unit)
    return variable.display_unit if has_one else None


def type_of(variable: Variable) -> str | None:
    """The name of its type, where its unit has a quantity."""
    unit = unit_of(variable)
    return _QUANTITIES.get(unit) if unit else None


def types(model: FmuModel) -> Iterator[tuple[str, str, str | None]]:
    """Names, units and display units of the quantity types in use."""
    reals = [v for v in model.variables if v.kind == "Real"]
    for unit in dict.fromkeys(filter(None, map(unit_of, reals))):
        if unit in _QUANTITIES:
            yield _QUANTITIES[unit], unit, next((d for v in reals if v.unit == unit and (d := display_unit_of(v))), None)


def naming(model: FmuModel) -> str:
    """The convention that the names of variables keep: the structured one knows some signs of ASCII alone between quotes."""
    return "flat" if any(_NOT_STRUCTURED.search(variable.name) for variable in model.variables) else "structured"


def unit_definitions(model: FmuModel, indent: int = 1) -> str:
    """Every unit in use with its SI dimension, and the display units below it."""
    shown: dict[str, dict[str, None]] = {}
    for variable in model.variables:
        unit = unit_of(variable)
        if unit is not None:
            displays = shown.setdefault(unit, {})
            if display := display_unit_of(variable):
                displays[display] = None
    units = [element("Unit", {"name": unit}, _base_unit(unit), *(_display_unit(unit, d) for d in displays), indent=indent + 1)
             for unit, displays in shown.items()]
    return element("UnitDefinitions", {}, *units, indent=indent) if units else ""


def _base_unit(unit: str) -> str:
    parsed = parse_unit(unit)
    exponents: dict[str, object] = {base: int(p) for base, p in zip(_BASES, parsed.dimension, strict=True) if p}
    if any(p.denominator != 1 for p in parsed.dimension):
        return ""
    above, _, below = unit.partition("/")
    radians = above.split(".").count("rad") - below.strip("()").split(".").count("rad")
    if radians:
        exponents["rad"] = radians
    if not isclose(parsed.factor, 1, rel_tol=1e-15):
        exponents["factor"] = float(parsed.factor)
    if parsed.offset:
        exponents["offset"] = float(parsed.offset)
    return element("BaseUnit", exponents, indent=3)


def _display_unit(unit: str, display: str) -> str:
    base, shown = parse_unit(unit), parse_unit(display)
    return element("DisplayUnit", {"name": display, "factor": base.factor / shown.factor}, indent=3)


def known_when_running(model: FmuModel, name: str, with_parameters: bool) -> dict[str, str]:
    """What an output or a derivative depends on while the simulation runs, and how."""
    groups = {"time", "state", "input"} | ({"parameter"} if with_parameters else set())
    return {known: kind for known, kind in model.dependencies[name].items() if model.named(known).group in groups}


def initial_unknowns(model: FmuModel) -> list[tuple[Variable, dict[str, str]]]:
    """The exact set that the standards name, in the order of the variables, and what each depends on at the start: as a constant
    factor or in another way, which is all that there is there."""
    free = [v.name for v in model.of("parameter") if v.causality == "parameter"]
    states = {v.name: v for v in model.of("state")}
    found = []
    for variable in model.variables:
        if variable.group == "state" and variable.initial != "exact":
            found.append((variable, dict.fromkeys(free, DEPENDENT)))
        elif variable.group in ("slope", "output"):
            found.append((variable, _at_start(model, model.dependencies[variable.name], states, free)))
        elif variable.causality == "calculatedParameter":
            found.append((variable, dict(model.dependencies[variable.name])))
    return [(variable, {known: kind if kind == CONSTANT else DEPENDENT for known, kind in knowns.items()})
            for variable, knowns in found]


def _at_start(model: FmuModel, knowns: Mapping[str, str], states: Mapping[str, Variable], free: Sequence[str]) -> dict[str, str]:
    """Dependencies with those states replaced that follow from parameters themselves, in no way that is known."""
    exact = {name: kind for name, kind in knowns.items() if name not in states or states[name].initial == "exact"}
    if len(exact) == len(knowns):
        return exact
    wanted = exact | dict.fromkeys(free, DEPENDENT)
    return {v.name: wanted[v.name] for v in model.variables if v.name in wanted}


def dependencies(knowns: Mapping[str, str], numbers: Mapping[str, int]) -> dict[str, object]:
    """The attributes of an unknown that name its knowns by their numbers, in rising order."""
    ordered = sorted(knowns, key=numbers.__getitem__)
    return {"dependencies": " ".join(str(numbers[known]) for known in ordered),
            "dependenciesKind": " ".join(knowns[known] for known in ordered)}


def too_many(lists: Iterable[Collection[str]]) -> bool:
    """Whether lists of dependencies are longer than readers bear."""
    return sum(map(len, lists)) > _MOST_DEPENDENCIES
