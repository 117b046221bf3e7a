"""Lagrange's equations with excitations, and their exact derivatives: what equilibria and small motion are computed from.

    R = d/dt(dT/dv) - dT/dq + dV/dq + dD/dv - f + J^T lambda = 0,   Phi(q, t, s) = 0

with excitations s(t) (probes.py). Time may stand still (pace 0): supports then rest where they are at that time. Where nothing
but loads depends on time it goes on (pace 1): a frame that turns steadily keeps turning, and equilibria are relative to it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca

from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import Expression, as_expression
from lagrangia.algebra.with_casadi import CORNERS, uses
from lagrangia.base.diagnostics import fail
from lagrangia.base.later import Later
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import default_parameters, scalars
from lagrangia.dynamics.driven_conditions import Pair
from lagrangia.dynamics.energies import Energies, evaluate_energies, generalised_force
from lagrangia.dynamics.found_conditions import conditions_in
from lagrangia.dynamics.held_motion import HeldMotion
from lagrangia.dynamics.reactions import build_reactions
from lagrangia.dynamics.switches import held_switches, jumps_at_rest
from lagrangia.language.observables import observe
from lagrangia.study.probes import Probe, ProbedKinematics, Triple, probe_kinematics

if TYPE_CHECKING:
    import numpy as np

    from lagrangia.constraints.rows import Constraints
    from lagrangia.dynamics.motion import Motion
    from lagrangia.frames.kinematics import Kinematics

DIRECTIONS = ("q", "v", "a", "lambda", "s", "ds", "dds")
_NONE = ca.SX(0, 1)


@dataclass(frozen=True)
class Holds:
    """What may hold at rest beside constraints, as the run time knows it: contacts, by the forces along their gaps, and friction,
    by the shares of its jumps (switches.py). `gaps` (c,) are positive where a contact is passed, `guards` (c,) where the rest of
    its condition holds; `slips` (f,) are the rates at which friction jumps; `cones` are pairs of these that are the components
    of one slip in the plane. `one_way` are the places of contacts of rates, as a ratchet's, whose gaps are by how much a rate is
    beyond its level."""

    forces: ca.SX = _NONE
    gaps: ca.SX = _NONE
    guards: ca.SX = _NONE
    shares: ca.SX = _NONE
    slips: ca.SX = _NONE
    contacts: tuple[str, ...] = ()
    rubs: tuple[str, ...] = ()
    cones: tuple[tuple[int, int], ...] = ()
    one_way: tuple[int, ...] = ()


@dataclass(frozen=True)
class SmallMotion:
    """The equations in numbers: n coordinates, m rows (m_h of them holonomic), k excitations, outputs y.

    Functions of q, v, a, lambda and of t, pace, u, p, made when they are first asked for; behind lambda (m,) stand the forces of
    contacts and the shares of friction:
    static:   R (n,), Phi (m_h,), rates of all rows (m,), V
    touching: gaps and guards of contacts (c,), slips of friction (f,)
    begins:   what vanishes where loops are closed, and nowhere else, of the rows that vanish elsewhere as well
    unsteady: R without loads, Phi and rates: what tells whether time matters
    observed: y
    slopes:   and of a direction of (q, v, a, lambda, s, s', s''): the derivatives of R, Phi, the rates, the gaps, the slips
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
        """-> R, Phi, the rates of the rows, V."""
        return self._parts.function("static", [self._parts.R, self._parts.phi, self._parts.rate, self._parts.V])

    @cached_property
    def begins(self) -> ca.Function | None:
        """-> what vanishes at the start (rows.py) of loops whose rows vanish for joints put together the wrong way round, too;
        None where there are none."""
        return self._parts.function("begins", [self._parts.begins]) if self._parts.begins.numel() else None

    @property
    def holds(self) -> Holds:
        """What may press or stick at rest."""
        return self._parts.holds

    @property
    def is_timed(self) -> bool:
        """Whether time is in the forces."""
        parts = self._parts
        modes = ca.vertcat(_NONE, *[mode.symbol for mode in parts.free.algebra.modes if not mode.of_attitude])
        return bool(ca.depends_on(parts.R, ca.vertcat(parts.motion.t, parts.free.symbols.tau, modes)))

    @cached_property
    def is_bent(self) -> bool:
        """Whether forces bend, or friction jumps, somewhere."""
        return bool(self.holds.shares.numel()) or uses(_function_of(self._parts.R), CORNERS)

    @cached_property
    def rubs_dry(self) -> tuple[str, ...]:
        """The components whose forces jump where a rate passes through 0, as those of dry friction do; each once."""
        h = self.holds
        jumping = jumps_at_rest(self._parts.R, h.shares, self._parts.motion.v)
        return tuple(dict.fromkeys(name for name, jumps in zip(h.rubs, jumping, strict=True) if jumps))

    def multipliers(self, lam: "np.ndarray | None" = None, forces: "np.ndarray | None" = None, shares: "np.ndarray | None" = None
                    ) -> "np.ndarray":
        """All of them: nothing presses, and friction is half way between its limits, where nothing else is given."""
        import numpy as np

        h = self.holds
        parts = ((lam, self.m, 0.0), (forces, h.forces.numel(), 0.0), (shares, h.shares.numel(), 0.5))
        return np.concatenate([np.full(size, usual) if given is None else given for given, size, usual in parts])

    @cached_property
    def touching(self) -> ca.Function:
        """-> gaps and guards of contacts, slips of friction."""
        h = self.holds
        return self._parts.function("touching", [h.gaps, h.guards, h.slips])

    @cached_property
    def unsteady(self) -> ca.Function:
        """-> R without loads, Phi, the rates of the rows."""
        return self._parts.function("unsteady", [self._parts.unloaded, self._parts.phi, self._parts.rate])

    @cached_property
    def observed(self) -> ca.Function:
        """-> outputs."""
        return self._parts.function("observed", [self._y])

    @cached_property
    def slopes(self) -> ca.Function:
        """-> derivatives of R, Phi, the rates, the gaps and the slips, along a direction."""
        h = self.holds
        return self._parts.derivatives("slopes", [self._parts.R, self._parts.phi, self._parts.rate, h.gaps, h.slips])

    @cached_property
    def second(self) -> ca.Function:
        """-> second rates of the rows."""
        return self._parts.function("second", [self._parts.second])

    @cached_property
    def second_slopes(self) -> ca.Function:
        """That of the second rates of the rows."""
        return self._parts.derivatives("second_slopes", [self._parts.second])

    @cached_property
    def observed_slopes(self) -> ca.Function:
        """-> derivatives of the outputs, along a direction."""
        return self._parts.derivatives("observed_slopes", [self._y])

    def directions(self, *names: str) -> dict[str, "np.ndarray"]:
        """Those of `slopes` along each of q, v, a, lambda, s, ds, dds: (3 n + m + c + f + 3 k, n, m + c + f or k)."""
        import numpy as np

        sizes = dict(zip(DIRECTIONS, (self.n, self.n, self.n, self.multipliers().size, *3 * (len(self.probes),)), strict=True))
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
        pace = free.turning
        along = ca.vertcat(v if pace is None else pace, motion.a, tau, s[1], s[2])
        inertia = ca.jtimes(momentum, ca.vertcat(q, v, t, s[0], s[1]), along) + free.carried(momentum)
        rows = constraints.rows
        self.phi = ca.vertcat(ca.SX(0, 1), *[ca.SX(row.value(free, 0)) for row in rows if row.is_holonomic])
        self.rate = ca.vertcat(ca.SX(0, 1), *[ca.SX(row.rate(free)) for row in rows])
        self.lam = motion.constrained.symbols if motion.constrained else ca.SX(0, 1)
        held = ca.jtimes(self.rate, v, self.lam, True) if rows else ca.SX.zeros(q.numel())
        self.unloaded = inertia - free.by_turns(self.T) + free.by_turns(self.V) + ca.gradient(self.D, v)
        self.R = self.unloaded + held
        self.loads = energies.loads
        if loads := (*energies.loads, *motion.impacts.loads_in(free)):
            self.R = self.R - generalised_force(loads, q, v)
        self.holds, self.moving = _find_holds(motion, energies, self)
        self.R, self.unloaded = (free.by_places(self.moving.rows([x])[0]) for x in self.still([self.R, self.unloaded]))
        rolling = ca.vertcat(ca.SX(0, 1), *[ca.SX(row.rate(free)) for row in rows if not row.is_holonomic])
        if rolling.numel() and ca.depends_on(rolling, ca.vertcat(*s)):
            fail("L0916", "not supported yet: an excitation of a constraint on velocities", free.graph.model.span)

    @cached_property
    def begins(self) -> ca.SX:
        """What vanishes at the start of the rows that have such a thing beside their values."""
        rows = (*self.constraints.rows, *self.constraints.repeated)
        return ca.vertcat(ca.SX(0, 1), *[ca.SX(row.start(self.free)) for row in rows if row.start is not None])

    @cached_property
    def second(self) -> ca.SX:
        """Second rates of the rows, (m,)."""
        return ca.vertcat(ca.SX(0, 1), *[ca.SX(row.second_rate(self.free)) for row in self.constraints.rows])

    def still(self, values: Sequence[ca.SX]) -> list[ca.SX]:
        """Without impulses."""
        impulses = self.motion.impacts.impulses
        return ca.substitute([*values], [impulses], [ca.SX.zeros(impulses.numel())]) if impulses.numel() else [*values]

    def function(self, name: str, values: list[ca.SX], seeds: Sequence[ca.SX] = ()) -> ca.Function:
        """Of the state, with the excitations at rest."""
        m = self.motion
        values = [ca.densify(ca.SX(x)) for x in values]
        references = [x.symbol for x in self.free.algebra.modes if x.of_attitude]  # behind inputs
        if modes := [x for x in self.free.algebra.modes if not x.of_attitude]:
            values = ca.substitute(values, [x.symbol for x in modes], [x.value for x in modes])
        if quiet := self.s[0].numel():
            values = ca.substitute(values, [ca.vertcat(*self.s)], [ca.SX.zeros(3 * quiet)])
        multipliers = ca.vertcat(self.lam, self.holds.forces, self.holds.shares)
        return ca.Function(name, [m.q, m.v, m.a, multipliers, m.t, self.free.symbols.tau, ca.vertcat(m.u, *references),
                                  m.p, *seeds], values)

    def derivatives(self, name: str, values: list[ca.SX]) -> ca.Function:
        """Along a direction: as long as the values themselves; a whole Jacobian would be as many times that as it has columns."""
        m = self.motion
        state = ca.vertcat(m.q, m.v, m.a, self.lam, self.holds.forces, self.holds.shares, *self.s)
        seed = ca.SX.sym("seed", state.numel())
        return self.function(name, [ca.jtimes(x, state, seed) if x.numel() else ca.SX(0, 1) for x in values], [seed])

    def outputs(self, names: Sequence[str]) -> tuple[tuple[str, ...], ca.SX]:
        labels, values = [], []
        for name in names:
            value = self.free.symbols.positions.get(name) if name in self.free.turned else self.free.attitude_named(name)
            value = self.free.evaluator.value(observe(self.free.graph.model, name)) if value is None else value
            for label, x in scalars(name, value):
                labels.append(label)
                values.append(ca.SX(x))
        symbols, reactions = ca.SX(0, 1), ca.SX(0, 1)
        if self.free.reactions or self.free.forces:
            self._require_fixed_supports()
            symbols, reactions = build_reactions(self.free, self.motion.bodies, self.constraints, self.motion)
        y = self.moving.outputs(ca.vertcat(ca.SX(0, 1), *values),
                                lambda x: self.still(ca.substitute([*x], [symbols], [reactions])))
        return tuple(labels), y

    def _require_fixed_supports(self) -> None:
        moving = ca.vertcat(self.T, self.V, self.D, self.phi)
        if self.s[0].numel() and ca.depends_on(moving, ca.vertcat(*self.s)):
            fail("L0916", "not supported yet: how reactions answer to the motion of a support", self.free.graph.model.span,
                 "ask for reactions to loads, or for displacements")


def _find_holds(motion: "Motion", energies: Energies, parts: _Parts) -> tuple[Holds, HeldMotion]:
    impacts = motion.impacts
    gaps = impacts.gaps_in(parts.free)
    numbering, whens = Numbering(), parts.free.graph.model.whens
    may_hold = uses(_function_of(parts.R), CORNERS | {ca.OP_SQRT})  # v/|v| has corners in |v| alone
    signals = {state.coordinate for state in parts.free.graph.model.states.values()}
    v = ca.vertcat(_NONE, *[motion.v[k] for k, name in enumerate(parts.free.symbols.rates) if name not in signals])
    conditions, rests, cones, _ = conditions_in([parts.R], v, v, numbering) if may_hold else ({}, {}, (), {})
    acting = replace(motion, inertial=Later(lambda: parts.R), unsolved=None)
    switches = held_switches(acting, conditions, _at_rest(conditions, rests), numbering)
    order, owners = {pair: k for k, pair in enumerate(switches.places)}, _owners(energies, motion.v, numbering)
    return Holds(
        ca.vertcat(_NONE, *[impacts.forces[k] for k in gaps]), ca.vertcat(_NONE, *gaps.values()),
        ca.vertcat(_NONE, *[impacts.conditions[k] for k in gaps]), switches.symbols, switches.values,
        tuple(whens[k].component or whens[k].condition.span.text for k in gaps),
        tuple(owners.get(pair) or "friction" for pair in order),
        tuple((order[a], order[b]) for a, b in cones if a in order and b in order),
        tuple(place for place, k in enumerate(gaps) if impacts.one_way[k]),
    ), HeldMotion(acting, switches, default_parameters(parts.free)[1])


def _at_rest(conditions: Mapping[Pair, Expression], rests: Mapping[Pair, Expression]) -> dict[Pair, Expression]:
    """Whether rates rest, by what they are."""
    return {pair: as_expression(ca.SX(conditions[pair]) == 0) for pair in rests}


def _function_of(x: ca.SX) -> ca.Function:
    return ca.Function("of", ca.symvar(x), [x])


def _owners(energies: Energies, v: ca.SX, numbering: Numbering) -> dict[Pair, str]:
    """The component that states what jumps."""
    stated = [(term.statement.component, [ca.gradient(ca.SX(term.value), v)]) for term in energies.dissipation]
    stated += [(load.statement.component, [ca.SX(x) for x in load.force]) for load in energies.loads]
    return {pair: component for component, values in reversed(stated) for pair in conditions_in(values, v, v, numbering)[0]}
