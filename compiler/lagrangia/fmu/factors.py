"""How each unknown of an FMU depends on each of its knowns: FMI's dependenciesKind (FMI 2.0.5, 2.2.8; FMI 3.0.2, 2.4.8).

In y = f x + g, where neither f nor g depends on x, x has a factor: constant where f is a number, tunable where it follows
from parameters (all of an FMU's are tunable), else dependent. The walk over the operations of y is structural, as that of
linearity.py: what it calls constant or tunable is so for all values, and steps (sign, floor, conditions) are dependent although
their derivative is 0.
"""

from collections.abc import Sequence

import casadi as ca

from lagrangia.base.records import dataclass

CONSTANT, TUNABLE, DEPENDENT = "constant", "tunable", "dependent"
_SUMS = (ca.OP_ASSIGN, ca.OP_NEG, ca.OP_TWICE, ca.OP_ADD, ca.OP_SUB)


@dataclass(frozen=True)
class _Node:
    """Sets of knowns, a bit each: those it depends on, those whose factor moves, those whose factor follows from parameters."""

    knowns: int = 0
    moving: int = 0
    tuned: int = 0


def strongest(*kinds: str) -> str:
    """The one that says least."""
    return max(kinds, key=(CONSTANT, TUNABLE, DEPENDENT).index)


def factor_kinds(unknowns: ca.SX, moving: Sequence[ca.SX], parameters: ca.SX) -> "list[Factors]":
    """Of each unknown (k,). `moving`: columns of what changes while the simulation runs, counted on through them; the parameters
    come behind."""
    function = ca.Function("unknowns", [*moving, parameters], [ca.densify(unknowns)])
    sizes = [function.numel_in(k) for k in range(function.n_in())]
    first = [sum(sizes[:k]) for k in range(len(sizes))]
    running = (1 << first[-1]) - 1
    work: dict[int, _Node] = {}
    found = [_Node()] * int(unknowns.numel())
    for k in range(function.n_instructions()):
        op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            work[outputs[0]] = _Node(1 << (first[inputs[0]] + inputs[1]))
        elif op == ca.OP_CONST:
            work[outputs[0]] = _Node()
        elif op == ca.OP_OUTPUT:
            found[outputs[1]] = work[inputs[0]]
        else:
            work[outputs[0]] = _combined(op, [work[i] for i in inputs], running)
    return [Factors(node, first[-1]) for node in found]


@dataclass(frozen=True)
class Factors:
    """Of one unknown."""

    node: _Node
    n_moving: int

    def kind(self, known: int) -> str:
        """Of the known with this number among what moves."""
        return DEPENDENT if self.node.moving >> known & 1 else TUNABLE if self.node.tuned >> known & 1 else CONSTANT

    def kind_of_parameter(self, number: int) -> str:
        """How a parameter, by its number, acts on the quantity."""
        return self.kind(self.n_moving + number)


def _combined(op: int, nodes: Sequence[_Node], running: int) -> _Node:
    a, b = nodes[0], nodes[-1]
    if op in _SUMS:
        return _Node(a.knowns | b.knowns, a.moving | b.moving, a.tuned | b.tuned)
    if op in (ca.OP_MUL, ca.OP_SQ):
        return _product(a, b, running)
    if op == ca.OP_DIV:
        return _product(a, _bent(b), running)
    if op == ca.OP_IF_ELSE_ZERO:
        return _product(_bent(a), b, running)
    return _bent(_Node(a.knowns | b.knowns))


def _bent(a: _Node) -> _Node:
    """A function of a that is not linear: its slope changes with all that a depends on."""
    return _Node(a.knowns, a.knowns)


def _product(a: _Node, b: _Node, running: int) -> _Node:
    """Each is the factor of the other's knowns."""
    moving, tuned = a.moving | b.moving | (a.knowns & b.knowns), a.tuned | b.tuned
    for own, factor in ((a.knowns, b.knowns), (b.knowns, a.knowns)):
        if factor & running:
            moving |= own
        elif factor:
            tuned |= own
    return _Node(a.knowns | b.knowns, moving, tuned)
