"""Are the equations linear? A walk over their operations, that finds how each depends on what moves.

h = C v + K q - b(t, u), with C and K of parameters alone, and powers that are quadratic in (q, v, u) and functions of time. The
walk is structural: what it accepts is linear for all values; sin, abs, conditions, products of what moves are never accepted.
"""

from enum import IntEnum

import casadi as ca

from lagrangia.algebra.scalars import Expression, apply, apply_to_one, as_expression
from lagrangia.base.records import dataclass


class Degree(IntEnum):
    """What an expression depends on, and how."""

    PARAMETER = 0
    MODE = 1  # changes at time events only
    TIME = 2
    LINEAR = 3  # in q, v and u
    QUADRATIC = 4


class NotLinear(Exception):
    """The message says what is not linear."""


@dataclass(frozen=True)
class Rewritten:
    """Expressions in which every function of time that stands beside what moves has a symbol of its own."""

    expressions: ca.SX
    degrees: tuple[Degree, ...]
    symbols: ca.SX
    loads: ca.SX  # what the symbols stand for: functions of t, p and the modes


@dataclass
class _Node:
    degree: Degree
    value: ca.SX
    load: ca.SX | None = None
    halves: "tuple[_Node, _Node] | None" = None  # of a product of a load and what moves: modes that come later join the load


_NAMES = {ca.OP_SIN: "a sine", ca.OP_COS: "a cosine", ca.OP_SQRT: "a square root", ca.OP_FABS: "an absolute value",
          ca.OP_SIGN: "a sign", ca.OP_IF_ELSE_ZERO: "a condition", ca.OP_EXP: "an exponential", ca.OP_FLOOR: "a floor",
          ca.OP_TANH: "a tanh", ca.OP_ATAN2: "an atan2", ca.OP_CONSTPOW: "a power", ca.OP_POW: "a power"}


def rewrite(expressions: ca.SX, moving: ca.SX, t: ca.SX, modes: ca.SX, p: ca.SX, factors_are_loads: bool = False,
            what: str = "its equations") -> Rewritten:
    """The expressions with their degrees in `moving` (q, v, u). A mode that multiplies what moves is a factor, that changes at
    events, or else a load: then the product is quadratic. Raises NotLinear; `what` are the expressions in its message."""
    return _Walk(factors_are_loads, what).run(expressions, [moving, t, modes, p])


class _Walk:
    def __init__(self, factors_are_loads: bool, what: str) -> None:
        self.what = what
        self.symbols: list[ca.SX] = []
        self.loads: list[ca.SX] = []
        self.least = Degree.MODE if factors_are_loads else Degree.TIME  # of loads in products

    def run(self, expressions: ca.SX, arguments: list[ca.SX]) -> Rewritten:
        is_timed = ca.depends_on(expressions, ca.vertcat(*arguments[1:3]))
        shared = ca.cse(ca.densify(expressions)) if is_timed else ca.densify(expressions)  # one symbol for equal loads
        function = ca.Function("walk", arguments, [shared])
        degrees = (Degree.LINEAR, Degree.TIME, Degree.MODE, Degree.PARAMETER)
        elements = [_elements(x) for x in arguments]
        work: dict[int, _Node] = {}
        results: list[_Node] = [_Node(Degree.PARAMETER, ca.SX(0))] * expressions.numel()
        for k in range(function.n_instructions()):
            op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
            if op == ca.OP_INPUT:
                work[outputs[0]] = _Node(degrees[inputs[0]], elements[inputs[0]][inputs[1]])
            elif op == ca.OP_CONST:
                work[outputs[0]] = _Node(Degree.PARAMETER, as_expression(function.instruction_constant(k)))
            elif op == ca.OP_OUTPUT:
                results[outputs[1]] = work[inputs[0]]
            else:
                work[outputs[0]] = self._combine(op, [work[i] for i in inputs])
        values = ca.SX(ca.vertcat(*[self._beside(node) for node in results]))
        used = {symbol.__hash__() for symbol in ca.symvar(values)}  # others have joined a product since
        kept = [k for k, symbol in enumerate(self.symbols) if symbol.__hash__() in used]
        symbols, loads = (ca.vertcat(*(column[k] for k in kept)) for column in (self.symbols, self.loads))
        return Rewritten(values, tuple(node.degree for node in results), symbols, loads)

    def _combine(self, op: int, nodes: list[_Node]) -> _Node:
        degree = max(node.degree for node in nodes)
        if op == ca.OP_IF_ELSE_ZERO and nodes[0].degree == self.least and degree >= Degree.LINEAR:
            op, nodes = ca.OP_MUL, [_Node(Degree.MODE, apply(op, nodes[0].value, ca.SX(1))), nodes[1]]
        if degree == Degree.QUADRATIC and (joined := self._joined(op, nodes)) is not None:
            return joined
        values = [node.value for node in nodes]
        if degree > Degree.TIME:
            if op in (ca.OP_ADD, ca.OP_SUB):
                values = [self._beside(node) for node in nodes]
            elif op in (ca.OP_MUL, ca.OP_SQ):
                degree = self._product(nodes[0], nodes[-1])
                values = [self._beside(node) if node.degree >= self.least else node.value for node in nodes]
            elif not _keeps_degree(op, nodes):
                raise NotLinear(f"{self.what} contain {_NAMES.get(op, 'a nonlinear function')} of what moves"
                                if op != ca.OP_DIV else f"{self.what} divide by what moves or by a function of time")
        made = _Node(degree, apply_to_one(op, values[0]) if len(values) == 1 else apply(op, *values))
        if op == ca.OP_MUL and degree == Degree.QUADRATIC and Degree.TIME >= min(nodes[0].degree, nodes[1].degree) >= self.least:
            made.halves = (nodes[0], nodes[1]) if nodes[0].degree <= Degree.TIME else (nodes[1], nodes[0])
        return made

    def _joined(self, op: int, nodes: list[_Node]) -> _Node | None:
        """Signs, factors and modes that multiply a product of a load and what moves multiply its load."""
        known = [node for node in nodes if node.degree <= Degree.MODE]
        (product, *more) = (node for node in nodes if node.degree > Degree.MODE)
        if product.halves is None or more or op not in (ca.OP_NEG, ca.OP_TWICE, ca.OP_MUL):
            return None
        load, other = product.halves
        values = [load.value, *(node.value for node in known)]
        value = apply_to_one(op, values[0]) if len(values) == 1 else apply(op, *values)
        return self._combine(ca.OP_MUL, [_Node(max(load.degree, *(node.degree for node in known), Degree.MODE), value), other])

    def _beside(self, node: _Node) -> ca.SX:
        """The node's value in a sum with what moves: a function of time or of modes is a load there."""
        if node.degree not in (Degree.MODE, Degree.TIME):
            return node.value
        if node.load is None:
            node.load = ca.SX.sym(f"load_{len(self.symbols)}")
            self.symbols.append(node.load)
            self.loads.append(node.value)
        return node.load


    def _product(self, a: _Node, b: _Node) -> Degree:
        low, high = sorted((a.degree, b.degree))
        if low < self.least:
            return high
        if high == Degree.QUADRATIC:
            raise NotLinear(f"{self.what} multiply more than two quantities that change in time")
        return Degree.QUADRATIC


def _elements(vector: ca.SX) -> list[Expression]:
    """Its scalars, with quick operators and without copies."""
    found: list[Expression] = ca.vertsplit(vector) if vector.numel() else []
    for scalar in found:
        scalar.__class__ = Expression
    return found


def _keeps_degree(op: int, nodes: list[_Node]) -> bool:
    if op in (ca.OP_NEG, ca.OP_TWICE, ca.OP_ASSIGN):
        return True
    if op == ca.OP_DIV:
        return nodes[1].degree <= Degree.MODE
    return op == ca.OP_IF_ELSE_ZERO and nodes[0].degree <= Degree.MODE
