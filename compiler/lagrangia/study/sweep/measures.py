"""What is kept of each run: `max(y)`, `at(0.5, y)`, `first_time(abs(y) > 3)` -> numbers of a motion as reduce.h takes them."""

import math
import re
from collections.abc import Iterable, Sequence

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.units import parse_unit, spell
from lagrangia.language.values import read_value
from lagrangia.run.batch import Kind, Reduction
from lagrangia.run.request import Experiment
from lagrangia.run.scene import Scene

_PLAIN = {
    "min": Kind.MIN, "max": Kind.MAX, "range": Kind.RANGE, "mean": Kind.MEAN, "rms": Kind.RMS,
    "time_of_min": Kind.TIME_OF_MIN, "time_of_max": Kind.TIME_OF_MAX,
}  # fmt: skip
_CROSSINGS = {
    ("first_time", ">"): Kind.FIRST_ABOVE, ("first_time", "<"): Kind.FIRST_BELOW,
    ("last_time", ">"): Kind.LAST_ABOVE, ("last_time", "<"): Kind.LAST_BELOW,
}  # fmt: skip
MEASURES = ("final", "initial", "at", *_PLAIN, "first_time", "last_time")
_TIMES = {"time_of_min", "time_of_max", "first_time", "last_time"}
_ENERGIES = {"energy.kinetic": 0, "energy.potential": 1, "energy.dissipated": 3}  # places behind the outputs of a row
_CALL = re.compile(r"(\w+)\((.*)\)", re.DOTALL)
_CONDITION = re.compile(r"(.*?)\s*([<>]=?)\s*([^<>=]*)", re.DOTALL)


@dataclass(frozen=True)
class Measure:
    """A number of a motion: `kind` of `quantity` (of its absolute value or not). `value` is a time or a level, as text."""

    text: str
    kind: str
    quantity: str
    absolute: bool = False
    relation: str = ""
    value: str = ""


def split_list(text: str) -> list[str]:
    """What stands between commas, as `cut_list` cuts it, without what is empty. Raises LagError L0711."""
    return [item for item in cut_list(text) if item]


def cut_list(text: str) -> list[str]:
    """What stands between commas; commas in parentheses and brackets belong to their item. Raises LagError L0711."""
    items, depth, begin = [], 0, 0
    for k, character in enumerate(text):
        depth += (character in "([{") - (character in ")]}")
        if depth < 0:
            break
        if character == "," and depth == 0:
            items.append(text[begin:k])
            begin = k + 1
    if depth:
        fail("L0711", f"'{text}': a parenthesis or bracket is {'missing' if depth > 0 else 'too many'}")
    return [item.strip() for item in (*items, text[begin:])]


def read_measures(given: str | Sequence[str]) -> list[Measure]:
    """A text alone is a list as on the command line. Raises LagError L0711."""
    if not isinstance(given, Iterable):
        fail("L0711", f"measures are a sequence of texts, not {given!r}"[:200])
    measures = [read_measure(text) for text in (split_list(given) if isinstance(given, str) else given)]
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
    kind, inner = match[1], match[2].strip()
    if kind not in MEASURES:
        fail("L0711", f"there is no measure '{kind}' in {text}", None, *filter(None, [suggest(kind, MEASURES)]),
             f"a measure is one of {', '.join(MEASURES)}: max(y), at(0.5, y), first_time(y > 3)")
    value = relation = ""
    if kind == "at":
        parts = split_list(inner)
        if len(parts) != 2:
            fail("L0711", f"'{text}' needs a time and a quantity: at(0.5, y)")
        value, inner = parts
    elif kind in ("first_time", "last_time"):
        condition = _CONDITION.fullmatch(inner)
        if condition is None:
            fail("L0711", f"'{text}' needs a condition: {kind}(y > 3) or {kind}(abs(y) < 0.01)")
        inner, relation, value = condition[1], condition[2], condition[3].strip()
    return _of_quantity(text, kind, inner, relation, value)


def _of_quantity(text: str, kind: str, inner: str, relation: str, value: str) -> Measure:
    match = _CALL.fullmatch(inner)
    absolute = match is not None and match[1] == "abs"
    name = match[2].strip() if match is not None and absolute else inner.strip()
    call = _CALL.fullmatch(name)
    if not name or (call is not None and call[1] != "der") or re.search(r"[<>=+*/ ]|,(?![^\[]*\])", name):
        fail("L0711", f"'{text}': '{name}' is not the name of a quantity", None,
             "a quantity is a coordinate, der(coordinate), an output, or a place such as bar.b.y; a formula needs an output")
    return Measure(text, kind, name, absolute, relation, value)


def usual_measures(scene: Scene) -> list[Measure]:
    """Final values of all coordinates, rates and outputs."""
    return [read_measure(f"final({c.name})") for c in (*scene.coordinates, *scene.rates, *scene.outputs)]


def quantities(measures: Sequence[Measure]) -> tuple[str, ...]:
    """The names to be compiled in; time and energies are in every row."""
    return tuple(dict.fromkeys(m.quantity for m in measures if m.quantity != "time" and m.quantity not in _ENERGIES))


def unit_of(scene: Scene, measure: Measure) -> str:
    """The unit of the measure's result."""
    if measure.kind in _TIMES:
        return "s"
    return _unit(scene, measure.quantity)


def reductions(scene: Scene, measures: Sequence[Measure], experiment: Experiment) -> tuple[Reduction, ...]:
    """For the columns of the scene's rows. Raises LagError L0701, L0711."""
    return tuple(_reduction(scene, measure, experiment) for measure in measures)


def _reduction(scene: Scene, measure: Measure, experiment: Experiment) -> Reduction:
    column = _column(scene, measure)
    rate = column + scene.n if 1 <= column <= scene.n else -1
    if measure.kind in _PLAIN:
        return Reduction(_PLAIN[measure.kind], column, measure.absolute, rate=rate)
    if measure.relation:
        level = _value(measure, _unit(scene, measure.quantity))
        kind = _CROSSINGS[measure.kind, measure.relation[0]]
        return Reduction(kind, column, measure.absolute, level, rate, or_equal=measure.relation.endswith("="))
    when = {"final": experiment.stop, "initial": experiment.start}.get(measure.kind)
    if when is None:
        when = _value(measure, "s")
        if not experiment.start <= when <= experiment.stop:
            fail("L0711", f"'{measure.text}': the time must lie between {experiment.start:g} and {experiment.stop:g}")
    return Reduction(Kind.AT, column, measure.absolute, when)


def _column(scene: Scene, measure: Measure) -> int:
    name = measure.quantity
    if name == "time":
        return 0
    slot = scene.slot(name)
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


def _value(measure: Measure, unit: str) -> float:
    try:
        value = read_value(measure.value, unit)
    except ValueError as error:
        fail("L0711", f"'{measure.text}': {error}")
    if isinstance(value, list) or not math.isfinite(value):
        fail("L0711", f"'{measure.text}': one number is needed" + (f" in {spell(parse_unit(unit).dimension)}" if unit else ""))
    return value
