"""Lagrange's equations with excitations, and their exact derivatives: what equilibria and small motion are computed from.

    R = d/dt(dT/dv) - dT/dq + dV/dq + dD/dv - f + J^T lambda = 0,   Phi(q, t, s) = 0

with excitations s(t) (probes.py). Time may stand still (pace 0): supports then rest where they are at that time. Where nothing
but loads depends on time it goes on (pace 1): a frame that turns steadily keeps turning, and equilibria are relative to it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca

from lagrangia.diagnostics import fail
from lagrangia.energies import evaluate_energies
from lagrangia.observables import observe
from lagrangia.parameters import scalars
from lagrangia.probes import Probe, ProbedKinematics, Triple, probe_kinematics
from lagrangia.reactions import build_reactions

if TYPE_CHECKING:
    import numpy as np

    from lagrangia.constraints import Constraints
    from lagrangia.kinematics import Kinematics
    from lagrangia.motion import Motion

DIRECTIONS = ("q", "v", "a", "lambda", "s", "ds", "dds")


@dataclass(frozen=True)
class SmallMotion:
    """The equations in numbers: n coordinates, m rows (m_h of them holonomic), k excitations, outputs y.

    Functions of q, v, a, lambda and of t, pace, u, p, made when they are first asked for:
    static:   R (n,), Phi (m_h,), rates of all rows (m,), V
    unsteady: R without loads, Phi and rates: what tells whether time matters
    observed: y
    slopes:   and of a direction of (q, v, a, lambda, s, s', s''): the derivatives of R, Phi, the rates
    observed_slopes: that of y
    """

    n: int
    m: int
    probes: tuple[Probe, ...]
    outputs: tuple[str, ...]
    _parts: "_Parts"
    _y: ca.SX

    @cached_property
    def static(self) -> ca.Function:
        return self._parts.function("static", [self._parts.R, self._parts.phi, self._parts.rate, self._parts.V])

    @cached_property
    def unsteady(self) -> ca.Function:
        return self._parts.function("unsteady", [self._parts.unloaded, self._parts.phi, self._parts.rate])

    @cached_property
    def observed(self) -> ca.Function:
        return self._parts.function("observed", [self._y])

    @cached_property
    def slopes(self) -> ca.Function:
        return self._parts.derivatives("slopes", [self._parts.R, self._parts.phi, self._parts.rate])

    @cached_property
    def observed_slopes(self) -> ca.Function:
        return self._parts.derivatives("observed_slopes", [self._y])

    def directions(self, *names: str) -> dict[str, "np.ndarray"]:
        """Those of `slopes` along each of q, v, a, lambda, s, ds, dds: (3 n + m + 3 k, n, m or k)."""
        import numpy as np

        sizes = dict(zip(DIRECTIONS, (self.n, self.n, self.n, self.m, *3 * (len(self.probes),)), strict=True))
        ends = dict(zip(sizes, np.cumsum(list(sizes.values())), strict=True))
        return {name: np.eye(sum(sizes.values()), sizes[name], sizes[name] - ends[name]) for name in names}


def build_small_motion(kinematics: "Kinematics", constraints: "Constraints", motion: "Motion", probes: Sequence[Probe] = (),
                       outputs: Sequence[str] = ()) -> SmallMotion:
    """Raises LagError L0701 for unknown outputs, L0916 for what is not supported yet."""
    k = len(probes)
    s = (ca.SX.sym("s", k), ca.SX.sym("ds", k), ca.SX.sym("dds", k))
    free = probe_kinematics(kinematics, constraints, probes, s)
    parts = _Parts(free, constraints, motion, s)
    names, y = parts.outputs(outputs)
    return SmallMotion(motion.q.numel(), parts.rate.numel(), tuple(probes), names, parts, y)


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

    def function(self, name: str, values: list[ca.SX], seeds: Sequence[ca.SX] = ()) -> ca.Function:
        """Of the state, with the excitations at rest."""
        m = self.motion
        values = [ca.densify(ca.SX(x)) for x in values]
        if modes := self.free.algebra.modes:
            values = ca.substitute(values, [x.symbol for x in modes], [x.value for x in modes])
        if quiet := self.s[0].numel():
            values = ca.substitute(values, [ca.vertcat(*self.s)], [ca.SX.zeros(3 * quiet)])
        return ca.Function(name, [m.q, m.v, m.a, self.lam, m.t, self.free.symbols.tau, m.u, m.p, *seeds], values)

    def derivatives(self, name: str, values: list[ca.SX]) -> ca.Function:
        """Along a direction: as long as the values themselves; a whole Jacobian would be as many times that as it has columns."""
        m = self.motion
        state = ca.vertcat(m.q, m.v, m.a, self.lam, *self.s)
        seed = ca.SX.sym("seed", state.numel())
        return self.function(name, [ca.jtimes(x, state, seed) if x.numel() else ca.SX(0, 1) for x in values], [seed])

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
