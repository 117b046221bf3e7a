"""Units of what calls make of their arguments: functions of the kernel, tables, and people's own functions."""

from collections.abc import Mapping
from fractions import Fraction
from functools import reduce
from typing import Protocol

from lagrangia.base.diagnostics import Report, Span
from lagrangia.language.flat import FlatModel
from lagrangia.language.function_variables import FlatFunction
from lagrangia.language.functions import FRAME_FUNCTIONS
from lagrangia.language.lookups import lookup_of, plane_of
from lagrangia.language.number_checks import require_numbers
from lagrangia.language.quantities import ANY, PURE, Quantity, fits, in_unit, over, times
from lagrangia.language.tree import Array, Call, Flat, FrameRef, String, Time
from lagrangia.language.units import dimension, parse_unit, power, spell

_METRE, _SECOND, _JOULE = dimension(m=1), dimension(s=1), dimension(kg=1, m=2, s=-2)


class Quantities(Protocol):
    """What tells quantities of expressions: dimensions.py."""

    model: FlatModel
    report: Report
    results: dict[tuple[object, ...], Quantity]

    def quantity(self, node: Flat, local: Mapping[str, Quantity] | None = None) -> Quantity:
        """What is known of an expression."""

    def same(self, a: Quantity, b: Quantity, span: Span, how: str) -> Quantity:
        """The common quantity of two that must agree."""

    def common(self, found: list[Quantity], span: Span, how: str) -> Quantity:
        """That of several."""

    def pure(self, quantity: Quantity, node: Flat, what: str, *hints: str) -> None:
        """Reports L0304 for what has a unit."""

    def refuse_frame(self, node: Flat, span: Span) -> Quantity:
        """Reports L0221."""


def units_of_call(checker: Quantities, node: Call[Flat], local: Mapping[str, Quantity] | None) -> Quantity:
    """What is known of the value of a call, whose arguments are checked; `local`: of the variables of a function it stands in."""
    if node.function in checker.model.functions:
        return _user_function(checker, node, local)
    if node.function in FRAME_FUNCTIONS:
        return checker.refuse_frame(node, node.span)
    if node.function == "distance":
        return _distance(checker, node, local)
    found = _arguments(checker, node, local)
    match node.function:
        case "der":
            return over(found[0], Quantity(_SECOND), node)
        case "sqrt":
            base = found[0].dimension
            return ANY if base is None else Quantity(power(base, Fraction(1, 2)), found[0].is_soft)
        case "abs" | "norm" | "floor" | "ceil" | "rotate" | "virtual" | "element" | "pre":
            return found[0]
        case "contact_force" | "constraint_force":
            return over(Quantity(_JOULE), found[0], node)
        case "sign":
            return PURE
        case "dot" | "cross":
            return times(found[0], found[1])
        case "atan2":
            checker.same(found[0], found[1], node.span, "be compared")
            return PURE
        case "mod" | "min" | "max" | "sum":
            return checker.common(found, node.span, "go together")
        case "table":
            return _table(checker, node, found)
        case "table2":
            return _table2(checker, node, found)
        case "product":
            return _product(checker, node, found)
    return _pure_function(checker, node, found)


def _pure_function(checker: Quantities, node: Call[Flat], found: list[Quantity]) -> Quantity:
    for quantity, argument in zip(found, node.arguments, strict=True):
        hints = [f"write: {node.function}(1[rad/s]*{argument.span.text})"] if isinstance(argument, Time) else []
        checker.pure(quantity, argument, f"the argument of {node.function}", *hints)
    return PURE


def _distance(checker: Quantities, node: Call[Flat], local: Mapping[str, Quantity] | None) -> Quantity:
    ends = [end for end in node.arguments if not (isinstance(end, FrameRef) and end.attribute == "")]
    points = [checker.quantity(end, local) for end in ends]
    checker.common([Quantity(_METRE), *points], node.span, "be points")
    return Quantity(_METRE)


def _arguments(checker: Quantities, node: Call[Flat], local: Mapping[str, Quantity] | None) -> list[Quantity]:
    """Of numbers; of tables also the names of files."""
    texts = String if node.function in ("table", "table2") else ()
    require_numbers((x for x in node.arguments if not isinstance(x, texts)), checker.report)
    return [checker.quantity(argument, local) for argument in node.arguments]


def _product(checker: Quantities, node: Call[Flat], found: list[Quantity]) -> Quantity:
    of_all = [one for one, count in zip(found, map(_count, node.arguments), strict=True) for _ in range(count)]
    return reduce(times, of_all, PURE)


def _table2(checker: Quantities, node: Call[Flat], found: list[Quantity]) -> Quantity:
    if len(found) == 5:
        for k in (0, 1):
            checker.same(found[k], found[k + 2], node.span, "be compared")
        return found[4]
    *wanted, value = (plane := checker.model.planes[plane_of(node)]).dimensions
    for k, one in enumerate(wanted):
        if one is not None and not fits(found[k], one):
            checker.report.error("L0304", f"column {k + 1} of '{plane.name}' is in {spell(one)}, this is in "
                              f"{found[k].spell()}", node.arguments[k].span)
    return ANY if value is None else Quantity(value)


def _table(checker: Quantities, node: Call[Flat], found: list[Quantity]) -> Quantity:
    """Of points, or of a file, whose columns may say their units."""
    if len(found) == 3:
        checker.same(found[0], found[1], node.span, "be compared")
        return found[2]
    read = checker.model.tables[lookup_of(node)]
    if read.argument is not None and not fits(found[0], read.argument):
        checker.report.error("L0304", f"the first column of '{read.data.name}' is in {spell(read.argument)}, this is in "
                          f"{found[0].spell()}", node.arguments[0].span)
    return ANY if read.value is None else Quantity(read.value)


def _user_function(checker: Quantities, node: Call[Flat], local: Mapping[str, Quantity] | None) -> Quantity:
    function = checker.model.functions[node.function]
    known: dict[str, Quantity] = {}
    for name, argument in zip(function.inputs, node.arguments, strict=True):
        found = checker.quantity(argument, local)
        unit = function.units[name]
        if unit and not fits(found, parse_unit(unit).dimension):
            called = node.function.partition("(")[0]
            checker.report.error("L0304", f"{called} wants '{name}' in {unit}, this is in {found.spell()}", argument.span)
        known[name] = in_unit(unit) if unit else found
    key = function.name, *known.values()
    if key not in checker.results:
        checker.results[key] = _result(checker, function, known)
    return checker.results[key]


def _result(checker: Quantities, function: FlatFunction, known: dict[str, Quantity]) -> Quantity:
    """What a user function makes of inputs, once for all calls with the same dimensions."""
    for name, expression in function.steps:
        found, unit = checker.quantity(expression, known), function.units[name]
        if unit and not fits(found, parse_unit(unit).dimension):
            said = name.partition("#")[0]
            checker.report.error("L0304", f"'{said}' of {function.name.partition('(')[0]} is in {unit}, this is in "
                              f"{found.spell()}", expression.span)
        known[name] = in_unit(unit) if unit else found
    return known[function.output]


def _count(node: Flat) -> int:
    return sum(map(_count, node.items)) if isinstance(node, Array) else 1
