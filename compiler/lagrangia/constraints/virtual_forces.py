"""Equations whose force acts elsewhere than where they hold: refused, for no motion of such a scene follows from energies alone.

An equation phi(q, t) = 0 with terms virtual(x) has the force G^T lambda, G = dphi/dq + V with the slopes V of these terms. Along
all motions that the constraints allow, q' = S w, Lagrange's equations are those of an ideal force as long as V S = 0, as of a
gear, whose axles one carrier holds. Else its force does work, or holds something else. What people write themselves may hold at
the start alone, or with the parameters as declared (k*virtual(x), k = 0): it is looked at beside both too.
"""

from collections.abc import Iterable, Iterator

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector, general_numbers
from lagrangia.base.diagnostics import LIBRARY, Report
from lagrangia.constraints.assembly import begin
from lagrangia.constraints.initial import InitialConditions, initial_function, start_function
from lagrangia.constraints.parameters import (
    at_declared_values,
    default_parameters,
    input_symbols,
    parameters_of,
    usual_parameters,
)
from lagrangia.constraints.rows import Constraints, Row
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import Equation
from lagrangia.language.mentions import reached
from lagrangia.language.tree import Call, Flat

_NOTHING = 1e-8
_LOOKS = 12  # steps of Newton's method, from beside the start


def refuse_forces_elsewhere(kinematics: Kinematics, constraints: Constraints, initial: InitialConditions) -> None:
    """Raises LagError L0917."""
    rows = _rows_with_virtual_terms(kinematics, constraints)
    if not rows:
        return
    report, V, J = Report(), _virtual_slopes(kinematics, rows), _slopes(kinematics, constraints)
    q, at = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values()), _place(kinematics, constraints, initial)
    V, J = _numbers(kinematics, [V, J], q, at)
    V = V - V @ np.linalg.pinv(J, rcond=1e-9) @ J if J.size else V  # what motions that the constraints allow are left with
    powerless, later = _powerless(kinematics, constraints, q, at), _elsewhere_later(kinematics, constraints, rows, at)
    for k, row in enumerate(rows):
        if np.abs(V[k]).max(initial=0.0) > _NOTHING or id(row) in later:
            report.error("L0917", "not supported yet: the force of this equation acts on what it does not hold", row.span,
                         "such a force is not the one by which constraints do no work: virtual(x) may only tell which bearings "
                         "share the force, as in Gear: of what the equation holds, or of what cannot move",
                         "let a force act instead: AppliedForce, ForcePair, or work ... on ...;")
        elif not row.is_holonomic and _says_virtual(kinematics, row):
            report.error("L0917", "not supported yet: virtual(x) in an equation between rates", row.span,
                         "it is a displacement, and an equation between rates displaces nothing: its force acts on what it holds",
                         "write it between positions or angles, where it is one, or leave virtual(x) out and let another force "
                         "act: AppliedForce, ForcePair, or work ... on ...;")
        elif id(row) in powerless:
            report.error("L0917", "the force of this equation acts on nothing that could make it hold", row.span,
                         "virtual(x) takes away as much as the equation says of x", "leave it out, so that the force acts on "
                         "what the equation holds")
    report.raise_errors()


def find_idle_displacements(kinematics: Kinematics, constraints: Constraints) -> Report:
    """L0224 for equations of people's own with virtual(x) of what nothing displaces, or that cancel."""
    report, told = Report(), set[int]()
    for row in constraints.all_rows:
        if row.equation is None or not row.is_holonomic or id(row.equation) in told:
            continue
        if any(not node.span.source.name.startswith(LIBRARY) for node in _virtuals(kinematics, [row.equation])):
            parts = [part for part in constraints.all_rows if part.equation is row.equation]
            told.add(id(row.equation))
            if _has_idle_displacement(kinematics, parts):
                report.warning("L0224", "virtual(x) is 0 here, and changes nothing", row.span,
                               "what it says cancels, or is of what nothing displaces: leave it out")
    return report


def _has_idle_displacement(kinematics: Kinematics, rows: list[Row]) -> bool:
    """Whether the rows, of one equation, take away again what they say of some virtual(x), or say nothing of all."""
    shift = kinematics.algebra.index.displacements.new(len(kinematics.dependents))
    varied = kinematics.displaced({name: (shift[k], 0.0) for k, name in enumerate(kinematics.dependents)})
    q = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values())
    said = dict[int, tuple[ca.SX, ca.SX]]()  # by hashes of x: the displacement, and x
    varied.evaluator.virtual = lambda x: said.setdefault(ca.SX(x).__hash__(), (ca.SX.sym("displacement"), ca.SX(x)))[0]
    values = ca.vertcat(*[row.value(varied, 0) for row in rows])
    unknowns = ca.vertcat(q, shift)
    slopes = [ca.jacobian(x, unknowns) for _, x in said.values()]
    shares = [ca.jacobian(ca.SX(values), given) @ slope for (given, _), slope in zip(said.values(), slopes, strict=True)]
    symbols = [*(given for given, _ in said.values()), shift]
    shares = ca.substitute(shares, symbols, [*[ca.SX(0)] * len(said), ca.SX.zeros(shift.numel())])
    at = np.random.default_rng(1).uniform(0.3, 1.7, q.numel())
    p, some = usual_parameters(kinematics)  # what is 0 as declared may be given another value
    shares = [ca.horzcat(*[_in_modes(kinematics, [share], modes)[0] for modes in (None, 0.0, 1.0)]) for share in shares]
    idle = [np.abs(share).max(initial=0.0) <= _NOTHING for share in
            _numbers(kinematics, ca.substitute(shares, [p], [ca.SX(some)]), q, at)]
    return all(idle) or any(none and slope.nnz() for none, slope in zip(idle, slopes, strict=True))


def _elsewhere_later(kinematics: Kinematics, constraints: Constraints, rows: list[Row], at: Vector) -> set[int]:
    """The rows of people's own, by their ids, whose force acts elsewhere beside the place `at`, (n,), later, or by other p.

    Factors of virtual(x) alone take other parameters first: geometry that is as declared may be what makes them right.
    """
    own = [row for row in rows if row.equation is not None and any(
        not node.span.source.name.startswith(LIBRARY) for node in _virtuals(kinematics, [row.equation]))]
    if not own:
        return set()
    look = _Look(kinematics, constraints, own)
    p, other = default_parameters(kinematics)[1].full().ravel(), look.other_parameters()
    beside = look.beside(at, p)
    wrong = look.misses(at if beside is None else beside, p, other)
    if wrong.any() and (moved := look.beside(at, other)) is not None:
        wrong &= look.misses(moved, other, other)
    return {id(row) for row, is_wrong in zip(own, wrong, strict=True) if is_wrong}


class _Look:
    """The slopes of virtual terms and constraints at other places, times, inputs and parameters than at the start."""

    def __init__(self, kinematics: Kinematics, constraints: Constraints, rows: list[Row]) -> None:
        self.kinematics, (self.p, _) = kinematics, default_parameters(kinematics)
        q = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values())
        rates = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.rates.values())
        gaps = ca.vertcat(ca.SX(0, 1), *[row.value(kinematics, 0) for row in constraints.rows if row.is_holonomic])
        factors, slopes = _factors_and_slopes(kinematics, rows, q)
        factors = ca.horzcat(*[_in_modes(kinematics, [factors], modes)[0] for modes in (None, 0.0, 1.0)])
        found = [factors, *_in_modes(kinematics, [slopes, _slopes(kinematics, constraints), gaps, ca.jacobian(gaps, q)], None)]
        found = [ca.densify(x) for x in ca.substitute(found, [kinematics.symbols.tau, rates],
                                                      [ca.SX(1), ca.SX.zeros(rates.numel())])]
        given = ca.vertcat(kinematics.symbols.time, input_symbols(kinematics))
        self.values = ca.Function("values", [q, given, self.p], found)
        experiment, others = kinematics.graph.model.experiment, general_numbers(3, 0.3, 0.7, given.numel())
        self.given = np.array([experiment.start + others[0] * (experiment.stop - experiment.start), *others[1:]])

    def other_parameters(self) -> Vector:
        """(n_p,): none is 0, and those that are bound to others follow them."""
        bound = parameters_of(self.kinematics, self.p)
        return np.asarray(ca.Function("bound", [self.p], [bound])(usual_parameters(self.kinematics)[1]).full()).ravel()

    def beside(self, at: Vector, p: Vector) -> Vector | None:
        """A place some way along the motions that the constraints allow, by Newton's method; None where it finds none."""
        q = at + general_numbers(2, 0.1, 0.3, at.size)
        for _ in range(_LOOKS):
            gaps, slopes = (x.full() for x in self.values(q, self.given, p)[3:])
            if not (np.isfinite(gaps).all() and np.isfinite(slopes).all()):
                return None
            if np.abs(gaps).max(initial=0.0) <= _NOTHING**2:
                return q
            q = q - np.linalg.pinv(slopes, rcond=1e-9) @ gaps.ravel()
        return q if np.abs(gaps).max(initial=0.0) <= _NOTHING else None

    def misses(self, q: Vector, p: Vector, other: Vector) -> NDArray[np.bool_]:
        """(rows,): whether the force acts on what constraints do not hold, where the factors know the `other` parameters."""
        slopes, J = (x.full() for x in self.values(q, self.given, p)[1:3])
        V = np.array([x @ slopes for x in np.hsplit(self.values(q, self.given, other)[0].full(), 3)])
        V = V - V @ np.linalg.pinv(J, rcond=1e-9) @ J if J.size else V
        return np.asarray(np.abs(V).max(axis=(0, 2), initial=0.0) > _NOTHING)


def _in_modes(kinematics: Kinematics, expressions: list[ca.SX], value: float | None) -> list[ca.SX]:
    """The expressions where conditions in time are as time says, or all of this value."""
    modes = kinematics.algebra.modes
    values = [mode.value if value is None else ca.SX(value) for mode in modes]
    found: list[ca.SX] = ca.substitute(expressions, [mode.symbol for mode in modes], values) if modes else expressions
    return found


def _factors_and_slopes(kinematics: Kinematics, rows: list[Row], q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Of all virtual(x) in the rows: what multiplies their displacements, (rows, k), and the slopes dx/dq of these, (k, n)."""
    varied = Kinematics(kinematics.graph, kinematics.symbols, kinematics.algebra, kinematics.dependents)
    said = dict[int, tuple[ca.SX, ca.SX]]()  # by hashes of x: the displacement, and x
    varied.evaluator.virtual = lambda x: said.setdefault(ca.SX(x).__hash__(), (ca.SX.sym("displacement"), ca.SX(x)))[0]
    values = ca.vertcat(*[row.value(varied, 0) if row.is_holonomic else 0 for row in rows])
    displacements = ca.vertcat(ca.SX(0, 1), *[displacement for displacement, _ in said.values()])
    factors = ca.substitute(ca.jacobian(ca.SX(values), displacements), displacements, ca.SX.zeros(displacements.numel()))
    return factors, ca.jacobian(ca.vertcat(ca.SX(0, 1), *[x for _, x in said.values()]), q)


def _rows_with_virtual_terms(kinematics: Kinematics, constraints: Constraints) -> list[Row]:
    if not _mentions_virtual(kinematics, kinematics.graph.model.constraints):
        return []
    return [row for row in constraints.all_rows if row.loop is None]


def _says_virtual(kinematics: Kinematics, row: Row) -> bool:
    return row.equation is not None and _mentions_virtual(kinematics, [row.equation])


def _mentions_virtual(kinematics: Kinematics, equations: Iterable[Equation]) -> bool:
    return next(_virtuals(kinematics, equations), None) is not None


def _virtuals(kinematics: Kinematics, equations: Iterable[Equation]) -> Iterator[Flat]:
    """Where the equations, or the variables that they name, say virtual(x)."""
    sides = [side for equation in equations for side in (equation.left, equation.right)]
    bindings = {name: v.binding for name, v in kinematics.graph.model.variables.items()}
    return (node for node in reached(sides, bindings) if isinstance(node, Call) and node.function == "virtual")


def _varied(kinematics: Kinematics, q: ca.SX, here: ca.SX) -> Kinematics:
    """The kinematics in which virtual(x) is what x differs by from the place `here`."""
    found = Kinematics(kinematics.graph, kinematics.symbols, kinematics.algebra, kinematics.dependents)
    found.evaluator.virtual = lambda x: x - ca.substitute([ca.SX(x)], [q], [here])[0]
    return found


def _virtual_slopes(kinematics: Kinematics, rows: list[Row]) -> ca.SX:
    """V, (rows, n)."""
    q = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values())
    here = ca.SX.sym("here", q.numel())
    varied = _varied(kinematics, q, here)
    terms = ca.vertcat(*[row.value(varied, 0) - row.value(kinematics, 0) if row.is_holonomic else 0 for row in rows])
    return ca.substitute(ca.jacobian(ca.SX(terms), q), here, q)


def _slopes(kinematics: Kinematics, constraints: Constraints) -> ca.SX:
    rates = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.rates.values())
    kept = ca.vertcat(ca.SX(0, 1), *[row.rate(kinematics) for row in constraints.rows])
    return ca.jacobian(kept, rates)


def _powerless(kinematics: Kinematics, constraints: Constraints, q: ca.SX, at: Vector) -> set[int]:
    """The rows that gave a coordinate, by their ids, whose force acts on none that was given up."""
    shift, rate = (kinematics.algebra.index.displacements.new(len(kinematics.dependents)) for _ in range(2))
    free = kinematics.displaced({name: (shift[k], rate[k]) for k, name in enumerate(kinematics.dependents)})
    rows = ca.vertcat(ca.SX(0, 1), *[row.value(free, 0) for row in constraints.absorbed])
    slopes = ca.substitute([ca.jacobian(rows, shift)], [shift, rate], [ca.SX.zeros(shift.numel())] * 2)[0]
    (numbers,) = _numbers(kinematics, [slopes], q, at)
    sizes = np.abs(numbers).max(axis=1, initial=0.0)
    return {id(row) for row, size in zip(constraints.absorbed, sizes, strict=True) if size <= _NOTHING}


def _place(kinematics: Kinematics, constraints: Constraints, initial: InitialConditions) -> Vector:
    """The start, where constraints are left, else any place."""
    n = len(kinematics.symbols.positions)
    if not constraints.rows:
        return np.random.default_rng(1).uniform(0.3, 1.7, n)
    table = {"initial": initial_function(kinematics, initial), "start": start_function(kinematics, initial)}
    return np.asarray(begin(kinematics, initial, table).assemble()[0][:n])


def _numbers(kinematics: Kinematics, expressions: list[ca.SX], q: ca.SX, at: Vector) -> list[Vector]:
    """At this place and the start time, parameters as declared, rates zero."""
    rates = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.rates.values())
    found = at_declared_values(kinematics, [ca.densify(x) for x in expressions])
    found = ca.substitute(found, [q, rates], [ca.SX(at), ca.SX.zeros(rates.numel())])
    return [np.asarray(ca.evalf(x).full()) for x in found]
