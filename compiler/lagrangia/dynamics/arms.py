"""Resets whose values have branches: numbers at random states, in every arm that what is written can take.

What a comparison, abs, min or max in a value chooses is a symbol, 0 or 1: each arm is looked at, wherever its threshold is.
Parameters choose as they are declared; time chooses together what it does at some time; what compares rates is chosen by how
fast something approaches (|b.v - x.v| is not its opposite); all else may be as it will.
"""

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from itertools import product
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import Expression, as_expression, column, operate, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, operations_in
from lagrangia.constraints.parameters import default_parameters, usual_parameters
from lagrangia.frames.kinematics import Kinematics

_RELATIONS = (ca.OP_LT, ca.OP_LE)
_CHOICES = frozenset({*_RELATIONS, ca.OP_EQ, ca.OP_NE, ca.OP_FABS, ca.OP_SIGN, ca.OP_FMIN, ca.OP_FMAX})
SAME = 1e-9  # relative difference of what is the same but for rounding
_SEEDS, _MOST_SEEDS = 2, 6  # of random states: of what is smooth, and of what may have branches
_TIMES = np.concatenate((np.geomspace(1e-6, 1e4, 2000), np.linspace(0, 20, 2001)))
SPEEDS = (1.0, *np.geomspace(1e-4, 1e4, 33))
SIZES = (1, -1, 10, -10, 100, -100)  # of walls that move
_MOST_ARMS = 64
_REACH = np.concatenate((-np.geomspace(100, 1e-3, 60), np.geomspace(1e-3, 100, 60)))  # m or rad about a random place
_PARTS, _CUTS = 32, 11  # of what is cut again and again, down to rounding
_MOST_CROSSINGS = 2
_NEAR = np.geomspace(1e-2, 1e-9, 15)  # m or rad about where a level changes
_STRAIGHT = 0.05  # relative: a level that goes on as a line
State = tuple[Vector, Vector, Vector]  # rates, all else that is known, and the arm


class Look:
    """`results` of rates v, all else that moves or is given, parameters beside those that are declared, and the choices in
    `wanted`."""

    def __init__(self, kinematics: Kinematics, v: ca.SX, results: Sequence[ca.SX], wanted: Sequence[ca.SX],
                 crossed: Sequence[ca.SX] = ()) -> None:
        """`crossed`: levels, (k,), and changes of positions along each reset, (n, r), where what changes there is looked at."""
        symbols = kinematics.symbols
        q = column(*symbols.positions.values())
        p, self.p = usual_parameters(kinematics)
        self.declared = np.array(default_parameters(kinematics)[1]).ravel()
        found, crossed = (kinematics.algebra.with_modes([*x]) for x in ((*results, *wanted), crossed))
        stated, whole = symbols_in(ca.vertcat(q, v, symbols.time, p)), ca.veccat(*found)
        others = [x for x in ca.symvar(ca.veccat(whole, *crossed)) if x.__hash__() not in stated]
        self.seeds = range(3, 3 + (_SEEDS if operations_in(whole).isdisjoint(CORNERS) else _MOST_SEEDS))
        self.expressions, self.inputs = found, [v, ca.vertcat(q, symbols.time, *others), p]
        self.time = q.numel()
        self.operations, self.differences, symbols_of = list[int](), list[ca.SX](), list[ca.SX]()
        self.groups, self.numbering = dict[tuple[int, ...], tuple[ca.SX, bool]](), Numbering()
        if len(self.seeds) == _MOST_SEEDS and any(not _CHOICES.isdisjoint(operations_in(x)) for x in found[len(results):]):
            symbols_of = self._find_choices(found[len(results):], [ca.vec(x) for x in found[:len(results)]])
        columns = [*map(ca.vec, found[:len(results)]), *self.differences]
        freed = rebuilt(columns, self.numbering, self._made) if symbols_of else columns
        chosen = column(*symbols_of)
        self.look = ca.Function("look", [*self.inputs, chosen], [
            ca.reshape(x, result.shape) for x, result in zip(freed, results, strict=False)])
        given, times = symbols_in(p), symbols_in(ca.vertcat(p, symbols.time))
        self.by_parameters, self.by_time = ([symbols_in(x) <= known for x in self.differences] for known in (given, times))
        self.by_rates = [not symbols_in(x).isdisjoint(symbols_in(v)) for x in self.differences]
        beyond = column(*freed[len(results):])
        self.beyond = ca.Function("beyond", [*self.inputs, chosen], [beyond]) if symbols_of else None
        self.crossed = ca.Function("crossed", self.inputs, crossed[:1]) if crossed else None
        self.along = ca.Function("along", self.inputs, crossed[1:])
        self.known_crossings = dict[tuple[int, int, bytes, bytes], list[tuple[Vector, bool]]]()

    def _find_choices(self, wanted: list[ca.SX], results: list[ca.SX]) -> list[ca.SX]:
        """A symbol for each threshold in `wanted`, however often and from whichever side it is asked for, in results, too."""
        noted: dict[tuple[int, ...], Expression] = {}

        def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
            if op in _CHOICES:
                noted.setdefault((op, *numbers), operands[0] - operands[1] if len(operands) > 1 else operands[0])

        rebuilt(wanted, self.numbering, note)
        own = len(noted)
        rebuilt(results, self.numbering, note)
        differences = [ca.SX(x) for x in noted.values()]
        at = ca.Function("at", self.inputs, [ca.vertcat(*differences)])
        random, given = np.random.default_rng(5), symbols_in(self.inputs[2])
        points = np.hstack([np.array(at(*(random.uniform(-1.6, 1.6, x.numel()) for x in self.inputs))) for _ in range(3)])
        known: dict[tuple[object, ...], tuple[ca.SX, float]] = {}
        made: list[ca.SX] = []
        for k, (key, x, values) in enumerate(zip(noted, differences, points, strict=True)):
            size, is_exact = np.abs(values).max(), key[0] in (ca.OP_EQ, ca.OP_NE) or symbols_in(x) <= given
            side = 1.0 if is_exact or not values[0] < 0 else -1.0
            alike = (*np.round(side*values/size, 9),) if 0 < size < np.inf else key
            name = (key if is_exact else alike)
            if name not in known and k >= own:
                continue
            if name not in known:
                known[name] = ca.SX.sym(f"arm_{len(made)}"), side
                made.append(known[name][0])
                self.operations.append(key[0])
                self.differences.append(x)
            symbol, first = known[name]
            self.groups[key] = symbol, side == first
        return made

    def _made(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        if (op, *numbers) not in self.groups:
            return None
        symbol, is_same = self.groups[op, *numbers]
        first, other = (as_expression(x) for x in ((symbol, 1 - symbol) if is_same else (1 - symbol, symbol)))
        a, b = operands if len(operands) > 1 else (operands[0], as_expression(0.0))
        match op:
            case ca.OP_FABS:
                return as_expression(a * (1 - 2*first))
            case ca.OP_SIGN:
                return as_expression(1 - 2*first)
            case ca.OP_FMIN | ca.OP_FMAX:
                a, b = (a, b) if op == ca.OP_FMIN else (b, a)
                return as_expression(operate(ca.OP_IF_ELSE_ZERO, [first, a]) + operate(ca.OP_IF_ELSE_ZERO, [other, b]))
        return first

    def where(self, p: Vector, choosing: Vector | None = None) -> "Look":
        """The same for other parameters, and others that choose."""
        found = copy(self)
        found.p, found.declared = p, self.declared if choosing is None else choosing
        return found

    def at(self, v: Vector, known: Vector, arm: Vector) -> list[Vector]:
        """The results, of their shapes."""
        return [np.array(x) for x in self.look(v, known, self.p, arm)]

    def states(self, spreads: Sequence[int] = (1,)) -> Iterator[list[State]]:
        """Random states about 1, each in all its arms; time is such a number to the power of each of `spreads`."""
        for v, known in self.places(spreads):
            yield [(v, *state) for state in self.arms(known)]

    def places(self, spreads: Sequence[int]) -> Iterator[tuple[Vector, Vector]]:
        """Rates and all else that is known of these states."""
        for seed, spread in product(self.seeds, spreads):
            random = np.random.default_rng(seed)
            v, known = (random.uniform(0.4, 1.6, x.numel()) for x in self.inputs[:2])
            known[self.time] **= spread
            yield v, known

    def crossings(self, k: int, j: int, known: Vector) -> list[tuple[Vector, bool]]:
        """As `_find_crossings` says, each looked for once."""
        key = k, j, known.tobytes(), self.p.tobytes()
        if key not in self.known_crossings:
            self.known_crossings[key] = [*self._find_crossings(k, j, known)]
        return self.known_crossings[key]

    def _find_crossings(self, k: int, j: int, known: Vector) -> Iterator[tuple[Vector, bool]]:
        """All that is known, where level k changes along reset j, each with whether it has a slope there; nothing where levels
        have the same slopes everywhere."""
        crossed = self.crossed
        if crossed is None:
            return
        step = np.zeros(known.size)
        step[:self.time] = np.array(self.along(0, known, self.p))[:, j]

        def level(distances: Vector) -> Vector:
            states = known[:, None] + np.multiply.outer(step, distances)
            shape = (1, distances.size)
            found = crossed(np.zeros((self.inputs[0].numel(), 1)), states, np.tile(self.p[:, None], shape))
            return np.asarray(np.array(found)[k])

        size = float(np.linalg.norm(step))
        if 0 < size < np.inf and (places := crossings_of(level, size)).size:
            yield from zip(known + np.multiply.outer(places, step), have_slopes(level, places, size), strict=True)

    def arms(self, known: Vector) -> Iterator[tuple[Vector, Vector]]:
        """All that is known, at times that bring them about, and arms."""
        arm = np.zeros(len(self.differences))
        for k in np.flatnonzero(self.by_parameters).tolist():
            arm[k] = self._chosen(k, known, self.declared, arm)
        for free, case in self.free_arms():
            arm[free] = case
            yield from self._at_times(known, arm)

    def free_arms(self) -> Iterator[tuple[NDArray[np.intp], Sequence[float]]]:
        """Which of them neither parameters nor time decide, and what these may be together."""
        free = np.flatnonzero(~np.array(self.by_time, dtype=bool))
        if 2**len(free) <= _MOST_ARMS:
            yield from ((free, case) for case in product((0.0, 1.0), repeat=len(free)))
        else:
            random = np.random.default_rng(7)
            yield from ((free, random.integers(0, 2, len(free)).astype(float).tolist()) for _ in range(_MOST_ARMS))

    def _at_times(self, known: Vector, arm: Vector) -> Iterator[tuple[Vector, Vector]]:
        timed = [k for k in np.flatnonzero(self.by_time).tolist() if not self.by_parameters[k]]
        if not timed or self.beyond is None:
            yield known, arm.copy()
            return
        states, arms = np.tile(known[:, None], _TIMES.size), np.tile(arm[:, None], _TIMES.size)
        states[self.time] = _TIMES
        for k in timed:
            beyond = np.array(self.beyond(np.ones((self.inputs[0].numel(), 1)), states, self.p, arms))[k]
            arms[k] = self.is_true(k, beyond)
        for place in np.unique(arms[timed], axis=1, return_index=True)[1]:
            yield states[:, place], arms[:, place]

    def _chosen(self, k: int, known: Vector, p: Vector, arm: Vector) -> float:
        assert self.beyond is not None
        v = np.ones(self.inputs[0].numel())
        return float(self.is_true(k, np.array(self.beyond(v, known, p, arm)).ravel()[k]))

    def is_true(self, k: int, beyond: Any) -> Any:
        """Whether arm k is taken, of numbers or an expression that it compares with 0."""
        match self.operations[k]:
            case ca.OP_LE:
                return beyond <= 0
            case ca.OP_EQ:
                return beyond == 0
            case ca.OP_NE:
                return beyond != 0
        return beyond < 0

    def approaches(self, v: Vector, step: Vector, pace: float, slope: Vector, state: tuple[Vector, Vector]
                   ) -> Iterator[tuple[Vector, Vector, bool]]:
        """Rates that go with a wall, those that approach it along `step`, so fast that the arm is chosen, and whether it is with
        the first, too. `pace` and `slope` are those of the gap at v; the state is all else that is known, and the arm."""
        known, arm = state
        still = v - step * (pace / np.dot(slope, step))
        if self.beyond is None or not any(self.by_rates):
            yield still, still + step, True
            return
        rates = np.flatnonzero(self.by_rates)
        for size in SIZES:
            still = size*v - step * ((pace + np.dot(slope, size*v - v)) / np.dot(slope, step))
            both = np.column_stack([still, *(still + speed*step for speed in SPEEDS)])
            shape = (1, both.shape[1])
            beyond = np.array(self.beyond(both, np.tile(known[:, None], shape), self.p, np.tile(arm[:, None], shape)))[rates]
            is_true = np.array([self.is_true(k, x) for k, x in zip(rates.tolist(), beyond, strict=True)])
            chosen = is_true == (arm[rates, None] > 0.5)
            is_level = np.abs(beyond[:, 0]) <= SAME*np.abs(beyond).max(axis=1)
            place = next(iter(np.flatnonzero(chosen[:, 1:].all(axis=0))), None)
            if place is not None:
                yield still, both[:, 1 + place], bool((chosen[:, 0] | is_level).all())


def crossings_of(level: Callable[[Vector], Vector], size: float) -> Vector:
    """Where a function changes its sign, nearest to 0; `size`: of what it is of, for a distance of 1."""
    values = level(places := _REACH / size)
    first = np.flatnonzero(values[:-1] * values[1:] < 0)
    first = first[np.argsort(np.abs(places[first]))][:_MOST_CROSSINGS]
    low, high, sign = places[first], places[first + 1], np.sign(values[first])
    rows = np.arange(first.size)
    for _ in range(_CUTS if first.size else 0):
        inner = np.linspace(low, high, _PARTS + 1, axis=1)
        place = np.argmax(np.sign(level(inner[:, 1:].ravel())).reshape(-1, _PARTS) != sign[:, None], axis=1)
        low, high = inner[rows, place], inner[rows, place + 1]
    sizes = np.abs(level(np.concatenate((low, high))).reshape(2, -1)).max(axis=0) if first.size else low
    found: Vector = high[sizes <= np.maximum(np.abs(values[first]), np.abs(values[first + 1]))]  # else they are poles
    return found


def have_slopes(level: Callable[[Vector], Vector], places: Vector, size: float) -> list[bool]:
    """Whether a function goes as a line at each of these, however near: as one on each side where it has a bend, which both rise
    or both fall."""
    steps = np.multiply.outer(((1.0, 0.25), (-1.0, -0.25)), _NEAR / size)
    rises = level((places[:, None, None, None] + steps).ravel()).reshape(-1, *steps.shape) / steps
    mean = rises.mean(axis=2)
    are_lines = (np.abs(rises - mean[:, :, None]) < _STRAIGHT * np.abs(mean[:, :, None])).all(axis=(1, 2))
    return [bool(x) for x in (are_lines & (mean[:, 0] * mean[:, 1] > 0)).any(axis=1)]
