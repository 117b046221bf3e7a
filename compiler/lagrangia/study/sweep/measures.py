"""What is kept of each run: `max(y, from=2)`, `at(0.5, y)`, `count(abs(y) > 3)` -> numbers of a motion as reduce.h takes them."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import NoReturn

from lagrangia.base.checked_values import names
from lagrangia.base.cutting import QUOTED, cut_list, split_list
from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.units import parse_unit, spell
from lagrangia.language.values import read_value
from lagrangia.run.batch import Kind, Reduction
from lagrangia.run.request import Experiment
from lagrangia.run.scene import Scene

_PLAIN = {
    "min": Kind.MIN, "max": Kind.MAX, "range": Kind.RANGE, "mean": Kind.MEAN, "rms": Kind.RMS, "integral": Kind.INTEGRAL,
    "time_of_min": Kind.TIME_OF_MIN, "time_of_max": Kind.TIME_OF_MAX, "overshoot": Kind.OVERSHOOT,
    "peak_frequency": Kind.PEAK_FREQUENCY, "peak_amplitude": Kind.PEAK_AMPLITUDE,
}  # fmt: skip
_CONDITIONS = {
    "first_time": (Kind.FIRST_ABOVE, Kind.FIRST_BELOW), "last_time": (Kind.LAST_ABOVE, Kind.LAST_BELOW),
    "count": (Kind.COUNT_ABOVE, Kind.COUNT_BELOW), "duration": (Kind.DURATION_ABOVE, Kind.DURATION_BELOW),
    "period": (Kind.PERIOD_ABOVE, Kind.PERIOD_BELOW),
}  # fmt: skip
_ENDS = ("final", "initial", "at")  # of one time: nothing to be taken over a window
MEASURES = (*_ENDS, *_PLAIN, *_CONDITIONS, "settling_time", "damage")
_NOT_OF_ABSOLUTE = {"settling_time", "peak_frequency", "peak_amplitude"}
_BAND = "0.02"  # of settling_time, where none is given
_TIMES = {"time_of_min", "time_of_max", "first_time", "last_time", "duration", "period", "settling_time"}
_BARE = {"count", "overshoot", "damage"}  # numbers without a unit
_ENERGIES = {"energy.kinetic": 0, "energy.potential": 1, "energy.dissipated": 3}  # places behind the outputs of a row
_CALL = re.compile(r"(\w+)\((.*)\)", re.DOTALL)
_CONDITION = re.compile(r"(.*?)\s*([<>]=?)\s*([^<>=]*)", re.DOTALL)
_OPTION = re.compile(r"(\w+)\s*=(?!=)\s*(.*)", re.DOTALL)


@dataclass(frozen=True)
class Measure:
    """A number of a motion: `kind` of `quantity` (of its absolute value or not). All other is text: `value` is a time, a level, a
    share or an exponent, `size` the range by which those of cycles are divided, `start` and `end` the times it is taken over."""

    text: str
    kind: str
    quantity: str
    absolute: bool = False
    relation: str = ""
    value: str = ""
    size: str = ""
    start: str = ""
    end: str = ""


def read_measures(given: str | Sequence[str]) -> list[Measure]:
    """A text alone is a list as on the command line. Raises LagError L0711."""
    measures = [read_measure(text) for text in (split_list(given) if isinstance(given, str) else names("measures", given))]
    texts = [measure.text for measure in measures]
    if twice := [text for text in texts if texts.count(text) > 1]:
        fail("L0711", f"{twice[0]} is measured twice")
    return measures


def read_measure(text: str) -> Measure:
    """`y` alone stands for its final value. Raises LagError L0711 when the text is no measure."""
    if not isinstance(text, str):
        fail("L0711", f"a measure is a text, such as 'max(y)', not {text!r}"[:200])
    text = " ".join(text.split())
    match = _CALL.fullmatch(text)
    if match is None or match[1] == "der":
        return Measure(f"final({text})", "final", text)
    kind, (inner, *arguments), options = match[1], *_arguments(text, match[2])
    if kind not in MEASURES:
        _refuse_kind(kind, text)
    if kind in _ENDS and options:
        fail("L0711", f"'{text}' is of one time: it is not taken over a window")
    quantity, relation, value, *more = _given(text, kind, inner, arguments)
    return _of_quantity(Measure(text, kind, quantity, False, relation, value, *more, **options))


def _arguments(text: str, inside: str) -> tuple[list[str], dict[str, str]]:
    """What stands between the parentheses of a measure: its arguments, one at least, and the window."""
    arguments, options = [], {}
    for part in cut_list(inside):
        match = _OPTION.fullmatch(part)
        if match is None or any(c in part.partition("=")[0] for c in "<>"):
            arguments.append(part)
            continue
        name = {"from": "start", "to": "end"}.get(match[1])
        if name is None:
            fail("L0711", f"'{text}': there is no option '{match[1]}'", None, "a window is given as in max(y, from=2, to=5)")
        if name in options:
            fail("L0711", f"'{text}': '{match[1]}' is given twice")
        options[name] = match[2]
    return arguments or [""], options


def _refuse_kind(kind: str, text: str) -> NoReturn:
    if kind == "rainflow":
        fail("L0711", f"'{text}' is a table, not a number", None,
             "damage(y, slope) is a number of its cycles; in Python, model.rainflow('y') gives them all")
    fail("L0711", f"there is no measure '{kind}' in {text}", None, *filter(None, [suggest(kind, MEASURES)]),
         f"a measure is one of {', '.join(MEASURES)}: max(y), at(0.5, y), first_time(y > 3)")


def _given(text: str, kind: str, inner: str, arguments: list[str]) -> tuple[str, ...]:
    """Quantity, relation, value and size. Raises LagError L0711."""
    if kind == "at":
        if len(arguments) != 1:
            fail("L0711", f"'{text}' needs a time and a quantity: at(0.5, y)")
        return arguments[0], "", inner
    if kind == "settling_time" and len(arguments) <= 1:
        return inner, "", *(arguments or [_BAND])
    if kind == "damage":
        if not 1 <= len(arguments) <= 2:
            fail("L0711", f"'{text}' needs a quantity and the slope of its fatigue line: damage(y, 5) or damage(y, 5, 100[N])")
        return inner, "", *arguments
    if arguments:
        fail("L0711", f"'{text}': '{arguments[0]}' has no meaning there", None, "a window is given as in max(y, from=2, to=5)")
    if kind not in _CONDITIONS:
        return inner, "", ""
    condition = _CONDITION.fullmatch(inner)
    if condition is None and kind != "period":
        fail("L0711", f"'{text}' needs a condition: {kind}(y > 3) or {kind}(abs(y) < 0.01)")
    return (inner, "", "") if condition is None else (condition[1], condition[2], condition[3].strip())


def _of_quantity(measure: Measure) -> Measure:
    text, inner = measure.text, measure.quantity
    match = _CALL.fullmatch(inner)
    absolute = match is not None and match[1] == "abs"
    name = match[2].strip() if match is not None and absolute else inner.strip()
    call = _CALL.fullmatch(name)
    if not name or (call is not None and call[1] != "der") or re.search(r"[<>=+*/ ]|,(?![^\[]*\])", QUOTED.sub("q", name)):
        fail("L0711", f"'{text}': '{name}' is not the name of a quantity", None,
             "a quantity is a coordinate, der(coordinate), an output, or a place such as bar.b.y; a formula needs an output")
    if absolute and measure.kind in _NOT_OF_ABSOLUTE:
        fail("L0711", f"not supported yet: '{text}', of an absolute value", None, "declare the value as an output")
    return replace(measure, quantity=name, absolute=absolute)


def usual_measures(scene: Scene) -> list[Measure]:
    """Final values of all that tables have of coordinates, rates and outputs; of attitudes, their quaternions."""
    told = (c for c in (*scene.coordinates, *scene.rates, *scene.outputs) if c.name not in scene.hidden)
    return [Measure(f"final({c.name})", "final", c.name) for c in told]


def quantities(measures: Sequence[Measure]) -> tuple[str, ...]:
    """The names to be compiled in; time and energies are in every row."""
    return tuple(dict.fromkeys(m.quantity for m in measures if m.quantity != "time" and m.quantity not in _ENERGIES))


def unit_of(scene: Scene, measure: Measure) -> str:
    """The unit of the measure's result."""
    if measure.kind == "peak_frequency":
        return "Hz"
    if measure.kind in _TIMES or measure.kind in _BARE:
        return "s" if measure.kind in _TIMES else ""
    unit = _unit(scene, measure.quantity)
    return unit if measure.kind != "integral" else f"{unit}.s" if unit and "/" not in unit else f"s.{unit}" if unit else "s"


def reductions(scene: Scene, measures: Sequence[Measure], experiment: Experiment) -> tuple[Reduction, ...]:
    """For the columns of the scene's rows. Raises LagError L0701, L0711."""
    return tuple(_reduction(scene, measure, experiment) for measure in measures)


def _reduction(scene: Scene, measure: Measure, experiment: Experiment) -> Reduction:
    column, kind = _column(scene, measure), measure.kind
    if kind in _ENDS:
        when = {"final": experiment.stop, "initial": experiment.start}.get(kind)
        if when is None:
            when = _time(measure, measure.value, experiment)
        return Reduction(Kind.AT, column, measure.absolute, when, or_equal=kind == "final")
    start = _time(measure, measure.start, experiment) if measure.start else -math.inf
    end = _time(measure, measure.end, experiment) if measure.end else math.inf
    if max(start, experiment.start) >= min(end, experiment.stop):
        fail("L0711", f"'{measure.text}': the window is empty")
    rate = column + scene.n if 1 <= column <= scene.n else -1
    taken = Reduction(_PLAIN.get(kind, Kind.PERIOD), column, measure.absolute, rate=rate, start=start, end=end)
    unit = _unit(scene, measure.quantity)
    if measure.relation:
        taken = replace(taken, kind=_CONDITIONS[kind][measure.relation[0] == "<"], value=_value(measure, measure.value, unit),
                        or_equal=measure.relation.endswith("="))
    elif kind == "settling_time":
        taken = replace(taken, kind=Kind.SETTLING, value=_positive(measure, measure.value))
    elif kind == "damage":
        size = _positive(measure, measure.size, unit) if measure.size else 1.0
        taken = replace(taken, kind=Kind.DAMAGE, value=_positive(measure, measure.value), size=size)
    return taken


def _time(measure: Measure, text: str, experiment: Experiment) -> float:
    when = _value(measure, text, "s")
    if not experiment.start <= when <= experiment.stop:
        fail("L0711", f"'{measure.text}': the time must lie between {experiment.start:g} and {experiment.stop:g}")
    return when


def _positive(measure: Measure, text: str, unit: str = "") -> float:
    if (value := _value(measure, text, unit)) <= 0:
        fail("L0711", f"'{measure.text}': a positive number is needed, not {text}")
    return value


def _column(scene: Scene, measure: Measure) -> int:
    name = measure.quantity
    if name == "time":
        return 0
    slot = scene.slot(name)
    if name in scene.turned:
        fail("L0711", f"'{measure.text}': '{name}' says nothing without the attitude that it is counted from", None,
             "ask for elements of a frame's Q or R as outputs")
    if slot is not None:
        return 1 + slot
    outputs = [column.name for column in scene.outputs]
    if name in outputs:
        return 1 + 2 * scene.n + outputs.index(name)
    if name in _ENERGIES:
        return 1 + 2 * scene.n + len(outputs) + _ENERGIES[name]
    parts = [known for known in outputs if re.fullmatch(rf"{re.escape(name)}\[[\d,]+\]", known)]
    if parts:
        fail("L0711", f"'{measure.text}': '{name}' has {len(parts)} elements", None, f"choose one, such as {parts[0]}")
    fail("L0701", f"there is no quantity '{name}' in {scene.name}", None, *filter(None, [suggest(name, outputs)]))


def _unit(scene: Scene, name: str) -> str:
    if name == "time":
        return "s"
    slot = scene.slot(name)
    columns = (*scene.coordinates, *scene.rates)
    if slot is not None:
        return columns[slot].unit
    return next((c.unit for c in scene.outputs if c.name == name), "J" if name in _ENERGIES else "")


def _value(measure: Measure, text: str, unit: str) -> float:
    try:
        value = read_value(text, unit)
    except ValueError as error:
        fail("L0711", f"'{measure.text}': {error}")
    if isinstance(value, list) or not math.isfinite(value):
        fail("L0711", f"'{measure.text}': one number is needed" + (f" in {spell(parse_unit(unit).dimension)}" if unit else ""))
    return value
