"""Flat expressions -> scalars and vectors of an algebra.

Everything is evaluated at a *level*: level 0 gives plain scalars of the base algebra, level 1 Duals that carry the rate along,
level 2 Duals of Duals with the acceleration as well. `der(e)` at level k is the rate of e at level k + 1.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from math import copysign
from typing import Any, Protocol, TypeAlias

from lagrangia.algebra.duals import (
    Algebra,
    DualAlgebra,
    Scalar,
    base_of,
    minus,
    plus,
    rate_of,
    times,
)
from lagrangia.base.diagnostics import LagError, Span, fail
from lagrangia.base.table_data import TableData
from lagrangia.frames.arrays import array_of, map_scalars, need_vectors, zip_scalars
from lagrangia.frames.elements import Elements, whole
from lagrangia.frames.expression_forms import refuse_division, sum_of_squares
from lagrangia.frames.planar import cross, turned_vector
from lagrangia.frames.table_values import lines_value, plane_value, table_of_points, table_value
from lagrangia.language.consequences import name_of_constraint, side_of
from lagrangia.language.events import contact_of, held_by, name_of_contact
from lagrangia.language.flat import FlatModel
from lagrangia.language.function_variables import FlatFunction
from lagrangia.language.lookups import lookup_of, plane_of
from lagrangia.language.tree import (
    Array,
    Binary,
    Boolean,
    Call,
    EnumerationLiteral,
    Flat,
    FrameRef,
    IfExpression,
    Local,
    Number,
    Ref,
    String,
    Time,
    Unary,
)

Value: TypeAlias = Any  # Scalar | tuple[Value, ...]
_HIGHEST_LEVEL = 2
_LARGEST_EXPANDED_POWER = 8
_MOST_STATEMENTS = 200_000  # of functions, evaluated: some 10 us each


class Leaves(Protocol):
    """Where the values of symbols and frames come from (kinematics.py)."""

    def symbol(self, name: str, level: int) -> Value | None:
        """A coordinate, parameter, input or held value (pre(x): before an instant); None for a variable with a binding."""

    def time(self, level: int) -> Scalar:
        """The time, s."""
    def frame(self, name: str, attribute: str, level: int) -> Value:
        """An attribute of a frame (language/frame_attributes.py)."""


class Evaluator:
    """Evaluates expressions of one flat model; values of variables are kept, so that each is computed once a level."""

    def __init__(self, model: FlatModel, algebra: Algebra, leaves: Leaves, virtual: Callable[[Scalar], Scalar] | None = None,
                 signed_length: Callable[[list[Scalar], int], Scalar | None] | None = None) -> None:
        """`virtual` gives what virtual displacements change of a scalar: nothing, without it. `signed_length` of a vector of
        plain scalars that stays on a line through zero: its length at a level, with a sign; None for others."""
        self.model, self.leaves, self.virtual, self._number = model, leaves, virtual, algebra.number
        self.signed_length = signed_length
        self.algebras: list[Algebra] = [algebra]
        for _ in range(_HIGHEST_LEVEL):
            self.algebras.append(DualAlgebra(self.algebras[-1]))
        self._known: dict[tuple[str, int], Value] = {}
        self._pending: list[str] = []
        self.begun: dict[tuple[str, int], Elements] = {}  # arrays in the midst of their evaluation
        self._results: dict[tuple[Any, ...], tuple[list[Value], Value]] = {}  # of functions; arguments are kept, their ids last
        self._tables: dict[int, tuple[Call[Flat], TableData]] = {}  # of points with options, by calls that are kept
        self._statements = 0
        self._asked: Span | None = None  # the call outside functions that is evaluated

    def value(self, node: Flat, level: int = 0, local: Mapping[str, Value] | None = None) -> Value:
        """The value of an expression at a level; `local` are the variables of a function. Raises LagError."""
        match node:  # what stands in most expressions first
            case Ref(name, index, span):
                if index and (name, level) in self.begun:
                    return self.begun[name, level].value(index)
                return _element(self.variable(name, level, span), index)
            case Binary():
                return self._binary(node, level, local)
            case Number(number):
                return self._number(number)
            case FrameRef(name, attribute, index, _):
                return _element(self.leaves.frame(name, attribute, level), index)
            case Call():
                return self._call(node, level, local)
            case Boolean(flag):
                return self._number(float(flag))
            case Time():
                return self.leaves.time(level)
            case Local(name, span):
                if local is None or name not in local:
                    fail("L0211", f"'{name}' is used before it is given a value", span)
                return local[name]
            case Unary("not", operand, _):
                return self.algebras[level].logic("not", self.value(operand, level, local))
            case Unary(_, operand, _):
                return map_scalars(lambda x: -x, self.value(operand, level, local))
            case IfExpression(condition, then, otherwise, _):
                chosen = self.value(condition, level, local)
                a, b = self.value(then, level, local), self.value(otherwise, level, local)
                return zip_scalars(lambda x, y: self.algebras[level].choose(chosen, x, y), a, b, node.span)
            case Array(items, _):
                return array_of(tuple(self.value(item, level, local) for item in items), node.span)
            case String(_, span):
                fail("L0302", "a text is no number", span)
            case EnumerationLiteral(type_name, _, _, span):
                fail("L0302", f"a value of {type_name} is no number", span,
                     "it can be compared: if e == E.a; Integer(e) is its place")

    def variable(self, name: str, level: int, span: Span) -> Value:
        """The value of a variable, by its binding where it has one. Raises LagError."""
        key = (name, level)
        if key not in self._known:
            value = self.leaves.symbol(name, level)
            if value is None:
                value = self._bound(name, level)
            self._known[key] = value
        return self._known[key]

    def _bound(self, name: str, level: int) -> Value:
        variable = self.model.variables[name]
        if name in self._pending:
            chain = self._pending[self._pending.index(name) :]
            fail("L0212", f"'{name}' depends on itself", variable.span, " > ".join([*chain, name]))
        assert variable.binding is not None
        self._pending.append(name)
        try:
            value = whole(self.begun, variable, variable.binding, lambda node, index: self.value(node, level), level)
            self._pending.pop()
            elements(value, variable.shape, variable.binding.span)
        except LagError as error:
            raise error.placed(variable.span) from None
        return value

    # ------------------------------------------------------------ operators

    def _binary(self, node: Binary[Flat], level: int, local: Mapping[str, Value] | None) -> Value:
        algebra = self.algebras[level]
        is_odd = node.operator == "^" and isinstance(node.right, Number) and node.right.value % 1 == 0.5
        if is_odd and isinstance(node.right, Number) and (parts := sum_of_squares(node.left)) is not None:  # |x|^(2 b)
            return self._power(self._root_of_squares(parts, level, local), 2 * node.right.value, level, node.span)
        a, b = self.value(node.left, level, local), self.value(node.right, level, local)
        match node.operator:
            case "+":
                return zip_scalars(plus, a, b, node.span)
            case "-":
                return zip_scalars(minus, a, b, node.span)
            case "*":
                return self._product(a, b, node.span, level)
            case "/":
                divisor = _number(b, node.right.span)
                if isinstance(divisor, float | int) and divisor == 0:
                    refuse_division(node, self.model)
                return map_scalars(lambda x: algebra.quotient(x, divisor, node.span), a)
        a, b = _number(a, node.left.span), _number(b, node.right.span)
        match node.operator:
            case "^":
                with _computable(node.span):
                    return self._power(a, b, level, node.span)
            case "and" | "or":
                return algebra.logic(node.operator, a, b)
            case _:
                return algebra.compare(node.operator, a, b)

    def _product(self, a: Value, b: Value, span: Span, level: int) -> Value:
        """Scalar times anything; of two vectors the inner product."""
        product = self.algebras[level].product
        if isinstance(a, tuple) and isinstance(b, tuple):
            return _sum(zip_scalars(times, a, b, span))
        if isinstance(a, tuple):
            return map_scalars(lambda x: product(x, b), a)
        return map_scalars(lambda y: product(a, y), b)

    def _power(self, base: Scalar, exponent: Scalar, level: int, span: Span) -> Scalar:
        """Whole and half powers by multiplication and sqrt: a C compiler calls pow for the others, which is slow."""
        algebra = self.algebras[level]
        if not isinstance(exponent, float | int) or isinstance(base, float | int):
            return algebra.call("pow", base, exponent)
        if exponent < 0:
            return algebra.quotient(1.0, self._power(base, -exponent, level, span), span)
        if exponent == 0.5:
            return algebra.call("sqrt", base)
        if not float(exponent).is_integer() or exponent > _LARGEST_EXPANDED_POWER:
            return algebra.call("pow", base, float(exponent))
        return self._whole_power(base, int(exponent))

    def _whole_power(self, base: Scalar, exponent: int) -> Scalar:
        if exponent == 0:
            return 1
        half = self._whole_power(base, exponent // 2)
        square = half * half if exponent > 1 else 1
        return square * base if exponent % 2 else square

    # ------------------------------------------------------------ functions

    def _call(self, node: Call[Flat], level: int, local: Mapping[str, Value] | None) -> Value:
        if node.function == "der":
            return self._rate(node, level, local)
        if node.function == "distance":
            return self._distance(node, level)
        if node.function == "pre" and isinstance(held := node.arguments[0], Ref) and self._is_held(held.name):
            return self.leaves.symbol(f"pre({held.name})", level)
        if node.function == "contact_force":
            return self._contact_force(node, level)
        if node.function == "constraint_force":
            return self._constraint_force(node, level)
        if node.function == "table" and (node.named or len(node.arguments) == 2):
            return self._look_up(node, level, local)
        if node.function == "table2" and len(node.arguments) == 3:
            return self._look_up_in_plane(node, level, local)
        if node.function == "sqrt" and (parts := sum_of_squares(node.arguments[0])) is not None:
            return self._root_of_squares(parts, level, local)
        arguments = [self.value(argument, level, local) for argument in node.arguments]
        if node.function in self.model.functions:
            numbers = [_number(value, argument.span) for value, argument in zip(arguments, node.arguments, strict=True)]
            self._asked = node.span if local is None else self._asked
            return self._user_function(self.model.functions[node.function], numbers, level)
        vector = _VECTOR_FUNCTIONS.get(node.function)
        if vector is not None:
            return vector(self, arguments, level, node.span)
        numbers = [_number(value, argument.span) for value, argument in zip(arguments, node.arguments, strict=True)]
        with _computable(node.span):
            return self.algebras[level].call(node.function, *numbers)

    def _is_held(self, name: str) -> bool:
        return self.model.variables[name].kind == "held"

    def _look_up(self, node: Call[Flat], level: int, local: Mapping[str, Value] | None) -> Scalar:
        """table(x, "file", ...), and tables of points with options."""
        x = _number(self.value(node.arguments[0], level, local), node.arguments[0].span)
        if len(node.arguments) == 2:
            return table_value(self.algebras[level], x, self.model.tables[lookup_of(node)].data, node)
        if id(node) not in self._tables:
            self._tables[id(node)] = node, table_of_points(node, *(self.value(points) for points in node.arguments[1:]))
        return table_value(self.algebras[level], x, self._tables[id(node)][1], node)

    def _look_up_in_plane(self, node: Call[Flat], level: int, local: Mapping[str, Value] | None) -> Scalar:
        """table2(x, y, "file")."""
        x, y = (_number(self.value(argument, level, local), argument.span) for argument in node.arguments[:2])
        plane = self.model.planes[plane_of(node)]
        return plane_value(self.algebras[level], x, y, plane.x, plane.y, plane.z, node.span)

    def _rate(self, node: Call[Flat], level: int, local: Mapping[str, Value] | None) -> Value:
        if local is not None:
            fail("L0302", "der(...) cannot stand in a function", node.span)
        if level >= _HIGHEST_LEVEL:
            fail("L0503", "der of der of der: only positions, velocities and accelerations are known", node.span)
        inner = node.arguments[0]
        if isinstance(inner, Ref) and inner.name in self.model.states:
            return self.value(self.model.states[inner.name].rate, level)
        return map_scalars(rate_of, self.value(inner, level + 1))

    @cached_property
    def _kept(self) -> list[Flat | None]:
        return [held_by(self.model, when) for when in self.model.whens]

    def _contact_force(self, node: Call[Flat], level: int) -> Scalar:
        """What holds x at its contact: 0 where the leaves know of no events."""
        event = contact_of(self._kept, node.arguments[0])
        if event is None:
            fail("L0226", f"nothing is in contact at {node.arguments[0].span.text}", node.span,
                 "contact_force(x) is the force of: when x < 0 then reinit(der(x), -e*pre(der(x))); end when;")
        if level > 0:
            fail("L0911", "the rate of a contact force is not known", node.span)
        known = self.leaves.symbol(name_of_contact(event), level)
        return 0.0 if known is None else known

    def _constraint_force(self, node: Call[Flat], level: int) -> Value:
        """What an equation exerts along the side x that it holds."""
        found = side_of(self.model, node.arguments[0])
        if found is None:
            fail("L0226", f"no equation holds {node.arguments[0].span.text}", node.span,
                 "constraint_force(x) is the force along x of an equation with x on one side, as x = f(time)")
        if level > 0:
            fail("L0911", "the rate of the force of a constraint is not known", node.span)
        force = self.leaves.symbol(name_of_constraint(found[0]), level)
        assert force is not None
        return force if found[1] > 0 else -force

    def _distance(self, node: Call[Flat], level: int) -> Scalar:
        """Between two frames or two points."""
        start, end = (self.value(origin_of(argument), level) for argument in node.arguments)
        need_vectors([start, end], 2, node.span)
        return self.norm(zip_scalars(lambda x, y: x - y, end, start, node.span), level)

    def norm(self, vector: Value, level: int) -> Scalar:
        """Of what stays on a line |s|, whose corner is a condition on s."""
        along = self._along(scalars_of(vector), level)
        if along is not None:
            self.algebras[0].note_length(base_of(along))
            return self.algebras[level].call("abs", along)
        squares = _sum(map_scalars(lambda x: x * x, vector))
        if isinstance(squares, float | int):
            return float(squares) ** 0.5
        return self.algebras[level].call("sqrt", squares + self.algebras[0].tiny)

    def _root_of_squares(self, parts: list[Flat], level: int, local: Mapping[str, Value] | None) -> Scalar:
        """sqrt(x^2 + y^2); the square of a vector is its inner product."""
        return self.norm(tuple(scalars_of(tuple(self.value(part, level, local) for part in parts))), level)

    def _along(self, vector: list[Scalar], level: int) -> Scalar | None:
        if self.signed_length is None:
            return None
        plain = [base_of(x) for x in vector]
        moving = [x for x, value in zip(vector, plain, strict=True) if not _is_nothing(value)]
        if len(moving) == 1:
            return moving[0]
        return self.signed_length(plain, level) if len(vector) == 2 else None

    def _user_function(self, function: FlatFunction, arguments: list[Value], level: int) -> Value:
        """Computed once for the same arguments. Raises LagError L0209 when calls in calls ask for more than can be computed."""
        key = function.name, level, *map(_identity, arguments)
        if key not in self._results:
            known = dict(zip(function.inputs, arguments, strict=True))
            for name, expression in function.steps:
                self._statements += 1
                if self._statements > _MOST_STATEMENTS:
                    fail("L0209", f"functions of more than {_MOST_STATEMENTS} statements in all, each counted as often as it is "
                         "called", self._asked, "what functions call inside each other multiplies")
                known[name] = self._measured(self.value(expression, level, known), self._asked)
            self._results[key] = arguments, known[function.output]
        return self._results[key][1]

    def _measured(self, value: Value, span: Span | None) -> Value:
        """The value, where an algebra does not mind how long it is; paper/symbolic.py refuses some."""
        return value


def _identity(x: Scalar) -> Any:
    """Equal for numbers that are equal, and for the same expression."""
    return (x, copysign(1.0, x)) if isinstance(x, float | int) else (id(x),)


def _is_nothing(x: Scalar) -> bool:
    return bool(x == 0) if isinstance(x, float | int) else bool(x.is_zero())


def origin_of(node: Flat) -> Flat:
    """The origin of a frame; a point is its own."""
    if isinstance(node, FrameRef) and not node.attribute:
        return replace(node, attribute="r")
    return node


# -------------------------------------------------------------------- vectors


@contextmanager
def _computable(span: Span) -> Iterator[None]:
    """Numbers alone are computed at once, which may fail."""
    try:
        yield
    except (ValueError, ArithmeticError):
        fail("L0217", "this cannot be computed", span, "a value outside the function's domain")


def _number(value: Value, span: Span) -> Scalar:
    if isinstance(value, tuple):
        fail("L0303", f"a number is needed here, this is an array of {len(value)}", span)
    return value


def scalars_of(value: Value) -> list[Scalar]:
    """The scalars of a value of any shape, row by row."""
    return [x for item in value for x in scalars_of(item)] if isinstance(value, tuple) else [value]


def elements(value: Value, shape: tuple[int, ...], span: Span) -> list[Scalar]:
    """The scalars of a value that must have this shape, row by row. Raises LagError L0303."""
    if not shape:
        if isinstance(value, tuple):
            fail("L0303", f"an array of {len(value)} for a number", span)
        return [value]
    if not isinstance(value, tuple) or len(value) != shape[0]:
        what = f"{len(value)} value{'s' * (len(value) != 1)}" if isinstance(value, tuple) else "one number"
        fail("L0303", f"{what} for an array of {shape[0]}", span)
    return [x for item in value for x in elements(item, shape[1:], span)]


def _sum(values: Value) -> Scalar:
    total: Scalar = 0.0
    for value in values if isinstance(values, tuple) else (values,):
        total = value if isinstance(total, float) and total == 0 else total + value
    return total


def _element(value: Value, index: tuple[int, ...]) -> Value:
    for i in index:
        value = value[i - 1]
    return value


def _dot(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Scalar:
    need_vectors(arguments, 2, span)
    a, b = arguments
    return _sum(zip_scalars(times, a, b, span))


def _cross(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Scalar:
    need_vectors(arguments, 2, span, size=2)
    return cross(*arguments)


def _norm(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Scalar:
    need_vectors(arguments, 1, span)
    return evaluator.norm(arguments[0], level)


def _rotate(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Value:
    """rotate(vector, angle), counter-clockwise."""
    need_vectors(arguments, 1, span, size=2)
    return turned_vector(arguments[0], _number(arguments[1], span), evaluator.algebras[level])


def _extreme(function: str) -> Callable[[Evaluator, list[Value], int, Span], Scalar]:
    def evaluate(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Scalar:
        if not (values := scalars_of(tuple(arguments))):
            fail("L0217", "the smallest or largest of no numbers", span)
        first, *rest = values
        for value in rest:
            first = evaluator.algebras[level].call(function, first, value)
        return first

    return evaluate


def _total(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Scalar:
    return _sum(tuple(scalars_of(tuple(arguments))))


def _product_of(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Scalar:
    total: Scalar = 1
    for value in scalars_of(tuple(arguments)):
        total = total * value
    return total


def _table(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Scalar:
    x, xs, ys = arguments
    return lines_value(evaluator.algebras[level], _number(x, span), xs, ys, span)


def _table2(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Scalar:
    x, y, xs, ys, zs = arguments
    return plane_value(evaluator.algebras[level], _number(x, span), _number(y, span), xs, ys, zs, span)


def _item(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Value:
    """element(vector, k), made by the compiler."""
    vector, k = arguments
    if not isinstance(vector, tuple) or not 1 <= int(k) <= len(vector):
        fail("L0303", "a vector is needed here", span)
    return vector[int(k) - 1]


def _before(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Value:
    """pre(x): x before the event, where it is read in any case."""
    return arguments[0]


def _virtual(evaluator: Evaluator, arguments: list[Value], level: int, span: Span) -> Value:
    """virtual(x): zero, but that its virtual displacement is that of x."""
    return map_scalars(evaluator.virtual or (lambda x: 0.0), arguments[0])


_VECTOR_FUNCTIONS: Mapping[str, Callable[[Evaluator, list[Value], int, Span], Value]] = {
    "dot": _dot, "cross": _cross, "norm": _norm, "rotate": _rotate, "min": _extreme("fmin"), "max": _extreme("fmax"),
    "sum": _total, "product": _product_of, "table": _table, "table2": _table2, "element": _item,
    "virtual": _virtual, "pre": _before,
}
