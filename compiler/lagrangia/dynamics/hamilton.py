"""Motion -> Hamilton's equations, for scenes that keep their energy.

    p = dT/dv = M(q) v;   dq/dt = M(q)^-1 p,   dp/dt = dT/dq - dV/dq.

Symplectic steps are taken in (q, p); only scenes have them whose equations know neither time nor power. Where M is constant,
(q, v) serve as well, and nothing more is needed than accelerations.
"""

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.constraints.rows import Constraints, moved_in_time
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.motion import Motion, is_quadratic, solve_mass
from lagrangia.frames.kinematics import Kinematics

_MOST_COORDINATES = 300


@dataclass(frozen=True)
class Hamilton:
    """All (n,): the symbols p of the momenta; M^-1 p; dT/dq - dV/dq in terms of q and v."""

    p: ca.SX
    velocity: ca.SX
    force: ca.SX


def energy_flow(kinematics: Kinematics, constraints: Constraints, energies: Energies, motion: Motion) -> str:
    """Why the scene does not keep its energy; "" when it does."""
    supports = [edge for edge in kinematics.graph.edges if edge.moves_with_time]
    if energies.dissipation:
        term = energies.dissipation[0]
        return f"{term.component} takes energy out ({term.statement.span})"
    if energies.loads:
        work = energies.loads[0].statement
        return f"{work.component or 'a force'} puts energy in ({work.span})"
    if delays := kinematics.graph.model.delays:
        return f"something acts late ({delays[0].span})"
    if motion.impacts.places:
        model = kinematics.graph.model
        return f"{model.set_at_events} at events ({model.whens[0].span})"
    if supports:
        return f"{supports[0].child} is moved in time ({supports[0].span})"
    for name, span in moved_in_time(kinematics, constraints):
        return f"{name} is moved in time ({span})"
    spoken = ca.vertcat(motion.acceleration, motion.T, motion.V) if kinematics.is_timed else ca.SX(0, 1)
    if any(not mode.of_attitude for mode in kinematics.algebra.modes) or ca.depends_on(spoken, motion.t):
        return "time stands in its equations"
    return ""


def no_momenta(kinematics: Kinematics, constraints: Constraints, energies: Energies, motion: Motion) -> str:
    """Why a scene that keeps its energy cannot be stepped in momenta; "" when it can."""
    for name in kinematics.symbols.attitudes:
        return f"not supported yet with attitudes as coordinates ('{name}')"
    if constraints.rows:
        return f"not supported yet with constraints that stay in the equations ({constraints.rows[0].span})"
    if not is_quadratic(energies.of_mechanism(), motion.v, but_for_rest=True):
        return "not supported yet with a kinetic energy that is not quadratic in the rates"
    if motion.q.numel() > _MOST_COORDINATES:
        return f"not supported yet beyond {_MOST_COORDINATES} coordinates"
    return ""


def is_separable(motion: Motion) -> bool:
    """Whether accelerations follow from positions alone, as they do where energy is kept and M is constant."""
    return not ca.depends_on(motion.acceleration, motion.v)


def build_hamilton(kinematics: Kinematics, motion: Motion) -> Hamilton:
    """Only for scenes of which energy_flow says nothing."""
    n = motion.q.numel()
    p = ca.SX.sym("momentum", n)
    velocity = solve_mass(kinematics, motion, p)
    slope = ca.densify(ca.gradient(motion.T - motion.V, motion.q))
    return Hamilton(p, velocity, slope)
