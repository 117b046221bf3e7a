"""Forms of flat expressions that are evaluated in ways of their own."""

from typing import NoReturn

from lagrangia.base.diagnostics import fail
from lagrangia.language.events import are_alike
from lagrangia.language.flat import FlatModel
from lagrangia.language.tree import Array, Binary, Call, Flat, Number, Ref

_DIRECTIONS = {2: "give it a direction, as {1, 0}", 3: "give it a direction, as {1, 0, 0}",
               4: "quaternion(1, 0, 0, 0) is no turn"}


def sum_of_squares(node: Flat) -> list[Flat] | None:
    """Those whose squares a sum is made of; None for other sums."""
    match node:
        case Binary("+", left, right, _):
            first, second = sum_of_squares(left), sum_of_squares(right)
            return None if first is None or second is None else first + second
        case Binary("^", base, Number(2.0), _):
            return [base]
        case Binary("*", left, right, _) if are_alike(left, right):
            return [left]
    return None


def refuse_division(node: Binary[Flat], model: FlatModel) -> NoReturn:
    """Raises LagError L0217 of a division by zero: of one by the length of a vector, where that vector is given."""
    if not isinstance(node.right, Call) or node.right.function != "norm":
        fail("L0217", "division by zero", node.span)
    vector = node.right.arguments[0]
    if isinstance(vector, Ref) and (given := model.variables[vector.name].binding) is not None:
        vector = given
    size = len(vector.items) if isinstance(vector, Array) else 0
    advice = _DIRECTIONS.get(size, "give it a direction")
    fail("L0217", f"division by zero: the length of {vector.span.text} is 0, which has no direction", vector.span, advice)
