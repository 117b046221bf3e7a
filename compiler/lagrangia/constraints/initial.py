"""Start values: `start`, `fixed` and initial equations -> guesses for q and v, and what remains to be solved.

Equations of accelerations, as of a steady state, become such residuals when the motion is known (`with_motion`).

An initial equation that gives one coordinate or rate a value known from parameters is taken as that value. The others are
residuals g(q, v, p) = 0, solved by the run time from the guesses, nearest to them, values given exactly not moved.

A coordinate that others give, by a loop or a linear constraint, is a value like the others where a start is stated for it or its
rate: s, with the residuals s - s(q) and der(s) - ds/dt.
"""

from collections.abc import Iterator
from copy import copy
from dataclasses import replace

import casadi as ca

from lagrangia.algebra.duals import Scalar, value_of
from lagrangia.algebra.duals import rate_of as rate_of_dual
from lagrangia.algebra.scalars import as_expression, column, symbols_in
from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import default_parameters, input_symbols, parameter_symbols, with_declared_inputs
from lagrangia.constraints.rows import Constraints, different_sizes
from lagrangia.constraints.vanishing_sums import VanishingSums
from lagrangia.frames.evaluation import Value
from lagrangia.frames.graph import Coordinate
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import Equation, rate_of
from lagrangia.language.frame_attributes import is_velocity, known_of
from lagrangia.language.tree import Call, Flat, FrameRef, Ref

_AGREES = 1e-9  # two values of one start, in m or rad
_MOVED = 1e-3  # less is taken for the rounding of a start value


GUESS, FIXED, FREE, LOOSE = range(4)  # LAG_START_... of runtime/model/model.h


@dataclass(frozen=True)
class InitialConditions:
    """q and v in SX of the parameters, each followed by the values of `lost` coordinates; `fixed` says of each, q then v,
    whether it is a GUESS, FIXED, FREE or, where nobody guessed it, a rate that moves no mass, or a place without whose balance
    is one of positions, LOOSE; the residuals have the spans of their equations."""

    q: ca.SX
    v: ca.SX
    lost: tuple[Coordinate, ...]  # given by others, with starts of their own
    lost_q: ca.SX  # their symbols
    lost_v: ca.SX
    lost_values: ca.SX  # what they are in terms of q
    fixed: tuple[int, ...]
    residuals: ca.SX
    residual_spans: tuple[Span, ...]
    residual_loops: tuple[str, ...]  # the components along the loop that a residual closes, "" for an equation
    n_positions: int  # so many residuals come first and depend on positions alone
    steady: tuple[tuple[ca.SX, Span], ...] = ()  # residuals of accelerations, until these are known
    level: tuple[tuple[Span, str], ...] = ()  # initial equations without slopes at the guesses, with the names they speak of

    def complaint(self, k: int) -> str:
        """What is wrong when residual k is not zero."""
        loop = self.residual_loops[k]
        if loop and k >= self.n_positions:
            return f"the rates that are stated at the start do not go together in the loop {loop}"
        names = next((names for span, names in self.level if span == self.residual_spans[k]), "")
        if names:
            return ("this cannot be solved from the start values, where it is the same in all directions (start "
                    f"{names} elsewhere, on the side that is meant)")
        return f"the loop {loop} cannot close" if loop else "this cannot hold at the start"


def build_initial(kinematics: Kinematics, constraints: Constraints) -> InitialConditions:
    """Raises LagError (L06xx)."""
    return _Starts(kinematics).build(constraints)


def with_motion(initial: InitialConditions, kinematics: Kinematics, momentum: ca.SX | None, acceleration: ca.SX
                ) -> InitialConditions:
    """With what is known of the motion: which rates move no mass, and what accelerations are. `momentum`: None where all rates
    move some.

    Raises LagError L0603 for equations of accelerations that contacts decide.
    """
    if momentum is not None:
        initial = _loosen(initial, momentum, ca.vertcat(*kinematics.symbols.rates.values()))
    return _settle(initial, kinematics, acceleration)


def initial_at(time: float, kinematics: Kinematics, constraints: Constraints, momentum: ca.SX | None, acceleration: ca.SX
               ) -> InitialConditions:
    """`build_initial` and `with_motion` at another time than the start (s), where starts of what time gives count no more."""
    graph = kinematics.graph
    experiment = graph.model.experiment
    model = replace(graph.model, experiment=replace(experiment, start=time, stop=time + experiment.stop - experiment.start))
    then = copy(kinematics)
    then.graph = replace(graph, model=model, dependent_coordinates=tuple(
        c for c in graph.dependent_coordinates if kinematics.dependents[c.name].terms))
    return with_motion(build_initial(then, constraints), then, momentum, acceleration)


def _loosen(initial: InitialConditions, momentum: ca.SX, v: ca.SX) -> InitialConditions:
    """Rates that nobody guessed and that move no mass go before all others: that of a lag follows from its equation."""
    n = len(initial.fixed) // 2
    is_massless = [not moves for moves in ca.which_depends(momentum, v, 1, True)]
    loose = {n + k for k, nothing in enumerate(is_massless) if nothing and initial.fixed[n + k] == FREE}
    return replace(initial, fixed=tuple(LOOSE if k in loose else kind for k, kind in enumerate(initial.fixed)))


def _settle(initial: InitialConditions, kinematics: Kinematics, acceleration: ca.SX) -> InitialConditions:
    """Equations of accelerations as equations of positions and rates."""
    if not initial.steady:
        return initial
    symbols, model = kinematics.symbols, kinematics.graph.model
    rates = ca.vertcat(*symbols.rates.values())
    gaps = ca.substitute([gap for gap, _ in initial.steady], [ca.vertcat(*symbols.accelerations.values())],
                         kinematics.at_start([acceleration]))
    positions, moving = list[tuple[ca.SX, Span]](), list[tuple[ca.SX, Span]]()
    for gap, (_, span) in zip(gaps, initial.steady, strict=True):
        if model.whens:
            fail("L0603", "not supported yet: an initial equation of accelerations that contacts may decide", span,
                 "state the place, or the rate at which it is steady")
        (moving if ca.depends_on(gap, rates) else positions).append((gap, span))
    n, known, spans, loops = initial.n_positions, initial.residuals, initial.residual_spans, initial.residual_loops
    return replace(
        initial, residuals=ca.vertcat(known[:n], *[x for x, _ in positions], known[n:], *[x for x, _ in moving]), steady=(),
        residual_spans=(*spans[:n], *[x for _, x in positions], *spans[n:], *[x for _, x in moving]),
        residual_loops=(*loops[:n], *[""] * len(positions), *loops[n:], *[""] * len(moving)), n_positions=n + len(positions))


def start_function(kinematics: Kinematics, initial: InitialConditions) -> ca.Function:
    """p -> q, v, the values of lost coordinates behind them."""
    return ca.Function("start", [parameter_symbols(kinematics)], [initial.q, initial.v], ["p"], ["q", "v"])


def initial_function(kinematics: Kinematics, initial: InitialConditions) -> ca.Function:
    """q, v, p -> the residuals, and their gradients as columns, where these are not 0; of q, v, p, u where inputs decide."""
    positions, rates = (ca.vertcat(ca.SX(0, 1), *x.values()) for x in (kinematics.symbols.positions, kinematics.symbols.rates))
    q, v, p = ca.vertcat(positions, initial.lost_q), ca.vertcat(rates, initial.lost_v), parameter_symbols(kinematics)
    gradients = ca.jacobian(initial.residuals, ca.vertcat(q, v)).T
    arguments, labels = [q, v, p], ["q", "v", "p"]
    if kinematics.graph.model.moving_inputs or ca.depends_on(initial.residuals, input_symbols(kinematics)):
        arguments, labels = [*arguments, input_symbols(kinematics)], [*labels, "u"]
    return ca.Function("initial", arguments, [ca.densify(initial.residuals), gradients], labels, ["g", "G"])


def find_idle_starts(kinematics: Kinematics) -> Report:
    """L0608 for starts of prescribed coordinates that are none: with the parameters as declared these begin elsewhere."""
    report = Report()
    for start in _prescribed_starts(kinematics):
        if start.miss > _MOVED * max(abs(start.stated), abs(start.begins), _AGREES):
            report.warning("L0608", f"this start has no effect: '{start.name}' is given by time alone, and begins "
                           f"at {start.begins:.6g}", start.span, "leave it out")
    return report


@dataclass(frozen=True)
class _PrescribedStart:
    """Of a coordinate or a rate that time alone gives: what is stated, and where it begins, with the parameters as declared."""

    name: str
    span: Span
    is_fixed: bool
    stated: float
    begins: float

    @property
    def miss(self) -> float:
        return abs(self.stated - self.begins)


def _prescribed_starts(kinematics: Kinematics) -> Iterator[_PrescribedStart]:
    for coordinate in kinematics.graph.dependent_coordinates:
        if kinematics.dependents[coordinate.name].terms:
            continue
        here = kinematics.coordinate(coordinate.name, 1)
        for name, start, is_fixed, value in (
                (coordinate.name, coordinate.start, coordinate.is_fixed, value_of(here)),
                (coordinate.rate_name, coordinate.rate_start, coordinate.is_rate_fixed, rate_of_dual(here))):
            if start is not None:
                p, defaults = default_parameters(kinematics)
                both = kinematics.at_start([ca.SX(value), as_expression(kinematics.evaluator.value(start))])
                numbers = ca.substitute(with_declared_inputs(kinematics, both), [p], [ca.SX(defaults)])
                begins, stated = (float(ca.evalf(x)) for x in numbers)
                yield _PrescribedStart(name, start.span, is_fixed, stated, begins)


class _Starts:
    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.lost = _lost_with_starts(kinematics)
        self.coordinates = (*kinematics.graph.coordinates, *self.lost)
        self.number = {c.name: k for k, c in enumerate(self.coordinates)}
        self.n = len(self.coordinates)
        self.lost_q = ca.vertcat(*[ca.SX.sym(c.name) for c in self.lost])
        self.lost_v = ca.vertcat(*[ca.SX.sym(c.rate_name) for c in self.lost])
        self.report = Report()
        self.sums = VanishingSums(kinematics)
        symbols = kinematics.symbols
        self.moving = ca.vertcat(kinematics.algebra.state, symbols.time)
        self.state = ca.vertcat(*symbols.positions.values(), *symbols.rates.values())
        self.accelerations = ca.vertcat(ca.SX(0, 1), *symbols.accelerations.values())
        # q in 0 .. n-1, v in n .. 2n-1
        self.values: list[Scalar] = [0.0] * (2 * self.n)
        self.fixed: dict[int, Span | None] = {}
        self.residuals: list[tuple[Scalar, Span]] = []
        self.steady: list[tuple[ca.SX, Span]] = []
        self.lost_values: list[ca.SX] = []

    def build(self, constraints: Constraints) -> InitialConditions:
        for k, coordinate in enumerate(self.coordinates):
            for slot, start, is_fixed in ((k, coordinate.start, coordinate.is_fixed),
                                          (self.n + k, coordinate.rate_start, coordinate.is_rate_fixed)):
                if start is not None:
                    self._start(slot, start)
                if is_fixed:
                    self.fixed[slot] = start.span if start is not None else coordinate.span
        for equation in self.kinematics.graph.model.initial_equations:
            self._equation(equation)
        if self.kinematics.graph.model.at_rest is not None:
            self._rest(self.kinematics.graph.model.at_rest)
        for prescribed in _prescribed_starts(self.kinematics):
            if prescribed.is_fixed and prescribed.miss > _AGREES:
                self.report.error("L0601", f"'{prescribed.name}' is given two initial values", prescribed.span,
                                  f"an equation prescribes it, and differs by {prescribed.miss:.3g} at the start",
                                  "leave `fixed` out")
        level = self._level()
        self._read_lost()
        loops, closed = [""] * len(self.residuals), list[tuple[ca.SX, Span]]()
        loose = {self.number[name] for row in constraints.rows if row.is_holonomic for name in row.follows if name in self.number}
        for row in constraints.rows:
            positions = [row.value_at_start(self.kinematics)] if row.is_holonomic else []
            values = [*positions, row.rate(self.kinematics)]
            closed += [(ca.SX(value), row.span) for value in values]
            loops += [row.loop.around if row.loop else ""] * len(values)
        closed += [(value, row.span) for value, row in constraints.agreements]
        self.residuals += zip(self.kinematics.at_start([x for x, _ in closed]), [span for _, span in closed], strict=True)
        loops += [row.loop.around if row.loop else "" for _, row in constraints.agreements]
        self.report.raise_errors()
        n, rates = self.n, ca.vertcat(column(*self.kinematics.symbols.rates.values()), self.lost_v)
        freedom = tuple(LOOSE if k in loose and self._freedom(k) == FREE else self._freedom(k) for k in range(2 * n))
        moving = [ca.depends_on(ca.SX(g), rates) for g, _ in self.residuals]
        order = sorted(range(len(moving)), key=lambda k: moving[k])
        return InitialConditions(
            column(*self.values[:n]), column(*self.values[n:]), self.lost, self.lost_q, self.lost_v,
            ca.vertcat(*self.lost_values), freedom,
            ca.vertcat(*[self.residuals[k][0] for k in order]), tuple(self.residuals[k][1] for k in order),
            tuple(loops[k] for k in order), moving.count(False), tuple(self.steady), level,
        )

    def _level(self) -> tuple[tuple[Span, str], ...]:
        """Of the residuals so far, those whose slopes vanish where the search for a start begins, as those of a length 0 do."""
        symbols, kept = self.kinematics.symbols, len(self.kinematics.symbols.positions)
        if not self.residuals or not kept:
            return ()
        p, defaults = default_parameters(self.kinematics)
        guesses = ca.vertcat(*self.values[:kept], *self.values[self.n : self.n + kept])
        slopes = ca.densify(ca.jacobian(ca.vertcat(*[x for x, _ in self.residuals]), self.state))
        (slopes,) = with_declared_inputs(self.kinematics, ca.substitute([slopes], [self.state], [guesses]))
        sizes = ca.evalf(ca.substitute(slopes, p, ca.SX(defaults))).full()
        named = [(f"'{name}'", x) for name, x in symbols.positions.items()]
        named += [(f"'der({name})'", x) for name, x in symbols.rates.items()]
        found = []
        for row, (residual, span) in zip(sizes, self.residuals, strict=True):
            if not row.any():
                mentioned = symbols_in(ca.SX(residual))
                found.append((span, " or ".join([name for name, x in named if x.__hash__() in mentioned][:4])))
        return tuple(found)

    def _freedom(self, slot: int) -> int:
        """How far a start value may be moved; what nobody said anything about moves most easily."""
        coordinate = self.coordinates[slot % self.n]
        start = coordinate.start if slot < self.n else coordinate.rate_start
        return FIXED if slot in self.fixed else FREE if start is None else GUESS

    def _read_lost(self) -> None:
        """What lost coordinates are in terms of the others; those that nobody guessed begin there."""
        symbols = self.kinematics.symbols
        kept = len(symbols.positions)
        for k, coordinate in enumerate(self.lost):
            here = self.kinematics.symbol(coordinate.name, 1)
            value, rate = (self._at_start(ca.SX(part(here))) for part in (value_of, rate_of_dual))
            self.lost_values.append(value)
            for slot, told, read in ((kept + k, self.lost_q[k], value), (self.n + kept + k, self.lost_v[k], rate)):
                span = coordinate.start.span if coordinate.start is not None else coordinate.span
                self.residuals.append((told - read, span))
                if self._freedom(slot) == FREE:
                    guesses = self.values[:kept] + self.values[self.n : self.n + kept]
                    known = ca.substitute([read], [self.state], [ca.vertcat(*guesses)])
                    (self.values[slot],) = with_declared_inputs(self.kinematics, known)

    def _rest(self, span: Span) -> None:
        """Nothing moves and nothing begins to; first-order states do not change."""
        signals = {state.coordinate for state in self.kinematics.graph.model.states.values()}
        for name, acceleration in self.kinematics.symbols.accelerations.items():
            coordinate, slot = self.coordinates[self.number[name]], self.n + self.number[name]
            if name not in signals and (coordinate.rate_start is not None or slot in self.fixed):
                place = self.fixed.get(slot) or (coordinate.rate_start and coordinate.rate_start.span)
                self.report.error("L0601", f"'{coordinate.rate_name}' is given two initial values", span,
                                  f"the other is at {place}", "in equilibrium nothing moves: leave the rate out")
            elif name not in signals:
                self.fixed[slot], self.values[slot] = span, 0.0
            self.steady.append((as_expression(acceleration), span))

    def _start(self, slot: int, start: Flat) -> None:
        value = self.kinematics.evaluator.value(start)
        if isinstance(value, tuple):
            self.report.error("L0303", "a start value is one number here", start.span)
        elif self._moves(value):
            self.report.error("L0602", "a start value depends on parameters only", start.span,
                              "write an initial equation instead")
        else:
            self.values[slot] = value

    def _equation(self, equation: Equation) -> None:
        for side, other in ((equation.left, equation.right), (equation.right, equation.left)):
            slots = self._slots(side)
            if slots is None:
                continue
            values = self.kinematics.evaluator.value(other)
            parts = list(values) if isinstance(values, tuple) else [values]
            if len(parts) != len(slots):
                self.report.error("L0303", f"{_counted(len(parts))} for {_counted(len(slots))}", equation.span)
                return
            if any(self._moves(part) for part in parts):
                continue
            for slot, part in zip(slots, parts, strict=True):
                self._fix(slot, part, equation.span)
            return
        self._residual(equation)

    def _fix(self, slot: int, value: Scalar, span: Span) -> None:
        earlier = self.fixed.get(slot)
        if earlier is not None:
            coordinate = self.coordinates[slot % self.n]
            name = coordinate.name if slot < self.n else coordinate.rate_name
            self.report.error("L0601", f"'{name}' is given two initial values", span,
                              f"the other is at {earlier}", "leave one of them out")
        self.values[slot], self.fixed[slot] = value, span

    def _residual(self, equation: Equation) -> None:
        left, right = (self.kinematics.evaluator.value(side) for side in (equation.left, equation.right))
        if isinstance(left, tuple) != isinstance(right, tuple) or (isinstance(left, tuple) and len(left) != len(right)):
            self.report.error("L0303", different_sizes(left, right), equation.span)
            return
        pairs = zip(left, right, strict=True) if isinstance(left, tuple) else ((left, right),)
        for gap in (ca.SX(a - b) for a, b in pairs):
            for part in self.sums.general.parts_of(gap) or (gap,):
                self._gap(part, equation.span)

    def _gap(self, gap: ca.SX, span: Span) -> None:
        """Of a side of an equation from the other."""
        if ca.depends_on(gap, input_symbols(self.kinematics)) and not self.kinematics.graph.model.moving_inputs:
            self.report.error("L0904", "not supported yet: an input in an initial equation", span,
                              "name a parameter: the value of an input is known when the run begins")
            return
        if ca.depends_on(gap, self.accelerations):
            self.steady.append((self._at_start(gap), span))
            return
        if not ca.depends_on(gap, self.state):
            self.report.error("L0603", "this initial equation says nothing about positions or velocities", span,
                              "name a coordinate, its rate or a place: hinge.phi = 0.5; der(hinge.phi) = 2;")
        self.residuals.append((self._at_start(gap), span))

    def _at_start(self, value: ca.SX) -> ca.SX:
        return self.kinematics.at_start([value])[0]

    # ------------------------------------------------------------ what an expression names

    def _slots(self, node: Flat) -> list[int] | None:
        """Slots of q and v that a side of an equation names: phi, der(phi), w bound to der(phi), bar.center.r when it floats."""
        if isinstance(node, Ref) and not node.index:
            return self._named(node.name)
        if isinstance(node, Call) and node.function == "der" and isinstance(node.arguments[0], Ref):
            position = self.number.get(node.arguments[0].name)
            return [self.n + position] if position is not None else None
        if isinstance(node, FrameRef):
            parts = self.kinematics.graph.model.space.components
            picked = known_of(node).picked(node.index) or (len(parts),)
            numbers = [self.number.get(f"{node.name}.{parts[k].name}") if k < len(parts) else None for k in picked]
            shift = self.n if is_velocity(node.attribute) else 0
            return None if None in numbers else [k + shift for k in numbers if k is not None]
        return None

    def _named(self, name: str) -> list[int] | None:
        if name in self.number:
            return [self.number[name]]
        variable = self.kinematics.graph.model.variables[name]
        of = rate_of(variable)
        return [self.n + self.number[of]] if of in self.number else None

    def _moves(self, value: Value) -> bool:
        return isinstance(value, ca.SX) and ca.depends_on(value, self.moving)


def _lost_with_starts(kinematics: Kinematics) -> tuple[Coordinate, ...]:
    """Coordinates that loops or linear constraints give, and that a start is stated for; not those that time alone gives."""
    graph = kinematics.graph
    given = [c for c in graph.dependent_coordinates if kinematics.dependents[c.name].terms]
    return tuple(c for c in (*given, *graph.lost_coordinates) if c.has_start)


def _counted(count: int) -> str:
    return "one number" if count == 1 else f"a vector of {count}"
