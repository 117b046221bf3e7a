"""FlatModel and kinematics -> the same energies and constraints in SymPy, with parameters under names that people use.

What a reader wants to see is kept as a symbol, the rest is put in. A parameter of the model itself stays. A component's
parameter follows its binding (bar.L is L); bound to a number it stays, but for 0 and for directions; bound to a formula it stays
and the formula is told beside. Loads, prescribed coordinates and user functions of time alone become given functions of time.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import field, replace
from itertools import count
from typing import Any, cast

import sympy as sp

from lagrangia.algebra.duals import Dual, Scalar, rate_of, value_of
from lagrangia.algebra.normal_form import Ring, TooLarge
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.algebra.with_sympy import TIME, Expr, SympyAlgebra, exact_throughout, slope
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import scalars
from lagrangia.constraints.rows import Constraints, Row
from lagrangia.dynamics.energies import Energies, Term, evaluate_energies
from lagrangia.frames.edges import Edge
from lagrangia.frames.evaluation import Evaluator, Value, scalars_of
from lagrangia.frames.kinematics import Dependent, Kinematics, Symbols
from lagrangia.frames.planar import ANGLES, LENGTHS, Pose
from lagrangia.language.attitudes import parts_of
from lagrangia.language.consequences import place_of_contact_forces
from lagrangia.language.events import level_of, position_of
from lagrangia.language.flat import Variable, When
from lagrangia.language.frame_attributes import COMPONENTS
from lagrangia.language.frame_steps import Step
from lagrangia.language.function_variables import FlatFunction
from lagrangia.language.mentions import nodes
from lagrangia.language.tree import Ref
from lagrangia.paper.euler_angles import Angles, ByAngles, angles_of
from lagrangia.paper.parameter_symbols import GRAVITY, Parameter, ParameterTable, ReadableEvaluator, number_of
from lagrangia.paper.turnings import Turning, turnings_of

_PRODUCTS_OF_A_SIZE = 2000


@dataclass(frozen=True)
class Given:
    """A function of time that is given: a load, a prescribed coordinate, the place of a support. `rate` and `acceleration` are
    symbols of their own unless they do not depend on time."""

    name: str
    symbol: Expr
    rate: Expr
    acceleration: Expr
    value: Expr
    what: str  # "load", "coordinate", "function" or, for small motion, "support"

    @property
    def moving(self) -> tuple[Expr, ...]:
        """Its symbols that stand for functions of time."""
        labels = (self.name, f"der({self.name})", f"der(der({self.name}))")
        return tuple(x for x, label in zip((self.symbol, self.rate, self.acceleration), labels, strict=True) if str(x) == label)


@dataclass(frozen=True)
class Event:
    """Where `level` comes to be positive, each rate of `resets` becomes what stands beside it."""

    level: Expr
    resets: tuple[tuple[Expr, Expr], ...]


@dataclass(frozen=True)
class SymbolicScene:
    """All of a scene in SymPy. Coordinates, rates and accelerations in the order of the CasADi functions."""

    kinematics: "SymbolicKinematics"
    names: tuple[str, ...]
    q: tuple[Expr, ...]
    v: tuple[Expr, ...]
    a: tuple[Expr, ...]
    t: Expr
    inputs: Mapping[str, Expr]
    parameters: tuple[Parameter, ...]
    given: tuple[Given, ...]
    dependents: Mapping[str, Expr]
    energies: Energies
    rows: tuple[Expr, ...]
    holonomic: int  # the first so many rows are positions, the others rates
    events: tuple[Event, ...] = ()
    positive: tuple[Expr, ...] = ()  # lengths that start positive, whose sizes were taken for themselves
    kept: tuple[Row, ...] = ()  # where the rows come from
    turnings: tuple[Turning, ...] = ()  # attitudes that are not written by angles

    @property
    def turned(self) -> frozenset[int]:
        """The places of coordinates that stand for small turns; their rates are angular velocities."""
        return frozenset(k for turning in self.turnings for k in turning.places)

    def directions(self, k: int) -> list[tuple[Expr, Expr]]:
        """What the k-th coordinate changes, and by how much."""
        mine = [turning.directions(k - turning.first) for turning in self.turnings if k in turning.places]
        return mine[0] if mine else [(self.q[k], sp.S.One)]

    @property
    def placed(self) -> tuple[Expr, ...]:
        """Coordinates, and parts of quaternions."""
        return (*self.q, *(part for turning in self.turnings for part in turning.parts))

    @property
    def turns(self) -> list[tuple[Expr, Expr]]:
        """Parts of quaternions and their rates."""
        return [pair for turning in self.turnings for pair in turning.paced([self.v[k] for k in turning.places])]

    @property
    def given_rates(self) -> list[tuple[Expr, Expr]]:
        """What changes by itself, and how fast: t and the given functions."""
        first = [(g.symbol, g.rate) for g in self.given]
        return [(self.t, sp.S.One), *first, *((g.rate, g.acceleration) for g in self.given if g.rate in g.moving)]

    @property
    def rates(self) -> list[tuple[Expr, Expr]]:
        """All that changes, and how fast: (q, v), (v, a), and what is given."""
        return [*zip(self.q, self.v, strict=True), *zip(self.v, self.a, strict=True), *self.turns, *self.given_rates]

    def time_rate(self, expression: Expr) -> Expr:
        """d/dt along the motion: sum (d/dq) v + (d/dv) a + d/dt."""
        return sp.Add(*(slope(expression, x) * rate for x, rate in self.rates if expression.has(x)))


def build_symbolic(kinematics: Kinematics, constraints: Constraints, is_small: bool = False, angles: str = "",
                   is_signed: bool = False) -> SymbolicScene:
    """The scene of `kinematics` (those that are left after the linear constraints) once more, in SymPy.

    For small motion the places of supports are given functions, too, and all rates of given functions symbols. `angles`: the
    sequence of axes by whose angles attitudes are written; "": by quaternions and angular velocities. `is_signed`: for programs,
    which go on where a length that starts positive changes its sign; people read |s| as s, with a word. Raises LagError L0914
    for forces that depend on a contact force.
    """
    pressing = place_of_contact_forces(kinematics.graph.model)
    if pressing is not None and not is_small:
        fail("L0914", "not supported yet: equations of forces that depend on a contact force", pressing,
             "lag simulate and FMUs know it")
    attitudes, taken = kinematics.graph.attitudes, {*kinematics.graph.model.variables, *kinematics.symbols.positions}
    known = angles_of(attitudes, angles, taken) if angles else {}
    turnings = () if angles else turnings_of(attitudes, list(kinematics.symbols.positions), taken)
    symbolic = SymbolicKinematics(kinematics, is_small=is_small, angles=known, turnings=turnings, is_signed=is_signed)
    symbolic = symbolic.reduced(constraints)
    energies = evaluate_energies(symbolic)
    kept = [row for row in constraints.rows if not row.balanced]  # a balance is Lagrange's equation of its place itself
    rows = tuple(exact_throughout(row.value(symbolic, 0)) for row in kept)
    events = () if is_small else tuple(_event(symbolic, when) for when in kinematics.graph.model.whens if when.resets)
    s = symbolic.symbols
    inputs = {label: x for v in kinematics.graph.model.variables.values() if v.kind == "input"
              for label, x in scalars(v.name, s.values[v.name])}
    q, v, a = (tuple(x.values()) for x in (s.positions, s.rates, s.accelerations))
    told = {part: name for x in turnings for part, name in zip(parts_of(x.name), x.told, strict=True)}
    names = tuple(told.get(name, name) for name in s.positions)
    return SymbolicScene(symbolic, names, q, v, a, s.time, inputs, tuple(symbolic.table.parameters.values()),
                         tuple(symbolic.given.values()), symbolic.dependent_values(), energies, rows,
                         sum(row.is_holonomic for row in kept), events, symbolic.positive(), tuple(kept), turnings)


def mapped(energies: Energies, change: Callable[[Expr], Expr]) -> Energies:
    """Every value of energies and loads, exact, changed."""
    def terms(group: tuple[Term, ...]) -> tuple[Term, ...]:
        return tuple(replace(term, value=change(exact_throughout(term.value))) for term in group)

    loads = tuple(replace(x, force=tuple(change(exact_throughout(y)) for y in x.force),
                          position=tuple(change(exact_throughout(y)) for y in x.position)) for x in energies.loads)
    return Energies(terms(energies.kinetic), terms(energies.potential), terms(energies.dissipation), loads)


def _starts_positive(variable: Variable, variables: Mapping[str, Variable]) -> bool:
    start = variable.start
    binding = variables[start.name].binding if isinstance(start, Ref) and start.name in variables else start
    number = None if binding is None else number_of(binding)
    return number is not None and number > 0


def _event(symbolic: "SymbolicKinematics", when: When) -> Event:
    evaluator, model = symbolic.evaluator, symbolic.graph.model
    resets = []
    for reset in when.resets:
        moving = scalars_of(evaluator.value(position_of(reset, model), 1))
        wanted = scalars_of(evaluator.value(reset.value))
        resets += [(exact_throughout(value_of(rate_of(x))), exact_throughout(w)) for x, w in zip(moving, wanted, strict=True)]
    return Event(exact_throughout(evaluator.value(level_of(when.condition))), tuple(resets))


# -------------------------------------------------------------------- kinematics


@dataclass
class SymbolicKinematics(ByAngles, Kinematics):
    """The kinematics of a scene in SymPy; its algebra is a SympyAlgebra. Attitudes are by three angles each, or quaternions."""

    given: dict[str, Given] = field(default_factory=dict)
    is_small: bool = False
    angles: Mapping[str, Angles] = field(default_factory=dict)
    turnings: tuple[Turning, ...] = ()
    is_signed: bool = False

    def __init__(self, base: Kinematics, positions: Iterable[str] | None = None, table: ParameterTable | None = None,
                 dependents: Mapping[str, Dependent] | None = None, given: dict[str, Given] | None = None,
                 is_small: bool = False, angles: Mapping[str, Angles] | None = None, turnings: tuple[Turning, ...] = (),
                 is_signed: bool = False) -> None:
        algebra = SympyAlgebra()
        self.angles = angles or getattr(base, "angles", {})
        self.turnings = turnings or getattr(base, "turnings", ())
        self.is_signed = is_signed or getattr(base, "is_signed", False)
        self.table = table or ParameterTable(base, algebra)
        names = list(base.symbols.positions) if positions is None else list(positions)
        written = {part: name for attitude, found in self.angles.items()
                   for part, name in zip(parts_of(attitude), found.names, strict=True)}
        names = [written.get(name, name) for name in names]
        symbols = _symbols(base, names, self.table, self.is_signed)
        symbols.attitudes.update({turning.name: turning.parts for turning in self.turnings})
        self.given = given if given is not None else {}
        self.is_small = is_small
        self.load_variables = _load_variables(base)
        super().__init__(base.graph, symbols, cast(CasadiAlgebra, algebra), dependents or {})

    def __post_init__(self) -> None:
        self.evaluator = _TimeEvaluator(self.graph.model, self.algebra, self)
        self.evaluator.kinematics = self
        self.quaternions |= {turning.name: turning.parts for turning in self.turnings}  # of s = 0, where the reference is

    def without_accelerations(self) -> "SymbolicKinematics":
        """Itself: positions and rates are the same, and SymPy does not mind the rest."""
        return self

    def reduced(self, constraints: Constraints) -> "SymbolicKinematics":
        """With the coordinates given up that the linear constraints give, solved for in SymPy."""
        lost = [c.name for c in self.graph.dependent_coordinates]
        if not lost:
            return self
        whole = SymbolicKinematics(_without_dependents(self), [*self.symbols.positions, *lost], self.table,
                                   given=self.given)
        balanced = {name: row for name, row in constraints.givers.items() if row.balanced}
        places = {name: whole.symbols.positions[name] for name in lost}
        tied = [name for name in lost if name not in balanced]
        ties = [row.value(whole, 0) for row in constraints.absorbed if not row.balanced]
        found = dict(zip(tied, _solve_linear(ties, [places[name] for name in tied]), strict=True))
        if balanced:  # of what acts on a place with all that equations tie to it
            between = SymbolicKinematics(whole, None, self.table, {}, self.given)
            between.dependents = {name: between._dependent_of(name, x) for name, x in found.items()}
            own = [name for name in lost if name in balanced]
            rows = [balanced[name].value(between, 0) for name in own]
            settled = dict(zip(own, _solve_linear(rows, [places[name] for name in own]), strict=True))
            known = {places[name]: x for name, x in settled.items()}
            found = {name: sp.expand(x.xreplace(known)) for name, x in found.items()} | settled
        reduced = SymbolicKinematics(self, None, self.table, {}, self.given, self.is_small)
        reduced.dependents = {name: reduced._dependent_of(name, found[name]) for name in lost}
        return reduced

    def _dependent_of(self, name: str, value: Expr) -> Dependent:
        slopes = {n: value.diff(q) for n, q in self.symbols.positions.items() if value.has(q)}
        constant = value.xreplace(dict.fromkeys(self.symbols.positions.values(), sp.S.Zero))
        if not slopes and constant.has(self.symbols.time):
            given = self.give(name, constant, "coordinate")
            return Dependent((given.symbol, given.rate, given.acceleration), {})
        first = self._rate(constant)
        return Dependent((constant, first, self._rate(first)), slopes)

    def positive(self) -> tuple[Expr, ...]:
        """Coordinates that were taken for their own sizes, as a distance from an origin is: they start positive."""
        sizes = cast(SympyAlgebra, self.algebra).sizes
        taken: set[Expr] = set()
        for x in sizes:
            try:
                root = Ring(_PRODUCTS_OF_A_SIZE).tidy(sp.sqrt(x))
            except TooLarge:  # no square of a coordinate
                continue
            taken |= set() if any(p.exp.is_Rational and p.exp.q == 2 for p in root.atoms(sp.Pow)) else root.free_symbols
        return tuple(q for q in self.symbols.positions.values() if q.is_positive and q in taken)

    def dependent_values(self) -> dict[str, Expr]:
        """Those that others give; a prescribed coordinate is among the given functions."""
        return {name: self.coordinate(name, 0) for name in self.dependents if name not in self.given}

    # ------------------------------------------------------------ given functions of time

    def symbol(self, name: str, level: int) -> Value | None:
        """As of other kinematics; a variable in a load that follows from time alone is a given function."""
        if name in self.load_variables:
            binding = self.graph.model.variables[name].binding
            assert binding is not None
            value = self.evaluator.value(binding, 0)
            return self._load(name, value, level) if self._is_given(value) else None
        return self.rates_of_angles(name, level) if name in self.angles else super().symbol(name, level)

    def _turned(self, pose: Any, attitude: str, is_inverse: bool, level: int) -> Any:
        if attitude in self.angles:
            return self.turned_by_angles(pose, attitude, is_inverse, level)
        return super()._turned(pose, attitude, is_inverse, level)

    def attitude(self, name: str, level: int) -> Value:
        """As of other kinematics. Raises LagError L0901 beside angles."""
        return self.attitude_by_angles(name) if self.angles else super().attitude(name, level)

    def _is_given(self, value: Value) -> bool:
        moving = {*self.symbols.positions.values(), *self.symbols.rates.values(), *self.symbols.accelerations.values(),
                  *(part for turning in self.turnings for part in turning.parts)}
        return not any(sp.sympify(x).free_symbols & moving for x in scalars_of(value))

    def _load(self, name: str, value: Value, level: int) -> Value:
        several = sum(sp.sympify(x) != 0 for x in scalars_of(value)) > 1

        def one(label: str, x: Scalar) -> Scalar:
            x = exact_throughout(x)
            if x.has(self.symbols.time) or (x.is_number and x != 0) or x.free_symbols & set(self._given_symbols()):
                given = self.give(label, x, "load")
                return self._lift(given, level)
            return x

        if not isinstance(value, tuple):
            return one(name, value)
        return tuple(one(f"{name}[{k}]" if several else name, x) for k, x in enumerate(value, 1))

    def give(self, name: str, value: Expr, what: str) -> Given:
        """A given function of this name, made when it is first asked for."""
        value = exact_throughout(value)
        if name not in self.given:
            value = value.xreplace({g.symbol: g.value for g in self.given.values()})
            first = slope(value, self.symbols.time)
            second = slope(first, self.symbols.time)
            symbols = [sp.Symbol(label, real=True) for label in (name, f"der({name})", f"der(der({name}))")]
            still = [x == 0 or not (self.is_small or x.has(self.symbols.time)) for x in (first, second)]
            rates = [x if is_still else s for x, is_still, s in zip((first, second), still, symbols[1:], strict=True)]
            self.given[name] = Given(name, symbols[0], rates[0], rates[1], value, what)
        return self.given[name]

    def follow(self, edge: Edge, pose: Pose, level: int, evaluator: Evaluator | None = None) -> Pose:
        """For small motion, with what time alone moves as given functions: road.x, arm.phi."""
        if not (self.is_small and edge.moves_with_time):
            return cast(Pose, super().follow(edge, pose, level, evaluator))
        for k, step in enumerate(edge.steps):
            amount = (evaluator or self.evaluator).value(step.amount, level)
            pose = self.along(step, self._support(edge, step, k, amount, level), pose, level)
        return pose

    def _support(self, edge: Edge, step: Step, k: int, amount: Value, level: int) -> Value:
        again = sum(other.kind == step.kind for other in edge.steps[:k])

        def one(axis: str, x: Scalar) -> Scalar:
            plain = sp.sympify(value_of(value_of(x)))
            if not plain.has(self.symbols.time) or not self._is_given(plain):
                return x
            return self._lift(self.give(f"{edge.child}.{axis}{again or ''}", plain, "support"), level)

        labels = [component.name for component in COMPONENTS]
        return tuple(map(one, labels[LENGTHS], amount)) if isinstance(amount, tuple) else one(labels[ANGLES][0], amount)

    def _given_symbols(self) -> list[Expr]:
        return [x for g in self.given.values() for x in g.moving]

    def _rate(self, value: Expr) -> Expr:
        chain = [pair for g in self.given.values() for pair in zip(g.moving, (g.rate, g.acceleration), strict=False)]
        return slope(value, self.symbols.time) + sum(slope(value, x) * r for x, r in chain if value.has(x))

    def _lift(self, given: Given, level: int) -> Scalar:
        g, g1, g2 = given.symbol, given.rate, given.acceleration
        return (g, Dual(g, g1), Dual(Dual(g, g1), Dual(g1, g2)))[level]

    def time_function(self, function: str, value: Scalar, level: int) -> Scalar:
        """The value of a user function as a given function, when it depends on time and on nothing else that changes."""
        plain = sp.sympify(value_of(value_of(value)))
        if not plain.has(self.symbols.time) or not self._is_given(plain) or plain.free_symbols & set(self._given_symbols()):
            return value
        same = [g for g in self.given.values() if g.value == exact_throughout(plain)]
        names = (f"{function}{k or ''}" for k in count())
        taken = {*self.given, *self.graph.model.variables}
        given = same[0] if same else self.give(next(n for n in names if n not in taken), plain, "function")
        return self._lift(given, level)


class _TimeEvaluator(ReadableEvaluator):
    """Keeps what a user function makes of time under the function's name."""

    kinematics: SymbolicKinematics

    def _user_function(self, function: FlatFunction, arguments: list[Value], level: int) -> Value:
        return self.kinematics.time_function(function.name, super()._user_function(function, arguments, level), level)


def _symbols(base: Kinematics, names: list[str], table: ParameterTable, is_signed: bool) -> Symbols:
    def real(name: str) -> Expr:
        return sp.Symbol(name, real=True)

    values: dict[str, Any] = {}
    for v in base.graph.model.variables.values():
        if v.kind == "parameter":
            values[v.name] = table.symbol(v.name, 0)
        elif v.kind == "input":
            values[v.name] = _shaped(v.name, v.shape)
    variables = base.graph.model.variables
    lengths = {n for n in names if n in variables and variables[n].unit == "m" and not is_signed
               and _starts_positive(variables[n], variables)}
    positions = {n: sp.Symbol(n, positive=True) if n in lengths else real(n) for n in names}
    return Symbols(TIME, sp.S.One, positions, {n: real(f"der({n})") for n in names},
                   {n: real(f"der(der({n}))") for n in names}, values)


def _shaped(name: str, shape: tuple[int, ...]) -> Value:
    if not shape:
        return sp.Symbol(name, real=True)
    return tuple(_shaped(f"{name}[{k}]", shape[1:]) for k in range(1, shape[0] + 1))


def _without_dependents(kinematics: Kinematics) -> Kinematics:
    graph = kinematics.graph
    return Kinematics(replace(graph, coordinates=(*graph.coordinates, *graph.dependent_coordinates), dependent_coordinates=()),
                      kinematics.symbols, kinematics.algebra)


def _load_variables(base: Kinematics) -> set[str]:
    variables = base.graph.model.variables
    model = base.graph.model
    roots = [*(work.force for work in model.works), *(e.value for e in model.energies if e.kind == "potential")]
    named = {node.name for root in roots for node in nodes(root) if isinstance(node, Ref)}
    return {name for name in named if variables[name].kind == "variable" and variables[name].binding is not None}


def _solve_linear(rows: list[Expr], unknowns: list[Expr]) -> list[Expr]:
    """The unknowns from as many independent linear equations, by SymPy's elimination."""
    if not unknowns:
        return []
    solved = sp.solve([exact_throughout(row) for row in rows], unknowns, dict=True)
    return [sp.expand(solved[0][x]) for x in unknowns]


__all__ = ["GRAVITY", "Given", "Parameter", "SymbolicKinematics", "SymbolicScene", "build_symbolic"]
