"""Energies -> warnings of friction in the plane whose slip can only go one way: of an arm's tip, of what runs on a rail.

What is told of the plane's friction at rest takes both components of a slip apart; where they are multiples of each other, the
run holds it to the wrong limit, or lets it creep.
"""

import casadi as ca
import numpy as np

from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import as_expression
from lagrangia.base.diagnostics import Report
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.constrained_motion import constraint_rows
from lagrangia.dynamics.dissipation import gradient_by_rates
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.switches import conditions_in
from lagrangia.frames.kinematics import Kinematics

_POINTS = 3
_SAME = 1e-9  # relative: of a direction that is no other one


def find_narrow_slips(kinematics: Kinematics, constraints: Constraints, energies: Energies) -> Report:
    """L0608 for each term of dissipation, placed there."""
    report, v = Report(), ca.vertcat(*kinematics.symbols.rates.values())
    for term in energies.dissipation:
        slope = gradient_by_rates(as_expression(term.value), v)
        found, _, cones = conditions_in([slope], v, v, Numbering())
        for pair in cones:
            if all(x in found for x in pair) and _is_narrow(ca.vertcat(*(found[x] for x in pair)), kinematics, constraints):
                name = f"of '{term.statement.component}' " if term.statement.component else ""
                report.warning("L0608", f"the slip {name}can only go one way", term.statement.span,
                               "not supported yet: a run may let it creep at rest, or slide where it holds; "
                               "take friction along that way, DryFriction or Friction")
    return report


def _is_narrow(slip: ca.SX, kinematics: Kinematics, constraints: Constraints) -> bool:
    """Whether the rates of the slip (2,) are never independent of each other, where constraints hold."""
    v = ca.vertcat(*kinematics.symbols.rates.values())
    held = constraint_rows(kinematics, constraints).rate if constraints.rows else ca.SX(0, 1)
    rows = ca.densify(ca.jacobian(ca.vertcat(slip, held), v))
    free = ca.vertcat(ca.SX(0, 1), *ca.symvar(rows))
    table = ca.Function("rows", [free], [rows])
    random = np.random.default_rng(2)
    looks = [np.array(table(random.uniform(0.5, 1.5, free.numel()))) for _ in range(_POINTS)]
    return all(np.linalg.matrix_rank(J, _SAME) - np.linalg.matrix_rank(J[2:], _SAME) < 2 for J in looks)
