"""Rules for the variables and units of an FMU (FMI 2.0.5, 2.2; FMI 3.0.2, 2.4), beside those that FMPy's validation knows."""

from collections.abc import Iterator
from math import prod

from lagrangia.base.diagnostics import Diagnostic
from lagrangia.fmu.description import Description, Quantity, number_in
from lagrangia.fmu.xmltree import Element

VARIABLES, UNITS = "L0732", "L0733"
_WITHOUT_START = ("Clock",)
_SET_BY_OTHERS = ("input", "parameter", "structuralParameter")
_FAMILY = {"Enumeration": "Integer"}  # FMI 2: types that share their value references


def variable_rules(description: Description) -> Iterator[Diagnostic]:
    """Faults of start values, ranges, units and the rest of what is said of each variable."""
    for quantity in description.quantities:
        yield from _start_rules(quantity)
        yield from _size_rules(quantity, description)
        yield from _range_rules(quantity)
        yield from _unit_rules(quantity, description)
    if description.version == "2":
        yield from _alias_rules(description)


def unit_rules(description: Description) -> Iterator[Diagnostic]:
    """Of the definitions themselves."""
    seen: set[str] = set()
    for unit in description.root.all("UnitDefinitions", "Unit"):
        name = unit.get("name") or ""
        if name in seen:
            yield unit.fault(UNITS, f"the unit '{name}' is defined twice", "name")
        seen.add(name)
        if name == "":
            yield unit.fault(UNITS, "a unit has no name", "name", "leave it out, and the attribute unit of numbers without one")
        for part in unit.children:
            if number_in(part.get("factor") or "1") == 0:
                yield part.fault(UNITS, f"a factor of 0 in the unit '{name}'", "factor")
    for kind in description.root.all("TypeDefinitions", "*"):
        holder = kind if description.version == "3" or not kind.children else kind.children[0]
        yield from _units_of(holder, holder.get("unit"), f"the type '{kind.get('name')}'", description)


def _start_rules(q: Quantity) -> Iterator[Diagnostic]:
    if q.kind in _WITHOUT_START:
        return
    needed = q.initial in ("exact", "approx") or q.causality == "input" or q.variability == "constant"
    why = q.causality if q.causality == "input" else "constant" if q.variability == "constant" else f"initial={q.initial}"
    if needed and q.start is None:
        yield q.value.fault(VARIABLES, f"'{q.name}' has no start value", "", f"what is {why} needs one")
    if q.start is not None and (q.initial == "calculated" or q.causality == "independent"):
        what = "the independent variable" if q.causality == "independent" else "a calculated variable"
        yield q.value.fault(VARIABLES, f"'{q.name}' is {what} and has a start value all the same", "start", "leave it out")
    if q.value.get("reinit") in ("true", "1") and q.variability != "continuous":
        yield q.value.fault(VARIABLES, f"'{q.name}' is {q.variability}, and only states are set anew at events", "reinit")


def _size_rules(q: Quantity, description: Description) -> Iterator[Diagnostic]:
    """Of arrays, which have a start value for each element or one for all (FMI 3.0.2, 2.4.7.3)."""
    for dimension in q.element.all("Dimension"):
        counted = description.find(dimension.get("valueReference"))
        if dimension.get("start") is None and counted is None:
            yield dimension.fault(VARIABLES, f"a dimension of '{q.name}' has neither a start nor a variable that tells it")
        elif counted is not None and counted.causality != "structuralParameter" and counted.variability != "constant":
            yield dimension.fault(VARIABLES, f"'{counted.name}', a dimension of '{q.name}', is no structural parameter",
                                  "valueReference")
    shape = description.shape(q)
    if shape and q.start is not None and len(q.starts) not in (1, prod(shape)):
        yield q.value.fault(VARIABLES, f"'{q.name}' has {prod(shape)} elements and {len(q.starts)} start values", "start")


def _range_rules(q: Quantity) -> Iterator[Diagnostic]:
    low, high = number_in(q.get("min")), number_in(q.get("max"))
    if low > high:
        yield q.value.fault(VARIABLES, f"'{q.name}' is at least {low:g} and at most {high:g}", "min")
    for text in (q.start or "").split() if q.kind not in ("String", "Boolean", "Binary", "Clock") else ():
        value = number_in(text)
        if value < low or value > high:
            where = f"below its minimum {low:g}" if value < low else f"above its maximum {high:g}"
            yield q.value.fault(VARIABLES, f"'{q.name}' starts at {value:g}, {where}", "start")
            break
    if number_in(q.get("nominal")) == 0:
        yield q.value.fault(VARIABLES, f"the nominal value of '{q.name}' is 0: importers divide by it", "nominal")


def _unit_rules(q: Quantity, description: Description) -> Iterator[Diagnostic]:
    if not q.is_float:
        return
    yield from _units_of(q.value, q.get("unit"), f"'{q.name}'", description)
    type_name = q.value.get("declaredType")
    if type_name is not None and q.declared is None:
        yield q.value.fault(VARIABLES, f"'{q.name}' is of the type '{type_name}', which is not defined", "declaredType")


def _units_of(element: Element, unit: str | None, what: str, description: Description) -> Iterator[Diagnostic]:
    display = element.get("displayUnit")
    if element.get("unit") == "":
        yield element.fault(UNITS, f"the unit of {what} is empty", "unit", "leave the attribute out of numbers without a unit")
    elif unit and unit not in description.units:
        yield element.fault(UNITS, f"the unit '{unit}' of {what} is not defined", "unit", "UnitDefinitions needs it")
    elif element.get("unit") == "1":
        yield element.fault(UNITS, f"the unit of {what} is '1'", "unit", "leave the attribute out of numbers without a unit: "
                            "some importers look for a unit of this name", severity="warning")
    if display is None:
        return
    if not unit:
        yield element.fault(UNITS, f"{what} has a display unit, and no unit", "displayUnit")
    elif unit in description.units and display not in description.display_units[unit]:
        yield element.fault(UNITS, f"the display unit '{display}' of {what} is none of '{unit}'", "displayUnit")


def _alias_rules(description: Description) -> Iterator[Diagnostic]:
    """FMI 2: variables with one value reference are one."""
    groups: dict[tuple[str, int], list[Quantity]] = {}
    for q in description.quantities:
        groups.setdefault((_FAMILY.get(q.kind, q.kind), q.reference), []).append(q)
    for group in groups.values():
        settable = [q for q in group if q.causality in _SET_BY_OTHERS]
        if len(settable) > 1:
            names = " and ".join(f"'{q.name}'" for q in settable[:2])
            yield settable[1].element.fault(VARIABLES, f"{names} are one variable, and both are set from outside",
                                            "valueReference")
        for other in group[1:]:
            if other.get("unit") != group[0].get("unit"):
                yield other.value.fault(UNITS, f"'{other.name}' is another name of '{group[0].name}' in another unit", "unit")
