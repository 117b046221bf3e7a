"""Impacts -> warnings of events that never come, as what they compare never changes: of a stop between two places of one body,
of a limit to a distance that a rod keeps."""

from collections.abc import Iterable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import symbols_in
from lagrangia.algebra.with_casadi import operations_in
from lagrangia.base.diagnostics import LIBRARY, Diagnostic, Report
from lagrangia.constraints.parameters import parameter_symbols, usual_parameters
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.collisions import Meeting
from lagrangia.dynamics.impacts import Impacts
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import When
from lagrangia.language.tree import Flat

_SIZES = (1e-3, 0.03, 1.0, 1e-3, 0.03, 1.0)  # m or rad about 1: what saturates does not do so at all of them
_NOTHING = 1e-11
_FROM_WALL = "write it from the rate w of what is met there: reinit(v, w - e*(v - w))"
_HELD_BY = {
    Meeting.IN_SOME: "what is set turns back in some of its branches, and in others it does not: each event sets what is "
                     "written, and when bounces have ended nothing keeps what is there from going on",
    Meeting.CARRIED: "what is set moves along what it is turned back from: each event sets what is written, and when bounces "
                     "have ended nothing keeps what is there from going on",
    Meeting.BACK: "these turn back, but by no impulse between them: when their bounces have ended nothing keeps them from going "
                  "on",
    Meeting.AS_DECLARED: "what is set is an impulse between those that meet for the masses as they are declared, and is taken "
                         "for one",
}
_BETTER = (
    "write it with their masses by name, so that m1*v1 + m2*v2 is the same before and after; or of the gap, which takes care of "
    "that: when gap < 0 then reinit(der(gap), -e*der(gap))",
    "to hold what rests, let each branch turn back what comes there, or write a `when` of its own for each, with what tells them "
    "apart in its condition",
)
_SMOOTH = frozenset({ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_DIV, ca.OP_NEG, ca.OP_SQ,
                     ca.OP_SQRT, ca.OP_TWICE, ca.OP_SIN, ca.OP_COS, ca.OP_HYPOT, ca.OP_INV, ca.OP_CONSTPOW})


def find_idle_events(kinematics: Kinematics, constraints: Constraints, impacts: Impacts, told: Iterable[Diagnostic]) -> Report:
    """L0224 for events of people's own whose gap or condition is a number, but where `told` speaks of them; and for those that
    would be contacts, but for an `or`, for impulses that are not between what meets, or for the rate of what is met."""
    report, known = Report(), {warning.span for warning in told}
    whens = [(k, when) for k, when in enumerate(kinematics.graph.model.whens)
             if when.span not in known and not when.span.source.name.startswith(LIBRARY)]
    gaps = [impacts.gaps[k] if symbols_in(impacts.gaps[k]) else impacts.conditions[k] for k, _ in whens]
    kept = _constant(kinematics, constraints, gaps)
    for (_, when), is_kept in zip(whens, kept, strict=True):
        if is_kept:
            name = f"'{when.component}' does nothing" if when.component else "this event never comes"
            report.warning("L0224", f"{name}: what it compares never changes", when.span,
                           "its two ends are held to each other: give it other ends, or leave it out")
    for k, when in whens:
        _tell_contacts(report, impacts, k, when)
    return report


def _tell_contacts(report: Report, impacts: Impacts, k: int, when: When) -> None:
    """What may be taken for a contact, and is none, or for some parameters alone."""
    def tell(node: Flat, text: str, hint: str) -> None:
        report.warning("L0224", text, node.span.within(when.span), hint)

    if (node := impacts.alternatives[k]) is not None:
        tell(node, f"'{node.span.text}' holds nothing here: beside `or` it is no contact, and the event comes where the whole "
             "condition comes true, not again while it stays so",
             f"give each alternative a `when` of its own: when {node.span.text} then ... end when")
    if (node := impacts.as_declared[k]) is not None:
        tell(node, f"where '{node.span.text}', what is set turns back what comes there for parameters as they are declared, not "
             "for others, and is taken for a contact", _FROM_WALL)
    if (node := impacts.as_if_still[k]) is not None:
        tell(node, f"where '{node.span.text}', this turns back as from what stands still, but that moves: it is a kick, and what "
             "comes to rest there is not kept from going on", _FROM_WALL)
    if (node := impacts.unheld[k]) is not None:
        is_beside = bool(symbols_in(impacts.gaps[k]))  # another comparison holds
        tell(node, f"where '{node.span.text}', this turns back what comes there, but is no contact in all that this may be: " + (
            "what comes from there goes on, without an event, and nothing keeps it from that" if is_beside else
            "each event sets what is written, and when bounces have ended nothing keeps what is there from going on"),
             "give each wall a `when` of its own, with its gap by itself: when gap < 0 and ... then ... end when")
    if (node := impacts.flat[k]) is not None:
        tell(node, f"where '{node.span.text}', this turns back what comes there, but what is compared has no slope at a place "
             "where it changes, as x^3 - x^5 has none at 0: when bounces have ended nothing keeps what is there where it is",
             "compare the distance itself: when gap < 0 then ... end when")
    elif (met := impacts.collisions[k]) is not None and met[1] != Meeting.BETWEEN:
        tell(met[0], f"where '{met[0].span.text}' {_HELD_BY[met[1]]}", _BETTER[met[1] == Meeting.IN_SOME])


def _constant(kinematics: Kinematics, constraints: Constraints, values: list[ca.SX]) -> list[bool]:
    """Whether scalars of q and p are the same wherever the constraints let them be: by all q, or their gradients are among the
    forces that keep them, J^T lambda, also beside the constraints. Only constraints of q and p alone keep anything: what time,
    inputs and events move carries others along."""
    q = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values())
    places, known = symbols_in(q), symbols_in(ca.vertcat(q, parameter_symbols(kinematics)))
    looked = [k for k, value in enumerate(values) if _speaks_of_places(value, places, known)]
    found = [False] * len(values)
    if not looked:
        return found
    p, numbers = usual_parameters(kinematics)
    rows = [row.value(kinematics, 0) for row in constraints.rows if row.is_holonomic and not row.is_timed]
    J = ca.jacobian(ca.vertcat(ca.SX(0, 1), *(row for row in rows if symbols_in(ca.SX(row)) <= known)), q)
    some = ca.vertcat(*(values[k] for k in looked))
    look = ca.Function("look", [q, p], [some, ca.densify(ca.jacobian(some, q)), ca.densify(J)])
    random, left = np.random.default_rng(1), np.ones(len(looked), dtype=bool)
    for size in _SIZES:
        left &= _are_kept(*(np.asarray(x) for x in look(1 + size * random.uniform(-1, 1, q.numel()), numbers)))
        if not left.any():
            break
    for k, is_kept in zip(looked, left, strict=True):
        found[k] = bool(is_kept)
    return found


def _speaks_of_places(value: ca.SX, places: frozenset[int], known: frozenset[int]) -> bool:
    """Whether a scalar is smooth, and of places and parameters alone."""
    named = symbols_in(value)
    return not named.isdisjoint(places) and named <= known and operations_in(value) <= _SMOOTH


def _are_kept(values: Vector, gradients: Vector, J: Vector) -> NDArray[np.bool_]:
    """Whether gradients, (k, n), are sums of the rows of J, (m, n)."""
    left = gradients.T - J.T @ np.linalg.lstsq(J.T, gradients.T, rcond=None)[0] if J.size else gradients.T
    is_kept: NDArray[np.bool_] = np.abs(left).max(axis=0) <= _NOTHING * (1 + np.abs(values.ravel()))
    return np.isfinite(values.ravel()) & is_kept
