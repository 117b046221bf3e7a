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
        first = expressions[next(iter(group))]
        found |= _together(first, group, [evaluators[k] for k in group]) or {}
    return found


def _groups(expressions: Sequence[Flat]) -> Iterator[dict[int, tuple[str, ...]]]:
    """Those that stand in one place of the source and are alike: by their places, the names of each in the same order."""
    by_place: dict[int, list[int]] = {}
    for k, node in enumerate(expressions):
        by_place.setdefault(id(node.span), []).append(k)
    for places in by_place.values():
        if len(places) < _FEWEST:
            continue
        names_of = next(filter(None, (_reader(expressions[k]) for k in places)), None)
        group = {k: names for k in places if names_of is not None and (names := names_of(expressions[k])) is not None}
        if len(group) >= _FEWEST:
            yield group


def _reader(first: Flat) -> Callable[[Flat], tuple[str, ...] | None] | None:
    """Of an expression that is made as this one is, the names in it; None of others. None where this one has what is not taken by
    columns. It is written as one expression of Python: there are many to be looked at."""
    known: dict[str, Any] = {cls.__name__: cls for cls in _PARTS}
    tests, names, pending = list[str](), list[str](), [("x", first)]
    while pending:
        way, node = pending.pop()
        if node.__class__ not in _PARTS or not _is_taken(node):
            return None
        own, (compared, inside) = f"x{len(tests)}", _PARTS[node.__class__]
        tests.append(f"({own} := {way}).__class__ is {node.__class__.__name__}")
        names += [f"{own}.name"] if isinstance(node, Ref | FrameRef) else []
        for part in compared:
            known[f"k{len(tests)}"] = getattr(node, part)
            tests.append(f"{own}.{part} == k{len(tests)}")
        for part in inside:
            items = getattr(node, part)
            if isinstance(items, tuple):
                tests.append(f"len({own}.{part}) == {len(items)}")
            pending += ([(f"{own}.{part}[{k}]", item) for k, item in enumerate(items)] if isinstance(items, tuple)
                        else [(f"{own}.{part}", items)])
    found: Callable[[Flat], tuple[str, ...] | None] = eval(
        f"lambda x: ({''.join(f'{name}, ' for name in names)}) if {' and '.join(tests)} else None", known)
    return found


# What is compared of two expressions, and what is looked into.
_PARTS: Mapping[type, tuple[tuple[str, ...], tuple[str, ...]]] = {
    Ref: (("index",), ()), FrameRef: (("attribute", "index"), ()), Number: (("value",), ()), Array: ((), ("items",)),
    Unary: (("operator",), ("operand",)), Binary: (("operator",), ("left", "right")), Call: (("function",), ("arguments",)),
}


def _is_taken(node: Flat) -> bool:
    """Whether that is done by columns."""
    match node:
        case FrameRef():
            return node.attribute != ""
        case Binary():
            return node.operator in _OPERATORS
        case Unary():
            return node.operator == "-"
        case Call():
            return node.function in _FUNCTIONS
    return True


def _together(first: Flat, group: Mapping[int, tuple[str, ...]], evaluators: Sequence[Evaluator]) -> dict[int, Value] | None:
    """None where what they read differs in kind."""
    names: dict[str, Sequence[str]] = {}
    for name, others in zip(next(iter(group.values())), zip(*group.values(), strict=True), strict=True):
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
