"""Motion -> what impulses do at time events.

Where the rate of a support or of a prescribed coordinate jumps, forces are infinite for no time: what they change at once is
momentum, and only along what holds the scene. So dT/dv of the coordinates stays as it is, but for the impulses J^T Lambda of
constraints: M dv + J^T Lambda = p(before) - p(after), J dv = -(J v + dPhi/dt).
"""

from dataclasses import dataclass

import casadi as ca

from lagrangia.constraints import Constraints
from lagrangia.energies import evaluate_energies
from lagrangia.kinematics import Kinematics
from lagrangia.kkt import factor
from lagrangia.motion import Motion, mass_matrix, solve_mass


@dataclass(frozen=True)
class Kick:
    """`rates`: dv (n,), empty where no rate can jump; `before`: symbols of the modes of the segment that ends."""

    rates: ca.SX
    before: ca.SX


def rates_jump(kinematics: Kinematics, constraints: Constraints) -> bool:
    """Whether there are kicks, of scenes that are not compiled as a whole."""
    modes = ca.vertcat(*[mode.symbol for mode in kinematics.algebra.modes])
    if modes.numel() == 0:
        return False
    energies = evaluate_energies(kinematics)
    momentum = ca.gradient(energies.total(energies.kinetic), ca.vertcat(*kinematics.symbols.rates.values()))
    return bool(ca.depends_on(ca.vertcat(momentum, *(row.rate(kinematics) for row in constraints.rows)), modes))


def find_kick(kinematics: Kinematics, motion: Motion) -> Kick:
    modes, held = ca.vertcat(*[mode.symbol for mode in kinematics.algebra.modes]), motion.constrained
    rows = held.rows.rate if held else ca.SX(0, 1)
    before = ca.vertcat(*[ca.SX.sym(f"before_{k}") for k in range(modes.numel())])
    if not modes.numel() or not ca.depends_on(ca.vertcat(motion.momentum, rows), modes):
        return Kick(ca.SX(0, 1), before)
    gained = motion.momentum - ca.substitute(motion.momentum, modes, before)
    if held is None:
        return Kick(ca.densify(solve_mass(kinematics, motion, -gained)), before)
    rates, _ = factor(mass_matrix(motion), held.J, True).solve(-gained, -rows, refine=False)
    return Kick(ca.densify(rates), before)
