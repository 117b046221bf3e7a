"""Kinematics -> T, V, D and the virtual work, term by term as the components state them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

import casadi as ca

from lagrangia.algebra.duals import Scalar, rate_of
from lagrangia.algebra.scalars import as_expression, column, symbols_in
from lagrangia.base.diagnostics import LagError, Report
from lagrangia.base.records import dataclass
from lagrangia.frames.alike import evaluate_all
from lagrangia.frames.evaluation import Value
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import Energy, Work
from lagrangia.language.tree import Flat, FrameRef


@dataclass(frozen=True)
class Term:
    """One energy term with its statement in the source."""

    value: Scalar
    statement: Energy

    @property
    def component(self) -> str:
        """The component that states it."""
        return self.statement.component


@dataclass(frozen=True)
class Load:
    """A force and the position it works on, both as lists of scalars of equal length; a torque on an attitude works on what has
    no position: there stands the angular velocity, if it `is_by_rate`."""

    force: tuple[Scalar, ...]
    position: tuple[Scalar, ...]
    statement: Work
    is_by_rate: bool = False
    pace: tuple[Scalar, ...] | None = None  # of the position, where attitudes are coordinates: their rates are no derivatives

    @property
    def moving(self) -> tuple[tuple[Scalar, ...], bool]:
        """What it works on, and whether that is a rate."""
        return (self.position, self.is_by_rate) if self.pace is None else (self.pace, True)

    @property
    def moved(self) -> Flat:
        """What the position is read off."""
        return _moved(self.statement)


@dataclass(frozen=True)
class Energies:
    """All terms of a scene, by kind, and its loads."""

    kinetic: tuple[Term, ...]
    potential: tuple[Term, ...]
    dissipation: tuple[Term, ...]
    loads: tuple[Load, ...]

    def of_mechanism(self) -> "Energies":
        """Without first-order states."""
        if not (any(t.statement.is_signal for t in self.kinetic) or any(load.statement.is_signal for load in self.loads)):
            return self
        return replace(self, kinetic=tuple(t for t in self.kinetic if not t.statement.is_signal),
                       loads=tuple(load for load in self.loads if not load.statement.is_signal))

    def total(self, terms: tuple[Term, ...]) -> ca.SX:
        """Sum by halves, which keeps the tree of additions shallow; all terms of a kind are summed once."""
        if not any(terms is own for own in (self.kinetic, self.potential, self.dissipation)):
            return _balanced_sum([as_expression(t.value) for t in terms])
        if id(terms) not in self._totals:
            self._totals[id(terms)] = _balanced_sum([as_expression(t.value) for t in terms])
        return self._totals[id(terms)]

    @cached_property
    def _totals(self) -> dict[int, ca.SX]:
        return {}

    @cached_property
    def moving(self) -> frozenset[int]:
        """The hashes of the symbols that kinetic energies mention."""
        return symbols_in(self.total(self.kinetic))


def generalised_force(loads: Sequence[Load], q: ca.SX, v: ca.SX) -> ca.SX:
    """sum_i (dr_i/dq)^T F_i, in one reverse sweep, and of torques on attitudes sum_i (dw_i/dv)^T M_i in another."""
    by_place, by_rate = ([load for load in loads if load.moving[1] is is_by_rate] for is_by_rate in (False, True))
    found = [_along(chosen, moving) for chosen, moving in ((by_place, q), (by_rate, v)) if chosen]
    return sum(found[1:], found[0]) if found else ca.SX.zeros(q.numel())


def _along(loads: Sequence[Load], moving: ca.SX) -> ca.SX:
    places, forces = (ca.vertcat(*[x for part in parts for x in part])
                      for parts in ([load.moving[0] for load in loads], [load.force for load in loads]))
    return ca.densify(ca.jtimes(places, moving, forces, True))


def build_energies(kinematics: Kinematics) -> Energies:
    """Raises LagError (L05xx) for a term that is no scalar or depends on accelerations or on an input where it must not."""
    energies, report = evaluate_energies(kinematics), Report()
    _check_dependence(energies, kinematics, report)
    report.in_order().raise_errors()
    return energies


def evaluate_energies(kinematics: Kinematics) -> Energies:
    """The terms in the algebra of the kinematics, unchecked but for their sizes. Raises LagError L0303."""
    report = Report()
    model = kinematics.graph.model
    terms: dict[str, list[Term]] = {"kinetic": [], "potential": [], "dissipation": []}
    values = evaluate_all([energy.value for energy in model.energies], [kinematics.evaluator] * len(model.energies))
    for energy, value in zip(model.energies, values, strict=True):
        _check_scalar(value, energy, report)
        terms[energy.kind].append(Term(value, energy))
    loads = [paced(_load(work, kinematics.evaluator.value, report), kinematics) for work in model.works]
    report.in_order().raise_errors()
    return Energies(tuple(terms["kinetic"]), tuple(terms["potential"]), tuple(terms["dissipation"]), tuple(loads))


def _moved(work: Work) -> Flat:
    """Of an attitude, the angular velocity."""
    is_by_rate = isinstance(work.position, FrameRef) and work.position.attribute == "attitude"
    return replace(work.position, attribute="w") if isinstance(work.position, FrameRef) and is_by_rate else work.position


def _load(work: Work, value: Callable[..., Value], report: Report) -> Load:
    is_by_rate = _moved(work) is not work.position
    try:
        force, position = value(work.force), value(_moved(work))
    except LagError as error:
        raise error.placed(work.span) from None
    force_size, position_size = ([isinstance(x, tuple) for x in v] if isinstance(v, tuple) else None for v in (force, position))
    if force_size != position_size or any(force_size or ()):  # of matrices none works
        report.error_in(work.span, work.position.span, "L0303", "a force works on a position of the same size",
                        "a vector on a point (at.r), a number on a length or an angle" if not is_by_rate else
                        "a torque on an attitude has three components, in the world's axes")
        return Load((), (), work)
    if isinstance(force, tuple):
        return Load(force, position, work, is_by_rate)
    return Load((force,), (position,), work)


def paced(load: Load, kinematics: Kinematics) -> Load:
    """A load on a position with its pace, where it needs one."""
    if load.is_by_rate or not kinematics.symbols.attitudes:
        return load
    moved = kinematics.evaluator.value(load.statement.position, 1)
    return replace(load, pace=tuple(map(rate_of, moved if isinstance(moved, tuple) else (moved,))))


def rate_of_potential(kinematics: Kinematics, terms: Sequence[Term]) -> ca.SX:
    """dV/dt, linear in the rates."""
    return _balanced_sum([as_expression(rate_of(kinematics.evaluator.value(term.statement.value, 1))) for term in terms])


def _check_scalar(value: Value, energy: Energy, report: Report) -> None:
    if isinstance(value, tuple):
        report.error_in(energy.span, energy.value.span, "L0303",
                        f"a {energy.kind} energy is one number, this is an array of {len(value)}", "dot(v, v) squares a vector")


def _check_dependence(energies: Energies, kinematics: Kinematics, report: Report) -> None:
    """V may depend on positions, T and D on velocities, nothing on accelerations."""
    symbols = kinematics.symbols
    accelerations = column(*(symbols.accelerations.values() if "accelerations" in symbols.asked else ()))
    rates = column(*symbols.rates.values())
    groups = {"kinetic": energies.kinetic, "potential": energies.potential, "dissipation": energies.dissipation}
    for kind, terms in groups.items():
        whole = energies.total(terms)
        checks = [(accelerations, "L0501", f"a {kind} energy cannot depend on accelerations", "")]
        if kind == "potential":
            checks.append((rates, "L0502", "a potential cannot depend on velocities", "what resists motion is a dissipation"))
        for wrong, code, message, hint in checks:
            if wrong.numel() and ca.depends_on(whole, wrong):
                for term in terms:
                    if ca.depends_on(ca.SX(term.value), wrong):
                        report.error_in(term.statement.span, term.statement.value.span, code, message, *filter(None, [hint]))
    for load in energies.loads:
        if accelerations.numel() and ca.depends_on(ca.vertcat(*load.force, 0), accelerations):
            report.error_in(load.statement.span, load.statement.force.span, "L0501", "a force cannot depend on accelerations")
        if rates.numel() and not load.is_by_rate and ca.depends_on(ca.vertcat(*load.position, 0), rates):
            report.error_in(load.statement.span, load.statement.position.span, "L0502",
                            "a force works on a position, this depends on velocities")


def _balanced_sum(values: list[ca.SX]) -> ca.SX:
    """Of neighbours, of these sums, and so on, by columns."""
    found = column(*values) if values else ca.SX(0)
    while (count := found.numel()) > 1:
        even = count // 2 * 2
        found = ca.vertcat(found[0:even:2] + found[1:even:2], found[even:])
    return as_expression(found)
