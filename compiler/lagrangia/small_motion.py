"""Lagrange's equations with excitations, and their exact derivatives: what equilibria and small motion are computed from.

    R = d/dt(dT/dv) - dT/dq + dV/dq + dD/dv - f + J^T lambda = 0,   Phi(q, t, s) = 0

with excitations s(t) (probes.py). Time may stand still (pace 0): supports then rest where they are at that time. Where nothing
but loads depends on time it goes on (pace 1): a frame that turns steadily keeps turning, and equilibria are relative to it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from lagrangia.diagnostics import fail
from lagrangia.energies import evaluate_energies
from lagrangia.observables import observe
from lagrangia.parameters import scalars
from lagrangia.probes import Probe, ProbedKinematics, Triple, probe_kinematics
from lagrangia.reactions import build_reactions

if TYPE_CHECKING:
    from lagrangia.constraints import Constraints
    from lagrangia.kinematics import Kinematics
    from lagrangia.motion import Motion


@dataclass(frozen=True)
class SmallMotion:
    """Functions of q, v, a, lambda and of t, pace, u, p; n coordinates, m rows (m_h holonomic first), k excitations, y outputs.

    static:   R (n,), Phi (m_h,), rates of all rows (m,), V
    tangent:  M = dR/da, C = dR/dv, K = dR/dq (n, n), dPhi/dq (m_h, n), d rate/dv (m, n),
              dR/ds, dR/ds', dR/ds'' (n, k), dPhi/ds (m_h, k)
    observed: y, and its derivatives by q, v, a, lambda, s, s', s''
    unsteady: R without loads, Phi and rates: what tells whether time matters
    """

    n: int
    m: int
    probes: tuple[Probe, ...]
    outputs: tuple[str, ...]
    static: ca.Function
    tangent: ca.Function
    observed: ca.Function
    unsteady: ca.Function


def build_small_motion(kinematics: "Kinematics", constraints: "Constraints", motion: "Motion", probes: Sequence[Probe] = (),
                       outputs: Sequence[str] = ()) -> SmallMotion:
    """Raises LagError L0701 for unknown outputs, L0916 for what is not supported yet."""
    k = len(probes)
    s = (ca.SX.sym("s", k), ca.SX.sym("ds", k), ca.SX.sym("dds", k))
    free = probe_kinematics(kinematics, constraints, probes, s)
    parts = _Parts(free, constraints, motion, s)
    names, y = parts.outputs(outputs)
    tau, quiet = kinematics.symbols.tau, ca.vertcat(*s)
    arguments = [motion.q, motion.v, motion.a, parts.lam, motion.t, tau, motion.u, motion.p]
    labels = ["q", "v", "a", "lambda", "t", "pace", "u", "p"]
    modes = kinematics.algebra.modes

    def function(name: str, values: list[ca.SX]) -> ca.Function:
        values = [ca.densify(ca.SX(x)) for x in values]
        if modes:
            values = ca.substitute(values, [m.symbol for m in modes], [m.value for m in modes])
        if k:
            values = ca.substitute(values, [quiet], [ca.SX.zeros(3 * k)])
        return ca.Function(name, arguments, ca.cse(values), labels, [f"x{i}" for i in range(len(values))])

    R, q, v, a = parts.R, motion.q, motion.v, motion.a
    tangent = [ca.jacobian(R, a), ca.jacobian(R, v), ca.jacobian(R, q), ca.jacobian(parts.phi, q), ca.jacobian(parts.rate, v),
               *(ca.jacobian(R, x) for x in s), ca.jacobian(parts.phi, s[0])]
    observed = [y, *(ca.jacobian(y, x) for x in (q, v, a, parts.lam, *s))]
    return SmallMotion(q.numel(), parts.rate.numel(), tuple(probes), names,
                       function("static", [R, parts.phi, parts.rate, parts.V]), function("tangent", tangent),
                       function("observed", observed), function("unsteady", [parts.unloaded, parts.phi, parts.rate]))


class _Parts:
    """The equations in SX."""

    def __init__(self, free: ProbedKinematics, constraints: "Constraints", motion: "Motion", s: Triple) -> None:
        self.free, self.constraints, self.motion, self.s = free, constraints, motion, s
        energies = evaluate_energies(free)
        self.T, self.V, self.D = (energies.total(x) for x in (energies.kinetic, energies.potential, energies.dissipation))
        q, v, t, tau = motion.q, motion.v, motion.t, free.symbols.tau
        momentum = ca.densify(ca.gradient(self.T, v))
        inertia = ca.jtimes(momentum, ca.vertcat(q, v, t, s[0], s[1]), ca.vertcat(v, motion.a, tau, s[1], s[2]))
        rows = constraints.rows
        self.phi = ca.vertcat(ca.SX(0, 1), *[ca.SX(row.value(free, 0)) for row in rows if row.is_holonomic])
        self.rate = ca.vertcat(ca.SX(0, 1), *[ca.SX(row.rate(free)) for row in rows])
        self.lam = motion.constrained.symbols if motion.constrained else ca.SX(0, 1)
        held = ca.jtimes(self.rate, v, self.lam, True) if rows else ca.SX.zeros(q.numel())
        self.unloaded = inertia - ca.gradient(self.T, q) + ca.gradient(self.V, q) + ca.gradient(self.D, v)
        self.R = self.unloaded + held
        self.loads = energies.loads
        if energies.loads:
            positions = ca.vertcat(*[x for load in energies.loads for x in load.position])
            forces = ca.vertcat(*[x for load in energies.loads for x in load.force])
            self.R = self.R - ca.jtimes(positions, q, forces, True)
        rolling = ca.vertcat(ca.SX(0, 1), *[ca.SX(row.rate(free)) for row in rows if not row.is_holonomic])
        if rolling.numel() and ca.depends_on(rolling, ca.vertcat(*s)):
            fail("L0916", "not supported yet: an excitation of a constraint on velocities", free.graph.model.span)

    def outputs(self, names: Sequence[str]) -> tuple[tuple[str, ...], ca.SX]:
        labels, values = [], []
        for name in names:
            for label, x in scalars(name, self.free.evaluator.value(observe(self.free.graph.model, name))):
                labels.append(label)
                values.append(ca.SX(x))
        y = ca.vertcat(ca.SX(0, 1), *values)
        if self.free.reactions:
            self._require_fixed_supports()
            y = ca.substitute(y, *build_reactions(self.free, self.motion.bodies, self.constraints, self.motion))
        return tuple(labels), y

    def _require_fixed_supports(self) -> None:
        moving = ca.vertcat(self.T, self.V, self.D, self.phi)
        if self.s[0].numel() and ca.depends_on(moving, ca.vertcat(*self.s)):
            fail("L0916", "not supported yet: how reactions answer to the motion of a support", self.free.graph.model.span,
                 "ask for reactions to loads, or for displacements")
