"""Whether what stands for a number is one, and whether arrays have the sizes that they are declared with."""

from collections.abc import Iterable, Iterator

from lagrangia.base.diagnostics import Report, fail
from lagrangia.language.elements import Size, element, length
from lagrangia.language.flat import FlatModel, Variable
from lagrangia.language.matrices import shape_of, spoken
from lagrangia.language.tree import (
    Array,
    Binary,
    Boolean,
    Call,
    EnumerationLiteral,
    Flat,
    IfExpression,
    Ref,
    String,
    Unary,
)

CONDITIONS = frozenset({"==", "<>", "<", "<=", ">", ">=", "and", "or"})
_OF_UNKNOWN_SIZE = frozenset({"pre", "to_world", "to_frame", "velocity_at"})
_LONGEST_SHOWN = 30  # characters


def require_number(node: Flat, report: Report) -> None:
    """Reports L0302 for what is true or false, for texts, and for values of enumerations."""
    match node:
        case String():
            report.error("L0302", "a text is no number", node.span)
        case EnumerationLiteral():
            report.error("L0302", f"a value of {node.type_name} is no number", node.span,
                         "it can be compared: if e == E.a; Integer(e) is its place")
        case Boolean() | Unary("not", _, _):
            _refuse_condition(node, report)
        case Binary(operator, _, _, _) if operator in CONDITIONS:
            _refuse_condition(node, report)
        case IfExpression(_, then, otherwise, _):
            require_number(then, report)
            require_number(otherwise, report)
        case Array(items, _):
            require_numbers(items, report)


def require_numbers(given: Iterable[Flat], report: Report) -> None:
    """Each of them."""
    for node in given:
        require_number(node, report)


def refuse_no_number(node: Flat) -> None:
    """Raises LagError L0302 where `require_number` reports it."""
    report = Report()
    require_number(node, report)
    report.raise_errors()


def require_comparable(node: Binary[Flat], report: Report) -> None:
    """Numbers are compared; true and false, texts and values of enumerations as equal with their like. Reports L0302."""
    kinds = {_kind(node.left), _kind(node.right)}
    if len(kinds) > 1 or not (kinds == {"enumeration"} or (node.operator in ("==", "<>") and kinds)):
        require_numbers((node.left, node.right), report)


def _kind(node: Flat) -> str:
    match node:
        case String():
            return "text"
        case EnumerationLiteral():
            return "enumeration"
        case Boolean() | Unary("not", _, _):
            return "condition"
        case Binary(operator, _, _, _) if operator in CONDITIONS:
            return "condition"
    return "number"


def _refuse_condition(node: Flat, report: Report) -> None:
    report.error("L0302", "this is true or false, no number", node.span, "as a number: if x > 0 then 1 else 0")


def require_shape(model: FlatModel, variable: Variable) -> None:
    """Of a variable that is bound, whether anything reads it or not. Raises LagError L0303."""
    node = variable.binding
    if node is None or variable.is_attitude:
        return

    def size(ref: Ref) -> int | None:
        found = model.variables.get(ref.name)
        return found.shape[len(ref.index)] if found is not None and len(found.shape) > len(ref.index) else None

    wrong = _misfit(node, variable.shape, size)
    if wrong is not None:
        part, wanted = wrong if shape_of(node, size) == variable.shape else (node, variable.shape)
        found = shape_of(part, size)
        what = "one number" if not found else spoken(found)
        if len(found) == len(wanted) == 1:
            what = f"{found[0]} value{'s' * (found[0] != 1)}"
        hints = _in_braces(wanted, part.span.text) if not found and part is node else ()
        fail("L0303", f"{what} for {spoken(wanted)}", part.span, *hints)


def _in_braces(wanted: tuple[int, ...], text: str) -> Iterator[str]:
    """How a vector is written of which there is one number."""
    x = text if len(text) <= _LONGEST_SHOWN and "\n" not in text else "x"
    if wanted == (2,):
        yield f"write its components: {{{x}, 0}} is along x, {{0, {x}}} along y, {{{x}, {x}}} has the same twice"
    elif wanted == (3,):
        yield f"write its components: {{{x}, 0, 0}} is along x, {{0, 0, {x}}} along z, about which a moment in the plane turns"


def _misfit(node: Flat, wanted: tuple[int, ...], size: Size) -> tuple[Flat, tuple[int, ...]] | None:
    """The first part of an expression that has another size than is wanted of it, and that; None where all have it."""
    count = length(node, size)
    if count is None and wanted and _is_unknown(node):
        return None
    if count != (wanted[0] if wanted else None):
        return node, wanted
    if count is None:
        return None
    parts = node.items if isinstance(node, Array) else (element(node, k, size) for k in range(1, count + 1))
    misfits = (_misfit(part, wanted[1:], size) for part in parts)
    return next((misfit for misfit in misfits if misfit is not None), None)


def _is_unknown(node: Flat) -> bool:
    """Whether the size of an expression is found when it is evaluated."""
    match node:
        case Call(function, _, _, _):
            return function in _OF_UNKNOWN_SIZE
        case Unary(_, operand, _):
            return _is_unknown(operand)
        case Binary(_, left, right, _) | IfExpression(_, left, right, _):
            return _is_unknown(left) or _is_unknown(right)
    return False
