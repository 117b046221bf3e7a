"""Closures and scalar equations -> constraint rows, linear ones solved for a coordinate.

A row is Phi(q, t) = 0, or linear in the rates: A(q, t) v + b(q, t) = 0 (nonholonomic). A row of positions that is linear with
constant coefficients (rolling, a gear, a prescribed coordinate, the angle of a cut slider) gives one coordinate as a function of
the others and of time: that coordinate disappears, and the row with it.
"""

from collections import ChainMap
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import field, replace
from functools import partial

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Dual, Scalar, plus, rate_of, times
from lagrangia.algebra.orthogonal import general_numbers
from lagrangia.algebra.scalars import symbols_in
from lagrangia.algebra.with_casadi import jumps_with
from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import default_parameters
from lagrangia.constraints.unfelt import find_unfelt, without_unfelt
from lagrangia.frames.closures import gaps, gaps_of_start
from lagrangia.frames.edges import Closure
from lagrangia.frames.evaluation import Value
from lagrangia.frames.kinematics import Dependent, Kinematics
from lagrangia.language.flat import Equation

_NEGLIGIBLE = 1e-12
_TILTED = 1e-6  # of what is 2 for half a turn
_TILTS = {"hinge": 2, "cylinder": 2, "slider": 3, "weld": 3}  # rows of a cut joint that say how its ends are tilted
_OF_JUMPS = frozenset({"choice", "sign", "floor", "ceil"})  # what is asked of the algebra for them


@dataclass(frozen=True)
class Row:
    """One scalar equation; `value(kinematics, level)` vanishes."""

    value: Callable[[Kinematics, int], Scalar]
    is_holonomic: bool
    loop: Closure | None
    span: Span
    part: int = 0  # which of the closure's gaps, or of the equation's elements
    component: str = ""  # that states the equation
    is_timed: bool = False  # the equation itself depends on time
    equation: Equation | None = None
    start: Callable[[Kinematics], Scalar] | None = None  # vanishes with it, and nowhere else: asked for at the start
    balanced: str = ""  # the coordinate that moves no mass, whose forces are in balance
    follows: tuple[str, ...] = ()  # of a balance the coordinates that it gives rather than others, which dampers hold back

    @property
    def told(self) -> str:
        """Where it comes from, in words."""
        if self.balanced:
            return f"the balance of forces at '{self.balanced}', which moves no mass,"
        return f"the loop {self.loop.around}" if self.loop else f"the equation '{self.span.text}' at {self.span}"

    def value_at_start(self, kinematics: Kinematics) -> Scalar:
        """What vanishes at the start, from places far from there as well."""
        return self.value(kinematics, 0) if self.start is None else self.start(kinematics)

    def rate(self, kinematics: Kinematics) -> Scalar:
        """d/dt of a holonomic row along the motion; a nonholonomic row itself."""
        return self._by_arms(rate_of(self.value(kinematics, 1)) if self.is_holonomic else self.value(kinematics, 0), kinematics)

    def second_rate(self, kinematics: Kinematics) -> Scalar:
        """The next derivative, with the accelerations that the kinematics hold."""
        rate = rate_of(self.value(kinematics, 2 if self.is_holonomic else 1))
        return self._by_arms(rate_of(rate) if self.is_holonomic else rate, kinematics)

    def _by_arms(self, rate: Scalar, kinematics: Kinematics) -> Scalar:
        """The same, with modes where max, min and abs of time bend."""
        return kinematics.algebra.arms_in_force([ca.SX(rate)])[0] if self.is_timed and kinematics.algebra.may_bend else rate


@dataclass(frozen=True)
class LeastSquares:
    """That reactions which the mechanics leave open are to be those of least squares, torques over `length` (m); the places of
    remaining rows that repeat others."""

    length: float
    dependent: tuple[int, ...]


@dataclass(frozen=True)
class Constraints:
    """The rows that remain to be kept while integrating, holonomic ones first."""

    rows: tuple[Row, ...]
    repeated: tuple[Row, ...] = ()  # rows that say nothing new
    agreements: tuple[tuple[ca.SX, Row], ...] = ()  # what vanishes as long as a repeated row says nothing new, with that row
    absorbed: tuple[Row, ...] = ()  # linear rows that gave a coordinate
    givers: Mapping[str, Row] = field(default_factory=dict)  # the absorbed row of each coordinate that was given up
    touching: tuple[Row, ...] = ()  # rows that only just hold, with whose slopes they are kept
    least_squares: LeastSquares | None = None  # where that is asked for

    @property
    def all_rows(self) -> tuple[Row, ...]:
        """Those that remain, those that repeat others, those that coordinates have taken up."""
        return (*self.rows, *self.repeated, *self.absorbed)


def reduce_kinematics(kinematics: Kinematics) -> tuple[Kinematics, Constraints]:
    """The kinematics in the coordinates that are left, and the constraints that are left.

    Raises LagError L0410 for equations that contradict each other, L0411 for one that says nothing about the motion.
    """
    rows = _rows(kinematics)
    if not rows:
        return kinematics, Constraints(())
    reduction = _Reduction(kinematics)
    left = [row for row in _without_rounding(kinematics, rows) if not reduction.absorb(row)]
    reduced = reduction.reduced()
    left = reduction.repeat_motionless(_without_rounding(reduced, left) if reduction.solved else left, reduced)
    reduction.require_right_way_round(reduced)
    reduction.report.raise_errors()
    remaining = sorted(left, key=lambda row: not row.is_holonomic)
    givers = {name: reduction.givers[name] for name in reduction.solved}
    return reduced, Constraints(tuple(remaining), tuple(reduction.repeated), tuple(reduction.agreements),
                                tuple(reduction.absorbed), givers)


def reduce_further(kinematics: Kinematics, constraints: Constraints, rows: Sequence[Row], among: Collection[str]
                   ) -> tuple[Kinematics, Constraints]:
    """The same with more rows, where linear ones give coordinates of these names. Raises LagError L0410."""
    reduction = _Reduction(kinematics, frozenset(among))
    left = [row for row in rows if not reduction.absorb(row)]
    reduction.report.raise_errors()
    remaining = sorted((*constraints.rows, *left), key=lambda row: not row.is_holonomic)
    return reduction.reduced(), replace(
        constraints, rows=tuple(remaining), repeated=(*constraints.repeated, *reduction.repeated),
        agreements=(*reduction.in_those_left(constraints.agreements), *reduction.agreements),
        absorbed=(*constraints.absorbed, *reduction.absorbed),
        givers={**constraints.givers, **{name: reduction.givers[name] for name in reduction.solved}})


def derived(value: ca.SX, kinematics: Kinematics, level: int) -> Scalar:
    """What is known as an expression of q, v and t, at a level of the kinematics: its derivatives along the motion by CasADi."""
    if level == 0:
        return value
    rate = _along_motion(value, kinematics)
    return Dual(value, rate) if level == 1 else Dual(Dual(value, rate), Dual(rate, _along_motion(rate, kinematics)))


def _along_motion(value: ca.SX, kinematics: Kinematics) -> ca.SX:
    symbols = kinematics.symbols
    state = ca.vertcat(*symbols.positions.values(), *symbols.rates.values(), symbols.time)
    pace = ca.vertcat(kinematics.paced([*symbols.rates.values()]), *symbols.accelerations.values(), symbols.tau)
    return ca.jtimes(value, state, pace)


def moved_in_time(kinematics: Kinematics, constraints: Constraints) -> list[tuple[str, Span]]:
    """What equations move in time, with their lines: coordinates that they give, and what those say that are kept."""
    timed = [row.span for row in constraints.givers.values() if row.is_timed]
    found = [(name, row.span if row.is_timed else timed[0]) for name, row in constraints.givers.items()
             if timed and _is_timed(kinematics, kinematics.dependents[name].constant[0])]
    return found + [(row.component or row.span.text, row.span) for row in constraints.rows if row.is_timed]


def _is_timed(kinematics: Kinematics, value: Scalar) -> bool:
    hashes = symbols_in(ca.SX(value))
    return kinematics.symbols.time.__hash__() in hashes or not hashes.isdisjoint(kinematics.algebra.index.hashes)


def _hashes(symbols: Iterable[ca.SX]) -> frozenset[int]:
    return frozenset(x.__hash__() for x in symbols)


# -------------------------------------------------------------------- rows


def _rows(kinematics: Kinematics) -> list[Row]:
    rows = []
    for closure in kinematics.graph.closures:
        for k, gap in enumerate(gaps(kinematics, closure, 0)):
            start = partial(_gap_of_start, closure, k) if kinematics.geometry.by_rates and k >= 3 else None  # of turns
            is_timed = _is_timed(kinematics, gap)
            rows.append(Row(partial(_gap, closure, k), True, closure, closure.span, k, is_timed=is_timed, start=start))
    for equation in kinematics.graph.model.constraints:
        rows += _equation_rows(equation, kinematics)
    return rows


def _gap(closure: Closure, k: int, kinematics: Kinematics, level: int) -> Scalar:
    return gaps(kinematics, closure, level)[k]


def _gap_of_start(closure: Closure, k: int, kinematics: Kinematics) -> Scalar:
    return gaps_of_start(kinematics, closure)[k]


def _without_rounding(kinematics: Kinematics, rows: list[Row]) -> list[Row]:
    """The same, those of loops in space without the coordinates that they mention and do not feel, nor their starts."""
    loops = [row for row in rows if row.loop is not None] if kinematics.geometry.by_rates else []
    if not loops:
        return rows
    gaps, rates = ca.vertcat(*[row.value(kinematics, 0) for row in loops]), ca.vertcat(*[row.rate(kinematics) for row in loops])
    unfelt = dict(zip(map(id, loops), find_unfelt(kinematics, gaps, rates), strict=True))
    turns = [row for row in loops if row.start is not None]
    starts = ca.vertcat(ca.SX(0, 1), *[row.value_at_start(kinematics) for row in turns])
    unfelt_starts = dict(zip(map(id, turns), find_unfelt(kinematics, starts, ca.SX(0, 1)), strict=True))
    return [_felt(row, unfelt.get(id(row), ()), unfelt_starts.get(id(row), ())) for row in rows]


def _felt(row: Row, unfelt: Sequence[str], unfelt_start: Sequence[str]) -> Row:
    """Without these coordinates, and without those at the start."""
    if unfelt:
        row = replace(row, value=partial(_value_felt, row.value, unfelt))
    return replace(row, start=partial(_start_felt, row.start, unfelt_start)) if row.start is not None and unfelt_start else row


def _value_felt(value: Callable[[Kinematics, int], Scalar], unfelt: Sequence[str], kinematics: Kinematics, level: int) -> Scalar:
    return without_unfelt(kinematics, value(kinematics, level), unfelt)


def _start_felt(start: Callable[[Kinematics], Scalar], unfelt: Sequence[str], kinematics: Kinematics) -> Scalar:
    return without_unfelt(kinematics, start(kinematics), unfelt)


def different_sizes(left: Value, right: Value) -> str:
    """What is told of an equation between such values."""
    one, other = (f"{size} numbers" if size is not None else "a number" for size in map(_size, (left, right)))
    return f"the sides of this equation have different sizes: {one} on the left, {other} on the right"


def _size(value: Value) -> int | None:
    return len(value) if isinstance(value, tuple) else None


def _equation_rows(equation: Equation, kinematics: Kinematics) -> list[Row]:
    left, right = (kinematics.evaluator.value(side) for side in (equation.left, equation.right))
    if _size(left) != _size(right):
        fail("L0303", different_sizes(left, right), equation.span)
    rates = ca.vertcat(*kinematics.symbols.rates.values())

    def row(index: int | None, gap: Scalar) -> Row:
        def value(kin: Kinematics, level: int) -> Scalar:
            a, b = (kin.evaluator.value(side, level) for side in (equation.left, equation.right))
            return a - b if index is None else a[index] - b[index]

        is_holonomic = not ca.depends_on(ca.SX(gap), rates)
        if not is_holonomic and ca.depends_on(ca.jacobian(ca.SX(gap), rates), rates):
            fail("L0412", "a constraint on velocities must be linear in them", equation.span)
        return Row(value, is_holonomic, None, equation.span, index or 0, equation.component, _is_timed(kinematics, gap), equation)

    if not isinstance(left, tuple):
        return [row(None, left - right)]
    return [row(i, a - b) for i, (a, b) in enumerate(zip(left, right, strict=True))]


# -------------------------------------------------------------------- linear rows


class _Reduction:
    """Gaussian elimination of the linear rows, the coefficients kept as expressions of the parameters."""

    def __init__(self, kinematics: Kinematics, among: frozenset[str] | None = None) -> None:
        symbols = kinematics.symbols
        self.kinematics = kinematics
        self.among = frozenset(symbols.positions) if among is None else among  # of the coordinates that may be given up
        self.report = Report()
        self.names, self.q = list(symbols.positions), list(symbols.positions.values())
        self.place = {x.__hash__(): k for k, x in enumerate(self.q)}
        p, defaults = default_parameters(kinematics)
        self.defaults = {x.__hash__(): value for x, value in zip(p.elements(), defaults.full().ravel(), strict=True)}
        self.moving = _hashes([*kinematics.algebra.state.elements(), symbols.time])
        self.accelerations = _hashes(symbols.accelerations.values())
        self.started = {c.name for c in kinematics.graph.coordinates if c.has_start}
        self.solved: dict[str, ca.SX] = {}
        self.users: dict[int, dict[str, None]] = {}  # the solutions in which a coordinate stands, by its place
        self.last: dict[str, ca.SX] = {}
        self.givers: dict[str, Row] = {}  # of each coordinate that was given up
        self.repeated: list[Row] = []
        self.agreements: list[tuple[ca.SX, Row]] = []
        self.absorbed: list[Row] = []

    def absorb(self, row: Row) -> bool:
        """Takes a linear row in: it gives a coordinate, or says nothing new. False for a row that must be kept."""
        gap = ca.SX(row.value(self.kinematics, 0))
        mentioned = symbols_in(gap)
        if self._is_refused(mentioned, row):
            return True
        if not row.is_holonomic:
            return False
        named = [self.names[k] for k in self._places(mentioned)]
        known = ChainMap(self.last, self.solved)
        gone = [name for name in named if name in known]
        if gone:
            gap = ca.substitute([gap], [self.kinematics.symbols.positions[n] for n in gone], [known[n] for n in gone])[0]
        places = self._places(symbols_in(gap))
        q = self._coordinates(places)
        slopes = ca.densify(ca.jacobian(gap, q))
        in_slopes = symbols_in(slopes)
        if not in_slopes.isdisjoint(m.hash for m in self.kinematics.algebra.modes if m.of_input is not None):
            self.report.error("L0904", "not supported yet: an input as a factor of what a constraint holds", row.span,
                              "an input can be added there, as in x = ratio*y + u, with a parameter for the factor")
            return True
        if not in_slopes.isdisjoint(self.kinematics.algebra.index.hashes):
            self.report.error("L0909", "not supported yet: a constraint whose coefficients jump at times", row.span,
                              "let them go over quickly, as with 1/(1 + exp(-(time - t0)/0.01[s]))")
            return True
        if not in_slopes.isdisjoint(self.moving) or self._jumps(gap, q):
            return False
        constant = ca.substitute(gap, q, ca.SX.zeros(len(places)))
        sizes = [abs(float(x)) for x in self._numbers(slopes).full().ravel()]
        if max(sizes, default=0.0) <= _NEGLIGIBLE:
            self._repeat(row, [constant, *ca.vertsplit(slopes.T)], named)
            return True
        pivot = self._choose(sizes, slopes, places, row.follows)
        if pivot is None:
            return False
        others = slopes[:]
        others[pivot] = 0
        solution = -(constant + ca.dot(others, q.T)) / slopes[pivot]
        return self._give(places.pop(pivot), solution, places, row)

    def _jumps(self, gap: ca.SX, q: ca.SX) -> bool:
        """Whether it is linear between jumps alone, as x + floor(x) is."""
        return not self.kinematics.algebra.index.asked.isdisjoint(_OF_JUMPS) and jumps_with(gap, q)

    def _give(self, place: int, solution: ca.SX, others: list[int], row: Row) -> bool:
        """The coordinate at this place is given up for others, in earlier solutions as well. False for the last one."""
        name = self.names[place]
        self.givers[name] = row
        if len(self.solved) == len(self.names) - 1:  # this coordinate stays with its row: something to integrate
            self.last = {name: solution}
            return False
        self.absorbed.append(row)
        users = self.users.pop(place, {})
        earlier = ca.substitute([self.solved[n] for n in users], [self.q[place]], [solution]) if users else []
        self.solved |= dict(zip(users, earlier, strict=True)) | {name: solution}
        for k in others:
            self.users.setdefault(k, {}).update(users | {name: None})
        return True

    def _places(self, mentioned: frozenset[int]) -> list[int]:
        return sorted(self.place[key] for key in mentioned & self.place.keys())

    def _coordinates(self, places: list[int]) -> ca.SX:
        return ca.vertcat(ca.SX(0, 1), *[self.q[k] for k in places])

    def _is_refused(self, mentioned: frozenset[int], row: Row) -> bool:
        if not mentioned.isdisjoint(self.accelerations):
            self.report.error("L0412", "a constraint cannot depend on accelerations", row.span,
                              "constrain positions or velocities, or let a force act")
            return True
        return False

    def _numbers(self, expression: ca.SX) -> ca.DM:
        symbols = ca.symvar(expression)
        values = [self.defaults[x.__hash__()] for x in symbols]
        return ca.evalf(ca.substitute(expression, ca.vertcat(*symbols), ca.DM(values)) if symbols else expression)

    def _choose(self, sizes: list[float], slopes: ca.SX, places: list[int], follows: tuple[str, ...]) -> int | None:
        """The coordinate to give up: one with no start of its own, that `follows`, and with a coefficient of 1, the last declared
        among equals. None where none may be given up."""
        largest = max(sizes)

        def preference(k: int) -> tuple[bool, bool, bool, int]:
            name, is_unit = self.names[places[k]], slopes[k].is_constant() and abs(float(slopes[k])) == 1.0
            return (name not in self.started, name in follows, is_unit, k)

        open_ones = (k for k, size in enumerate(sizes) if size > 1e-6 * largest and self.names[places[k]] in self.among)
        return max(open_ones, key=preference, default=None)

    def repeat_motionless(self, rows: list[Row], kinematics: Kinematics) -> list[Row]:
        """Takes in what no motion changes, such as a rod between two points of one body; the rows that are left."""
        holonomic = [row for row in rows if row.is_holonomic]
        q = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values())
        gaps = ca.vertcat(ca.SX(0, 1), *[row.value(kinematics, 0) for row in holonomic])
        places, ways = general_numbers(1, 0.3, 1.7, 2 * q.numel()).reshape(2, -1)
        here, slopes = ca.substitute([gaps, ca.jtimes(gaps, q, ca.DM(ways))], [q], [ca.SX(places)])
        sizes = self._sizes_in_time(slopes)
        still = [k for k, size in enumerate(sizes) if size <= _NEGLIGIBLE]
        for k in still:
            named = [self.names[place] for place in self._places(symbols_in(ca.SX(holonomic[k].value(self.kinematics, 0))))]
            self._repeat(holonomic[k], [here[k], slopes[k]], named)
        gone = {id(holonomic[k]) for k in still}
        return [row for row in rows if id(row) not in gone]

    def require_right_way_round(self, kinematics: Kinematics) -> None:
        """That ends of loops which keep one tilt against each other, whatever moves, are not half a turn from each other."""
        q, tilts = ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values()), dict[int, list[Row]]()
        for row in self.repeated:
            if row.loop is not None and row.start is not None:
                tilts.setdefault(id(row.loop), []).append(row)
        places = ca.SX(general_numbers(1, 0.3, 1.7, q.numel()))
        for rows in tilts.values():
            if rows[0].loop is not None and rows[0].loop.kind == "cross":  # whose axes are square either way: the start tells
                self.agreements += [(ca.SX(row.value_at_start(kinematics)), row) for row in rows]
            if len(rows) < _TILTS.get(rows[0].loop.kind if rows[0].loop else "", len(rows) + 1):
                continue
            (turns,) = ca.substitute([ca.vertcat(*[row.value_at_start(kinematics) for row in rows])], [q], [places])
            if max(self._sizes_in_time(turns)) > _TILTED:
                self.report.error("L0410", f"{rows[0].told} cannot close: its ends are half a turn from each other", rows[0].span,
                                  "turn one of the frames that the joint ties by 180[deg]")
            self.agreements += [(x, row) for x, row in zip(ca.vertsplit(turns), rows, strict=True) if symbols_in(x)]

    def _repeat(self, row: Row, vanishing: Sequence[ca.SX], named: list[str]) -> None:
        """A row without coordinates, once others gave those it names: it repeats what they impose, or contradicts them.

        `vanishing` are its constant and its slopes, of parameters and time.
        """
        (gap,) = self._sizes_in_time(vanishing[0])
        if row.balanced and not named:
            self.report.error("L0504", f"the coordinate '{row.balanced}' moves no mass, and no spring or damper says where it is",
                              row.span, "hold it by a spring, or give a body there a mass")
        elif not named and row.loop is None:
            self.report.error("L0411", "this equation says nothing about the motion", row.span,
                              "a constraint needs coordinates or frames on one of its sides")
        elif gap > 1e-9:
            givers = dict.fromkeys(f"{self.givers[name].span}" for name in named if name in self.givers)
            contradiction = "this equation contradicts the others" if givers else "this cannot hold, whatever moves"
            what = f"the loop {row.loop.around} cannot close" if row.loop else contradiction
            others = [f"the other is at {', '.join(givers)}"] if len(givers) == 1 else [f"the others are at {', '.join(givers)}"]
            self.report.error("L0410", f"{what}: it misses by {gap:.3g}", row.span, "with the parameters as they are declared",
                              *others[: len(givers)])
        else:
            self.repeated.append(row)
            self.agreements += [(x, row) for x in vanishing if symbols_in(x)]

    def in_those_left(self, agreements: Sequence[tuple[ca.SX, Row]]) -> list[tuple[ca.SX, Row]]:
        """The same, those of coordinates that were given up meanwhile by what gave these."""
        if not self.solved or not agreements:
            return [*agreements]
        given_up = [self.kinematics.symbols.positions[name] for name in self.solved]
        values = ca.substitute([value for value, _ in agreements], given_up, [*self.solved.values()])
        return [(value, row) for value, (_, row) in zip(values, agreements, strict=True)]

    def _sizes_in_time(self, values: ca.SX) -> list[float]:
        """How large functions of time become, with the parameters as they are declared, and inputs of all kinds."""
        experiment, time = self.kinematics.graph.model.experiment, self.kinematics.symbols.time
        (values,) = self.kinematics.algebra.with_modes([values])
        symbols = [x for x in ca.symvar(values) if x.__hash__() != time.__hash__()]
        evaluate = ca.Function("values", [time, ca.vertcat(ca.SX(0, 1), *symbols)], [values])
        others = general_numbers(3, 0.3, 1.7, len(symbols))
        numbers = ca.DM([self.defaults.get(x.__hash__(), other) for x, other in zip(symbols, others, strict=True)])
        times = [experiment.start + part * (experiment.stop - experiment.start) for part in (0.0, 0.381, 0.764)]
        found = np.abs(np.hstack([evaluate(t, numbers).full() for t in times]))
        return [float(x) for x in found.max(axis=1)]

    def reduced(self) -> Kinematics:
        if not self.solved:
            return self.kinematics
        kinematics, t = self.kinematics, self.kinematics.symbols.time
        dependents = {}
        for name, solution in self.solved.items():
            places = self._places(symbols_in(solution))
            q = self._coordinates(places)
            constant = ca.substitute(solution, q, ca.SX.zeros(len(places)))
            if kinematics.algebra.may_bend and ca.depends_on(constant, t):
                (constant,) = kinematics.algebra.arms_in_force([constant])
            first = ca.jacobian(constant, t)
            slopes = ca.jacobian(solution, q)
            terms = {self.names[place]: slopes[0, k] for k, place in enumerate(places) if slopes.sparsity().has_nz(0, k)}
            dependents[name] = Dependent((constant, _plain(first), _plain(ca.jacobian(first, t))), terms)
        graph = kinematics.graph
        kept = tuple(c for c in graph.coordinates if c.name not in dependents)
        given = (*graph.dependent_coordinates, *(c for c in graph.coordinates if c.name in dependents))
        dependents = {name: _composed(x, dependents) for name, x in kinematics.dependents.items()} | dependents
        old = kinematics.symbols
        positions, rates, accelerations = ({name: symbol for name, symbol in symbols.items() if name not in dependents}
                                           for symbols in (old.positions, old.rates, old.accelerations))
        symbols = replace(old, positions=positions, rates=rates, accelerations=accelerations)
        return Kinematics(replace(graph, coordinates=kept, dependent_coordinates=given), symbols, kinematics.algebra, dependents)


def _composed(given: Dependent, dependents: Mapping[str, Dependent]) -> Dependent:
    """The same, where coordinates that it follows are given by others now."""
    constant, terms = list(given.constant), dict[str, Scalar]()
    for name, factor in given.terms.items():
        inner = dependents.get(name, Dependent((0.0, 0.0, 0.0), {name: 1.0}))
        constant = [plus(c, times(factor, more)) for c, more in zip(constant, inner.constant, strict=True)]
        for other, slope in inner.terms.items():
            terms[other] = plus(terms.get(other, 0.0), times(factor, slope))
    return Dependent((constant[0], constant[1], constant[2]), terms)


def _plain(x: ca.SX) -> Scalar:
    """The float 0 where nothing is left, which then costs nothing."""
    return 0.0 if ca.SX(x).is_zero() else x
