"""Motion -> what impulses do at time events.

Where the rate of a support or of a prescribed coordinate jumps, forces are infinite for no time: what they change at once is
momentum, and only along what holds the scene. So dT/dv of the coordinates stays as it is, but for the impulses J^T Lambda of
constraints: M dv + J^T Lambda = p(before) - p(after), J dv = -(J v + dPhi/dt).

Where a support itself jumps, dampers on it give an impulse: that of a force linear in rates, c times the way of the support.
It is the limit of supports that go over ever faster. A jump that carries mass along has no limit, nor have other laws of
damping: they add nothing here.
"""

import math
from collections.abc import Callable, Iterator, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.modes import RELATIONS, Mode
from lagrangia.algebra.numbering import rebuilt
from lagrangia.algebra.scalars import Expression, as_expression
from lagrangia.algebra.with_casadi import operations_in
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import usual_parameters
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.energies import evaluate_energies, generalised_force
from lagrangia.dynamics.held_switches import WHOLE
from lagrangia.dynamics.kkt import factor
from lagrangia.dynamics.motion import Motion, mass_matrix, solve_mass
from lagrangia.frames.kinematics import Kinematics

_FIRST_KNOTS = 50  # of a table of steps
_BESIDE = 1e-9  # s
_DRAWS, _PARABOLA = 8, (2.0, 1.0, 0.2, 0.0)  # coefficients of inputs, of as many tries
_HORIZON = 20.0  # s: of runs that do not say when they end
_ROUNDING = 1e-14  # of the largest of what is carried
_MOMENT, _LAST_PLACES = 1e-11, 1e-15  # s beside an event, and relative: its time is known to less
_NOTHING = 1e-6  # of the size of its terms: an impulse that is rounding


@dataclass(frozen=True)
class Kick:
    """`rates`: dv (n,), empty where no rate can jump; `before`: symbols of the modes of the segment that ends."""

    rates: ca.SX
    before: ca.SX


def rates_jump(kinematics: Kinematics, constraints: Constraints) -> bool:
    """Whether there are kicks, of scenes that are not compiled as a whole."""
    if not kinematics.algebra.modes and not _may_change_in_time(kinematics):
        return False
    energies = evaluate_energies(kinematics)
    q, v = (ca.vertcat(*values.values()) for values in (kinematics.symbols.positions, kinematics.symbols.rates))
    momentum = ca.gradient(energies.total(energies.kinetic), v)
    momentum, rows = _by_arms(kinematics, momentum, ca.vertcat(ca.SX(0, 1), *(row.rate(kinematics) for row in constraints.rows)))
    modes, before = _jumping(kinematics), ca.SX.sym("before", len(kinematics.algebra.modes))
    if _counts_in_time(kinematics, momentum, rows):
        return True
    if modes.numel() == 0:
        return False
    return bool(ca.depends_on(ca.vertcat(momentum, rows), modes)
                or _impulse_of_dampers(kinematics, q, v, kinematics.algebra.mode_symbols, before) is not None)


def _may_bend_in_time(kinematics: Kinematics) -> bool:
    return kinematics.algebra.may_bend and "time" in kinematics.symbols.asked


def _may_change_in_time(kinematics: Kinematics) -> bool:
    return _may_bend_in_time(kinematics) or not kinematics.algebra.index.asked.isdisjoint(("floor", "ceil"))


def _counts_in_time(kinematics: Kinematics, *moved: ca.SX) -> bool:
    """Whether whole numbers of what goes its way in time stand in these: they jump at events that no mode tells."""
    counted = _counted(kinematics, moved, 1)
    return any(x is not y for x, y in zip(counted, moved, strict=True))


def _counted(kinematics: Kinematics, expressions: Sequence[ca.SX], side: int) -> list[ca.SX]:
    """The same, with whole numbers of what goes its way in time as they are a moment after (1) or before (-1) the present time:
    an event that was found lies on one side of its jump."""
    algebra, time, found = kinematics.algebra, kinematics.symbols.time, list[int]()

    def made(op: int, _: list[int], operands: list[Expression]) -> Expression | None:
        x = as_expression(operands[0]) if op in WHOLE else None
        if x is None or not ca.depends_on(x, time) or ca.depends_on(x, algebra.state):
            return None
        found.append(op)
        slope = ca.jacobian(x, time)
        aside = _MOMENT * (1 + ca.fabs(time)) * slope + _LAST_PLACES * ca.fabs(x) * ca.sign(slope)
        return as_expression((ca.floor if op == ca.OP_FLOOR else ca.ceil)(x + side * aside))

    if all(operations_in(x).isdisjoint(WHOLE) for x in expressions):
        return list(expressions)
    results = rebuilt(expressions, algebra.index.numbering, made)
    return results if found else list(expressions)


def _by_arms(kinematics: Kinematics, momentum: ca.SX, rows: ca.SX) -> list[ca.SX]:
    """The same, with modes where supports move by max, min and abs of time: their rates jump at these bends."""
    is_timed = _may_bend_in_time(kinematics) and ca.depends_on(ca.vertcat(momentum, rows), kinematics.symbols.time)
    return kinematics.algebra.arms_in_force([momentum, rows]) if is_timed else [momentum, rows]


def _refuse_untold(kinematics: Kinematics, momentum: ca.SX, rows: ca.SX) -> None:
    """Raises LagError L0914 where rates of supports jump at times that nothing tells beforehand: no step would meet them."""
    algebra, time, found = kinematics.algebra, kinematics.symbols.time, list[ca.SX]()

    def note(op: int, _: list[int], operands: list[Expression]) -> None:
        if op == ca.OP_SIGN or op in RELATIONS:
            g = as_expression(operands[0] - (operands[1] if len(operands) > 1 else 0))
            found.extend([g] if ca.depends_on(g, time) and not ca.depends_on(g, algebra.state) else [])

    moved = ca.vertcat(momentum, rows)
    if not _may_bend_in_time(kinematics) or not ca.depends_on(moved, time):
        return
    rebuilt([moved], algebra.index.numbering, note)
    others = [mode for mode in algebra.modes if mode.of_input is None]
    known = ca.substitute(found, [mode.symbol for mode in others], [mode.in_time for mode in others]) if others else found
    if any(_jumps_with(kinematics, *driven) for g in known for driven in _driven(kinematics, g, moved)):
        fail("L0914", "not supported yet: a support or a prescribed coordinate whose rate jumps at a time that is not known "
             "beforehand", kinematics.graph.model.span, "straight lines, parabolas, powers, exponentials and sines of time "
             "tell when they are 0, as in max(0, (time/1[s])^2 - 1) or abs(sin(2*time/1[s])), "
             "and powers and exponentials of an input; "
             "others as branches of time: if time < 1 then ... else ...")


def _driven(kinematics: Kinematics, *asked: ca.SX) -> Iterator[list[ca.SX]]:
    """What is asked and what modes are, by inputs that go one way or the other, where there are such: by known parabolas."""
    modes, start = kinematics.algebra.modes, kinematics.graph.model.experiment.start
    pieces = [mode for mode in modes if mode.of_input is not None]
    values = ca.vertcat(*[mode.symbol if mode.of_input is not None else mode.in_time for mode in modes])
    known, rng = [*asked, values], np.random.default_rng(3)
    for _ in range(_DRAWS if pieces and ca.depends_on(ca.vertcat(*known), ca.vertcat(*[mode.symbol for mode in pieces])) else 1):
        numbers = [start if mode.column == 0 else rng.uniform(-1, 1) * _PARABOLA[mode.column - 1] for mode in pieces]
        yield ca.substitute(known, [mode.symbol for mode in pieces], [ca.SX(x) for x in numbers]) if pieces else known


def _jumps_with(kinematics: Kinematics, g: ca.SX, moved: ca.SX, in_force: ca.SX) -> bool:
    """Whether something else than modes tell jumps where g passes 0 in the first 20 s, or until the run ends, with parameters and
    positions like any others."""
    p, numbers = usual_parameters(kinematics)
    modes, run = kinematics.algebra.mode_symbols, kinematics.graph.model.experiment
    known = ca.vertcat(kinematics.symbols.time, p, modes)
    others = ca.vertcat(ca.SX(0, 1), *[x for x in ca.symvar(ca.vertcat(g, moved, in_force)) if not ca.depends_on(known, x)])
    rest = np.random.default_rng(2).uniform(0.3, 1.7, others.numel())
    told, carried = (ca.Function("look", [kinematics.symbols.time, p, modes, others], [x]) for x in (g, moved))
    segment = ca.Function("segment", [kinematics.symbols.time, p, others], [in_force])
    times = np.linspace(run.start + 2 * _BESIDE, run.stop if run.ends else run.start + _HORIZON, 4001)
    for place in _roots(lambda t: told(t, numbers, 0, rest), times):
        told_there = segment(place - _BESIDE, numbers, rest) if modes.numel() else 0
        before, after = (np.array(carried(t, numbers, told_there, rest)) for t in (place - _BESIDE, place + _BESIDE))
        sizes = np.maximum(np.abs(before), np.abs(after))
        if np.any(np.abs(after - before) > np.maximum(_NOTHING * sizes, _ROUNDING * sizes.max())):
            return True
    return False


def _roots(of: Callable[[object], ca.DM], times: NDArray[np.float64]) -> Iterator[float]:
    """Where a function passes 0 between two of these times, once, to within a part of _BESIDE."""
    below = np.array(of(times[np.newaxis])).ravel() < 0
    for k in np.flatnonzero(below[1:] != below[:-1]):
        low, high = float(times[k]), float(times[k + 1])
        while high - low > _BESIDE / 4:
            middle = (low + high) / 2
            low, high = (middle, high) if (float(of(middle)) < 0) == below[k] else (low, middle)
        yield high


def _jumping(kinematics: Kinematics) -> ca.SX:
    """The symbols of the modes with which something may jump."""
    return ca.vertcat(ca.SX(0, 1), *[mode.symbol for mode in kinematics.algebra.modes if mode.jumps])


def find_kick(kinematics: Kinematics, motion: Motion) -> Kick:
    """How rates jump where supports and prescribed coordinates jump in theirs."""
    held = motion.constrained
    if all(mode.of_attitude for mode in kinematics.algebra.modes) and not _may_change_in_time(kinematics):
        return Kick(ca.SX(0, 1), ca.SX.sym("before", len(kinematics.algebra.modes)))
    momentum, rows = _by_arms(kinematics, motion.momentum, held.rows.rate if held else ca.SX(0, 1))
    _refuse_untold(kinematics, momentum, rows)
    modes = ca.vertcat(ca.SX(0, 1), kinematics.algebra.mode_symbols)
    before = ca.vertcat(ca.SX(0, 1), *[ca.SX.sym(f"before_{k}") for k in range(modes.numel())])
    counts = _counts_in_time(kinematics, momentum, rows)
    if all(mode.of_attitude for mode in kinematics.algebra.modes) and not counts:
        return Kick(ca.SX(0, 1), before)
    impulse = _impulse_of_dampers(kinematics, motion.q, motion.v, modes, before)
    jumping, earlier = _jumping(kinematics), [before[k] for k, mode in enumerate(kinematics.algebra.modes) if mode.jumps]
    if impulse is None and not ca.depends_on(ca.vertcat(momentum, rows), jumping) and not counts:
        return Kick(ca.SX(0, 1), before)
    carried, rows = _counted(kinematics, [momentum, rows], 1)
    (gone,) = ca.substitute(_counted(kinematics, [momentum], -1), [jumping], [ca.vertcat(ca.SX(0, 1), *earlier)])
    gained = carried - gone - (0 if impulse is None else impulse)
    known = [ca.SX.sym("gained", gained.numel()), ca.SX.sym("rows", rows.numel())]
    if held is None:
        rates = solve_mass(kinematics, motion, -known[0])
    else:
        rates, _ = factor(mass_matrix(motion), held.J, True).solve(-known[0], -known[1], refine=False)
    rates = _counted(kinematics, _by_arms(kinematics, ca.densify(rates), ca.SX(0, 1))[:1], 1)[0]
    is_struck = ca.logic_or(ca.sumsqr(modes - before) > 0, ca.sumsqr(gained) > 0)
    return Kick(ca.densify(ca.substitute(rates, ca.vertcat(*known), ca.vertcat(gained, rows * is_struck))), before)


def bends_by_inputs(kinematics: Kinematics) -> list[ca.SX]:
    """What passes 0 where rates jump as inputs go: importers of FMUs may set them otherwise than was foreseen."""
    conditions = [mode.in_pieces for mode in kinematics.algebra.modes if mode.in_pieces is not None]
    return list({x.__hash__(): as_expression(x.dep(0) - x.dep(1)) for x in conditions}.values())


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
    arguments = ca.vertcat(ca.SX(0, 1), *[argument for mode in _telling(kinematics) for argument in mode.arguments])
    return any(_acts_where(kinematics, impulse, size, modes, before, *driven) for driven in _driven(kinematics, arguments))


def _acts_where(kinematics: Kinematics, impulse: ca.SX, size: ca.SX, modes: ca.SX, before: ca.SX, arguments: ca.SX, values: ca.SX
                ) -> bool:
    """The same, where events are those of these arguments."""
    t, (p, numbers) = kinematics.symbols.time, usual_parameters(kinematics)
    times = [*_event_times(kinematics, arguments, p, numbers)]
    if not times:
        return False
    in_force = ca.Function("modes", [t, p], [values])
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


def _telling(kinematics: Kinematics) -> list[Mode]:
    """Modes whose events may be jumps, but for those of tables."""
    return [mode for mode in kinematics.algebra.modes if mode.use is None]


def _event_times(kinematics: Kinematics, arguments: ca.SX, p: ca.SX, numbers: NDArray[np.float64]) -> Iterator[float]:
    """Of each condition that crosses zero, three of each that crosses integers, and the first knots of tables of steps: others do
    not jump."""
    kinds = [kind for mode in _telling(kinematics) for kind in mode.kinds]
    values = ca.Function("arguments", [kinematics.symbols.time, p], [arguments])
    start, later = (np.array(values(moment, numbers)).ravel() for moment in (0.0, 1.0))
    for kind, a, slope in zip(kinds, start, later - start, strict=True):
        if not np.isfinite(slope):
            continue
        levels = range(math.ceil(a), math.ceil(a) + 3) if kind else (0,)
        yield from (float((level - a) / slope) for level in levels if slope)
    steps = {id(mode.use): mode.use for mode in kinematics.algebra.modes if mode.use is not None and mode.use.table.degree == 0}
    for use in steps.values():
        argument = ca.Function("argument", [kinematics.symbols.time, p], [use.argument])
        a, later_a = (float(argument(moment, numbers)) for moment in (0.0, 1.0))
        yield from ((use.table.knot(k) - a) / (later_a - a) for k in range(min(use.table.n, _FIRST_KNOTS)) if later_a != a)
