"""Forms of flat expressions that are evaluated in ways of their own."""

from lagrangia.language.events import are_alike
from lagrangia.language.tree import Binary, Flat, Number


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
