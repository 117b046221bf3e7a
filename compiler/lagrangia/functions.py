"""Motion -> CasADi Functions with named inputs and outputs.

For the run time, in the order that runtime/model.h states, with everything that depends on parameters alone computed once
(`hoist`: p -> c); for people the same equations as functions of t, q, v, u, p.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NoReturn

import casadi as ca

from lagrangia.algebra import Mode, Scalar
from lagrangia.diagnostics import Span, fail
from lagrangia.evaluation import Evaluator, Value, elements
from lagrangia.flat import FlatModel
from lagrangia.initial import InitialConditions
from lagrangia.kinematics import Kinematics
from lagrangia.motion import Motion, mass_matrix
from lagrangia.observables import observe


@dataclass(frozen=True)
class Functions:
    """The functions of runtime/model.h by name, and what the run time needs to know about them."""

    table: Mapping[str, ca.Function]
    outputs: tuple[str, ...]
    event_kinds: tuple[int, ...]
    n_power: int
    outputs_need_acceleration: bool


def build_functions(kinematics: Kinematics, motion: Motion, initial: InitialConditions, outputs: tuple[str, ...]) -> Functions:
    """`outputs` are the names to report besides coordinates and rates; see observables.py. Raises LagError L0701."""
    names, y = _outputs(kinematics, outputs)
    has_power = not (motion.dissipated_power.is_zero() and motion.source_power.is_zero())
    power = ca.vertcat(motion.dissipated_power, motion.source_power) if has_power else ca.SX(0, 1)
    energy = ca.vertcat(motion.T, motion.V, motion.H)
    expressions, c, hoisted = _hoist([motion.acceleration, power, y, energy], motion.p)
    acceleration, power, y, energy = expressions
    modes = kinematics.algebra.modes
    t, q, v, a, u = motion.t, motion.q, motion.v, motion.a, motion.u
    d = ca.vertcat(*[mode.symbol for mode in modes])
    given, mask, p = _parameters(kinematics.graph.model, kinematics, motion.p)
    multipliers = ca.SX.sym("lambda", 0)
    arguments = [t, q, v, u, d, c]
    table = {
        "parameters": ca.Function("parameters", [given, mask], [p], ["given", "mask"], ["p"]),
        "hoist": ca.Function("hoist", [motion.p], [hoisted], ["p"], ["c"]),
        "start": ca.Function("start", [motion.p], [initial.q, initial.v], ["p"], ["q", "v"]),
        "rhs": ca.Function("rhs", arguments, [acceleration, power, multipliers], ["t", "q", "v", "u", "d", "c"],
                           ["a", "power", "lambda"]),
        "outputs": ca.Function("outputs", [t, q, v, a, multipliers, u, d, c], [y],
                               ["t", "q", "v", "a", "lambda", "u", "d", "c"], ["y"]),
        "energies": ca.Function("energies", arguments, [energy], ["t", "q", "v", "u", "d", "c"], ["energies"]),
    }
    if initial.residual_spans:
        table["initial"] = _initial_function(motion, initial)
    if modes:
        table |= _mode_functions(motion, modes)
    return Functions(table, names, tuple(mode.kind for mode in modes), power.numel(), ca.depends_on(y, a) if y.numel() else False)


def people_functions(kinematics: Kinematics, motion: Motion, outputs: tuple[str, ...]) -> dict[str, ca.Function]:
    """M, h, rhs, energies, outputs and jacobian as functions of t, q, v, u, p, in SI units.

    M(q, p) (n, n): M dv/dt + h = 0;  rhs: dv/dt (n,);  energies: T, V, D;  jacobian: d(dv/dt)/d(q, v) (n, 2 n).
    """
    t, q, v, u, p = motion.t, motion.q, motion.v, motion.u, motion.p
    _names, y = _outputs(kinematics, outputs)
    y = ca.substitute(y, motion.a, motion.acceleration) if y.numel() else y
    expressions = {
        "M": [mass_matrix(motion)], "h": [motion.h], "rhs": [motion.acceleration], "energies": [motion.T, motion.V, motion.D],
        "outputs": [y], "jacobian": [ca.jacobian(motion.acceleration, ca.vertcat(q, v))],
    }
    labels = {"energies": ["T", "V", "D"], "outputs": ["y"], "rhs": ["a"]}
    modes = kinematics.algebra.modes
    symbols, values = [mode.symbol for mode in modes], [mode.value for mode in modes]
    return {
        name: ca.Function(name, [t, q, v, u, p], ca.substitute(results, symbols, values) if modes else results,
                          ["t", "q", "v", "u", "p"], labels.get(name, [name]))
        for name, results in expressions.items()
    }


def observer(kinematics: Kinematics, motion: Motion, names: tuple[str, ...]) -> tuple[tuple[str, ...], ca.Function]:
    """Any quantities as a function of t, q, v, a, u, p; vectors give one row an element."""
    labels, y = _outputs(kinematics, names)
    modes = kinematics.algebra.modes
    if modes and y.numel():
        y = ca.substitute(y, ca.vertcat(*[m.symbol for m in modes]), ca.vertcat(*[m.value for m in modes]))
    return labels, ca.Function("observe", [motion.t, motion.q, motion.v, motion.a, motion.u, motion.p], [y])


def _outputs(kinematics: Kinematics, names: tuple[str, ...]) -> tuple[tuple[str, ...], ca.SX]:
    labels: list[str] = []
    values: list[Scalar] = []
    for name in names:
        value = kinematics.evaluator.value(observe(kinematics.graph.model, name))
        for label, scalar in _scalars(name, value):
            labels.append(label)
            values.append(scalar)
    y = ca.densify(ca.vertcat(*values)) if values else ca.SX(0, 1)
    tau = kinematics.symbols.tau
    return tuple(labels), ca.substitute(y, tau, ca.SX(1)) if values else y


def _scalars(name: str, value: Value) -> list[tuple[str, Scalar]]:
    if not isinstance(value, tuple):
        return [(name, value)]
    return [pair for k, item in enumerate(value, 1) for pair in _scalars(f"{name}[{k}]", item)]


def _hoist(expressions: list[ca.SX], p: ca.SX) -> tuple[list[ca.SX], ca.SX, ca.SX]:
    """The expressions in terms of c, and c as a function of p. Common subexpressions are shared first."""
    shared = ca.cse([ca.densify(e) for e in expressions])
    if p.numel() == 0:
        return shared, ca.SX(0, 1), ca.SX(0, 1)
    sizes = [e.numel() for e in shared]
    reduced, symbols, values = ca.extract_parametric(ca.vertcat(*shared), p, {"extract_trivial": True})
    pieces, start = [], 0
    for size in sizes:
        pieces.append(reduced[start : start + size])
        start += size
    return pieces, ca.vertcat(*symbols), ca.vertcat(*values)


def _initial_function(motion: Motion, initial: InitialConditions) -> ca.Function:
    q, v, p = motion.q, motion.v, motion.p
    jacobian = ca.densify(ca.jacobian(initial.residuals, ca.vertcat(q, v)))
    return ca.Function("initial", [q, v, p], [initial.residuals, ca.vec(jacobian)], ["q", "v", "p"], ["g", "J"])


def _mode_functions(motion: Motion, modes: list[Mode]) -> dict[str, ca.Function]:
    """Modes at a time, and the arguments a + b t whose crossings are events."""
    t, p = motion.t, motion.p
    slopes = [ca.jacobian(mode.argument, t) for mode in modes]
    offsets = [ca.substitute(mode.argument, t, ca.SX(0)) for mode in modes]
    return {
        "events": ca.Function("events", [p], [ca.vertcat(*offsets), ca.densify(ca.vertcat(*slopes))], ["p"], ["a", "b"]),
        "modes": ca.Function("modes", [t, p], [ca.vertcat(*[mode.value for mode in modes])], ["t", "p"], ["d"]),
    }


def _parameters(model: FlatModel, kinematics: Kinematics, p: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """All parameters from those given: one that is not given follows from its binding."""
    n = p.numel()
    given, mask = ca.SX.sym("given", n), ca.SX.sym("mask", n)
    if n == 0:
        return given, mask, ca.SX(0, 1)
    leaves = _ParameterLeaves(model, kinematics, given, mask)
    parameters = [v for v in model.variables.values() if v.kind == "parameter"]
    values = [x for v in parameters for _, x in _scalars(v.name, leaves.parameter(v.name, v.span))]
    return given, mask, ca.cse(ca.vertcat(*values))


class _ParameterLeaves:
    """Leaves of an evaluator in which every parameter is what was given for it, or else its binding."""

    def __init__(self, model: FlatModel, kinematics: Kinematics, given: ca.SX, mask: ca.SX) -> None:
        self.model, self.given, self.mask = model, given, mask
        self.evaluator = Evaluator(model, kinematics.algebra, self)
        self.known: dict[str, Value] = {}
        self.pending: list[str] = []
        self.place: dict[str, int] = {}
        count = 0
        for variable in model.variables.values():
            if variable.kind == "parameter":
                self.place[variable.name] = count
                count += len(variable.elements())

    def symbol(self, name: str, level: int) -> Value | None:
        variable = self.model.variables[name]
        if variable.kind in ("coordinate", "input"):
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
        bound = self.evaluator.value(variable.binding)
        values = elements(bound, variable.shape, variable.binding.span)
        self.pending.pop()
        start = self.place[name]
        chosen = [ca.if_else(self.mask[start + k], self.given[start + k], x) for k, x in enumerate(values)]
        self.known[name] = _nest(iter(chosen), variable.shape)
        return self.known[name]

    def time(self, level: int) -> Scalar:
        self._refuse("time")

    def frame(self, name: str, attribute: str, level: int) -> Value:
        self._refuse(f"the frame '{name}'")

    def _refuse(self, what: str) -> NoReturn:
        parameter = self.model.variables[self.pending[-1]]
        place = parameter.binding.span if parameter.binding is not None else parameter.span
        fail("L0604", f"the parameter '{parameter.name}' cannot depend on {what}", place,
             "what changes during the run is a variable: leave `parameter` away")


def _nest(values: Iterator[Scalar], shape: tuple[int, ...]) -> Value:
    if not shape:
        return next(values)
    return tuple(_nest(values, shape[1:]) for _ in range(shape[0]))
