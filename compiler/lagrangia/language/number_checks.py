"""Whether what stands for a number is one, and whether arrays have the sizes that they are declared with."""

from lagrangia.base.diagnostics import Report, fail
from lagrangia.language.flat import FlatModel, Variable
from lagrangia.language.matrices import shape_of
from lagrangia.language.tree import Array, Binary, Boolean, Flat, IfExpression, Number, Ref, String, Time, Unary

CONDITIONS = frozenset({"==", "<>", "<", "<=", ">", ">=", "and", "or"})


def require_number(node: Flat, report: Report) -> None:
    """Reports L0302 for what is true or false, and for texts."""
    match node:
        case String():
            report.error("L0302", "a text is no number", node.span)
        case Boolean() | Unary("not", _, _):
            _refuse_condition(node, report)
        case Binary(operator, _, _, _) if operator in CONDITIONS:
            _refuse_condition(node, report)
        case IfExpression(_, then, otherwise, _):
            require_number(then, report)
            require_number(otherwise, report)
        case Array(items, _):
            for item in items:
                require_number(item, report)


def _refuse_condition(node: Flat, report: Report) -> None:
    report.error("L0302", "this is true or false, no number", node.span, "as a number: if x > 0 then 1 else 0")


def require_shape(model: FlatModel, variable: Variable) -> None:
    """Of a variable that is bound, whether anything reads it or not. Raises LagError L0303."""
    node, wanted = variable.binding, variable.shape
    if node is None or variable.is_attitude:
        return

    def size(ref: Ref) -> int | None:
        found = model.variables.get(ref.name)
        return found.shape[len(ref.index)] if found is not None and len(found.shape) > len(ref.index) else None

    found = shape_of(node, size)
    if found and not wanted:
        fail("L0303", f"an array of {found[0]} for a number", node.span)
    if wanted and (isinstance(node, Number | Time) or (found and found[0] != wanted[0])):
        what = f"{found[0]} value{'s' * (found[0] != 1)}" if found else "one number"
        fail("L0303", f"{what} for an array of {wanted[0]}", node.span)
