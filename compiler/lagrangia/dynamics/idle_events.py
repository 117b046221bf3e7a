"""Impacts -> warnings of events that never come, as what they compare never changes: of a stop between two places of one body,
of a limit to a distance that a rod keeps."""

from collections.abc import Iterable

import casadi as ca
import numpy as np

from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import symbols_in
from lagrangia.algebra.with_casadi import operations_in
from lagrangia.base.diagnostics import LIBRARY, Diagnostic, Report
from lagrangia.constraints.parameters import parameter_symbols, usual_parameters
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.impacts import Impacts
from lagrangia.frames.kinematics import Kinematics

_SIZES = (1e-3, 0.03, 1.0, 1e-3, 0.03, 1.0)  # m or rad about 1: what saturates does not do so at all of them
_NOTHING = 1e-11
_SMOOTH = frozenset({ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_DIV, ca.OP_NEG, ca.OP_SQ,
                     ca.OP_SQRT, ca.OP_TWICE, ca.OP_SIN, ca.OP_COS, ca.OP_HYPOT, ca.OP_INV, ca.OP_CONSTPOW})


def find_idle_events(kinematics: Kinematics, constraints: Constraints, impacts: Impacts, told: Iterable[Diagnostic]) -> Report:
    """L0224 for events of people's own whose gap or condition is a number, but where `told` speaks of them."""
    report, known = Report(), {warning.span for warning in told}
    for k, when in enumerate(kinematics.graph.model.whens):
        if when.span in known or when.span.source.name.startswith(LIBRARY):
            continue
        gap = impacts.gaps[k] if symbols_in(impacts.gaps[k]) else impacts.conditions[k]
        if _is_constant(kinematics, constraints, gap):
            name = f"'{when.component}' does nothing" if when.component else "this event never comes"
            report.warning("L0224", f"{name}: what it compares never changes", when.span,
                           "its two ends are held to each other: give it other ends, or leave it out")
    return report


def _is_constant(kinematics: Kinematics, constraints: Constraints, value: ca.SX) -> bool:
    """Whether a scalar of q and p is the same wherever the constraints let it be: it is by all q, or its gradient is one of
    the forces that keep them, J^T lambda, also beside the constraints."""
    q = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values())
    named = symbols_in(value)
    if named.isdisjoint(symbols_in(q)) or not named <= symbols_in(ca.vertcat(q, parameter_symbols(kinematics))):
        return False
    if not operations_in(value) <= _SMOOTH:
        return False
    p, numbers = usual_parameters(kinematics)
    rows = [row.value(kinematics, 0) for row in constraints.rows if row.is_holonomic]
    J = ca.jacobian(ca.vertcat(ca.SX(0, 1), *rows), q)
    (J,) = kinematics.at_start([ca.densify(J)])
    look = ca.Function("look", [q], ca.substitute([value, ca.densify(ca.gradient(value, q)), J], [p], [ca.SX(numbers)]),
                       {"allow_free": True})
    if look.get_free():
        return False
    random = np.random.default_rng(1)
    return all(_is_kept(*(np.asarray(x) for x in look(1 + size * random.uniform(-1, 1, q.numel())))) for size in _SIZES)


def _is_kept(value: Vector, gradient: Vector, J: Vector) -> bool:
    """Whether a gradient, (n, 1), is a sum of the rows of J, (m, n)."""
    left = gradient - J.T @ np.linalg.lstsq(J.T, gradient, rcond=None)[0] if J.size else gradient
    return bool(np.isfinite(value).all() and np.abs(left).max(initial=0.0) <= _NOTHING * (1 + np.abs(value).max()))
