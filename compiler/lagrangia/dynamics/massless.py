"""Places that move no mass, between springs, dampers and gears: where they are follows from the balance of what acts on them.

    dV/dz + dD/dz' - f_z = 0

is Lagrange's equation of a coordinate z that T does not depend on. Of springs and loads alone it is an equation between
positions, which gives z; with linear dampers one between rates, which gives z'. Both join the constraints, where the linear ones
of positions give z away. Their multipliers vanish: M a + h + J^T lambda = 0 has the balance itself in its rows of z.

Where dampers join places without mass to each other alone, some sums of balances have no rate in them (those along which the
dampers do not resist): such a sum takes the place of one of its balances.
"""

from collections.abc import Sequence
from typing import Any, NoReturn

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Scalar, rate_of
from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import symbols_in
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.assembly import begin
from lagrangia.constraints.initial import build_initial, initial_function, start_function
from lagrangia.constraints.parameters import at_declared_values, usual_parameters
from lagrangia.constraints.rows import Constraints, Row, derived, reduce_further
from lagrangia.dynamics.energies import Energies, Load, build_energies, evaluate_energies
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.graph import Coordinate
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.consequences import speaks_of_contact_forces
from lagrangia.language.events import position_of

_NOTHING = 1e-9  # of a damping, beside the largest
_LOOKS = 6  # at random rates, whether a force is linear in them
_SMALL_MASS = "give the place a small mass, or state its motion by an equation of rates: c*der(x) = k*(s - x)"


def settle_massless(kinematics: Kinematics, constraints: Constraints, energies: Energies
                    ) -> tuple[Kinematics, Constraints, Energies]:
    """The scene with the balance of what acts on places without mass; the same where there are none.

    Raises LagError L0504 for a place that nothing holds, or whose balance is none of positions or linear in rates.
    """
    names, held = _massless(kinematics, constraints, energies)
    if held:
        _require_held(kinematics, constraints, held)
    if not names:
        return kinematics, constraints, energies
    places = _Places(kinematics, energies, names)
    places.require_nothing_else()
    balances = places.balances_of_rows()
    kinematics, constraints = reduce_further(kinematics, constraints, [x.row() for x in balances], names)
    _require_all(kinematics, constraints, names)
    _require_stable(kinematics, constraints, [x for x in balances if x.is_still])
    return kinematics, constraints, build_energies(kinematics)


def _massless(kinematics: Kinematics, constraints: Constraints, energies: Energies) -> tuple[list[str], list[str]]:
    """Coordinates that T does not depend on: those that some force acts on and no constraint holds, and those that one does."""
    symbols, kinetic = kinematics.symbols, symbols_in(energies.total(energies.kinetic))
    found = [name for name in symbols.positions if _symbols_of(kinematics, name).isdisjoint(kinetic)]
    if not found:
        return [], []
    rows = symbols_in(ca.vertcat(ca.SX(0, 1), *[row.value(kinematics, 0) for row in constraints.rows]))
    pushed = symbols_in(ca.vertcat(energies.total(energies.potential), energies.total(energies.dissipation),
                                   *[x for load in energies.loads for x in load.position]))
    held = [name for name in found if not _symbols_of(kinematics, name).isdisjoint(rows)]
    return [name for name in found if name not in held and not _symbols_of(kinematics, name).isdisjoint(pushed)], held


def _require_held(kinematics: Kinematics, constraints: Constraints, names: Sequence[str]) -> None:
    """Constraints that speak of places without mass say all of where these are: what is left free has no acceleration."""
    rates = ca.vertcat(*[kinematics.symbols.rates[name] for name in names])
    slopes = ca.jacobian(ca.vertcat(*[row.rate(kinematics) for row in constraints.rows]), rates)
    ranks = [np.linalg.matrix_rank(_numbers(kinematics, [slopes], seed)[0]) for seed in range(_LOOKS)]
    if max(ranks) < len(names):
        coordinate = next(c for c in kinematics.graph.coordinates if c.name in names)
        _refuse(coordinate, "and constraints do not say all of where it is (not supported yet)", _SMALL_MASS)


def _symbols_of(kinematics: Kinematics, name: str) -> frozenset[int]:
    return frozenset(x[name].__hash__() for x in (kinematics.symbols.positions, kinematics.symbols.rates))


def _require_all(kinematics: Kinematics, constraints: Constraints, names: Sequence[str]) -> None:
    """Every one of these places was given away, or is in a row that is left."""
    left = symbols_in(ca.vertcat(ca.SX(0, 1), *[row.value(kinematics, 0) for row in constraints.rows]))
    for coordinate in kinematics.graph.coordinates:
        if coordinate.name in names and _symbols_of(kinematics, coordinate.name).isdisjoint(left):
            _refuse(coordinate, "and no spring or damper says where it is", "hold it by a spring, or give a body there a mass")


def _require_stable(kinematics: Kinematics, constraints: Constraints, balances: "Sequence[_Balance]") -> None:
    """Where the scene begins, springs bring a place without mass back: it would not stay at a maximum of the potential."""
    initial = build_initial(kinematics, constraints)
    table = {"initial": initial_function(kinematics, initial), "start": start_function(kinematics, initial)}
    start, failed = begin(kinematics, initial, table).assemble()
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
        _refuse(balances[0].coordinate, "and where the forces on it are in balance at the start they drive it away: a maximum of "
                "the potential", "begin nearer to where it is held, or give the place a small mass")


def _refuse(coordinate: Coordinate, why: str, *hints: str) -> NoReturn:
    fail("L0504", f"the coordinate '{coordinate.name}' moves no mass, {why}", coordinate.span, *(hints or (_SMALL_MASS,)))


@dataclass(frozen=True)
class _Balance:
    """A sum of what acts on places without mass, in the symbols of `base`; `factors` by their names, `is_still` without rates."""

    base: Kinematics
    coordinate: Coordinate
    value: ca.SX
    factors: tuple[tuple[str, ca.SX], ...]
    is_still: bool

    def row(self) -> Row:
        """As a constraint."""
        is_timed = self.base.symbols.time.__hash__() in symbols_in(self.value)
        return Row(self._at, self.is_still, None, self.coordinate.span, balanced=self.coordinate.name, is_timed=is_timed)

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
    """The balances of these coordinates."""

    def __init__(self, kinematics: Kinematics, energies: Energies, names: Sequence[str]) -> None:
        self.kinematics, self.energies, self.names = kinematics, energies, names
        symbols = kinematics.symbols
        self.coordinates = [c for c in kinematics.graph.coordinates if c.name in names]
        self.names = [c.name for c in self.coordinates]
        self.q, self.v = (ca.vertcat(*[values[name] for name in self.names]) for values in (symbols.positions, symbols.rates))
        self.rates = ca.vertcat(*symbols.rates.values())
        self.state = ca.vertcat(*symbols.positions.values(), self.rates)
        V, D = energies.total(energies.potential), energies.total(energies.dissipation)
        self.balances = ca.densify(ca.gradient(V, self.q) + ca.gradient(D, self.v))
        if energies.loads:
            positions = ca.vertcat(ca.SX(0, 1), *[x for load in energies.loads for x in load.position])
            forces = ca.vertcat(ca.SX(0, 1), *[x for load in energies.loads for x in load.force])
            self.balances -= ca.jtimes(positions, self.q, forces, True)

    def require_nothing_else(self) -> None:
        """Raises LagError L0504 for balances that positions and linear terms of rates do not decide."""
        kinematics, model = self.kinematics, self.kinematics.graph.model
        inputs = symbols_in(ca.vertcat(ca.SX(0, 1), *[x for name, v in model.variables.items() if v.kind == "input"
                                                      for x in scalars_of(kinematics.symbols.values[name])]))
        accelerations = symbols_in(ca.vertcat(*kinematics.symbols.accelerations.values()))
        moved = symbols_in(ca.vertcat(ca.SX(0, 1), *[x for when in model.whens for reset in when.resets for x in scalars_of(
            kinematics.evaluator.value(position_of(reset, model)))]))
        for coordinate, balance in zip(self.coordinates, self.balances.elements(), strict=True):
            mentioned = symbols_in(balance)
            if not mentioned.isdisjoint(inputs):
                _refuse(coordinate, "and an input acts on it (not supported yet)", _SMALL_MASS)
            if not mentioned.isdisjoint(kinematics.algebra.index.hashes):
                _refuse(coordinate, "and what acts on it jumps (not supported yet): it would jump, too", _SMALL_MASS)
            if not mentioned.isdisjoint(accelerations):
                _refuse(coordinate, "and a force that depends on accelerations acts on it")
            if not moved.isdisjoint(_symbols_of(kinematics, coordinate.name)) or self._is_pressed(coordinate):
                _refuse(coordinate, "and a contact or an event acts on it (not supported yet)", _SMALL_MASS)
            if not self._is_linear(balance):
                _refuse(coordinate, "and what acts on it is not linear in rates, as friction is not (not supported yet)")

    def _is_linear(self, balance: ca.SX) -> bool:
        """Whether it is linear in rates, whatever their signs."""
        if not ca.depends_on(balance, self.rates):
            return True
        slope = ca.jacobian(balance, self.rates)
        still = ca.substitute(balance, self.rates, ca.SX.zeros(self.rates.numel()))
        gap, size = balance - still - slope @ self.rates, ca.fabs(still) + ca.norm_1(slope)
        looks = [_numbers(self.kinematics, [gap, size], seed) for seed in range(_LOOKS)]
        return not ca.depends_on(slope, self.rates) and all(abs(float(a[0, 0])) <= _NOTHING * float(b[0, 0]) for a, b in looks)

    def _is_pressed(self, coordinate: Coordinate) -> bool:
        """Whether a load that depends on a contact force acts there."""
        own, model = _symbols_of(self.kinematics, coordinate.name), self.kinematics.graph.model

        def acts(load: Load) -> bool:
            return not own.isdisjoint(symbols_in(ca.vertcat(ca.SX(0, 1), *load.position)))

        return any(acts(load) and speaks_of_contact_forces(model, load.statement.force) for load in self.energies.loads)

    def balances_of_rows(self) -> list[_Balance]:
        """Of each coordinate one; those that have no rates in them first."""
        slopes = ca.jacobian(self.balances, self.rates)
        order, factors = self._eliminate(ca.densify(ca.jacobian(self.balances, self.v)), slopes)
        still = ca.substitute(self.balances, self.rates, ca.SX.zeros(self.rates.numel()))
        found = []
        for k, row in zip(order, factors, strict=True):
            parts = [(k, ca.SX(1))] if row is None else [(i, row[i]) for i in range(row.numel()) if not row[i].is_zero()]
            value = sum((factor * (self.balances if row is None else still)[i] for i, factor in parts), ca.SX(0))
            named = tuple((self.names[i], factor) for i, factor in parts)
            found.append(_Balance(self.kinematics, self.coordinates[k], value, named, row is not None))
        return found

    def _eliminate(self, damping: ca.SX, slopes: ca.SX) -> tuple[list[int], list[ca.SX | None]]:
        """Gaussian elimination of the rates: first the rows that are left without one, each with the sum of all balances that has
        none, as its factors, then those that keep their rates, with None."""
        m = len(self.names)
        sums, (C, all_of_them) = ca.SX.eye(m), _numbers(self.kinematics, [damping, slopes])
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
        for i in left:
            if np.abs(numbers[i] @ all_of_them).max(initial=0.0) > _NOTHING * scale or ca.depends_on(sums[i, :], self.state):
                _refuse(self.coordinates[i], "and dampers act on it that do not say how fast it is (not supported yet)")
        return [*left, *with_pivot], [*(_simple(sums[i, :].T) for i in left), *([None] * len(with_pivot))]


def _numbers(kinematics: Kinematics, expressions: list[ca.SX], seed: int = 1) -> list[Vector]:
    """At a general state, with parameters beside the declared ones; rates of either sign."""
    p, numbers = usual_parameters(kinematics)
    known = symbols_in(p) if p.numel() else frozenset()
    free = [x for x in ca.symvar(ca.veccat(*expressions)) if x.__hash__() not in known]
    random, rates = np.random.default_rng(seed), {x.__hash__() for x in kinematics.symbols.rates.values()}
    values = random.uniform(0.4, 1.6, len(free)) * [random.choice((-1, 1)) if x.__hash__() in rates else 1 for x in free]
    found = ca.Function("numbers", [p, ca.vertcat(ca.SX(0, 1), *free)], [ca.densify(x) for x in expressions])(numbers, values)
    return [np.array(x) for x in (found if len(expressions) > 1 else [found])]


def _simple(factors: ca.SX) -> ca.SX:
    """Quotients of equal dampings as the numbers that they are."""
    symbols = ca.symvar(factors)
    look = ca.Function("look", [ca.vertcat(ca.SX(0, 1), *symbols)], [factors])
    random = np.random.default_rng(2)
    here, there = (np.array(look(random.uniform(0.4, 1.6, len(symbols)))).ravel() for _ in range(2))
    return ca.vertcat(*[ca.SX(round(a, 9)) if abs(a - b) < 1e-12 and abs(a - round(a, 9)) < 1e-12 else factors[k]
                        for k, (a, b) in enumerate(zip(here, there, strict=True))])
