"""Parameters of a scene as symbols that a reader wants to see, or as what they are; an evaluator that refuses endless work."""

from dataclasses import replace
from functools import cached_property

import sympy as sp

from lagrangia.algebra.duals import Dual, Scalar
from lagrangia.algebra.with_sympy import Expr, SympyAlgebra
from lagrangia.base.diagnostics import Span, fail
from lagrangia.base.records import dataclass
from lagrangia.frames.elements import whole
from lagrangia.frames.evaluation import Evaluator, Value, scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import Variable
from lagrangia.language.tree import Array, Flat, Number, Unary

GRAVITY, _INERTIA = "world.gravity", "kg.m2"
_LONGEST = 1500  # parts of the expression of one variable or function: some 10 s


@dataclass(frozen=True)
class Parameter:
    """A parameter that stayed a symbol; `formula` is its binding where that is one."""

    name: str
    symbol: Expr
    unit: str
    description: str
    formula: Expr | None


class ReadableEvaluator(Evaluator):
    """Refuses what SymPy, which shares no sub-expressions when it differentiates or prints, would work on without end."""

    @cached_property
    def _lengths(self) -> dict[int, tuple[Expr, int]]:
        return {}  # by the id of an expression, which is kept: to compare long ones may take as long

    def _bound(self, name: str, level: int) -> Value:
        return self._measured(super()._bound(name, level), self.model.variables[name].span)

    def _measured(self, value: Value, span: Span | None) -> Value:
        parts = scalars_of(value)
        while parts:
            x = parts.pop()
            if isinstance(x, Dual):
                parts += [x.value, x.rate]
            elif isinstance(x, sp.Basic) and self._length(x) > _LONGEST:
                fail("L0712", f"not supported yet: equations with an expression of more than {_LONGEST} parts, each counted as "
                     "often as it stands in it", span,
                     "lag simulate, FMUs, --to python and --to casadi compute once what stands in several places")
        return value

    def _length(self, x: Expr) -> int:
        known = self._lengths.get(id(x))
        if known is None:
            known = self._lengths[id(x)] = x, 1 + sum(self._length(part) for part in x.args)
        return known[1]


class ParameterTable:
    """Leaves of an evaluator of parameters alone; remembers which stayed symbols."""

    def __init__(self, kinematics: Kinematics, algebra: SympyAlgebra) -> None:
        self.model = kinematics.graph.model
        self.evaluator = ReadableEvaluator(self.model, algebra, self)
        self.parameters: dict[str, Parameter] = {}
        self.known: dict[str, Value] = {}
        self.moments: dict[tuple[str, float | None], str] = {}

    def symbol(self, name: str, level: int) -> Value:
        """A parameter, as a symbol where a reader wants to see one."""
        if name not in self.known:
            variable = self.model.variables[name]
            assert variable.binding is not None
            self.known[name] = self._resolve(variable, variable.binding)
        return self.known[name]

    def time(self, level: int) -> Scalar:
        """Parameters do not depend on it."""
        raise AssertionError("a parameter does not depend on time")

    def frame(self, name: str, attribute: str, level: int) -> Value:
        """Parameters do not depend on frames."""
        raise AssertionError("a parameter does not depend on frames")

    def _resolve(self, variable: Variable, binding: Flat) -> Value:
        if variable.name == GRAVITY:
            return self._gravity(variable, binding)
        if isinstance(binding, Array) and len(variable.shape) == 1:
            return whole(self.evaluator.begun, variable, binding,
                         lambda item, index: self._element(variable, f"{variable.name}[{index[0]}]", item))
        if variable.shape:
            return whole(self.evaluator.begun, variable, binding, lambda item, index: self.evaluator.value(item))
        if "." not in variable.name:
            formula = None if number_of(binding) is not None else self.evaluator.value(binding)
            return self._keep(variable, variable.name, formula)
        number = number_of(binding)
        if number is not None:
            is_plain = number == 0 or (variable.unit in ("", "1") and number in (1, -1))
            return self.evaluator.value(binding) if is_plain else self._keep(variable, variable.name, None)
        value = self.evaluator.value(binding)
        return value if _is_simple(value) else self._keep(variable, variable.name, value)

    def _element(self, variable: Variable, name: str, item: Flat) -> Value:
        number = number_of(item)
        if number in (None, 0, 1, -1):
            return self.evaluator.value(item)
        if variable.unit != _INERTIA:
            return self._keep(variable, name, None)
        first = self.moments.setdefault((variable.name, number), name)  # equal moments have one symbol: bodies that are symmetric
        if first == name:
            return self._keep(variable, name, None)
        known = self.parameters[first]
        self.parameters[first] = replace(known, description=f"{known.description}; {name} is the same")
        return known.symbol

    def _gravity(self, variable: Variable, binding: Flat) -> Value:
        """g along an axis."""
        items = binding.items if isinstance(binding, Array) else ()
        numbers = [number_of(item) for item in items]
        pulling = [x for x in numbers if x]
        if None in numbers or len(pulling) != 1:
            return tuple(self._element(variable, f"{GRAVITY}[{k}]", item) for k, item in enumerate(items, 1)) if items \
                else self.evaluator.value(binding)
        g = self._keep(variable, GRAVITY, None, nonnegative=True)
        return tuple(g if x and x > 0 else -g if x else sp.S.Zero for x in numbers)

    def _keep(self, variable: Variable, name: str, formula: Expr | None, nonnegative: bool = False) -> Expr:
        known = nonnegative or (variable.minimum is not None and variable.minimum >= 0)
        symbol = sp.Symbol(name, real=True, **({"nonnegative": True} if known else {}))
        self.parameters[name] = Parameter(name, symbol, variable.unit, variable.description, formula)
        return symbol


def number_of(node: Flat) -> float | None:
    """A number that is written as one."""
    match node:
        case Number(value):
            return value
        case Unary("-", Number(value), _):
            return -value
    return None


def _is_simple(value: Expr) -> bool:
    """A number times one symbol: 2 L, -r."""
    rest = value.as_coeff_Mul()[1] if isinstance(value, sp.Expr) else value
    return isinstance(rest, sp.Symbol | sp.Number | int | float)
