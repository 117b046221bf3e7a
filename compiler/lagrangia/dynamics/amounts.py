"""Expressions that are made of unknowns -> the same, affine in amounts: of each what nonlinear function of the unknowns it is.

Where forces of friction depend on reactions x (mu |x| against the motion), accelerations and reactions are affine in the forces,
and these in |x|. An amount is the largest part of an expression that is no affine function of x, or x itself where that stands
in it as it is.
"""

from collections.abc import Sequence

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, operate, symbol, symbols_in

_SUMS = (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE)


class Amounts:
    """Of expressions in `unknowns` (k,); what is the same in several expressions is one amount."""

    def __init__(self, unknowns: ca.SX) -> None:
        self.hashes = symbols_in(unknowns)
        self.unknowns = {x.__hash__(): x for x in unknowns.elements()}
        self.numbering = Numbering()
        self.laws = dict[int, Expression]()  # by the numbers of values that are not affine: these, of the unknowns
        self.exact = dict[int, Expression]()  # by the numbers of values that depend on unknowns: in terms of these
        self.symbols = dict[int, Expression]()  # by the numbers of values: of their amounts

    def affine(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """Each in terms of amounts."""
        found = rebuilt(expressions, self.numbering, self._made)
        left = [x for x in ca.symvar(ca.veccat(ca.SX(0, 1), *found)) if x.__hash__() in self.hashes]
        linear = ca.substitute(found, left, [self._amount(self.numbering.of_symbol(x), x) for x in left]) if left else found
        return self._without_laws(linear)

    def of(self, expressions: Sequence[ca.SX]) -> tuple[ca.SX, ca.SX]:
        """The symbols of the amounts that stand in these, and what each is as a function of the unknowns."""
        used = symbols_in(ca.veccat(ca.SX(0, 1), *expressions))
        chosen = [(s, self._law(k)) for k, s in self.symbols.items() if s.__hash__() in used]
        nothing = ca.SX(0, 1)
        return (ca.vertcat(nothing, *(s for s, _ in chosen)), ca.vertcat(nothing, *(law for _, law in chosen)))

    def _law(self, number: int) -> ca.SX:
        return self.laws[number] if number in self.laws else self.exact[number]

    def _amount(self, number: int, value: ca.SX) -> Expression:
        self.exact.setdefault(number, value)
        return self.symbols.setdefault(number, symbol(f"amount_{len(self.symbols)}"))

    def _made(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        asks = [self._depends(number) for number in numbers]
        if not any(asks):
            return None
        number = self.numbering.of(op, numbers)
        exact = operate(op, [self.exact.get(k, x) for k, x in zip(numbers, operands, strict=True)])
        self.exact[number] = exact
        if not _is_linear(op, asks):
            self.laws[number] = exact
            return exact
        return operate(op, [self._amount(k, x) if k in self.laws else x for k, x in zip(numbers, operands, strict=True)])

    def _depends(self, number: int) -> bool:
        op, *rest = self.numbering.keys[number]
        return number in self.exact or (op == ca.OP_INPUT and rest[0] in self.hashes)

    def _without_laws(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """What as a whole is not affine is an amount."""
        laws = {law.__hash__(): number for number, law in self.laws.items()}
        found = []
        for x in expressions:
            elements = x.nz[:].elements() if x.nnz() else []
            parts = [self._amount(laws[e.__hash__()], e) if e.__hash__() in laws else e for e in elements]
            found.append(ca.SX(x.sparsity(), ca.vertcat(ca.SX(0, 1), *parts)))
        return found


def _is_linear(op: int, asks: Sequence[bool]) -> bool:
    """Whether an operation is linear in the operands that depend on unknowns, `asks`."""
    if op in _SUMS:
        return True
    if op == ca.OP_MUL:
        return sum(asks) == 1
    return (op == ca.OP_DIV and not asks[1]) or (op == ca.OP_IF_ELSE_ZERO and not asks[0])
