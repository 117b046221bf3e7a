"""Closures and scalar equations -> constraint rows, linear ones solved for a coordinate.

A row is Phi(q, t) = 0, or linear in the rates: A(q, t) v + b(q, t) = 0 (nonholonomic). A row of positions that is linear with
constant coefficients (rolling, a gear, a prescribed coordinate, the angle of a cut slider) gives one coordinate as a function of
the others and of time: that coordinate disappears, and the row with it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import casadi as ca

from lagrangia.algebra import Scalar, rate_of
from lagrangia.closures import gaps
from lagrangia.diagnostics import Report, Span, fail
from lagrangia.edges import Closure
from lagrangia.evaluation import scalars_of
from lagrangia.flat import Equation
from lagrangia.kinematics import Dependent, Kinematics
from lagrangia.parameters import default_parameters

_NEGLIGIBLE = 1e-12


@dataclass(frozen=True)
class Row:
    """One scalar equation; `value(kinematics, level)` vanishes."""

    value: Callable[[Kinematics, int], Scalar]
    is_holonomic: bool
    loop: Closure | None
    span: Span
    part: int = 0  # which of the closure's gaps
    component: str = ""  # that states the equation
    is_timed: bool = False  # the equation itself depends on time

    def rate(self, kinematics: Kinematics) -> Scalar:
        """d/dt of a holonomic row along the motion; a nonholonomic row itself."""
        return rate_of(self.value(kinematics, 1)) if self.is_holonomic else self.value(kinematics, 0)

    def second_rate(self, kinematics: Kinematics) -> Scalar:
        """The next derivative, with the accelerations that the kinematics hold."""
        rate = rate_of(self.value(kinematics, 2 if self.is_holonomic else 1))
        return rate_of(rate) if self.is_holonomic else rate


@dataclass(frozen=True)
class Constraints:
    """The rows that remain to be kept while integrating, holonomic ones first."""

    rows: tuple[Row, ...]
    repeated: tuple[Row, ...] = ()  # linear rows that say nothing new
    absorbed: tuple[Row, ...] = ()  # linear rows that gave a coordinate
    givers: Mapping[str, Row] = field(default_factory=dict)  # the absorbed row of each coordinate that was given up

    @property
    def all_rows(self) -> tuple[Row, ...]:
        return (*self.rows, *self.repeated, *self.absorbed)


def reduce_kinematics(kinematics: Kinematics) -> tuple[Kinematics, Constraints]:
    """The kinematics in the coordinates that are left, and the constraints that are left.

    Raises LagError L0410 for equations that contradict each other, L0411 for one that says nothing about the motion.
    """
    rows = _rows(kinematics)
    if not rows:
        return kinematics, Constraints(())
    reduction = _Reduction(kinematics)
    left = [row for row in rows if not reduction.absorb(row)]
    reduction.report.raise_errors()
    remaining = sorted(left, key=lambda row: not row.is_holonomic)
    givers = {name: reduction.givers[name] for name in reduction.solved}
    return reduction.reduced(), Constraints(tuple(remaining), tuple(reduction.repeated), tuple(reduction.absorbed), givers)


def moved_in_time(kinematics: Kinematics, constraints: Constraints) -> list[tuple[str, Span]]:
    """What equations move in time, with their lines: coordinates that they give, and what those say that are kept."""
    timed = [row.span for row in constraints.givers.values() if row.is_timed]
    found = [(name, row.span if row.is_timed else timed[0]) for name, row in constraints.givers.items()
             if timed and _is_timed(kinematics, kinematics.dependents[name].constant[0])]
    return found + [(row.component or row.span.text, row.span) for row in constraints.rows if row.is_timed]


def _is_timed(kinematics: Kinematics, value: Scalar) -> bool:
    modes = [mode.symbol for mode in kinematics.algebra.modes]
    return bool(ca.depends_on(ca.SX(value), ca.vertcat(kinematics.symbols.time, *modes)))


# -------------------------------------------------------------------- rows


def _rows(kinematics: Kinematics) -> list[Row]:
    rows = []
    for closure in kinematics.graph.closures:
        for k, gap in enumerate(gaps(kinematics, closure, 0)):
            rows.append(Row(partial(_gap, closure, k), True, closure, closure.span, k, is_timed=_is_timed(kinematics, gap)))
    for equation in kinematics.graph.model.constraints:
        rows += _equation_rows(equation, kinematics)
    return rows


def _gap(closure: Closure, k: int, kinematics: Kinematics, level: int) -> Scalar:
    return gaps(kinematics, closure, level)[k]


def _equation_rows(equation: Equation, kinematics: Kinematics) -> list[Row]:
    left, right = (kinematics.evaluator.value(side) for side in (equation.left, equation.right))
    if isinstance(left, tuple) != isinstance(right, tuple) or (isinstance(left, tuple) and len(left) != len(right)):
        fail("L0303", "the sides of this equation have different sizes", equation.span)
    rates = ca.vertcat(*kinematics.symbols.rates.values())

    def row(index: int | None, gap: Scalar) -> Row:
        def value(kin: Kinematics, level: int) -> Scalar:
            a, b = (kin.evaluator.value(side, level) for side in (equation.left, equation.right))
            return a - b if index is None else a[index] - b[index]

        is_holonomic = not ca.depends_on(ca.SX(gap), rates)
        if not is_holonomic and ca.depends_on(ca.jacobian(ca.SX(gap), rates), rates):
            fail("L0412", "a constraint on velocities must be linear in them", equation.span)
        return Row(value, is_holonomic, None, equation.span, component=equation.component, is_timed=_is_timed(kinematics, gap))

    if not isinstance(left, tuple):
        return [row(None, left - right)]
    return [row(i, a - b) for i, (a, b) in enumerate(zip(left, right, strict=True))]


# -------------------------------------------------------------------- linear rows


class _Reduction:
    """Gaussian elimination of the linear rows, the coefficients kept as expressions of the parameters."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.report = Report()
        self.names = list(kinematics.symbols.positions)
        self.q = ca.vertcat(*kinematics.symbols.positions.values())
        self.p, self.defaults = default_parameters(kinematics)
        self.solved: dict[str, ca.SX] = {}
        self.last: dict[str, ca.SX] = {}
        self.givers: dict[str, Row] = {}  # of each coordinate that was given up
        self.repeated: list[Row] = []
        self.absorbed: list[Row] = []

    def absorb(self, row: Row) -> bool:
        """Takes a linear row in: it gives a coordinate, or says nothing new. False for a row that must be kept."""
        gap = ca.SX(row.value(self.kinematics, 0))
        if self._is_refused(gap, row):
            return True
        if not row.is_holonomic:
            return False
        mentioned = {x.__hash__() for x in ca.symvar(gap)}
        named = [name for name, x in self.kinematics.symbols.positions.items() if x.__hash__() in mentioned]
        known = self.solved | self.last
        if known:
            gap = ca.substitute([gap], [self.kinematics.symbols.positions[n] for n in known], list(known.values()))[0]
        slopes = ca.densify(ca.jacobian(gap, self.q))
        moving = ca.vertcat(self.kinematics.algebra.state, self.kinematics.symbols.time)
        if ca.depends_on(slopes, moving):
            return False
        constant = ca.substitute(gap, self.q, ca.SX.zeros(self.q.numel()))
        sizes = [abs(float(x)) for x in self._numbers(slopes).full().ravel()]
        if max(sizes, default=0.0) <= _NEGLIGIBLE:
            self._repeat(row, constant, named)
            return True
        pivot = self._choose(sizes, slopes)
        others = slopes[:]
        others[pivot] = 0
        solution = -(constant + ca.dot(others, self.q.T)) / slopes[pivot]
        name, symbol = self.names[pivot], self.q[pivot]
        if len(self.solved) == len(self.names) - 1:  # this coordinate stays with its row: something to integrate
            self.last, self.givers[name] = {name: solution}, row
            return False
        self.absorbed.append(row)
        self.givers[name] = row
        self.solved = {n: ca.substitute(x, symbol, solution) for n, x in self.solved.items()} | {name: solution}
        return True

    def _is_refused(self, gap: ca.SX, row: Row) -> bool:
        symbols, model = self.kinematics.symbols, self.kinematics.graph.model
        accelerations = ca.vertcat(*symbols.accelerations.values())
        if ca.depends_on(gap, accelerations):
            self.report.error("L0412", "a constraint cannot depend on accelerations", row.span,
                              "constrain positions or velocities, or let a force act")
            return True
        inputs = ca.vertcat(*[x for n, v in model.variables.items() if v.kind == "input" for x in scalars_of(symbols.values[n])])
        if inputs.numel() and ca.depends_on(gap, inputs):
            self.report.error("L0904", "not supported yet: an input in a constraint", row.span, "let it act as a force")
            return True
        return False

    def _numbers(self, expression: ca.SX) -> ca.DM:
        return ca.evalf(ca.substitute(expression, self.p, self.defaults)) if self.p.numel() else ca.evalf(expression)

    def _choose(self, sizes: list[float], slopes: ca.SX) -> int:
        """The coordinate to give up: one with a coefficient of 1 and no start of its own, the last declared among equals."""
        coordinates = self.kinematics.graph.coordinates
        starts = {c.name: c.has_start for c in coordinates}
        largest = max(sizes)

        def preference(k: int) -> tuple[bool, bool, int]:
            is_unit = slopes[k].is_constant() and abs(float(slopes[k])) == 1.0
            return (not starts.get(self.names[k], False), is_unit, k)

        return max((k for k, size in enumerate(sizes) if size > 1e-6 * largest), key=preference)

    def _repeat(self, row: Row, constant: ca.SX, named: list[str]) -> None:
        """A row without coordinates, once others gave those it names: it repeats what they impose, or contradicts them."""
        experiment = self.kinematics.graph.model.experiment
        times = [experiment.start + part * (experiment.stop - experiment.start) for part in (0.0, 0.381, 0.764)]
        modes = self.kinematics.algebra.modes
        if modes:
            constant = ca.substitute([constant], [m.symbol for m in modes], [m.value for m in modes])[0]
        moments = [ca.substitute(constant, self.kinematics.symbols.time, ca.SX(t)) for t in times]
        gap = max(abs(float(self._numbers(x))) for x in moments)
        if not named and row.loop is None:
            self.report.error("L0411", "this equation says nothing about the motion", row.span,
                              "a constraint needs coordinates or frames on one of its sides")
        elif gap > 1e-9:
            what = f"the loop {row.loop.around} cannot close" if row.loop else "this equation contradicts the others"
            givers = dict.fromkeys(f"{self.givers[name].span}" for name in named if name in self.givers)
            others = [f"the other is at {', '.join(givers)}"] if len(givers) == 1 else [f"the others are at {', '.join(givers)}"]
            self.report.error("L0410", f"{what}: it misses by {gap:.3g}", row.span, "with the parameters as they are declared",
                              *others[: len(givers)])
        else:
            self.repeated.append(row)

    def reduced(self) -> Kinematics:
        if not self.solved:
            return self.kinematics
        kinematics, t = self.kinematics, self.kinematics.symbols.time
        dependents = {}
        for name, solution in self.solved.items():
            constant = ca.substitute(solution, self.q, ca.SX.zeros(self.q.numel()))
            first = ca.jacobian(constant, t)
            slopes = ca.jacobian(solution, self.q)
            terms = {self.names[k]: slopes[0, k] for k in range(self.q.numel()) if slopes.sparsity().has_nz(0, k)}
            dependents[name] = Dependent((constant, _plain(first), _plain(ca.jacobian(first, t))), terms)
        graph = kinematics.graph
        kept = tuple(c for c in graph.coordinates if c.name not in dependents)
        given = tuple(c for c in graph.coordinates if c.name in dependents)
        symbols = replace(kinematics.symbols, **{
            field: {n: s for n, s in getattr(kinematics.symbols, field).items() if n not in dependents}
            for field in ("positions", "rates", "accelerations")
        })
        return Kinematics(replace(graph, coordinates=kept, dependent_coordinates=given), symbols, kinematics.algebra, dependents)


def _plain(x: ca.SX) -> Scalar:
    """The float 0 where nothing is left, which then costs nothing."""
    return 0.0 if ca.SX(x).is_zero() else x
