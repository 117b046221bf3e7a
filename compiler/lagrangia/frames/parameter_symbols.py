"""Symbols of parameters and inputs in the shapes of their values, and what is 0 as they are declared."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from math import isnan, nan

import casadi as ca

from lagrangia.algebra.scalars import column, symbol
from lagrangia.base.records import dataclass
from lagrangia.frames.evaluation import Value, scalars_of
from lagrangia.language.compiled_numbers import values_as_declared
from lagrangia.language.flat import FlatModel


def shaped_symbols(name: str, shape: tuple[int, ...], index: tuple[int, ...] = ()) -> Value:
    """Of a quantity, one for each of its elements."""
    if not shape:
        return symbol(name + (f"[{','.join(map(str, index))}]" if index else ""))
    return tuple(shaped_symbols(name, shape[1:], (*index, i)) for i in range(1, shape[0] + 1))


def compiled_in(value: Value, numbers: Sequence[float | None]) -> Value:
    """The symbols of a parameter, with numbers in place of those that are compiled in."""
    known = iter(numbers)

    def pick(item: Value) -> Value:
        if isinstance(item, tuple):
            return tuple(pick(x) for x in item)
        number = next(known)
        return item if number is None else number

    return pick(value)


@dataclass(frozen=True)
class VanishAsDeclared:
    """Tells of expressions whether they are 0 with all parameters as declared; of what else they mention nothing is known."""

    model: FlatModel
    symbols: Mapping[str, Value]

    @cached_property
    def _declared(self) -> tuple[ca.SX, list[float]]:
        """The symbols of all elements of parameters, and their values; NaN where these are not known."""
        parameters = [v for v in self.model.variables.values() if v.kind == "parameter"]
        known = [nan if value is None else value for v in parameters for value in values_as_declared(self.model, v)]
        return column(*[part for v in parameters for part in scalars_of(self.symbols[v.name])]), known

    def __call__(self, x: ca.SX) -> bool:
        """Of a scalar."""
        own, known = self._declared
        others = [part for part in ca.symvar(x) if not ca.depends_on(own, part)]
        value = float(ca.evalf(ca.substitute(x, ca.vertcat(own, *others), ca.DM([*known, *[nan] * len(others)]))))
        return not isnan(value) and value == 0
