"""modelDescription.xml of FMI 2 and 3 -> what it says, in the words of both, with what is left out filled in."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import product

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.fmu.xmltree import Element

INTERFACES = {"ModelExchange": "me", "CoSimulation": "cs", "ScheduledExecution": "se"}
_INITIAL = {
    ("constant", "output"): "exact", ("constant", "local"): "exact",
    ("fixed", "parameter"): "exact", ("fixed", "structuralParameter"): "exact", ("fixed", "calculatedParameter"): "calculated",
    ("fixed", "local"): "calculated", ("tunable", "parameter"): "exact", ("tunable", "structuralParameter"): "exact",
    ("tunable", "calculatedParameter"): "calculated", ("tunable", "local"): "calculated",
    ("discrete", "input"): "exact", ("discrete", "output"): "calculated", ("discrete", "local"): "calculated",
    ("continuous", "input"): "exact", ("continuous", "output"): "calculated", ("continuous", "local"): "calculated",
}
_FLOATS = ("Real", "Float32", "Float64")
_ELEMENT = re.compile(r"(?P<head>(?:der\()*)(?P<name>.+)\[(?P<index>\d+(?:,\d+)*)\](?P<tail>(?:(?:,\d+)?\))*)")
_DERIVATIVE = re.compile(r"(?P<head>(?:der\()+)(?P<name>.+?)(?P<tail>(?:(?:,\d+)?\))+)")
_PARAMETERS = ("parameter", "calculatedParameter", "structuralParameter")
_UNKNOWNS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "2": {"output": ("Outputs", "Unknown"), "derivative": ("Derivatives", "Unknown"),
          "initial": ("InitialUnknowns", "Unknown"), "indicator": ("EventIndicators", "Unknown")},
    "3": {"output": ("Output",), "derivative": ("ContinuousStateDerivative",), "initial": ("InitialUnknown",),
          "indicator": ("EventIndicator",)}}


def number_in(text: str | None) -> float:
    """NaN, which is in no order with any number, where there is none."""
    try:
        return float(text or "nan")
    except ValueError:
        return math.nan


@dataclass(frozen=True, eq=False)
class Quantity:
    """One variable. `place` counts from 1; `element` holds its names, `value` its numbers: the same one in FMI 3."""

    name: str
    place: int
    reference: int
    kind: str
    causality: str
    variability: str
    initial: str | None
    element: Element
    value: Element
    declared: Element | None
    aliases: tuple[str, ...] = ()

    def get(self, name: str) -> str | None:
        """Of the variable, or of its type."""
        own = self.value.get(name)
        return self.declared.get(name) if own is None and self.declared is not None else own

    @property
    def is_float(self) -> bool:
        """Whether it is a real number."""
        return self.kind in _FLOATS

    @property
    def start(self) -> str | None:
        """Its start value as it is written; None without one."""
        if self.kind in ("String", "Binary") and (given := self.value.first("Start")) is not None:
            return given.get("value")
        return self.value.get("start")

    @property
    def starts(self) -> list[str]:
        """The start values of an array, as they are written; there may be one for all."""
        if self.kind in ("String", "Binary"):
            return [given.get("value") or "" for given in self.value.all("Start")]
        return (self.start or "").split()

    @property
    def has_dimensions(self) -> bool:
        """Whether it is an array."""
        return self.element.first("Dimension") is not None


@dataclass(frozen=True, eq=False)
class Unknown:
    """A row of ModelStructure; `knowns` is None where nothing is said of dependencies."""

    quantity: Quantity
    knowns: tuple[Quantity, ...] | None
    element: Element


@dataclass(frozen=True, eq=False)
class Description:
    """What modelDescription.xml says, as elements with their places, of either version."""

    root: Element
    version: str  # "2", "3"
    quantities: tuple[Quantity, ...]

    @cached_property
    def by_reference(self) -> Mapping[int, Quantity]:
        """The first variable of each value reference."""
        found: dict[int, Quantity] = {}
        for quantity in self.quantities:
            found.setdefault(quantity.reference, quantity)
        return found

    @cached_property
    def by_name(self) -> Mapping[str, Quantity]:
        """Other names of a variable too."""
        return {name: q for q in self.quantities for name in (q.name, *q.aliases)}

    @cached_property
    def units(self) -> Mapping[str, Element]:
        """The elements of units, by name."""
        return {unit.get("name") or "": unit for unit in self.root.all("UnitDefinitions", "Unit")}

    @cached_property
    def interfaces(self) -> Mapping[str, Element]:
        """ "me", "cs", "se": what the FMU offers."""
        return {short: found for tag, short in INTERFACES.items() if (found := self.root.first(tag)) is not None}

    @cached_property
    def bad_identifier(self) -> Element | None:
        """An interface whose identifier is none of C, and so no name of a library in the FMU."""
        return next((element for tag in INTERFACES for element in self.root.all(tag)
                     if not re.fullmatch(r"[A-Za-z_]\w*", element.get("modelIdentifier") or "", re.ASCII)), None)

    def find(self, text: str | None) -> Quantity | None:
        """What a number in ModelStructure, or the attribute `derivative`, stands for."""
        try:
            number = int(text or "")
        except ValueError:
            return None
        if self.version == "3":
            return self.by_reference.get(number)
        return self.quantities[number - 1] if 1 <= number <= len(self.quantities) else None

    def shape(self, quantity: Quantity) -> tuple[int, ...] | None:
        """Of an array, as its dimensions start, () of a scalar; None where they are no numbers."""
        sizes = []
        for dimension in quantity.element.all("Dimension"):
            counted = self.find(dimension.get("valueReference"))
            text = dimension.get("start") if counted is None else counted.start
            if text is None or not text.strip().isdecimal():
                return None
            sizes.append(int(text))
        return tuple(sizes)

    def element(self, name: str) -> tuple[Quantity, int] | None:
        """An array and the place in it, row by row and from 0, of a name such as x[1,2]; None for all other names."""
        part = element_of(name) if name not in self.by_name else None
        quantity = self.by_name.get(part[0]) if part is not None else None
        shape = self.shape(quantity) if quantity is not None else None
        place = place_of(part[1], shape) if part is not None and shape is not None else None
        return (quantity, place) if quantity is not None and place is not None else None

    def unknowns(self, kind: str) -> list[Unknown]:
        """Of kind output, derivative, initial, indicator; those that point nowhere are left out."""
        found = []
        for element in self.root.all("ModelStructure", *_UNKNOWNS[self.version][kind]):
            quantity = self.find(element.get("index" if self.version == "2" else "valueReference"))
            listed = element.get("dependencies")
            knowns = None if listed is None else tuple(q for text in listed.split() if (q := self.find(text)) is not None)
            if quantity is not None:
                found.append(Unknown(quantity, knowns, element))
        return found

    def states(self) -> list[tuple[Quantity, Quantity]]:
        """States and their derivatives, in the order of the states' vector."""
        pairs = [(self.find(u.quantity.value.get("derivative")), u.quantity) for u in self.unknowns("derivative")]
        return [(state, derivative) for state, derivative in pairs if state is not None]

    @cached_property
    def state_references(self) -> frozenset[int]:
        """Value references of the states."""
        return frozenset(state.reference for state, _ in self.states())

    @cached_property
    def names_of_floats(self) -> Mapping[int, frozenset[str]]:
        """All names of the real numbers, by value reference."""
        found: dict[int, set[str]] = {}
        for q in self.quantities:
            if q.is_float:
                found.setdefault(q.reference, set()).update((q.name, *q.aliases))
        return {reference: frozenset(names) for reference, names in found.items()}

    @cached_property
    def display_units(self) -> Mapping[str, frozenset[str | None]]:
        """Names of the display units of each unit."""
        return {name: frozenset(d.get("name") for d in unit.all("DisplayUnit")) for name, unit in self.units.items()}


def element_of(name: str) -> tuple[str, tuple[int, ...]] | None:
    """The array that a name would be of, and where in it: der(x[2]) is the second of der(x)."""
    found = _ELEMENT.fullmatch(name)
    if found is None:
        return None
    return found["head"] + found["name"] + found["tail"], tuple(map(int, found["index"].split(",")))


def place_of(index: Sequence[int], shape: Sequence[int]) -> int | None:
    """Counted row by row from 0; None where it is outside."""
    if len(index) != len(shape) or not all(1 <= k <= size for k, size in zip(index, shape, strict=True)):
        return None
    place = 0
    for k, size in zip(index, shape, strict=True):
        place = place * size + k - 1
    return place


def labels(name: str, shape: Sequence[int] | None) -> list[str]:
    """x, or x[1,1], x[1,2], ...: row by row; of der(x) der(x[1]), ..."""
    if not shape:
        return [name]
    whole = _DERIVATIVE.fullmatch(name)
    head, of, tail = (whole["head"], whole["name"], whole["tail"]) if whole else ("", name, "")
    return [f"{head}{of}[{','.join(map(str, index))}]{tail}" for index in product(*(range(1, size + 1) for size in shape))]


def read_description(root: Element) -> Description:
    """Raises LagError L0730 for what is no description of FMI 2.0 or 3.0, or lacks what every variable has."""
    version = root.get("fmiVersion") or ""
    if root.tag != "fmiModelDescription":
        fail("L0730", f"the root is <{root.tag}>, not <fmiModelDescription>", root.span())
    if version.startswith("1."):
        fail("L0901", f"not supported yet: FMI {version}", root.span("fmiVersion"), "FMI 2.0 and 3.0 are")
    if version != "2.0" and not re.fullmatch(r"3\.\d+(\.\d+)?(-.+)?", version):
        fail("L0730", f"'{version}' is no version of FMI", root.span("fmiVersion"), 'there are "2.0" and "3.0"')
    types = _types(root, version[0])
    quantities = [_quantity(element, place, version[0], types) for place, element in enumerate(_elements(root), 1)]
    return Description(root, version[0], tuple(quantities))


def _elements(root: Element) -> Iterator[Element]:
    for element in root.all("ModelVariables", "*"):
        for attribute in ("name", "valueReference"):
            if element.get(attribute) is None:
                fail("L0730", f"a variable has no {attribute}", element.span())
        yield element


def _types(root: Element, version: str) -> dict[str, Element]:
    """By name: the elements that hold unit, min and max."""
    if version == "3":
        return {t.get("name") or "": t for t in root.all("TypeDefinitions", "*")}
    return {t.get("name") or "": t.children[0] for t in root.all("TypeDefinitions", "SimpleType") if t.children}


def _quantity(element: Element, place: int, version: str, types: Mapping[str, Element]) -> Quantity:
    value = element if version == "3" else next((c for c in element.children if c.tag != "Annotations"), element)
    try:
        reference = int(element.get("valueReference") or "")
    except ValueError:
        fail("L0730", "a value reference is a whole number", element.span("valueReference"))
    kind = value.tag
    causality = element.get("causality") or "local"
    variability = element.get("variability")
    if variability is None:
        discrete = version == "3" and kind not in _FLOATS
        fixed = version == "3" and causality in _PARAMETERS
        variability = "fixed" if fixed else "discrete" if discrete else "continuous"
    initial = element.get("initial") or _INITIAL.get((variability, causality))
    aliases = tuple(alias.get("name") or "" for alias in element.all("Alias"))
    return Quantity(element.get("name") or "", place, reference, kind, causality, variability, initial, element, value,
                    types.get(value.get("declaredType") or ""), aliases)
