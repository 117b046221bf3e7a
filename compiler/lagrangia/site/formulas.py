"""Expressions as they are written in a text -> formulas, for a reader: nothing is computed or reordered."""

import re
from fractions import Fraction
from typing import Any

from lagrangia.language.tree import (
    Array,
    Binary,
    Call,
    EnergyTerm,
    Equality,
    IfExpression,
    Number,
    Reference,
    Unary,
    WorkTerm,
)
from lagrangia.paper.layout import (
    Apply,
    Bracket,
    Cases,
    Listing,
    Name,
    Node,
    Numeral,
    Pieces,
    Power,
    Product,
    Quotient,
    Relation,
    Root,
    Total,
    Words,
)
from lagrangia.paper.mathml import mathml

_LETTERS = {"kinetic": "T", "potential": "V", "dissipation": "D"}
_SUBSCRIPT = re.compile(r"([A-Za-z]+?)_?(\d+|(?<=_)\w+)$")
_COMPARED = {"<=": "≤", ">=": "≥", "<>": "≠", "==": "=", "and": "∧", "or": "∨"}


def formula(clause: Any) -> str:
    """The MathML of an energy, a work or an equation between expressions; "" for other clauses."""
    match clause:
        case EnergyTerm(kind, value):
            node: Node = Relation(Name(_LETTERS[kind]), written(value), "=")
        case WorkTerm(force, position):
            node = Relation(Name("W", prefix="δ"), Product((_tight(force), Name("", prefix="δ"), _tight(position))), "=")
        case Equality(left, right):
            node = Relation(written(left), written(right), "=")
        case _:
            return ""
    return f'<math display="block">{mathml(node)}</math>'


def written(node: Any) -> Node:
    """The formula of an expression."""
    match node:
        case Number(value, unit):
            number = Numeral(Fraction(value) if value == int(value) and abs(value) < 1e6 else Fraction(repr(value)),
                             0 if value == int(value) and abs(value) < 1e6 else 4)
            return number if unit in (None, "1") else Product((number, Words(unit)))
        case Reference():
            return _named(str(node))
        case Unary("-", operand):
            return Total(((-1, _term(operand)),))
        case Unary("not", operand):
            return Product((Words("not "), written(operand)))
        case Unary(_, operand):
            return written(operand)
        case Binary():
            return _binary(node)
        case Call():
            return _call(node)
        case Array(items):
            return Listing(tuple(map(written, items)))
        case IfExpression(condition, then, otherwise):
            return Cases(((written(then), written(condition)), (written(otherwise), None)))
        case _:
            return Words(" ".join(node.span.text.split()))


def _binary(node: Binary[Any]) -> Node:
    left, right = node.left, node.right
    match node.operator:
        case "+" | "-" as sign:
            return Total((*_terms(left), (1 if sign == "+" else -1, _term(right))))
        case "*" | ".*":
            return Product((*_factors(left), _tight(right)))
        case "/" | "./":
            return Quotient(written(left), written(right))
        case "^" | ".^":
            return Power(_tight(left), written(right))
        case other:
            return Relation(written(left), written(right), _COMPARED.get(other, other))


def _terms(node: Any) -> tuple[tuple[int, Node], ...]:
    found = written(node)
    return found.items if isinstance(found, Total) and isinstance(node, Binary) else ((1, found),)


def _term(node: Any) -> Node:
    found = written(node)
    return Bracket(found) if isinstance(found, Total | Relation) else found


def _factors(node: Any) -> tuple[Node, ...]:
    found = _tight(node)
    return found.items if isinstance(found, Product) else (found,)


def _tight(node: Any) -> Node:
    """As a factor, or what is raised."""
    found = written(node)
    return Bracket(found) if isinstance(found, Total | Relation | Cases) else found


def _call(call: Call[Any]) -> Node:
    arguments = tuple(map(written, call.arguments))
    if call.function == "der" and len(arguments) == 1:
        inside = arguments[0]
        if isinstance(inside, Name) and inside.marks < 2:
            return Name(inside.base, inside.sub, inside.marks + 1)
    if call.function == "sqrt" and len(arguments) == 1:
        return Root(arguments[0])
    if call.function == "abs" and len(arguments) == 1:
        return Apply("abs", arguments[0])
    if call.function == "norm" and len(arguments) == 1:
        return Pieces((("", Words("|")), ("", arguments[0]), ("", Words("|"))))
    if call.function == "dot" and len(arguments) == 2:
        return Pieces((("", _tight(call.arguments[0])), ("·", _tight(call.arguments[1]))))
    return Apply(call.function, arguments[0] if len(arguments) == 1 else Listing(arguments))


def _named(text: str) -> Node:
    """k1 and k_1 with a subscript; of a frame's attribute, that of the frame: center.v is v with the subscript center."""
    owner, _, last = text.replace("[", " ").replace("]", "").rpartition(".")
    parts = _SUBSCRIPT.fullmatch(last.split(" ")[0])
    base, sub = (parts[1], parts[2]) if parts else (last.split(" ")[0], "")
    indices = last.split(" ")[1:]
    return Name(base, " ".join(filter(None, [sub, *owner.replace(".", " ").split(), *indices])))
