"""Hoisting: expressions of t, q, v, p become expressions of t, q, v, c, where c depends on the parameters p alone, computed once.

Constant factors are drawn together on the way: 2*(k/2)*x is c x, x/m is x times the hoisted 1/m, -(a - b) is b - a. Every value
is a product, sign * factor * base, whose factor depends on parameters alone. Negations, doublings, products with and divisions by
parameters change sign and factor, and cost nothing until a sum needs the value.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from itertools import pairwise

import casadi as ca

from lagrangia.algebra.scalars import Expression, apply, apply_to_one, as_expression, operate, symbol, symbols_in
from lagrangia.base.records import dataclass

_MOST_OPERATIONS = 6_000  # 25 us each, and saves 5 % of a chain: large functions are better compiled sooner
_MOST_RESULTS = 2_000  # hardly any are made of two operations
_MOVES = (ca.OP_INPUT, ca.OP_CONST)
_FREE = (ca.OP_MUL, ca.OP_DIV)  # by a parameter, they take a factor over; so do _SCALING, whatever they are of
_SCALING = (ca.OP_NEG, ca.OP_TWICE)


@dataclass(frozen=True)
class Hoisted:
    """Expressions in terms of c, and c (n,) as a function of p: the first `settled` of its values are constants drawn together.
    Behind them stand the parameters themselves, where there are large functions: what these compute of c alone is taken out of
    their instructions (hoisted_tapes.py)."""

    expressions: list[ca.SX]
    c: ca.SX
    values: ca.SX
    settled: int


def hoist(groups: Sequence[Sequence[ca.SX]], p: ca.SX) -> Hoisted:
    """A group holds the results of one function: what several results share is computed once, and is then not taken apart for the
    sake of one of them."""
    constants = _Constants(p)
    found: list[ca.SX] = []
    is_large = False
    for group in groups:
        dense = [ca.densify(expression) for expression in group]
        column = ca.vertcat(ca.SX(0, 1), *dense)
        is_too_large = column.numel() > _MOST_RESULTS or ca.n_nodes(column) > _MOST_OPERATIONS
        found += dense if is_too_large else _gathered(dense, column, constants)
        is_large |= is_too_large
    found, c, values = _merged(found, constants) if constants.values else (found, ca.SX(0, 1), ca.SX(0, 1))
    settled = c.numel()
    return Hoisted(found, ca.vertcat(c, p), ca.vertcat(values, p), settled) if is_large else Hoisted(found, c, values, settled)


def _merged(expressions: list[ca.SX], constants: "_Constants") -> tuple[list[ca.SX], ca.SX, ca.SX]:
    """With one symbol for equal values, and none for what is not used."""
    symbols, values = ca.vertcat(*constants.symbols), ca.cse(ca.vertcat(*constants.values))
    first: dict[int, int] = {}
    chosen = [first.setdefault(value.__hash__(), k) for k, value in enumerate(values.elements())]
    if len(first) < len(chosen):
        expressions = ca.substitute(expressions, [symbols], [symbols[chosen]])
    used = symbols_in(ca.veccat(*expressions))
    kept = [k for k in first.values() if constants.symbols[k].__hash__() in used]
    return expressions, symbols[kept], values[kept]


@dataclass
class _Constants:
    """What is hoisted, each with its symbol."""

    p: ca.SX
    symbols: list[ca.SX] = field(default_factory=list)
    values: list[ca.SX] = field(default_factory=list)
    known: dict[int, Expression] = field(default_factory=dict)

    @cached_property
    def parameters(self) -> frozenset[int]:
        """Hashes of their symbols."""
        return symbols_in(self.p)

    def named(self, value: Expression) -> Expression:
        """The symbol of a value; a number stays one."""
        if value.is_constant():
            return value
        key = value.__hash__()
        if key not in self.known:
            self.known[key] = symbol(f"c_{len(self.symbols)}")
            self.symbols.append(self.known[key])
            self.values.append(value)
        return self.known[key]


@dataclass(slots=True)
class _Term:
    """sign * factor * base: without a base it depends on parameters alone, without a factor it is 1."""

    base: Expression | None
    factor: Expression | None = None
    sign: int = 1


def _gathered(expressions: list[ca.SX], column: ca.SX, constants: _Constants) -> list[ca.SX]:
    symbols = ca.symvar(column)
    if not symbols:
        return expressions
    function = ca.Function("gather", [ca.vertcat(*symbols)], [ca.cse(column)])
    reduced = ca.vertcat(*_Walk(function, symbols, constants).outputs())
    ends = [0]
    for expression in expressions:
        ends.append(ends[-1] + expression.numel())
    return [reduced[a:b] for a, b in pairwise(ends)]


class _Walk:
    """Goes through the instructions of a function and makes every value anew."""

    def __init__(self, function: ca.Function, symbols: list[ca.SX], constants: _Constants) -> None:
        self.function, self.constants = function, constants
        fixed = constants.parameters
        self.leaves = [_Term(None, as_expression(s)) if s.__hash__() in fixed else _Term(as_expression(s)) for s in symbols]
        self.code = [(function.instruction_id(k), function.instruction_input(k), function.instruction_output(k))
                     for k in range(function.n_instructions())]

    def outputs(self) -> list[Expression]:
        needs, work = self._needs(), dict[int, _Term]()
        found: list[Expression] = [as_expression(0.0)] * self.function.numel_out(0)
        for k, (op, inputs, places) in enumerate(self.code):
            if op == ca.OP_OUTPUT:
                found[places[1]] = self.value(work[inputs[0]])
                continue
            if op == ca.OP_INPUT:
                term = self.leaves[inputs[1]]
            elif op == ca.OP_CONST:
                term = _Term(None, as_expression(self.function.instruction_constant(k)))
            else:
                term = self._made(op, [work[place] for place in inputs])
            work[places[0]] = self.settled(term) if needs[k] > 1 else term
        return found

    def _needs(self) -> list[int]:
        """How many readers of each result would have to multiply by its factor."""
        needs, maker, is_fixed = [0] * len(self.code), dict[int, int](), dict[int, bool]()
        for k, (op, inputs, places) in enumerate(self.code):
            if op in _MOVES:
                is_fixed[k] = op == ca.OP_CONST or self.leaves[inputs[1]].base is None
            else:
                made = [maker[place] for place in inputs]
                is_fixed[k] = all(is_fixed[m] for m in made)
                if op not in _SCALING and not (op in _FREE and (is_fixed[made[1]] or (is_fixed[made[0]] and op == ca.OP_MUL))):
                    for m in made:
                        needs[m] += 1
            if op != ca.OP_OUTPUT:
                maker[places[0]] = k
        return needs

    def value(self, term: _Term) -> Expression:
        if term.base is None:
            return self.constants.named(as_expression(term.factor))
        if term.factor is None:
            return _opposite(term.base) if term.sign < 0 else term.base
        factor = -term.factor if term.sign < 0 else term.factor
        return as_expression(term.base * self.constants.named(factor))

    def settled(self, term: _Term) -> _Term:
        """The same with the product by the factor made; the sign still costs nothing."""
        if term.base is None or term.factor is None:
            return term
        return _Term(term.base * self.constants.named(term.factor), None, term.sign)

    def _made(self, op: int, terms: list[_Term]) -> _Term:
        if all(term.base is None for term in terms):
            return _Term(None, operate(op, [as_expression(term.factor) for term in terms]))
        if op in (ca.OP_ADD, ca.OP_SUB):
            return self._sum(terms[0], terms[1] if op == ca.OP_ADD else _negative(terms[1]))
        if op == ca.OP_DIV and terms[0].base is None:
            quotient = _over(terms[0].factor, terms[1].factor)
            top = self.constants.named(as_expression(1.0 if quotient is None else quotient))
            return _Term(top / terms[1].base, None, terms[1].sign)
        rule = _RULES.get(op)
        made = rule(*terms) if rule is not None else None
        if made is None:
            return _Term(operate(op, [self.value(term) for term in terms]))
        return _Term(made.base, None, -made.sign) if made.factor is not None and made.factor.is_minus_one() else made

    def _sum(self, a: _Term, b: _Term) -> _Term:
        """x + y with the signs of both, and with the factor that both have."""
        factor = a.factor
        if a.base is None or b.base is None or not _is_same(a.factor, b.factor):
            factor = None
            a, b = (_Term(self.value(x)) if x.base is None else self.settled(x) for x in (a, b))
        x, y = as_expression(a.base), as_expression(b.base)
        if a.sign == b.sign:
            return _Term(x + y, factor, a.sign)
        return _Term(x - y if a.sign > 0 else y - x, factor)


def _opposite(x: Expression) -> Expression:
    return apply(ca.OP_SUB, x.dep(1), x.dep(0)) if x.op() == ca.OP_SUB else -x


def _is_same(a: Expression | None, b: Expression | None) -> bool:
    return a is b if a is None or b is None else bool(ca.is_equal(a, b, 3))


# -------------------------------------------------------------------- rules; those that do not apply give None


def _times(a: Expression | None, b: Expression | None) -> Expression | None:
    product = b if a is None else a if b is None else a * b
    return None if product is not None and product.is_one() else product


def _over(a: Expression | None, b: Expression | None) -> Expression | None:
    return a if b is None else _times(None, (as_expression(1.0) if a is None else a) / b)


def _negative(a: _Term) -> _Term:
    return _Term(None, -as_expression(a.factor)) if a.base is None else _Term(a.base, a.factor, -a.sign)


def _twice(a: _Term) -> _Term:
    return _Term(a.base, _times(a.factor, as_expression(2.0)), a.sign)


def _square(a: _Term) -> _Term:
    return _Term(apply_to_one(ca.OP_SQ, a.base), _times(a.factor, a.factor))


def _product(a: _Term, b: _Term) -> _Term:
    base = b.base if a.base is None else a.base if b.base is None else a.base * b.base
    return _Term(base, _times(a.factor, b.factor), a.sign * b.sign)


def _quotient(a: _Term, b: _Term) -> _Term:
    return _Term(a.base if b.base is None else a.base / b.base, _over(a.factor, b.factor), a.sign * b.sign)


def _where(condition: _Term, a: _Term) -> _Term | None:
    """The factor of what holds under a condition that moves."""
    if condition.base is None or a.base is None or condition.factor is not None or condition.sign < 0:
        return None
    return _Term(apply(ca.OP_IF_ELSE_ZERO, condition.base, a.base), a.factor, a.sign)


_RULES: Mapping[int, Callable[..., _Term | None]] = {
    ca.OP_NEG: _negative, ca.OP_TWICE: _twice, ca.OP_SQ: _square, ca.OP_MUL: _product, ca.OP_DIV: _quotient,
    ca.OP_IF_ELSE_ZERO: _where,
}
