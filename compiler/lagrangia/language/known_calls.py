"""Calls of people's own functions whose arguments are known when the scene is compiled: `parameter Integer n = count(3)`."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import field, replace

from lagrangia.base.records import dataclass
from lagrangia.language.folding import folded
from lagrangia.language.function_variables import FlatFunction
from lagrangia.language.loops import Work
from lagrangia.language.mentions import nodes
from lagrangia.language.tree import (
    Array,
    Binary,
    Boolean,
    Call,
    EnumerationLiteral,
    Flat,
    IfExpression,
    Local,
    Number,
    String,
    Unary,
)

_EVALUATED = "the calls of functions whose values are needed when this model is compiled take"


@dataclass
class MadeFunctions:
    """The functions of a model, each made for what calls give it, and the results of calls that were evaluated."""

    functions: dict[str, FlatFunction] = field(default_factory=dict)
    _results: dict[Hashable, Flat | None] = field(default_factory=dict)

    def with_known_calls(self, node: Flat, work: Work, locals_: Mapping[str, Flat] | None = None) -> Flat:
        """An expression in which calls of known arguments, and `locals_`, are the values that they have. Raises TooMuchError
        L0209 where that takes more steps than `work` allows."""
        known = locals_ or {}

        def inside(part: Flat) -> Flat:
            return self.with_known_calls(part, work, known)

        match node:
            case Local(name):
                return known.get(name, node)
            case Array(items, span):
                return Array(tuple(map(inside, items)), span)
            case Unary(operator, operand, span):
                return Unary(operator, inside(operand), span)
            case Binary(operator, left, right, span):
                return Binary(operator, inside(left), inside(right), span)
            case IfExpression(condition, then, otherwise, _):
                chosen = folded(inside(condition))
                return inside(then if chosen.value else otherwise) if isinstance(chosen, Boolean) else node
            case Call(function, arguments, (), _):
                values = tuple(map(inside, arguments))
                found = self._result(self.functions[function], values, work) if function in self.functions else None
                return found if found is not None else replace(node, arguments=values)
        return node

    def _result(self, function: FlatFunction, values: Sequence[Flat], work: Work) -> Flat | None:
        """Each call is evaluated once, for functions that call others twice would take twice the time of these."""
        known: dict[str, Flat] = {}
        for name, value in zip(function.inputs, values, strict=True):
            if (found := folded(value)) is None:
                return None
            known[name] = found
        key = function.name, *map(_said, known.values())
        if key not in self._results:
            self._results[key] = self._evaluated(function, known, work)
        return self._results[key]

    def _evaluated(self, function: FlatFunction, known: dict[str, Flat], work: Work) -> Flat | None:
        for name, value in function.steps:
            work.spend(sum(1 for _ in nodes(value)), function.span, _EVALUATED)
            found = folded(self.with_known_calls(value, work, known))
            if found is None:
                return None
            known[name] = found
        return known.get(function.output)


def _said(value: Flat) -> Hashable:
    """What tells one literal, or array of literals, from another, wherever it is written."""
    match value:
        case Array(items):
            return tuple(map(_said, items))
        case Number(number, unit, _, is_integer):
            return repr(number), unit, is_integer  # -0.0 is another one than 0.0
        case Boolean(said) | String(said):
            return type(value), said
        case EnumerationLiteral(type_name, _, ordinal):
            return type_name, ordinal
    return id(value)
