"""Parameters: all values from those given, the dependent ones following their bindings."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from functools import reduce
from math import prod
from typing import NoReturn

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.orthogonal import general_numbers
from lagrangia.algebra.scalars import apply, cells, column
from lagrangia.base.checked_values import misfit
from lagrangia.base.diagnostics import LagError, Report, Span, fail
from lagrangia.base.inertias import ROUNDING, axis_words, principal, told_beyond_others
from lagrangia.frames.alike import evaluate_alike
from lagrangia.frames.arrays import map_scalars
from lagrangia.frames.elements import whole
from lagrangia.frames.evaluation import Evaluator, Value, elements, scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.directions import directions
from lagrangia.language.flat import FlatModel, Variable
from lagrangia.language.folding import numbers_of
from lagrangia.language.tree import Number

_NO_LENGTH = "the direction '{}' has no length: all its parts are 0"


def scalars(name: str, value: Value) -> list[tuple[str, Scalar]]:
    """The entries of an array by name[k] or name[i,k], counted from 1; a scalar by its name."""
    def entries(value: Value, index: tuple[int, ...]) -> list[tuple[str, Scalar]]:
        if not isinstance(value, tuple):
            return [(name + (f"[{','.join(map(str, index))}]" if index else ""), value)]
        return [pair for k, item in enumerate(value, 1) for pair in entries(item, (*index, k))]

    return entries(value, ())


def all_parameters(kinematics: Kinematics, n: int) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Symbols of the values given and of their mask, (n,) each, and all parameters: one not given follows from its binding."""
    model = kinematics.graph.model
    given, mask = ca.SX.sym("given", n), ca.SX.sym("mask", n)
    if n == 0:
        return given, mask, ca.SX(0, 1)
    leaves = _ParameterLeaves(model, kinematics, given, mask)
    parameters = [v for v in model.variables.values() if v.kind == "parameter"]
    values = [x for v in parameters for x in scalars_of(leaves.parameter(v.name, v.span))]
    return given, mask, column(*values)


def parameters_of(kinematics: Kinematics, p: ca.SX, given: Collection[str] = ()) -> ca.SX:
    """All parameters in terms of p, both (n,).

    One whose binding speaks of other parameters follows them, and its entry of p is not read, unless its name is in `given`; all
    others are their entries of p. Derivatives with respect to p thus go through the bindings.
    """
    n = p.numel()
    symbols, mask, values = all_parameters(kinematics, n)
    rows, columns = ca.Function("values", [symbols, mask], [values]).jac_sparsity(0, 0).get_triplet()
    bound = {i for i, j in zip(rows, columns, strict=True) if i != j}
    model = kinematics.graph.model
    names = [name for v in model.variables.values() if v.kind == "parameter" for name, _ in v.elements()]
    is_read = ca.DM([float(k not in bound or name in given) for k, name in enumerate(names)])
    return ca.substitute(values, ca.vertcat(symbols, mask), ca.vertcat(p, is_read)) if n else values


def parameter_symbols(kinematics: Kinematics) -> ca.SX:
    """Of all parameters, (n,)."""
    model, symbols = kinematics.graph.model, kinematics.symbols
    return column(*[x for v in model.variables.values() if v.kind == "parameter" for x in scalars_of(symbols.values[v.name])])


def input_symbols(kinematics: Kinematics) -> ca.SX:
    """Of all inputs, (n_u,)."""
    inputs = [v.name for v in kinematics.graph.model.variables.values() if v.kind == "input"]
    return ca.vertcat(ca.SX(0, 1), *[x for name in inputs for x in scalars_of(kinematics.symbols.values[name])])


def with_declared_inputs(kinematics: Kinematics, expressions: list[ca.SX]) -> list[ca.SX]:
    """The expressions where inputs have the values with which they are declared."""
    inputs = [v for v in kinematics.graph.model.variables.values() if v.kind == "input"]
    if not inputs:
        return expressions
    values = [x or 0.0 for v in inputs for x in _declared(v)]
    found: list[ca.SX] = ca.substitute(expressions, [input_symbols(kinematics)], [ca.SX(values)])
    return found


def _declared(variable: Variable) -> list[float | None]:
    source = variable.start or variable.binding
    return [0.0] * prod(variable.shape) if source is None else numbers_of(source, variable.shape)


def default_parameters(kinematics: Kinematics) -> tuple[ca.SX, ca.DM]:
    """The symbols of all parameters, and their values when none is given."""
    if kinematics.declared is None:
        p = parameter_symbols(kinematics)
        given, mask, values = all_parameters(kinematics, p.numel())
        zeros = ca.DM.zeros(2 * p.numel())
        kinematics.declared = p, ca.evalf(ca.substitute(values, ca.vertcat(given, mask), zeros)) if p.numel() else ca.DM(0, 1)
    return kinematics.declared


def require_possible(kinematics: Kinematics) -> None:
    """Raises LagError L0605, each at its place, for parameters that are declared as no finite number or beyond their limits."""
    report, values = Report(), iter(default_parameters(kinematics)[1].elements())
    along = directions(kinematics.graph.model)
    for variable in kinematics.graph.model.variables.values():
        if variable.kind == "parameter":
            unit = f" {variable.unit}" if variable.unit else ""
            own = {name: float(next(values)) for name, _ in variable.elements()}
            for name, value in own.items():
                if wrong := misfit(value, unit, variable.minimum, variable.maximum):
                    report.error("L0605", f"the parameter '{name}' {wrong}", variable.span)
            if variable.name in along and not any(own.values()):
                report.error("L0605", _NO_LENGTH.format(variable.name), variable.span)
    report.raise_errors()
    find_odd_inertias(kinematics).raise_errors()


def find_odd_inertias(kinematics: Kinematics) -> Report:
    """Of inertias about three axes: L0605 for those that are negative or not symmetric; a warning, L0746, for those of no rigid
    body, where one is more than the other two together: measured ones often are."""
    report = Report()
    for variable, _, own in _inertias(kinematics):
        matrix = np.diag(own) if own.ndim == 1 else own
        if np.abs(matrix - matrix.T).max() > ROUNDING * np.abs(matrix).max():
            report.error("L0605", f"the inertia '{variable.name}' is not symmetric", variable.span,
                         "write {{Ixx, Ixy, Ixz}, {Ixy, Iyy, Iyz}, {Ixz, Iyz, Izz}}")
            continue
        moments, axes = principal(own)
        if moments.min() < -ROUNDING * np.abs(moments).max():
            axis = axis_words(axes[:, int(np.argmin(moments))])
            report.error("L0605", f"the inertia '{variable.name}' is negative about {axis}: {moments.min():g} kg.m2",
                         variable.span)
        elif told := told_beyond_others(variable.name, own):
            report.warning("L0746", told, variable.span)
    return report


def places_of_inertias(kinematics: Kinematics) -> list[tuple[str, int, list[int]]]:
    """Of inertias about three axes that a rigid body may have as they are declared: the name, the place of the first element
    among all parameters, the shape."""
    return [(variable.name, first, [*variable.shape]) for variable, first, own in _inertias(kinematics)
            if not told_beyond_others(variable.name, own)]


def _inertias(kinematics: Kinematics) -> Iterator[tuple[Variable, int, NDArray[np.float64]]]:
    """Of each about three axes that is finite, the place of its first element among all parameters, and its value."""
    model = kinematics.graph.model
    if not model.space.is_spatial:
        return
    values, first = default_parameters(kinematics)[1].elements(), 0
    for variable in (v for v in model.variables.values() if v.kind == "parameter"):
        count = prod(variable.shape)
        if variable.is_inertia:
            own = np.array(values[first : first + count], float).reshape(variable.shape)
            if np.isfinite(own).all():
                yield variable, first, own
        first += count


def lengths_of_directions(kinematics: Kinematics) -> Iterator[tuple[ca.SX, str, Span]]:
    """Of each direction 1 where it has a length and else 0, of all parameters; what is told then; where it is declared."""
    model = kinematics.graph.model
    for v in map(model.variables.__getitem__, directions(model)):
        size = reduce(ca.fmax, map(ca.fabs, column(*scalars_of(kinematics.symbols.values[v.name])).elements()))
        yield size > 0, _NO_LENGTH.format(v.name), v.span


def possible_inertias(kinematics: Kinematics) -> Iterator[tuple[ca.SX, str, Span]]:
    """The same of matrices of moments of inertia that are symmetric, and not negative about any axis (Sylvester). Three moments
    are not negative by the limits of their type."""
    model = kinematics.graph.model
    for v in (v for v in model.variables.values() if v.kind == "parameter" and v.is_inertia and v.shape == (3, 3)):
        _, b, c, d, _, f, g, h, _ = own = column(*scalars_of(kinematics.symbols.values[v.name])).elements()
        size = reduce(ca.fmax, map(ca.fabs, own))
        apart = reduce(ca.fmax, map(ca.fabs, (b - d, c - g, f - h)))
        yield apart <= ROUNDING * size, f"the inertia '{v.name}' is not symmetric", v.span
        yield _is_not_negative(own, size), f"the inertia '{v.name}' is negative about an axis", v.span


def usual_inertias(kinematics: Kinematics) -> Iterator[tuple[ca.SX, str, Span]]:
    """The same of no moment that is more than the other two together, of inertias that are not declared so: half of the sum about
    all axes, without the inertia, is not negative."""
    variables = kinematics.graph.model.variables
    for name, _, shape in places_of_inertias(kinematics):
        own = column(*scalars_of(kinematics.symbols.values[name])).elements()
        moments = own if shape == [3] else own[::4]
        half, size = sum(moments) / 2, reduce(ca.fmax, map(ca.fabs, own))
        rest = [half - x for x in moments]
        holds = (reduce(ca.fmin, rest) >= -ROUNDING * size if shape == [3] else
                 _is_not_negative([rest[k // 4] if k % 4 == 0 else -x for k, x in enumerate(own)], size))
        said = f"no rigid body has the inertia '{name}': one moment is more than the other two together"
        yield holds, said, variables[name].span


def _is_not_negative(own: list[ca.SX], size: ca.SX) -> ca.SX:
    """Of the rows of a symmetric matrix whose largest element has this size."""
    a, b, c, _, e, f, _, _, i = own
    minors = ([a, e, i], [a * e - b * b, a * i - c * c, e * i - f * f],
              [a * (e * i - f * f) - b * (b * i - f * c) + c * (b * f - e * c)])
    return reduce(ca.logic_and, (reduce(ca.fmin, of_size) >= -ROUNDING * size**k for k, of_size in enumerate(minors, 1)))


def usual_parameters(kinematics: Kinematics) -> tuple[ca.SX, NDArray[np.float64]]:
    """The symbols of all parameters, and values beside those that are declared; none is 0."""
    p, declared = default_parameters(kinematics)
    values = np.array(declared).ravel()
    return p, np.where(values == 0, 1.0, values) * general_numbers(1, 0.7, 1.3, values.size)


def at_declared_values(kinematics: Kinematics, expressions: list[ca.SX]) -> list[ca.SX]:
    """The expressions at the start time, the parameters as declared, inputs zero: functions of q and v alone."""
    p, values = default_parameters(kinematics)
    found: list[ca.SX] = ca.substitute(at_start(kinematics, expressions), [p], [ca.SX(values)])
    return found


def at_start(kinematics: Kinematics, expressions: list[ca.SX]) -> list[ca.SX]:
    """The expressions at the start time, inputs zero: functions of q, v and p."""
    inputs = input_symbols(kinematics).elements()
    found: list[ca.SX] = ca.substitute(kinematics.at_start(expressions), inputs, [ca.SX(0)] * len(inputs))
    return found


class _ParameterLeaves:
    """Leaves of an evaluator in which every parameter is what was given for it, or else its binding."""

    def __init__(self, model: FlatModel, kinematics: Kinematics, given: ca.SX, mask: ca.SX) -> None:
        self.model = model
        # what CasadiAlgebra.choose makes of each, of all at once
        given, is_open = ca.SX.binary(ca.OP_IF_ELSE_ZERO, mask, given), ca.SX.unary(ca.OP_NOT, mask)
        self.given, self.is_open = cells(given), cells(is_open)
        self.evaluator = Evaluator(model, kinematics.algebra, self)
        self.known: dict[str, Value] = {}
        self.pending: list[str] = []
        self.place: dict[str, int] = {}
        count = 0
        for variable in model.variables.values():
            if variable.kind == "parameter":
                self.place[variable.name] = count
                count += len(variable.elements())
        self._choose_together(given, is_open)

    def _choose_together(self, given: ca.SX, is_open: ca.SX) -> None:
        """Those that are bound to numbers, as most are, all at once; then those whose bindings are alike."""
        def choose(bound: Mapping[str, ca.SX | float]) -> None:
            if bound:
                places = [self.place[name] for name in bound]
                values = ca.SX.binary(ca.OP_IF_ELSE_ZERO, is_open[places], column(*bound.values()))
                self.known.update(zip(bound, cells(ca.SX.binary(ca.OP_ADD, given[places], values)), strict=True))

        bindings = {name: binding for name in self.place
                    if not (v := self.model.variables[name]).shape and (binding := v.binding) is not None}
        choose({name: binding.value for name, binding in bindings.items() if isinstance(binding, Number)})
        others = [name for name in bindings if name not in self.known]
        self.pending += others[:1]
        with suppress(LagError):  # what is wrong with one is told when it is its turn
            found = evaluate_alike([bindings[name] for name in others], [self.evaluator] * len(others))
            choose({others[k]: x for k, x in found.items() if not isinstance(x, tuple) and others[k] not in self.known})
        self.pending.clear()

    def symbol(self, name: str, level: int) -> Value | None:
        variable = self.model.variables[name[4:-1] if name.startswith("pre(") else name]
        if variable.kind in ("coordinate", "input", "held", "delayed"):
            self._refuse(f"the {variable.kind} '{name}'")
        return self.parameter(name, variable.span) if variable.kind == "parameter" else None

    def parameter(self, name: str, span: Span) -> Value:
        if name in self.known:
            return self.known[name]
        variable = self.model.variables[name]
        if name in self.pending:
            chain = self.pending[self.pending.index(name) :]
            fail("L0212", f"parameter '{name}' depends on itself", variable.span, " > ".join([*chain, name]))
        self.pending.append(name)
        assert variable.binding is not None
        bound = whole(self.evaluator.begun, variable, variable.binding,
                      lambda node, index: self._chosen(variable, self.evaluator.value(node), index))
        elements(bound, variable.shape, variable.binding.span)
        self.pending.pop()
        self.known[name] = bound
        return bound

    def _chosen(self, variable: Variable, value: Value, index: tuple[int, ...]) -> Value:
        """What is given for the element at an index, or else this value; sizes that do not fit are told by others."""
        if any(k > size for k, size in zip(index, variable.shape, strict=False)):
            return value
        strides = [prod(variable.shape[k + 1 :]) for k in range(len(index))]
        first = self.place[variable.name] + sum((k - 1) * stride for k, stride in zip(index, strides, strict=True))
        places = iter(range(first, first + prod(variable.shape[len(index) :])))
        return map_scalars(lambda x: self._given_or(x, next(places, first)), value)

    def _given_or(self, value: Scalar, k: int) -> Scalar:
        return apply(ca.OP_ADD, self.given[k], apply(ca.OP_IF_ELSE_ZERO, self.is_open[k], value))

    def time(self, level: int) -> Scalar:
        self._refuse("time")

    def frame(self, name: str, attribute: str, level: int) -> Value:
        self._refuse(f"the frame '{name}'")

    def _refuse(self, what: str) -> NoReturn:
        parameter = self.model.variables[self.pending[-1]]
        place = parameter.binding.span if parameter.binding is not None else parameter.span
        is_of_component = "." in parameter.name
        fail("L0604", f"the parameter '{parameter.name}' cannot depend on {what}", place,
             "what changes during the run is a variable: leave `parameter` away" +
             (", in a component of your own" if is_of_component else ""))

