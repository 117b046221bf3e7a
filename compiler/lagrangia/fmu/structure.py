"""Rules for the states of an FMU and its ModelStructure (FMI 2.0.5, 2.2.8; FMI 3.0.2, 2.4.8), beside those that FMPy knows."""

import re
from collections.abc import Iterator, Mapping
from functools import lru_cache

from lagrangia.base.diagnostics import Diagnostic
from lagrangia.fmu.description import Description, Quantity, Unknown
from lagrangia.fmu.xmltree import Element

STRUCTURE = "L0734"
_DERIVATIVE_NAME = re.compile(r"der\((.+)\)")
_BASES = ("kg", "m", "s", "A", "K", "mol", "cd")
_ONLY_WHILE_RUNNING = {"fixed", "tunable", "discrete"}
_ROWS = {"output": "outputs", "derivative": "derivatives", "initial": "initial unknowns", "indicator": "event indicators"}


def structure_rules(description: Description) -> Iterator[Diagnostic]:
    """Faults of derivatives, of the model structure and of what depends on what."""
    for quantity in description.quantities:
        if quantity.value.get("derivative") is not None:
            yield from _derivative_rules(quantity, description)
    yield from _one_derivative_each(description)
    for element in description.root.all("ModelStructure", *(("*", "Unknown") if description.version == "2" else ("*",))):
        yield from _pointing_rules(element, description)
    for kind in _ROWS:
        yield from _row_rules(kind, description)
    yield from _indicators_are_no_start(description)
    yield from _unlisted(description)


# -------------------------------------------------------------------- states and their derivatives


def _derivative_rules(q: Quantity, description: Description) -> Iterator[Diagnostic]:
    state = description.find(q.value.get("derivative"))
    if state is None:
        yield q.value.fault(STRUCTURE, f"'{q.name}' is the derivative of a variable that is not there", "derivative")
        return
    what = f"'{q.name}' is said to be the derivative of '{state.name}'"
    if state is q:
        yield q.value.fault(STRUCTURE, f"'{q.name}' is its own derivative", "derivative", _count_hint(description))
    elif not state.is_float or state.causality not in ("local", "output"):
        kind = state.causality if state.causality not in ("local", "output") else state.kind
        yield q.value.fault(STRUCTURE, f"{what}, which is no state but of the kind {kind}", "derivative",
                            _count_hint(description))
    elif state.variability != "continuous":
        yield state.element.fault(STRUCTURE, f"'{state.name}' is a state and {state.variability}: states are continuous",
                                  "variability")
    elif q.variability != "continuous":
        yield q.element.fault(STRUCTURE, f"'{q.name}' is the derivative of a state and {q.variability}: it must be continuous",
                              "variability")
    else:
        yield from _meaning_rules(q, state, what, description)


def _count_hint(description: Description) -> str:
    return "variables are counted from 1" if description.version == "2" else "it takes the value reference of the state"


def _meaning_rules(q: Quantity, state: Quantity, what: str, description: Description) -> Iterator[Diagnostic]:
    """What names and units say of the pair."""
    meant = _meant_state(q.reference, state.reference, description)
    if meant and description.root.get("variableNamingConvention") == "structured":
        yield q.value.fault(STRUCTURE, f"{what}, but its name says it is that of '{meant}'", "derivative",
                            _count_hint(description))
        return
    units = [description.units.get(x.get("unit") or "") for x in (q, state)]
    rate, base = (_dimension(unit) for unit in units)
    if rate is not None and base is not None and rate != {**base, "s": base["s"] - 1}:
        yield q.value.fault(STRUCTURE, f"{what}, but {q.get('unit')} is not {state.get('unit')} per second", "derivative",
                            _count_hint(description))


@lru_cache(maxsize=1)  # a hundred thousand names may stand for one pair
def _meant_state(derivative: int, state: int, description: Description) -> str:
    """The variable whose derivative one is by its names, where that is not the state; else an empty text."""
    names = (_DERIVATIVE_NAME.fullmatch(name) for name in sorted(description.names_of_floats.get(derivative, ())))
    meant = [found[1] for found in names if found and found[1] in description.by_name]
    return meant[0] if meant and description.names_of_floats[state].isdisjoint(meant) else ""


def _dimension(unit: Element | None) -> Mapping[str, int] | None:
    """Exponents of the base units, without the radian; None where they are not given."""
    base = unit.first("BaseUnit") if unit is not None else None
    try:
        return {name: int(base.get(name) or 0) for name in _BASES} if base is not None else None
    except ValueError:
        return None


def _one_derivative_each(description: Description) -> Iterator[Diagnostic]:
    first: dict[int, Quantity] = {}
    for state, q in _pairs(description):
        other = first.setdefault(state.reference, q)
        if other.reference != q.reference:
            yield q.value.fault(STRUCTURE, f"'{other.name}' and '{q.name}' are both said to be the derivative of '{state.name}'",
                                "derivative", _count_hint(description))


def _pairs(description: Description) -> Iterator[tuple[Quantity, Quantity]]:
    for q in description.quantities:
        state = description.find(q.value.get("derivative"))
        if state is not None and state.is_float and q.is_float:
            yield state, q


def _unlisted(description: Description) -> Iterator[Diagnostic]:
    listed = {u.quantity.reference for u in description.unknowns("derivative")}
    for _state, q in _pairs(description) if "me" in description.interfaces else ():
        if q.reference not in listed:
            yield q.element.fault(STRUCTURE, f"'{q.name}' is a derivative, and not listed among those of ModelStructure", "name",
                                  "Model Exchange leaves its state out", severity="warning")
            listed.add(q.reference)


# -------------------------------------------------------------------- rows of ModelStructure


def _row_rules(kind: str, description: Description) -> Iterator[Diagnostic]:
    seen: set[int] = set()
    last = 0
    for row in description.unknowns(kind):
        place = row.quantity.place if description.version == "2" else row.quantity.reference
        if place in seen:
            yield row.element.fault(STRUCTURE, f"'{row.quantity.name}' stands twice among the {_ROWS[kind]}")
        seen.add(place)
        if kind == "initial" and description.version == "2" and place < last:
            yield row.element.fault(STRUCTURE, "initial unknowns stand in rising order of their index", "index",
                                    severity="warning")
        last = max(last, place)
        yield from _known_rules(kind, row, description)

def _pointing_rules(element: Element, description: Description) -> Iterator[Diagnostic]:
    attribute = "index" if description.version == "2" else "valueReference"
    if description.find(element.get(attribute)) is None:
        yield element.fault(STRUCTURE, f"no variable has the {attribute} {element.get(attribute)}", attribute)
    texts = (element.get("dependencies") or "").split()
    for text in texts:
        if description.find(text) is None:
            yield element.fault(STRUCTURE, f"no variable has the {attribute} {text}", "dependencies")
    kinds = element.get("dependenciesKind")
    if kinds is not None and len(kinds.split()) != len(texts):
        yield element.fault(STRUCTURE, f"{len(texts)} dependencies are of {len(kinds.split())} kinds", "dependenciesKind")
    if len(set(texts)) < len(texts):
        yield element.fault(STRUCTURE, "a dependency stands twice", "dependencies", severity="warning")


def _known_rules(kind: str, row: Unknown, description: Description) -> Iterator[Diagnostic]:
    """What the unknowns may depend on."""
    kinds = set((row.element.get("dependenciesKind") or "").split())
    others = kinds - {"dependent"}
    if others and not row.quantity.is_float:
        yield row.element.fault(STRUCTURE, f"'{row.quantity.name}' is no real number, and has '{min(others)}' dependencies",
                                "dependenciesKind", "it has dependent ones alone", severity="warning")
    if kind == "initial" and kinds & _ONLY_WHILE_RUNNING:
        yield row.element.fault(STRUCTURE, f"'{row.quantity.name}' depends on start values in a way that is '{min(kinds)}'",
                                "dependenciesKind", "initial unknowns have dependent and constant ones", severity="warning")
    if description.version == "3":
        return
    states = description.state_references
    for known in row.knowns or ():
        if kind == "initial":
            allowed = known.initial == "exact" or known.causality in ("input", "parameter", "independent")
        else:
            allowed = known.causality in ("input", "independent") or known.reference in states or known.variability == "discrete"
        if not allowed:
            yield row.element.fault(STRUCTURE, f"'{row.quantity.name}' depends on '{known.name}', which is not known before it",
                                    "dependencies", severity="warning")
            break


def _indicators_are_no_start(description: Description) -> Iterator[Diagnostic]:
    indicators = {row.quantity.reference for row in description.unknowns("indicator")}
    listed = {row.quantity.reference for row in description.unknowns("derivative")}
    state_like = listed | description.state_references
    for row in description.unknowns("initial"):
        quantity = row.quantity
        expected = quantity.causality in ("output", "calculatedParameter") or quantity.reference in state_like
        if quantity.reference in indicators and not expected:
            yield row.element.fault(STRUCTURE, f"the event indicator '{quantity.name}' is no initial unknown")
