"""Annotations of a model: the experiment that it declares, and the warnings that it allows."""

import re
from collections.abc import Mapping

from lagrangia.base.diagnostics import WARNINGS, Report, Span, fail, nearest, suggest
from lagrangia.language.classes import BUILTIN_TYPES, ClassTable
from lagrangia.language.flat import Experiment
from lagrangia.language.folding import fold
from lagrangia.language.instances import Scope
from lagrangia.language.names import Names
from lagrangia.language.tree import Argument, ClassDefinition, Extends, Number, String
from lagrangia.language.units import ONE, dimension
from lagrangia.language.units_written import read_unit

_CODE = re.compile(r"L\d{4}")
_FIELDS = {"StartTime": "start", "StopTime": "stop", "Tolerance": "tolerance", "Interval": "interval"}


def allowed_of(table: ClassTable, definition: ClassDefinition) -> tuple[str, ...]:
    """The codes of annotation(allow = "L0224, L0741"). Raises LagError L0208."""
    found: list[str] = []
    for top in (top for base in table.lineage(definition) for top in base.annotation):
        if top.name == "allow":
            codes = top.value.value.replace(",", " ").split() if isinstance(top.value, String) else []
            if not codes or not all(_CODE.fullmatch(code) for code in codes):
                fail("L0208", "'allow' is a text with codes of warnings", top.span, 'annotation(allow = "L0224, L0741")')
            if unknown := [code for code in codes if code not in WARNINGS]:
                fail("L0208", f"there is no warning '{unknown[0]}'", top.span, f"those are {', '.join(WARNINGS)}")
            found += codes
    return tuple(found)


def experiment_of(table: ClassTable, definition: ClassDefinition, names: Names, scope: Scope) -> Experiment:
    """As the model's annotation says, and where it says nothing, those of the models it extends. Raises LagError L0208, L0301."""
    values: dict[str, float] = {}
    places: dict[str, Span] = {}
    annotation = [top for base in reversed(table.lineage(definition)) for top in base.annotation]
    for top in annotation:
        if top.name != "experiment" and nearest(top.name, ["experiment"]):
            fail("L0208", f"there is no annotation '{top.name}'", top.name_span, "did you mean 'experiment'?")
    if wrong := [top for top in annotation if top.name == "experiment" and top.value is not None]:
        fail("L0208", "an experiment has no value", wrong[0].span, "write: annotation(experiment(StopTime = 10))")
    for argument in (a for top in annotation if top.name == "experiment" for a in top.arguments):
        if argument.name not in _FIELDS:
            fail("L0208", f"experiment has no '{argument.name}'", argument.name_span, suggest(argument.name, _FIELDS))
        _require_unit(argument)
        value = _value_of(argument, names, scope)
        if value is None or isinstance(value, bool):
            fail("L0208", f"{argument.name} must be a number known beforehand", argument.span)
        values[_FIELDS[argument.name]], places[argument.name] = float(value), argument.span
    return _checked(Experiment(**values, ends="stop" in values), places)


def _require_unit(argument: Argument) -> None:
    """Times may be in any unit of time; a tolerance has none. Raises LagError L0301."""
    unit = argument.value.unit if isinstance(argument.value, Number) else None
    is_time = argument.name != "Tolerance"
    if unit and read_unit(unit, argument.span).dimension != (dimension(s=1) if is_time else ONE):
        fail("L0301", f"{argument.name} is in {unit}: it is {'a time, in s' if is_time else 'a number'}", argument.span)


def _checked(experiment: Experiment, places: Mapping[str, Span]) -> Experiment:
    start, stop, tolerance, interval = experiment.start, experiment.stop, experiment.tolerance, experiment.interval
    if not stop > start:
        place = places.get("StopTime", places.get("StartTime"))
        fail("L0208", f"the StopTime {stop:g} must be later than the StartTime {start:g}", place)
    if not 0 < tolerance < 1:
        fail("L0208", f"the Tolerance must lie between 0 and 1, not {tolerance:g}", places["Tolerance"],
             "1e-6 is loose, 1e-12 is tight")
    if interval is not None and not interval > 0:
        fail("L0208", f"the Interval must be positive, not {interval:g}", places["Interval"])
    return experiment


def find_rivals(table: ClassTable, definition: ClassDefinition, names: Names, scope: Scope) -> Report:
    """A warning (L0224) where two of the models that one extends say other values of its experiment, of which the first counts,
    and it says none itself."""
    report, heir = Report(), definition.name
    for name in _FIELDS:
        stated = [a for a in reversed(_stated(table, definition, name)) if a.value is not None]
        found = list({_value_of(a, names, scope): a for a in stated}.values())
        if len(found) > 1:
            first, other = found[-1], found[0]
            report.warning("L0224", f"this {name} has no effect: another model that {heir} extends has one, at {first.span}",
                           other.span, f"state it in {heir}: annotation(experiment({name} = ...))")
    return report


def _value_of(argument: Argument, names: Names, scope: Scope) -> float | bool | None:
    return fold(names.flatten(argument.value, scope)) if argument.value is not None else None


def _stated(table: ClassTable, definition: ClassDefinition, name: str) -> list[Argument]:
    """By the class itself, or else by each of those that it extends."""
    own = [a for top in definition.annotation if top.name == "experiment" for a in top.arguments if a.name == name]
    bases = (table.lookup(e.type_name, e.span) for e in definition.elements
             if isinstance(e, Extends) and e.type_name not in BUILTIN_TYPES)
    return own or [a for base in bases for a in _stated(table, base, name)]
