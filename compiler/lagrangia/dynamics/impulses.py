"""Motion -> what impulses do at time events.

Where the rate of a support or of a prescribed coordinate jumps, forces are infinite for no time: what they change at once is
momentum, and only along what holds the scene. So dT/dv of the coordinates stays as it is, but for the impulses J^T Lambda of
constraints: M dv + J^T Lambda = p(before) - p(after), J dv = -(J v + dPhi/dt).

Where a support itself jumps, dampers on it give an impulse: that of a force linear in rates, c times the way of the support.
It is the limit of supports that go over ever faster. A jump that carries mass along has no limit, nor have other laws of
damping: they add nothing here.
"""

import math
from collections.abc import Iterator

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import usual_parameters
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.energies import evaluate_energies, generalised_force
from lagrangia.dynamics.kkt import factor
from lagrangia.dynamics.motion import Motion, mass_matrix, solve_mass
from lagrangia.frames.kinematics import Kinematics

_FIRST_KNOTS = 50  # of a table of steps
_NOTHING = 1e-6  # of the size of its terms: an impulse that is rounding


@dataclass(frozen=True)
class Kick:
    """`rates`: dv (n,), empty where no rate can jump; `before`: symbols of the modes of the segment that ends."""

    rates: ca.SX
    before: ca.SX


def rates_jump(kinematics: Kinematics, constraints: Constraints) -> bool:
    """Whether there are kicks, of scenes that are not compiled as a whole."""
    modes = _jumping(kinematics)
    if modes.numel() == 0:
        return False
    energies, before = evaluate_energies(kinematics), ca.SX.sym("before", len(kinematics.algebra.modes))
    q, v = (ca.vertcat(*values.values()) for values in (kinematics.symbols.positions, kinematics.symbols.rates))
    momentum = ca.gradient(energies.total(energies.kinetic), v)
    return bool(ca.depends_on(ca.vertcat(momentum, *(row.rate(kinematics) for row in constraints.rows)), modes)
                or _impulse_of_dampers(kinematics, q, v, kinematics.algebra.mode_symbols, before) is not None)


def _jumping(kinematics: Kinematics) -> ca.SX:
    """The symbols of the modes with which something may jump."""
    return ca.vertcat(ca.SX(0, 1), *[mode.symbol for mode in kinematics.algebra.modes if mode.jumps])


def find_kick(kinematics: Kinematics, motion: Motion) -> Kick:
    """How rates jump where supports and prescribed coordinates jump in theirs."""
    modes, held = kinematics.algebra.mode_symbols, motion.constrained
    rows = held.rows.rate if held else ca.SX(0, 1)
    before = ca.vertcat(*[ca.SX.sym(f"before_{k}") for k in range(modes.numel())])
    if all(mode.of_attitude for mode in kinematics.algebra.modes):
        return Kick(ca.SX(0, 1), before)
    impulse = _impulse_of_dampers(kinematics, motion.q, motion.v, modes, before)
    jumping, earlier = _jumping(kinematics), [before[k] for k, mode in enumerate(kinematics.algebra.modes) if mode.jumps]
    if impulse is None and not ca.depends_on(ca.vertcat(motion.momentum, rows), jumping):
        return Kick(ca.SX(0, 1), before)
    gained = motion.momentum - ca.substitute(motion.momentum, jumping, ca.vertcat(ca.SX(0, 1), *earlier))
    gained -= 0 if impulse is None else impulse
    if held is None:
        return Kick(ca.densify(solve_mass(kinematics, motion, -gained)), before)
    rates, _ = factor(mass_matrix(motion), held.J, True).solve(-gained, -rows, refine=False)
    return Kick(ca.densify(rates), before)


def _impulse_of_dampers(kinematics: Kinematics, q: ca.SX, v: ca.SX, modes: ca.SX, before: ca.SX) -> ca.SX | None:
    """Of supports that jump, (n,): the forces per pace of modes, the mean of before and after. None where there is none."""
    places = [ca.SX(dependent.constant[0]) for dependent in kinematics.dependents.values()]
    jumps = ca.vertcat(modes, *places)
    jumps -= ca.substitute(jumps, modes, before)
    pace = ca.SX.sym("pace", jumps.numel())
    energies = evaluate_energies(kinematics.gliding(pace[: modes.numel()], pace.elements()[modes.numel() :]))
    damping = ca.gradient(energies.total(energies.dissipation), v)
    forces = ca.jacobian(generalised_force(energies.loads, q, v) - damping, pace)
    if not forces.nnz() or ca.depends_on(forces, ca.vertcat(pace, v)):
        return None
    mean = (forces + ca.substitute(forces, modes, before)) / 2
    impulse, size = ca.densify(mean @ jumps), ca.fabs(mean) @ ca.fabs(jumps)
    return impulse if _acts(kinematics, impulse, size, modes, before) else None


def _acts(kinematics: Kinematics, impulse: ca.SX, size: ca.SX, modes: ca.SX, before: ca.SX) -> bool:
    """Whether there is an impulse at some event, with parameters and positions like any others: ramps go on where they were.
    It is compared with its `size`, that of its terms, there and at a time when all modes change at once."""
    t, (p, numbers) = kinematics.symbols.time, usual_parameters(kinematics)
    times = [*_event_times(kinematics, p, numbers)]
    if not times:
        return False
    in_force = ca.Function("modes", [t, p], [ca.vertcat(*[mode.value for mode in kinematics.algebra.modes])])
    known = ca.vertcat(t, p, modes, before)
    others = ca.vertcat(ca.SX(0, 1), *[x for x in ca.symvar(ca.vertcat(impulse, size)) if not ca.depends_on(known, x)])
    strike = ca.Function("strike", [t, p, modes, before, others], [impulse, size])
    rest = np.random.default_rng(2).uniform(0.3, 1.7, others.numel())

    def sizes(when: float, after: object, earlier: object) -> list[float]:
        return [float(np.abs(np.array(x)).max(initial=0.0)) for x in strike(when, numbers, after, earlier, rest)]

    usual = sizes(0.7, np.ones(modes.numel()), np.zeros(modes.numel()))[1]
    for when in times:
        beside = 1e-9 * max(1.0, abs(when))
        found, own = sizes(when, in_force(when + beside, numbers), in_force(when - beside, numbers))
        if found > _NOTHING * max(own, usual):
            return True
    return False


def _event_times(kinematics: Kinematics, p: ca.SX, numbers: NDArray[np.float64]) -> Iterator[float]:
    """Of each condition that crosses zero, three of each that crosses integers, and the first knots of tables of steps: others do
    not jump."""
    modes = [mode for mode in kinematics.algebra.modes if mode.use is None]
    arguments = [(argument, mode.kind) for mode in modes for argument in mode.arguments]
    values = ca.Function("arguments", [kinematics.symbols.time, p], [ca.vertcat(*[argument for argument, _ in arguments])])
    start, later = (np.array(values(moment, numbers)).ravel() for moment in (0.0, 1.0))
    for (_, kind), a, slope in zip(arguments, start, later - start, strict=True):
        levels = range(math.ceil(a), math.ceil(a) + 3) if kind else (0,)
        yield from (float((level - a) / slope) for level in levels if slope)
    steps = {id(mode.use): mode.use for mode in kinematics.algebra.modes if mode.use is not None and mode.use.table.degree == 0}
    for use in steps.values():
        argument = ca.Function("argument", [kinematics.symbols.time, p], [use.argument])
        a, later_a = (float(argument(moment, numbers)) for moment in (0.0, 1.0))
        yield from ((use.table.knot(k) - a) / (later_a - a) for k in range(min(use.table.n, _FIRST_KNOTS)) if later_a != a)
