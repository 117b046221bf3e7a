"""Places that move no mass, between springs, dampers and gears: where they are follows from the balance of what acts on them.

    dV/dz + dD/dz' - f_z = 0

is Lagrange's equation of a coordinate z that T does not depend on. Of springs and loads alone it is an equation between
positions, which gives z; with linear dampers one between rates, which gives z'. Both join the constraints, where the linear ones
of positions give z away. Their multipliers vanish: M a + h + J^T lambda = 0 has the balance itself in its rows of z.

Places in series that share a rate, with nothing on the frame between them, are such a place together: what acts along the way in
which they go against each other is in balance (massless_directions.py).

Where dampers join places without mass to each other alone, some sums of balances have no rate in them (those along which the
dampers do not resist): such a sum takes the place of one of its balances. So it is across the line of a damper in the plane,
which turns: springs alone decide where the place is there.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Scalar, rate_of
from lagrangia.algebra.scalars import symbols_in
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.assembly import assembled
from lagrangia.constraints.initial import build_initial
from lagrangia.constraints.parameters import at_declared_values
from lagrangia.constraints.rows import Constraints, Row, derived, reduce_further
from lagrangia.dynamics.energies import Energies, Term, build_energies, evaluate_energies
from lagrangia.dynamics.massless_directions import Direction, numbers_at, refuse_attitudes, refuse_loose, shared_directions
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.consequences import speaks_of_contact_forces
from lagrangia.language.events import position_of
from lagrangia.language.space_limits import refuse_in_space
from lagrangia.language.tree import Ref

_NOTHING = 1e-9  # of a damping, beside the largest
_LOOKS = 6  # at random rates, whether a force is linear in them
_CANCELS = 1e-12  # of what several coordinates of a direction do, beside what each does
_SMALL_MASS = "give the place a small mass, or state its motion by an equation of rates: c*der(x) = k*(s - x)"
_IN_A_ROW = ("a spring in a row with a damper is a MaxwellSpring(k = ..., c = ...), one in a row with dry friction a "
             "JenkinsSpring(k = ..., F = ...)")


def settle_massless(kinematics: Kinematics, constraints: Constraints, energies: Energies
                    ) -> tuple[Kinematics, Constraints, Energies]:
    """The scene with the balance of what acts on places without mass; the same where there are none.

    Raises LagError L0504 for a place that nothing holds, or whose balance is none of positions or linear in rates.
    """
    names, held, idle = _massless(kinematics, constraints, energies)
    if idle and (constraints.rows or names):  # without constraints motion.py looks at T itself
        refuse_loose(kinematics, [c for c in kinematics.graph.coordinates if c.name in idle])
    if held:
        _require_held(kinematics, constraints, held)
    alone = [Direction.of_one(c) for c in kinematics.graph.coordinates if c.name in names]
    directions = [*alone, *shared_directions(kinematics, constraints, energies, (*names, *idle))]
    if not directions:
        return kinematics, constraints, energies
    places = _Places(kinematics, energies, directions)
    places.require_nothing_else()
    balances = places.balances_of_rows()
    places.require_all(balances)
    among = {name for direction in directions for name, _ in direction.factors}
    kinematics, constraints = reduce_further(kinematics, constraints, [x.row() for x in balances], among)
    _require_stable(kinematics, constraints, [x for x in balances if x.is_still])
    return kinematics, constraints, build_energies(kinematics)


def _massless(kinematics: Kinematics, constraints: Constraints, energies: Energies) -> tuple[list[str], list[str], list[str]]:
    """Coordinates that T does not depend on: those that some force acts on and no constraint holds, those that one does, and
    those of which nothing speaks."""
    symbols, kinetic = kinematics.symbols, energies.moving
    kept = kinematics.graph.kept_coordinates  # whose own constraints say where they are
    found = [name for name in symbols.positions if name not in kept and _symbols_of(kinematics, name).isdisjoint(kinetic)]
    if not found:
        return [], [], []
    for coordinate in kinematics.graph.coordinates:
        if coordinate.name in found:
            refuse_attitudes([(coordinate, 1.0)])
    rows = symbols_in(ca.vertcat(ca.SX(0, 1), *[row.value(kinematics, 0) for row in constraints.rows]))
    pushed = symbols_in(ca.vertcat(energies.total(energies.potential), energies.total(energies.dissipation),
                                   *[x for load in energies.loads for x in load.position]))
    held = [name for name in found if not _symbols_of(kinematics, name).isdisjoint(rows)]
    free = [name for name in found if name not in held]
    idle = [name for name in free if _symbols_of(kinematics, name).isdisjoint(pushed)]
    return [name for name in free if name not in idle], held, idle


def _require_held(kinematics: Kinematics, constraints: Constraints, names: Sequence[str]) -> None:
    """Constraints that speak of places without mass say all of where these are: what is left free has no acceleration."""
    rates = ca.vertcat(*[kinematics.symbols.rates[name] for name in names])
    slopes = ca.jacobian(ca.vertcat(*[row.rate(kinematics) for row in constraints.rows]), rates)
    ranks = [np.linalg.matrix_rank(numbers_at(kinematics, [slopes], seed)[0]) for seed in range(_LOOKS)]
    if max(ranks) < len(names):
        coordinate = next(c for c in kinematics.graph.coordinates if c.name in names)
        _refuse(Direction.of_one(coordinate), "and constraints do not say all of where it is (not supported yet)", _SMALL_MASS)


def _symbols_of(kinematics: Kinematics, name: str) -> frozenset[int]:
    return frozenset(x[name].__hash__() for x in (kinematics.symbols.positions, kinematics.symbols.rates))


def _require_stable(kinematics: Kinematics, constraints: Constraints, balances: "Sequence[_Balance]") -> None:
    """Where the scene begins, springs bring a place without mass back: it would not stay at a maximum of the potential."""
    initial = build_initial(kinematics, constraints)
    start, failed = assembled(kinematics, initial)
    if failed >= 0 or not balances:
        return
    n, symbols = len(kinematics.symbols.positions), kinematics.symbols
    state = ca.vertcat(ca.SX(0, 1), *symbols.positions.values(), *symbols.rates.values())
    slopes = [ca.horzcat(*[a.slope_along(b, kinematics) for b in balances]) for a in balances]
    found = at_declared_values(kinematics, [ca.vertcat(*slopes)])
    places = ca.SX(np.concatenate([start[:n], start[start.size // 2 :][:n]]))
    K = np.array(ca.evalf(ca.substitute(found[0], state, places)))
    worst = float(np.linalg.eigvalsh((K + K.T) / 2)[0]) if np.isfinite(K).all() else 0.0
    if worst < -_NOTHING * np.abs(K).max(initial=0.0):
        _refuse(balances[0].direction, "and where the forces on it are in balance at the start they drive it away: a maximum of "
                "the potential", "begin nearer to where it is held, or give the place a small mass")


def _refuse(direction: Direction, why: str, *hints: str) -> NoReturn:
    fail("L0504", f"{direction.told}, {why}", direction.coordinate.span, *(hints or (_SMALL_MASS,)))


@dataclass(frozen=True)
class _Balance:
    """A sum of what acts on places without mass, in the symbols of `base`; `factors` by their names, `is_still` without rates;
    `follows` those of them that no damper holds back, or all."""

    base: Kinematics
    direction: Direction
    value: ca.SX
    factors: tuple[tuple[str, ca.SX], ...]
    is_still: bool
    follows: tuple[str, ...]

    def row(self) -> Row:
        """As a constraint."""
        is_timed = self.base.symbols.time.__hash__() in symbols_in(self.value)
        coordinate, follows = self.direction.coordinate, self.follows
        return Row(self._at, self.is_still, None, coordinate.span, balanced=coordinate.name, follows=follows, is_timed=is_timed)

    def slope_along(self, other: "_Balance", kinematics: Kinematics) -> ca.SX:
        """How it grows where the places of another one move by its factors, in the symbols of these kinematics."""
        slopes = [factor * ca.gradient(self.value, self.base.symbols.positions[name]) for name, factor in other.factors]
        return self._in(kinematics, sum(slopes, ca.SX(0)))

    def _at(self, kinematics: Kinematics, level: int) -> Scalar:
        is_casadi = isinstance(kinematics.algebra, CasadiAlgebra)
        return derived(self._in(kinematics, self.value), kinematics, level) if is_casadi else self._anew(kinematics)

    def _in(self, kinematics: Kinematics, expression: ca.SX) -> ca.SX:
        """In the coordinates that are left."""
        own, known = self.base.symbols, kinematics.symbols
        gone = [name for name in own.positions if name not in known.positions]
        values = [kinematics.coordinate(name, 0) for name in gone] + [rate_of(kinematics.coordinate(name, 1)) for name in gone]
        replaced = [own.positions[name] for name in gone] + [own.rates[name] for name in gone] + [own.tau]
        return ca.substitute([expression], replaced, [ca.SX(x) for x in (*values, known.tau)])[0]

    def _anew(self, kinematics: Kinematics) -> Scalar:
        """In another algebra, whose kinematics still have the coordinates."""
        algebra: Any = kinematics.algebra
        energies, slope = evaluate_energies(kinematics), algebra.slope
        terms = [(energy.value, kinematics.symbols.positions) for energy in energies.potential]
        terms += [(energy.value, kinematics.symbols.rates) for energy in energies.dissipation if not self.is_still]
        total: Scalar = 0
        for name, factor in self.factors:
            if not factor.is_constant():
                fail("L0914", "not supported yet: equations of places without mass that uneven dampers join",
                     self.base.graph.model.span, "lag simulate and FMUs know them")
            here = sum(slope(x, of[name]) for x, of in terms)
            for load in energies.loads:
                here -= sum(force * slope(x, kinematics.symbols.positions[name])
                            for force, x in zip(load.force, load.position, strict=True))
            total += here * (1 if float(factor) == 1 else algebra.number(float(factor)))
        return algebra.at_rest(total, list(kinematics.symbols.rates.values())) if self.is_still else total


class _Places:
    """The balances of these directions."""

    def __init__(self, kinematics: Kinematics, energies: Energies, directions: Sequence[Direction]) -> None:
        self.kinematics, self.energies, self.directions = kinematics, energies, directions
        symbols = kinematics.symbols
        self.names = [name for name in symbols.positions if any(name == x for d in directions for x, _ in d.factors)]
        self.q, self.v = (ca.vertcat(*[values[name] for name in self.names]) for values in (symbols.positions, symbols.rates))
        self.rates = ca.vertcat(*symbols.rates.values())
        self.state = ca.vertcat(*symbols.positions.values(), self.rates)
        self.factors = ca.SX.zeros(len(self.names), len(directions))
        for column, direction in enumerate(directions):
            for name, factor in direction.factors:
                self.factors[self.names.index(name), column] = factor
        if any(load.is_by_rate for load in energies.loads):
            refuse_in_space(kinematics.graph.model, "massless")
        places = [x for load in energies.loads for x in load.position]
        self.moved = self._slopes_along(places, self.q)  # the places of loads
        forces = ca.vertcat(ca.SX(0, 1), *[x for load in energies.loads for x in load.force])
        ones = [ca.SX.ones(len(terms)) for terms in (energies.potential, energies.dissipation)]
        self.balances = ca.densify(
            self._slopes_along(_values(energies.potential), self.q).T @ ones[0]
            + self._slopes_along(_values(energies.dissipation), self.v).T @ ones[1] - self.moved.T @ forces)

    def _slopes_along(self, values: Sequence[Scalar], places: ca.SX) -> ca.SX:
        """How values grow along each direction, (values, directions): nothing where coordinates do so against each other."""
        slopes = ca.jacobian(ca.vertcat(ca.SX(0, 1), *values), places)
        found = slopes @ self.factors
        if all(len(direction.factors) == 1 for direction in self.directions):
            return found
        looks = [numbers_at(self.kinematics, [found, ca.fabs(slopes) @ ca.fabs(self.factors)], seed) for seed in range(_LOOKS)]
        is_there = np.any([np.abs(a) > _CANCELS * b for a, b in looks], axis=0)
        return found * ca.DM(is_there.astype(float))

    def require_nothing_else(self) -> None:
        """Raises LagError L0504 for balances that positions and linear terms of rates do not decide."""
        kinematics, model = self.kinematics, self.kinematics.graph.model
        inputs = symbols_in(ca.vertcat(ca.SX(0, 1), *[x for name, v in model.variables.items() if v.kind == "input"
                                                      for x in scalars_of(kinematics.symbols.values[name])]))
        accelerations = symbols_in(ca.vertcat(*kinematics.symbols.accelerations.values()))
        felt = symbols_in(ca.vertcat(ca.SX(0, 1), *(x for wrench in kinematics.reactions.values() for x in wrench),
                                     *kinematics.forces.values()))
        resets = [x for when in model.whens for reset in when.resets for x in scalars_of(
            kinematics.evaluator.value(position_of(reset, model)))]
        pressed = [k for load in self._pressing() for k in load]
        moved = ca.vertcat(self._slopes_along(resets, self.q), self.moved[pressed, :])
        for column, (direction, balance) in enumerate(zip(self.directions, self.balances.elements(), strict=True)):
            mentioned = symbols_in(balance)
            if not mentioned.isdisjoint(inputs):
                _refuse(direction, "and an input acts on it (not supported yet)", _SMALL_MASS)
            if not mentioned.isdisjoint(felt):
                _refuse(direction, "and a force that feels a reaction acts on it (not supported yet)", _SMALL_MASS)
            if not mentioned.isdisjoint(kinematics.algebra.index.hashes):
                _refuse(direction, "and what acts on it jumps (not supported yet): it would jump, too", _SMALL_MASS)
            if not mentioned.isdisjoint(accelerations):
                _refuse(direction, "and a force that depends on accelerations acts on it")
            if not moved[:, column].is_zero():
                _refuse(direction, "and a contact or an event acts on it (not supported yet)", _SMALL_MASS)
            if not self._is_linear(balance):
                _refuse(direction, "and what acts on it is not linear in rates, as friction is not (not supported yet)",
                        _IN_A_ROW, _SMALL_MASS)

    def _is_linear(self, balance: ca.SX) -> bool:
        """Whether it is linear in rates, whatever their signs."""
        if not ca.depends_on(balance, self.rates):
            return True
        slope = ca.jacobian(balance, self.rates)
        still = ca.substitute(balance, self.rates, ca.SX.zeros(self.rates.numel()))
        gap, size = balance - still - slope @ self.rates, ca.fabs(still) + ca.norm_1(slope)
        looks = [numbers_at(self.kinematics, [gap, size], seed) for seed in range(_LOOKS)]
        return not ca.depends_on(slope, self.rates) and all(abs(float(a[0, 0])) <= _NOTHING * float(b[0, 0]) for a, b in looks)

    def _pressing(self) -> Iterator[range]:
        """The places of loads that depend on a contact force, by their numbers."""
        first = 0
        for load in self.energies.loads:
            if speaks_of_contact_forces(self.kinematics.graph.model, load.statement.force):
                yield range(first, first + len(load.position))
            first += len(load.position)

    def require_all(self, balances: "Sequence[_Balance]") -> None:
        """Raises LagError L0504 for a direction of which the balances do not say where it is, or how fast."""
        slopes = ca.vertcat(*[ca.jacobian(x.value, self.q if x.is_still else self.v) for x in balances]) @ self.factors
        looks = [numbers_at(self.kinematics, [slopes], seed)[0] for seed in range(_LOOKS)]
        best = max(looks, key=np.linalg.matrix_rank)
        if np.linalg.matrix_rank(best) < len(self.directions):
            loose = np.abs(np.linalg.svd(best)[2][-1])
            direction = self.directions[int(np.argmax(loose > _NOTHING))]
            _refuse(direction, "and no spring or damper says where it is", *self._about(direction),
                    "hold it by a spring, or give a body there a mass")

    def _about(self, direction: Direction) -> list[str]:
        """The axes about which one joint turns along it, in words: they are parallel. None elsewhere."""
        names = [name for name, _ in direction.factors]
        for edge in self.kinematics.graph.edges:
            axes = {step.amount.name: step.axis for step in edge.steps if step.kind == "turn" and isinstance(step.amount, Ref)}
            if len(names) > 1 and axes.keys() >= {*names} and all(axis is not None for axis in axes.values()):
                told = [axis.name if isinstance(axis, Ref) else axis.span.text for axis in axes.values() if axis is not None]
                return [f"they turn about axes that are parallel: {' and '.join(told)}"]
        return []

    def balances_of_rows(self) -> list[_Balance]:
        """Of each coordinate one; those that have no rates in them first."""
        slopes = ca.jacobian(self.balances, self.rates)
        sums = self._eliminate(ca.densify(ca.jacobian(self.balances, self.v) @ self.factors), slopes)
        still = ca.substitute(self.balances, self.rates, ca.SX.zeros(self.rates.numel()))
        resisted, found = symbols_in(self.balances), []
        held_back = {name for name in self.names if self.kinematics.symbols.rates[name].__hash__() in resisted}
        for k, row, is_still in sums:
            parts = [(i, row[i]) for i in range(row.numel()) if not row[i].is_zero()]
            value = sum((factor * (still if is_still else self.balances)[i] for i, factor in parts), ca.SX(0))
            summed = sum((factor * self.factors[:, i] for i, factor in parts), ca.SX.zeros(len(self.names))).elements()
            named = tuple((name, x) for name, x in zip(self.names, summed, strict=True) if not x.is_zero())
            own = [name for name, _ in named]
            follows = tuple(name for name in own if name not in held_back) or tuple(own)
            found.append(_Balance(self.kinematics, self.directions[k], value, named, is_still, follows))
        return found

    def _eliminate(self, damping: ca.SX, slopes: ca.SX) -> list[tuple[int, ca.SX, bool]]:
        """Gaussian elimination of the rates: of each direction the sum of all balances that stands for its own, as their factors,
        and whether no rate is left in it; these come first."""
        m, whole = len(self.directions), ca.SX(damping)
        sums, (C, all_of_them) = ca.SX.eye(m), numbers_at(self.kinematics, [damping, slopes])
        scale = float(np.abs(all_of_them).max(initial=0.0))
        numbers, left, with_pivot = np.eye(m), list(range(m)), list[int]()
        while left:
            sizes = np.abs(C[left])
            k, column = np.unravel_index(int(np.argmax(sizes)), sizes.shape)
            if sizes[k, column] <= _NOTHING * scale:
                break
            pivot = left.pop(int(k))
            with_pivot.append(pivot)
            for i in left:
                if abs(C[i, column]) > _NOTHING * scale:
                    factor, number = damping[i, column] / damping[pivot, column], C[i, column] / C[pivot, column]
                    damping[i, :] -= factor * damping[pivot, :]
                    sums[i, :] -= factor * sums[pivot, :]
                    C[i] -= number * C[pivot]
                    numbers[i] -= number * numbers[pivot]
        rows = {k: ca.SX.eye(m)[:, k] for k in with_pivot} | {i: _simple(sums[i, :].T) for i in left}
        alone = set(with_pivot)
        for i in left:
            is_free = np.abs(numbers[i] @ all_of_them).max(initial=0.0) <= _NOTHING * scale
            if is_free and not ca.depends_on(sums[i, :], self.state):
                continue
            pivots = [k for k in with_pivot if abs(numbers[i, k]) > _NOTHING]
            if len(pivots) != 1 or not alone.issuperset(pivots) or not self._turn(rows, pivots[0], i, whole, slopes):
                _refuse(self.directions[i], "and dampers act on it that do not say how fast it is across their lines "
                         "(not supported yet)", _IN_A_ROW, _SMALL_MASS)
            alone.discard(pivots[0])
        return [(k, rows[k], k in left) for k in (*left, *with_pivot)]

    def _turn(self, rows: dict[int, ca.SX], k: int, i: int, damping: ca.SX, slopes: ca.SX) -> bool:
        """Along and across the line of a damper whose line turns: the rows of this pair of directions, at its angle between them.
        That turns back by pi at once somewhere, and both rows change their signs. False where there are rates across, too, and
        where one spring alone acts: pushed, it and the damper would buckle, which no position on their line tells."""
        pair = ca.vertcat(*[self.q[row] for row in range(self.q.numel()) if not self.factors[row, [k, i]].is_zero()])
        acting = sum(ca.depends_on(ca.SX(value), pair) for value in _values(self.energies.potential))
        if acting + (not self.moved[:, [k, i]].is_zero()) < 2:
            return False
        angle = ca.atan2(2 * damping[i, k], damping[k, k] - damping[i, i]) / 2
        along, across = ca.SX(damping.size1(), 1), ca.SX(damping.size1(), 1)
        along[k], along[i] = ca.cos(angle), ca.sin(angle)
        across[k], across[i] = -ca.sin(angle), ca.cos(angle)
        rows[k], rows[i] = along, across
        looks = [numbers_at(self.kinematics, [across.T @ slopes, slopes], seed) for seed in range(_LOOKS)]
        return all(np.abs(a).max(initial=0.0) <= _NOTHING * np.abs(b).max(initial=0.0) for a, b in looks)


def _values(terms: Sequence[Term]) -> list[Scalar]:
    return [term.value for term in terms]


def _simple(factors: ca.SX) -> ca.SX:
    """Quotients of equal dampings as the numbers that they are."""
    symbols = ca.symvar(factors)
    look = ca.Function("look", [ca.vertcat(ca.SX(0, 1), *symbols)], [factors])
    random = np.random.default_rng(2)
    here, there = (np.array(look(random.uniform(0.4, 1.6, len(symbols)))).ravel() for _ in range(2))
    return ca.vertcat(*[ca.SX(round(a, 9)) if abs(a - b) < 1e-12 and abs(a - round(a, 9)) < 1e-12 else factors[k]
                        for k, (a, b) in enumerate(zip(here, there, strict=True))])
