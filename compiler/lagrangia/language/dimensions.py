"""Checks of dimensions on the flat model: adding metres to seconds is an error with both units named.

A bare number takes the unit of its place. So a product with a bare factor is *soft*: it has the dimension of the rest, but gives
way where another one is wanted (`sin(3*time)`, `torque = 0.5*sin(2*time)`); an integer divisor, as in m*L^2/12, is a pure number.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from fractions import Fraction

from lagrangia.base.diagnostics import LagError, Report, Span
from lagrangia.language.figure_checks import check_figure
from lagrangia.language.flat import Delay, Equation, FlatModel, Sampler, Variable, When
from lagrangia.language.folding import fold
from lagrangia.language.frame_attributes import dimension_of, known_of
from lagrangia.language.functions import FRAME_FUNCTIONS
from lagrangia.language.number_checks import CONDITIONS, require_comparable, require_number, require_numbers, require_shape
from lagrangia.language.quantities import ANY, PURE, Quantity, fits, in_unit, over, times, unit_told
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
from lagrangia.language.units import ONE, Dimension, dimension, mixes_turns, power, spell
from lagrangia.language.units_of_calls import units_of_call

_METRE, _SECOND = dimension(m=1), dimension(s=1)
_JOULE, _WATT = dimension(kg=1, m=2, s=-2), dimension(kg=1, m=2, s=-3)


def check_dimensions(model: FlatModel) -> FlatModel:
    """The model with warnings of turns taken for radians. Raises LagError L03xx with all mismatches found."""
    checker = _Checker(model)
    for variable in model.news(model.variables.values()):
        checker.guard(checker.check_variable, variable, place=variable.span)
    for constant in model.constants:
        checker.guard(checker.check_constant, constant, place=constant.span)
    for frame in model.frames.values():
        for name, start in frame.starts.items():
            checker.guard(checker.expect, start, dimension_of(name), f"the start of {name}")
    for frames in model.news(model.frame_equations):
        for side in (frames.left, frames.right):
            if isinstance(side, Call):
                checker.guard(checker.check_frame, side, place=frames.span)
    for equation in model.news((*model.constraints, *model.initial_equations)):
        checker.guard(checker.check_equation, equation, place=equation.span)
    for state in model.states.values():
        checker.guard(checker.check_equation, state.equation, place=state.span)
    for when in model.whens:
        checker.guard(checker.check_when, when)
    for guard in model.guards:
        checker.guard(checker._require_condition, guard.condition, None)
    for sampler in model.samplers:
        checker.guard(checker.check_sampler, sampler)
    for delay in model.delays:
        checker.guard(checker.check_delay, delay)
    for energy in (energy for energy in model.news(model.energies) if not energy.is_signal):
        wanted = _WATT if energy.kind == "dissipation" else _JOULE
        what = "a dissipation function" if energy.kind == "dissipation" else f"a {energy.kind} energy"
        checker.guard(checker.expect, energy.value, wanted, what, place=energy.span)
    for work in (work for work in model.news(model.works) if not work.is_signal):
        checker.guard(checker.check_work, work.force, work.position, work.span, place=work.span)
    for figure in model.figures:
        checker.guard(check_figure, checker, figure)
    checker.report.raise_errors()
    return replace(model, warnings=(*model.warnings, *checker.report.diagnostics))


def dimension_of_value(model: FlatModel, node: Flat) -> Dimension | None:
    """Of an expression that was checked; None where any will do."""
    return _Checker(model).quantity(node).dimension


def units_of_given(model: FlatModel) -> Mapping[str, str]:
    """Of parameters and inputs, by their names: as declared, or that of what they are bound to or start from; "" where any will
    do, as beside a bare number, which gives way."""
    checker, given = _Checker(model), (v for v in model.variables.values() if v.kind in ("parameter", "input"))
    return {v.name: v.unit or unit_told(checker.quantity_of(v.name)) for v in given}


def units_of(model: FlatModel, nodes: Iterable[Flat]) -> list[str]:
    """The units of observables as text: as declared, or that of what they are bound to; "" where any will do, or none."""
    checker = _Checker(model)
    return [_unit(checker, node) for node in nodes]


def _unit(checker: "_Checker", node: Flat) -> str:
    match node:
        case Ref(name, _, _) if declared := checker.model.variables[name].unit:
            return declared
        case FrameRef():
            return known_of(node).unit if node.attribute else ""
        case Call("der", (inner,), _, _) if unit := _unit(checker, inner):
            return _rate_unit(unit)
    return unit_told(checker.quantity(node))


def _rate_unit(unit: str) -> str:
    return f"{unit}2" if unit.endswith("/s") else f"{unit}/s"


class _Checker:
    def __init__(self, model: FlatModel) -> None:
        self.model = model
        self.report = Report()
        self.known: dict[str, Quantity] = {}
        self.given = model.given_at_events()
        self.pending: set[str] = set()
        self.results: dict[tuple[object, ...], Quantity] = {}

    def guard(self, check: Callable[..., object], *arguments: object, place: Span | None = None) -> None:
        """Collects what a check raises, so that the next one is made all the same; what it finds in the library is told at
        `place`."""
        found = len(self.report.diagnostics)
        try:
            check(*arguments)
        except LagError as error:
            self.report.add(error.diagnostics)
        if place is not None and len(self.report.diagnostics) > found:
            self.report.diagnostics[found:] = [x.placed(place) for x in self.report.diagnostics[found:]]

    # ------------------------------------------------------------ checks

    def check_variable(self, variable: Variable) -> None:
        require_shape(self.model, variable)
        declared = self.declared(variable)
        for value, what in ((variable.binding, f"'{variable.name}'"), (variable.start, f"the start of '{variable.name}'")):
            if value is None:
                continue
            if variable.is_attitude:
                self.expect(value, ONE, what, "1")
            elif declared.dimension is not None:
                self.expect(value, declared.dimension, what, variable.unit)
                self.check_turns(value, what, variable.unit)
            else:
                require_number(value, self.report)
                self.quantity(value)

    def check_constant(self, constant: Variable) -> None:
        """Of what is known when the scene is compiled; only numbers have a dimension."""
        if constant.type_name in ("Real", "Integer"):
            self.check_variable(constant)
        else:
            require_shape(self.model, constant)

    def check_turns(self, value: Flat, what: str, unit: str) -> None:
        """Hz counts turns and rad/s radians, rpm and deg/s made of them: units that SI takes for the same, 6.28 apart."""
        told = value.unit if isinstance(value, Number) else None
        if told is None or not mixes_turns(told, unit):
            return
        if unit == "rad/s":
            self.report.warning("L0305", f"{what} is in rad/s: {value.span.text} is taken for that many radians a second",
                                value.span, "of turns a second, write 2*pi[rad/s] times as many")
        else:
            self.report.warning("L0305", f"{what} is in Hz: {value.span.text} is taken in radians a second, 6.28 times its turns",
                                value.span, "divide by 2*pi, or declare an AngularFrequency")

    def check_equation(self, equation: Equation) -> None:
        require_numbers((equation.left, equation.right), self.report)
        self.same(self.quantity(equation.left), self.quantity(equation.right), equation.span, "be equal")

    def check_when(self, when: When) -> None:
        self._require_condition(when.condition, None)
        for reset in when.resets:
            require_number(reset.value, self.report)
            self.same(self.quantity(reset.rate), self.quantity(reset.value), reset.span, "be equal")

    def check_sampler(self, sampler: Sampler) -> None:
        """Times of the instants, and values in the units of what holds them."""
        for node, what in ((sampler.start, "the first instant"), (sampler.interval, "the interval")):
            self.expect(node, _SECOND, what)
        for held in sampler.held:
            require_number(held.value, self.report)
            self.same(self.declared(self.model.variables[held.name]), self.quantity(held.value), held.span, "be equal")

    def check_delay(self, delay: Delay) -> None:
        """A time, and what was before in the unit of what is late."""
        self.expect(delay.lag, _SECOND, "a delay")
        require_numbers((delay.value, *filter(None, [delay.before])), self.report)
        if delay.before is not None:
            self.same(self.quantity(delay.value), self.quantity(delay.before), delay.span, "be equal")

    def declared(self, variable: Variable) -> Quantity:
        return in_unit(variable.unit) if variable.unit else ANY

    def check_frame(self, node: Flat) -> None:
        """The shifts and turns of a frame expression."""
        if isinstance(node, Call) and node.function in FRAME_FUNCTIONS:
            base, amount, *axis = node.arguments
            self.check_frame(base)
            for direction in axis:
                self.quantity(direction)
            self.expect(amount, *((_METRE, "a shift") if node.function == "shift" else (ONE, "an angle")))

    def check_work(self, force: Flat, position: Flat, span: Span) -> None:
        require_numbers((force, position), self.report)
        product = times(self.quantity(force), self.quantity(position))
        if not fits(product, _JOULE):
            self.report.error("L0304", f"force times position is in {product.spell()}, not in J", span,
                              "a force in N works on a length, a torque in N.m on an angle")

    def expect(self, node: Flat, wanted: Dimension, what: str, unit: str = "") -> None:
        if isinstance(node, Array):
            for item in node.items:
                self.expect(item, wanted, what, unit)
            return
        require_number(node, self.report)
        found = self.quantity(node)
        if not fits(found, wanted):
            name = unit or spell(wanted)
            hints = [f"give it a unit: 1[{name}]*..."] if found.dimension == ONE else []
            self.report.error("L0304", f"{what} is in {name}, this is in {found.spell()}", node.span, *hints)

    def same(self, a: Quantity, b: Quantity, span: Span, how: str) -> Quantity:
        """The common quantity of two that must agree."""
        if a.dimension is None or b.dimension is None:
            return b if a.dimension is None else a
        if a.dimension == b.dimension:
            return Quantity(a.dimension, a.is_soft and b.is_soft)
        if a.is_soft or b.is_soft:
            return (ANY if a.is_soft and b.is_soft else b if a.is_soft else a)
        self.report.error("L0304", f"{spell(a.dimension)} and {spell(b.dimension)} cannot {how}", span)
        return ANY

    # ------------------------------------------------------------ inference

    def quantity(self, node: Flat, local: Mapping[str, Quantity] | None = None) -> Quantity:
        match node:
            case Number(_, unit, _, _):
                return ANY if unit is None else in_unit(unit)
            case Boolean() | String() | EnumerationLiteral():
                return ANY
            case Ref(name, _, _):
                return self.quantity_of(name)
            case FrameRef(_, "", _, span):
                return self.refuse_frame(node, span)
            case FrameRef(_, attribute, _, _):
                return Quantity(dimension_of(attribute))
            case Local(name, _):
                return (local or {}).get(name, ANY)
            case Time():
                return Quantity(_SECOND)
            case Unary(operator, operand, _):
                if operator == "not":
                    self._refuse_numbers(operand)
                else:
                    require_number(operand, self.report)
                return self.quantity(operand, local)
            case Binary():
                return self._binary(node, local)
            case IfExpression(condition, then, otherwise, span):
                self._require_condition(condition, local)
                return self.same(self.quantity(then, local), self.quantity(otherwise, local), span, "stand for one value")
            case Array(items, span):
                return self.common([self.quantity(item, local) for item in items], span, "stand in one array")
            case Call():
                return units_of_call(self, node, local)

    def quantity_of(self, name: str) -> Quantity:
        """Of a variable."""
        if name not in self.known:
            variable = self.model.variables[name]
            found = self.declared(variable)
            if found.dimension is None and name not in self.pending:
                self.pending.add(name)
                found = self._told(variable)
                self.pending.discard(name)
            self.known[name] = found
        return self.known[name]

    def _told(self, variable: Variable) -> Quantity:
        """By what it is bound to, starts from, or is given at events, where it was declared without a unit. Numbers of these give
        way, as they do where they are written: `w = 0.5 + time/1[s]` at an event may be a place."""
        found = ANY
        for node in (variable.binding, variable.start, *self.given.get(variable.name, ())):
            said = ANY if node is None else self.quantity(node)
            if said == PURE and not (variable.kind == "variable" and node is variable.binding):
                said = replace(said, is_soft=True)
            if said.dimension is not None and not said.is_soft:
                return said
            found = found if said.dimension is None else said
        if variable.name in self.model.states:
            rate = self.quantity(self.model.states[variable.name].rate)
            return found if rate.dimension is None or rate.is_soft or rate == PURE else times(rate, Quantity(_SECOND))
        return found

    def common(self, found: list[Quantity], span: Span, how: str) -> Quantity:
        """That of several."""
        total = ANY
        for quantity in found:
            total = self.same(total, quantity, span, how)
        return total

    def _binary(self, node: Binary[Flat], local: Mapping[str, Quantity] | None) -> Quantity:
        a, b = self.quantity(node.left, local), self.quantity(node.right, local)
        if node.operator not in CONDITIONS:
            require_numbers((node.left, node.right), self.report)
        elif node.operator in ("and", "or"):
            self._refuse_numbers(node.left)
            self._refuse_numbers(node.right)
        else:
            require_comparable(node, self.report)
        match node.operator:
            case "+" | "-":
                return self.same(a, b, node.span, "be added" if node.operator == "+" else "be subtracted")
            case "*":
                return times(a, b)
            case "/":
                return over(a, b, node.right)
            case "^":
                return self._power(a, b, node)
            case "and" | "or":
                return PURE
            case _:
                self.same(a, b, node.span, "be compared")
                return PURE

    def _power(self, base: Quantity, exponent: Quantity, node: Binary[Flat]) -> Quantity:
        self.pure(exponent, node.right, "an exponent")
        if base.dimension is None or base.dimension == ONE:
            return base
        value = fold(node.right)
        if value is None or isinstance(value, bool):
            if not base.is_soft:
                self.report.error("L0304", f"{base.spell()} to a power that is not a fixed number", node.span,
                                  "its unit would change with the exponent: write a number, or declare it as a constant")
            return ANY
        return Quantity(power(base.dimension, Fraction(value).limit_denominator(12)), base.is_soft)

    def _require_condition(self, node: Flat, local: Mapping[str, Quantity] | None) -> None:
        self._refuse_numbers(node)
        self.quantity(node, local)

    def _refuse_numbers(self, node: Flat) -> None:
        """Conditions are comparisons, `true` and `false`, and what and, or and not make of them."""
        match node:
            case Boolean() | Unary("not", _, _):
                pass
            case Binary(operator, _, _, _) if operator in CONDITIONS:
                pass
            case _:
                self.report.error("L0302", "a condition is true or false", node.span, "compare it with something, as x > 0")

    def refuse_frame(self, node: Flat, span: Span) -> Quantity:
        """Reports L0221."""
        self.report.error("L0221", "a frame is no number", span, f"its position is {node}.r, its angle {node}.phi"
                          if isinstance(node, FrameRef) else "bind it to a port: Frame f = ...; and then f.r, f.phi")
        return ANY

    def pure(self, quantity: Quantity, node: Flat, what: str, *hints: str) -> None:
        """Reports L0304 for what has a unit."""
        if not fits(quantity, ONE):
            self.report.error("L0304", f"{what} must be a number without unit, this is in {quantity.spell()}", node.span, *hints)
