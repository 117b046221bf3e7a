"""Expressions that differ in names alone, as those of the elements of an array do: evaluated together, by columns.

One operation on a column of a thousand scalars takes CasADi about as long as a hundred on scalars, each of which is an object of
Python's besides. Element by element the results are the expressions that come out one by one. Sums, products, powers and inner
products are taken so: conditions, tables and lengths ask what their arguments are.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import casadi as ca

from lagrangia.algebra.duals import Dual, Scalar
from lagrangia.algebra.scalars import as_expression, cells, column
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.frames.evaluation import Evaluator, Value
from lagrangia.language.tree import Array, Binary, Call, Flat, FrameRef, Number, Ref, Unary

_FEWEST = 8  # expressions: fewer are as soon evaluated one by one
_OPERATORS = frozenset("+-*/^")
_FUNCTIONS = frozenset({"dot", "cross"})


class _Unlike(Exception):
    """What the names stand for differs in kind."""


def evaluate_all(expressions: Sequence[Flat], evaluators: Sequence[Evaluator]) -> list[Value]:
    """The value of each, by its own evaluator; all are of one model and one algebra. Raises LagError."""
    found = evaluate_alike(expressions, evaluators)
    return [found[k] if k in found else evaluators[k].value(node) for k, node in enumerate(expressions)]


def evaluate_alike(expressions: Sequence[Flat], evaluators: Sequence[Evaluator]) -> dict[int, Value]:
    """The values, by their places, of those that can be taken together. Raises LagError."""
    found: dict[int, Value] = {}
    has_columns = bool(evaluators) and isinstance(evaluators[0].algebras[0], CasadiAlgebra)  # SymPy has none
    for group in _groups(expressions) if has_columns else ():
        found |= _together(group, [evaluators[k] for k in group]) or {}
    return found


def _groups(expressions: Sequence[Flat]) -> Iterator[dict[int, tuple[Flat, list[str]]]]:
    """Those that stand in one place of the source and are alike: each with its names, in the same order."""
    by_place: dict[int, dict[int, tuple[Flat, list[str]]]] = {}
    for k, node in enumerate(expressions):
        group = by_place.setdefault(id(node.span), {})
        first = next(iter(group.values()))[0] if group else node
        names: list[str] = []
        if _is_alike(first, node, names):
            group[k] = node, names
    return (group for group in by_place.values() if len(group) >= _FEWEST)


def _is_alike(a: Flat, b: Flat, names: list[str]) -> bool:
    """Whether b is made as a is, of what is taken by columns. `names`: those of b are added."""
    look = _LOOKS.get(a.__class__)
    return look is not None and a.__class__ is b.__class__ and look(a, b, names)


def _are_names(a: Ref, b: Ref, names: list[str]) -> bool:
    names.append(b.name)
    return a.index == b.index


def _are_of_frames(a: FrameRef, b: FrameRef, names: list[str]) -> bool:
    names.append(b.name)
    return a.attribute == b.attribute != "" and a.index == b.index


def _are_binary(a: Binary[Flat], b: Binary[Flat], names: list[str]) -> bool:
    return (a.operator == b.operator and a.operator in _OPERATORS and _is_alike(a.left, b.left, names)
            and _is_alike(a.right, b.right, names))


def _are_alike(a: Sequence[Flat], b: Sequence[Flat], names: list[str]) -> bool:
    return len(a) == len(b) and all(_is_alike(x, y, names) for x, y in zip(a, b, strict=True))


_LOOKS: Mapping[type, Callable[[Any, Any, list[str]], bool]] = {
    Ref: _are_names,
    FrameRef: _are_of_frames,
    Number: lambda a, b, names: bool(a.value == b.value),
    Binary: _are_binary,
    Unary: lambda a, b, names: a.operator == b.operator == "-" and _is_alike(a.operand, b.operand, names),
    Call: lambda a, b, names: (a.function == b.function and a.function in _FUNCTIONS
                               and _are_alike(a.arguments, b.arguments, names)),
    Array: lambda a, b, names: _are_alike(a.items, b.items, names),
}


def _together(group: dict[int, tuple[Flat, list[str]]], evaluators: Sequence[Evaluator]) -> dict[int, Value] | None:
    """None where what they read differs in kind."""
    (first, own), *_ = group.values()
    columns = zip(*(names for _, names in group.values()), strict=True)
    names: dict[str, Sequence[str]] = {}
    for name, others in zip(own, columns, strict=True):
        if names.setdefault(name, others) != others:
            return None  # the first reads one name twice where others read two
    leaves = _Columns(evaluators, names)
    try:
        value = Evaluator(evaluators[0].model, evaluators[0].algebras[0], leaves).value(first)
    except _Unlike:
        return None
    return dict(zip(group, _rows(value, len(group)), strict=True))


class _Columns:
    """Leaves in which a name of the first expression stands for the names that all have in its place."""

    def __init__(self, evaluators: Sequence[Evaluator], names: dict[str, Sequence[str]]) -> None:
        self.evaluators, self.names = evaluators, names

    def symbol(self, name: str, level: int) -> Value:
        """Raises _Unlike for variables that have bindings: these are evaluated once, for all that read them."""
        variables = self.evaluators[0].model.variables
        of_each = [(e, variables[n]) for e, n in zip(self.evaluators, self.names[name], strict=True)]
        if any(variable.kind == "variable" for _, variable in of_each):
            raise _Unlike
        return _stacked([e.variable(variable.name, level, variable.span) for e, variable in of_each])

    def time(self, level: int) -> Scalar:
        raise _Unlike

    def frame(self, name: str, attribute: str, level: int) -> Value:
        leaves = self.evaluators[0].leaves
        if hasattr(leaves, "frames_together") and all(e.leaves is leaves for e in self.evaluators):
            return leaves.frames_together(self.names[name], attribute, level, _stacked)
        return _stacked([e.leaves.frame(n, attribute, level) for e, n in zip(self.evaluators, self.names[name], strict=True)])


def _stacked(values: Sequence[Value]) -> Value:
    """Columns of what the values are made of; one scalar where it is the same for all. Raises _Unlike."""
    first = values[0]
    kinds = {*map(type, values)}
    if len(kinds) > 1 and not all(issubclass(kind, ca.SX) for kind in kinds):
        raise _Unlike
    if all(value is first for value in values):
        return first
    if isinstance(first, tuple):
        if any(len(value) != len(first) for value in values):
            raise _Unlike
        return tuple(_stacked(part) for part in zip(*values, strict=True))
    if isinstance(first, Dual):
        return Dual(_stacked([value.value for value in values]), _stacked([value.rate for value in values]))
    if isinstance(first, float | int):
        if any(value != first for value in values):
            raise _Unlike
        return first
    return as_expression(column(*values))


def _rows(value: Value, count: int) -> Sequence[Value]:
    """The values that columns hold, one by one."""
    if isinstance(value, tuple):
        return list(zip(*(_rows(part, count) for part in value), strict=True))
    if not isinstance(value, ca.SX) or value.is_scalar():
        return [value] * count
    return cells(value)
