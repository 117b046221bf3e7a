"""Statics and small motion of a compiled scene in numbers: positions of rest, linearisation, modes, frequency response."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.base.checked_values import a_number
from lagrangia.base.cutting import stem
from lagrangia.base.diagnostics import RunError, fail
from lagrangia.constraints.singular_positions import told
from lagrangia.dynamics.constrained_motion import constraint_rows
from lagrangia.dynamics.equilibrium import Rest, find_all, find_rest, onto_constraints
from lagrangia.dynamics.freedom import repeated_rows
from lagrangia.frames.joints import all_reactions, reaction_ports
from lagrangia.language.consequences import refuse_felt_reactions
from lagrangia.language.delays import refuse_delays
from lagrangia.language.dimensions import unit_of
from lagrangia.language.observables import observe
from lagrangia.language.tree import Ref
from lagrangia.run.input_pieces import InputTable
from lagrangia.run.request import Values, check_parameters
from lagrangia.study.beginning import Beginning
from lagrangia.study.contacts_at_rest import Grip, balance, find_all_held, find_held, holds_at
from lagrangia.study.corners_at_rest import BENT, bends_at
from lagrangia.study.equilibria import Equilibria, Equilibrium
from lagrangia.study.linearization import Given, Linearization, TangentParts, linearization, no_mass, tangent_of, with_signals
from lagrangia.study.modes import Modes, find_modes, modes_of_ways, stability_of_ways
from lagrangia.study.moving import about_motion, in_turning_axes
from lagrangia.study.probes import Probe, find_probes, unprobed, usual_probes
from lagrangia.study.response import Response, find_response
from lagrangia.study.rest_equations import Resting, forces_of_grip, told_grip
from lagrangia.study.small_motion import DIRECTIONS, SmallMotion, build_small_motion
from lagrangia.study.turned import turned_of
from lagrangia.view.mechanism import Mechanism, build_mechanism
from lagrangia.view.statics import told_shares

if TYPE_CHECKING:
    from lagrangia.compile.pipeline import Compilation
    from lagrangia.language.flat import FlatModel

Vector = NDArray[np.float64]
Held = tuple[Rest, Grip | None]  # a position of rest, and what holds there beside constraints
ABOUT = ("equilibrium", "start")
_FROM = 24  # places from which positions of rest are looked for
_STEADY = 1e-9
_MOMENTS = (0.37, 1.71, 0.0123)
_STOPPED = ("warning[L0740]: the coefficients of small motion change with time, which was stopped at {:g} s: what moves supports "
            "or loads may make it stable or unstable, and frequencies are of that moment; lag simulate has the motion itself")
_PASSING = ("warning[L0740]: the coefficients of small motion change with time, which goes on, and are those of {:g} s: what "
            "moves supports or loads may make it stable or unstable; lag simulate has the motion itself")
_GOES_ON = "time goes on there: supports that move have their rates and accelerations of that moment"
_BALANCED = 1e-9  # of the forces at the point
_LARGE = 40  # coordinates: above, the usual search is from few starts


class Study(Beginning):
    """One scene with its numbers: parameters, start values, constant inputs, and the time at which it is looked at."""

    def __init__(self, compilation: "Compilation", values: Values, time: float | None) -> None:
        refuse_delays(compilation.flat, "rest and small motion",
                      "what is late changes what is stable, and has endlessly many modes: run it from a start beside rest "
                      "(--initial), or put a lag in its place, FirstOrder")
        refuse_felt_reactions(compilation.flat, "rest and small motion")
        self.c, self.scene, self.values = compilation, compilation.scene, values
        self.time = self.scene.start if time is None else a_number("time", time)
        if not math.isfinite(self.time):
            fail("L0702", f"the time must be a finite number, not {self.time}")
        table = compilation.functions.table
        self.p = table["parameters"](values.parameters, values.mask).full().ravel()
        check_parameters(self.scene, list(map(float, self.p)))
        self.u = InputTable(self.scene, values, self.time).at(np.array([self.time]))[:, 0]
        if self.scene.n == 0:
            fail("L0505", "nothing can move: the scene has no coordinate", compilation.flat.span,
                 "lag simulate tells the reactions of such a scene")
        self.names = tuple(c.name for c in self.scene.coordinates)
        self.is_angle = np.array([c.unit == "rad" for c in self.scene.coordinates])
        self.turned = turned_of(self.scene)

    # ------------------------------------------------------------ the equations in numbers

    def equations(self, probes: Sequence[Probe] = (), outputs: Sequence[str] = ()) -> SmallMotion:
        """Small motion with excitations at these places and these outputs beside the coordinates."""
        impacts = self.c.run.impacts
        known = self.c.kinematics.knowing(impacts.contact_forces()) if impacts.pressing else self.c.kinematics
        return build_small_motion(known, self.c.constraints, self.c.run, probes, outputs)

    def call(self, function: ca.Function, q: Vector, lam: Vector, pace: float, v: Vector | None = None, a: Vector | None = None,
             time: float | None = None, seeds: tuple[Vector, ...] = ()) -> list[Vector]:
        """Values of a function of the state at rest, or in the motion given, and its directions `seeds`."""
        still = np.zeros(self.scene.n)
        state = q, still if v is None else v, still if a is None else a, lam
        given = np.concatenate([self.u, self.references.ravel()])
        found = function.call([*state, self.time if time is None else time, pace, given, self.p, *seeds])
        return [x.full() for x in found]

    def slopes(self, e: SmallMotion, function: ca.Function, names: Sequence[str], q: Vector, lam: Vector, pace: float,
               v: Vector | None = None, a: Vector | None = None, time: float | None = None) -> dict[str, list[Vector]]:
        """The derivatives of a function's values by each of small_motion.DIRECTIONS named: a column for each of its entries."""
        directions = e.directions(*names)
        columns = self.call(function, q, lam, pace, v, a, time, seeds=(np.hstack(list(directions.values())),))
        ends = np.cumsum([x.shape[1] for x in directions.values()])[:-1]
        parts = [np.split(x, ends, axis=1) for x in columns]
        return {name: [part[k] for part in parts] for k, name in enumerate(names)}

    def tangent(self, e: SmallMotion, q: Vector, lam: Vector, pace: float, v: Vector | None = None, a: Vector | None = None,
                grip: Grip | None = None) -> tuple[TangentParts, list[int]]:
        """At a state, what holds there among the constraints, and the places of their multipliers."""
        by = self.slopes(e, e.slopes, ("a", "v", "q", "s", "ds", "dds", *(("lambda",) if grip else ())), q, lam, pace, v, a)
        M, (C, _, rates, *_), (K, J, *_), (E0, pushed, *_), E1, E2 = (by[x] for x in ("a", "v", "q", "s", "ds", "dds"))
        parts = TangentParts(M[0], C, K, J, rates, (E0, E1[0], E2[0]), pushed)
        return self.resting(e, pace).held(parts, by, grip) if grip else (parts, list(range(e.m)))

    def observed(self, e: SmallMotion, q: Vector, lam: Vector, pace: float, v: Vector | None = None, a: Vector | None = None
                 ) -> list[Vector]:
        """y, and its derivatives by q, v, a, lambda, s, s', s''."""
        by = self.slopes(e, e.observed_slopes, DIRECTIONS, q, lam, pace, v, a)
        return [*self.call(e.observed, q, lam, pace, v, a), *(x for (x,) in by.values())]

    def pace(self, e: SmallMotion) -> float:
        """1 where only loads depend on time, no contact or slip; else 0: tried at two other times, at a general state."""
        if not self.scene.notes["is_driven"] and not self._time_in_energies():
            return 1.0
        random = np.random.default_rng(2)
        q = self.start[0] + 0.1 * self.reach * random.uniform(-1, 1, self.scene.n)
        v, lam = random.uniform(-1, 1, self.scene.n), e.multipliers()
        asked = (e.unsteady, e.touching) if e.holds.contacts or e.holds.rubs else (e.unsteady,)
        here = [x for f in asked for x in self.call(f, q, lam, 1.0, v)]
        for moment in _MOMENTS:
            there = [x for f in asked for x in self.call(f, q, lam, 1.0, v, time=self.time + moment)]
            for x, y in zip(here, there, strict=True):
                if not np.abs(x - y).max(initial=0.0) <= _STEADY * max(float(np.abs(x).max(initial=0.0)), _STEADY):
                    return 0.0
        return 1.0

    def _time_in_energies(self) -> bool:
        m = self.c.motion
        return bool(ca.depends_on(ca.vertcat(m.T, m.V, m.D), m.t))

    def resting(self, e: SmallMotion, pace: float) -> Resting:
        """The equations at rest in numbers, time passing at `pace`."""
        m_h = sum(row.is_holonomic for row in self.c.constraints.rows)

        s = self.signals

        def slopes(names: Sequence[str], q: Vector, lam: Vector) -> dict[str, list[Vector]]:
            found = s.by_states(self.slopes(e, e.slopes, s.asked(names), q, lam, pace, s.steady(q)))
            if self.turned.names and "v" in found:  # rows of rates, beside forces on positions
                found["v"] = [self.turned.by_positions(x, q) if x.size else x for x in found["v"]]
            return found

        def call(f: ca.Function, q: Vector, lam: Vector) -> list[Vector]:
            first, *others = self.call(f, q, lam, pace, s.steady(q))
            return [s.held(first, q, self.first) if f is e.static else first, *others]

        return Resting(e, call, slopes, m_h, self.reach,
                       self.is_angle & ~np.isin(np.arange(self.scene.n), self.turned.all), tuple(map(tuple, self.turned.places)))

    @property
    def first(self) -> Vector:
        """From where rest is looked for: the start."""
        return self.signals.in_places(*self.start)

    # ------------------------------------------------------------ what is asked for

    def rest(self, e: SmallMotion, pace: float) -> Held:
        """The position of rest found from the start, and what holds there. Raises RunError."""
        self.require_rest(e, pace)
        resting = self.resting(e, pace)
        found: Held | None
        if e.holds.contacts or e.holds.rubs:
            found = find_held(resting.equations(), self.first)
        else:
            rest = find_rest(resting.statics(), self.first)
            found = None if rest is None else (rest, None)
        if found is None and self.signals.states and len(others := self.all_rests(e, pace, _FROM)[0]) == 1:
            return others[0]  # limits of controllers keep Newton's steps from coming there from the start
        if found is None:
            raise RunError("; ".join(["no equilibrium was found from the start values: forces stay unbalanced, or it runs away",
                                      *self._left_over(e, pace),
                                      "try other values with --initial, or look at the start itself with --about start"]))
        return found

    def _left_over(self, e: SmallMotion, pace: float) -> list[str]:
        """The force on a coordinate at the start that has most to do with what no constraint can balance, in words."""
        q = self.start[0]
        R, *pushed = (self.call(e.static, q, e.multipliers(lam), pace)[0].ravel() for lam in (np.zeros(e.m), *np.eye(e.m)))
        pushes = np.array([x - R for x in pushed]).reshape(e.m, R.size).T * self.reach[:, None]
        left = R * self.reach
        left = (left + pushes @ np.linalg.lstsq(pushes, -left, rcond=None)[0]) / self.reach if e.m else R
        k = int(np.abs(left * R).argmax())
        unit = "N.m" if self.is_angle[k] else "N"
        return [f"at the start nothing balances the {abs(R[k]):.3g} {unit} on {self.names[k]}"] if left[k] * R[k] else []

    def all_rests(self, e: SmallMotion, pace: float, most: int) -> tuple[Sequence[Held], bool]:
        """Positions of rest from so many starts, and whether there is one from the start of the scene."""
        resting = self.resting(e, pace)
        if e.holds.contacts or e.holds.rubs:
            return find_all_held(resting.equations(), self.first, most)
        found, is_reached = find_all(resting.statics(), self.first, most)
        return [(rest, None) for rest in found], is_reached

    def require_rest(self, e: SmallMotion, pace: float) -> None:
        """Raises RunError when a constraint keeps the scene moving, LagError L0916 when it would at other positions."""
        aside = self.start[0] + self.reach * np.random.default_rng(5).uniform(0.1, 0.3, self.scene.n)
        rates, other = (self.call(e.static, q, e.multipliers(), pace)[2].ravel() for q in (self.start[0], aside))
        for row, here, there in zip(self.c.constraints.rows, rates, other, strict=True):
            if not row.is_holonomic and abs(there - here) > 1e-9 * max(abs(there), abs(here)):
                fail("L0916", "not supported yet: equilibria and small motion where a constraint ties rates to positions",
                     row.span, "as 0.2[s]*der(x) = s - x of a coordinate x does: Real x(start = 0) makes it a first-order state")
        if np.abs(rates).max(initial=0.0) > 1e-12 * self.size:
            raise RunError("nothing can rest here: a constraint prescribes a speed")

    def equilibria(self, starts: int | None) -> Equilibria:
        """Positions of rest from the start and from `starts` - 1 other places."""
        graph = self.c.kinematics.graph
        outputs = [c.name for c in graph.dependent_coordinates]
        e = self.equations((), outputs)
        pace = self.pace(e)
        self.require_rest(e, pace)
        notes, asked = list[str](), all_reactions(graph)
        if asked and pace == 0.0 and self.scene.notes["is_driven"]:
            notes.append("reactions are not told while supports move")
            asked = []
        if asked and (straight := self.c.constraints.touching):
            notes.append(f"reactions are not told: {straight[0].told} only just holds, so that nothing bounds them")
            asked = []
        if asked:
            sharing = self.c.constraints.least_squares
            notes += told_shares(repeated_rows(self.c.kinematics, self.c.motion, self.c.constraints, self.c.initial,
                                               self.c.functions.table), sharing.length if sharing else None)
        full = self.equations((), (*outputs, *asked)) if asked else e
        most = starts if starts is not None else (_FROM if self.scene.n <= _LARGE else 3)
        found, is_reached = self.all_rests(e, pace, most)
        if len(found) == 1:
            self.linears_at(e, *found[0], pace)  # there is nothing else to tell where it fails
        if found and (linears := self._linears_told(e, *found[0], pace)[0]):
            notes += [x for x in self._timely(next(iter(linears.values())), e).notes if x.startswith("warning")]
        units = {name: (rate if name != own.name else own).unit for name, own, rate in
                 zip(self.signals.names, self.scene.coordinates, self.scene.rates, strict=True)}
        along = [name for name in asked if name in graph.model.variables]
        units |= {name: unit_of(graph.model, observe(graph.model, name)) for name in (*outputs, *along)}
        units |= {c.name: "" for c in self.scene.told_positions if c.name not in units}  # quaternions
        return Equilibria(self.scene.name, self.time, tuple(self._told(full, *x, pace, len(outputs)) for x in found),
                          is_reached, units, tuple(notes), reaction_ports(graph))

    def _told(self, e: SmallMotion, rest: Rest, grip: Grip | None, pace: float, n_given: int) -> Equilibrium:
        y = self.call(e.observed, rest.q, rest.multipliers, pace, self.signals.steady(rest.q))[0].ravel()
        position = dict(zip(self.signals.names, map(float, rest.q), strict=True))
        position = {k: x for k, x in position.items() if k not in self.scene.turned} | self.turned.told(rest.q, self.references)
        position |= dict(zip(e.outputs[:n_given], map(float, y[:n_given]), strict=True))
        reactions = dict(zip(e.outputs[n_given:], map(float, y[n_given:]), strict=True))
        linears, untold = self._linears_told(e, rest, grip, pace)
        kind, growth = ("unknown" if untold else "singular", math.nan) if linears is None else \
            stability_of_ways(list(linears.values()))
        eigenvalues = [complex(x) for linear in (linears or {}).values() for x in linear.eigenvalues]
        R = self.call(e.static, rest.q, rest.multipliers, pace, self.signals.steady(rest.q))[0]
        ways = tuple(name for name in linears or () if name)
        reactions = {} if rest.ways is not None and rest.ways.is_rigid else reactions  # these have no bound
        return Equilibrium(position, rest.V, kind, growth, tuple(eigenvalues), rest.n_neutral, reactions,
                           float(np.abs(R).max(initial=0.0)), ways, *forces_of_grip(e, grip), (*told_grip(e, grip), *untold))

    def _linears_told(self, e: SmallMotion, rest: Rest, grip: Grip | None, pace: float
                      ) -> tuple[dict[str, Linearization] | None, tuple[str, ...]]:
        """As `linears_at`, and the word of why there is no small motion at this position, as where motion moves no mass."""
        try:
            return self.linears_at(e, rest, grip, pace), ()
        except RunError as error:
            return None, (f"no small motion is told here: {error}",)

    def linears_at(self, e: SmallMotion, rest: Rest, grip: Grip | None, pace: float) -> dict[str, Linearization] | None:
        """About a position of rest, one of each way of moving, by their names; one without a name at an ordinary position. None
        where ways meet that linear motion does not know."""
        planes: Sequence[Vector | None] = [None]
        if rest.ways is not None:
            if rest.ways.is_open or self.turned.names:
                return None
            planes = [self.reach[:, None] * plane for plane in rest.ways.planes or (np.zeros((self.scene.n, 0)),)]
        here, q = self.centred(rest.q)
        still = self.signals.steady(q)
        return {told(plane, self.names) if plane is not None and len(planes) > 1 else "":
                here.linear_at(e, q, still, rest.multipliers, pace, True, None, plane, grip) for plane in planes}

    def linear_at(self, e: SmallMotion, q: Vector, v: Vector, lam: Vector, pace: float, is_equilibrium: bool,
                  a: Vector | None = None, plane: Vector | None = None, grip: Grip | None = None) -> Linearization:
        """About a state and its accelerations; the forces R that are left over without those are the load."""
        lam = e.multipliers(lam) if lam.size == e.m else lam
        parts, places = self.tangent(e, q, lam, pace, v, a, grip)
        tangent = tangent_of(parts, self.is_preferred, self.reach, plane, self.signals.kept_places)
        y, yq, yv, ya, yl, *ys = self.observed(e, q, lam, pace, v, a)
        residual = np.zeros(e.n) if is_equilibrium else self.call(e.static, q, lam, pace, v)[0].ravel()
        given = Given(self.scene.name, self.names, tuple(p.name for p in e.probes), e.outputs,
                      self.point(q, v), residual, is_equilibrium,
                      (y, yq, yv, ya, yl[:, places], *ys))
        found = replace(linearization(tangent, given), notes=told_grip(e, grip))
        return with_signals(found, self.scene.signals) if self.signals.states else found

    def linearize(self, about: str, excitations: Sequence[str] | None, outputs: Sequence[str] | None) -> Linearization:
        """About the equilibrium found from the start, or the start itself. Raises LagError, RunError."""
        found = self._linearized(about, excitations, outputs)
        return replace(found, notes=(*found.notes, *(unprobed(self.c.kinematics) if excitations is None else ())))

    def _linearized(self, about: str, excitations: Sequence[str] | None, outputs: Sequence[str] | None) -> Linearization:
        if about not in ABOUT:
            fail("L0702", f"a linearisation is about the equilibrium or the start, not '{about}'", None, *ABOUT)
        kinematics = self.c.kinematics
        probes = usual_probes(kinematics) if excitations is None else find_probes(kinematics, self.c.constraints, excitations)
        e = self.equations(probes, self._usual_outputs() if outputs is None else tuple(dict.fromkeys(outputs)))
        pace = self.pace(e)
        if about == "start":
            linear = self._about_start(e, pace)
            linear = linear if pace else replace(linear, notes=(*linear.notes, _GOES_ON))
            return self._timely(linear, e, self.start[1])
        found = self._linears(e, pace)
        if len(found) > 1:
            raise RunError(f"the equilibrium is a singular position, where {len(found)} ways of moving meet, and matrices are of "
                           f"one: {'; or '.join(found)}; lag modes tells the modes of each")
        return next(iter(found.values()))

    def _linears(self, e: SmallMotion, pace: float) -> dict[str, Linearization]:
        """Of each way of moving, about the equilibrium found from the start. Raises RunError where none is linear."""
        found = self.linears_at(e, *self.rest(e, pace), pace)
        if found is None:
            raise RunError("the equilibrium is a singular position, where ways of moving meet that no linear motion tells; "
                           "try other values with --initial")
        return {way: self._timely(linear, e) for way, linear in found.items()}

    def _timely(self, linear: Linearization, e: SmallMotion, v: Vector | None = None) -> Linearization:
        """With a word where its coefficients change from side to side, or with time, as supports or loads move. `v`: rates at the
        start, where time goes on; else it stands still."""
        return self.about_point(linear.point)._timely_here(linear, e, v)

    def _timely_here(self, linear: Linearization, e: SmallMotion, v: Vector | None) -> Linearization:
        word = (_STOPPED if v is None else _PASSING).format(self.time)
        q = np.array([linear.point.get(name, 0.0) for name in self.signals.names])
        N, free = linear.tangent.N, e.multipliers()
        if e.is_bent and bends_at(lambda dq, side: self._sided(e, N, q + dq, v, side), N, self.reach):
            linear = replace(linear, notes=(*linear.notes, BENT))
        if linear.free_rates:  # of a moment while time goes on: moving.py says so
            return linear
        if self._is_held_by_time:
            return replace(linear, notes=(*linear.notes, word))
        if not e.is_timed:
            return linear
        found = []
        for moment in (0.0, *_MOMENTS):
            by = self.slopes(e, e.slopes, ("a", "v", "q"), q, free, 1.0, self.signals.steady(q), time=self.time + moment)
            found.append([N.T @ by[name][0] @ N for name in ("a", "v", "q")])
        largest = [max(float(np.abs(x).max(initial=0.0)) for x in tables) for tables in zip(*found, strict=True)]
        changes = [max(float(np.abs(x - tables[0]).max(initial=0.0)) for x in tables) for tables in zip(*found, strict=True)]
        inertia, damping, stiffness = largest
        sizes = (inertia, max(damping, math.sqrt(inertia * stiffness)), stiffness)  # damping that is rounding alone is none
        if all(change <= _STEADY * max(size, 1e-300) for change, size in zip(changes, sizes, strict=True)):
            return linear
        return replace(linear, notes=(*linear.notes, word))

    @cached_property
    def _is_timed_by_rows(self) -> bool:
        """Whether a loop or an equation knows the time, or its pieces."""
        kinematics = self.c.kinematics
        rows, symbols = constraint_rows(kinematics, self.c.constraints), kinematics.symbols
        modes = [mode.symbol for mode in kinematics.algebra.modes if not mode.of_attitude]
        return bool(ca.depends_on(ca.vertcat(rows.phi, rows.rate), ca.vertcat(symbols.time, symbols.tau, *modes)))

    @cached_property
    def _is_held_by_time(self) -> bool:
        """Whether a loop or an equation that knows the time has slopes that change: a rod to a support that moves."""
        kinematics = self.c.kinematics
        q, v = (ca.vertcat(ca.SX(0, 1), *values.values()) for values in (kinematics.symbols.positions, kinematics.symbols.rates))
        rows = constraint_rows(kinematics, self.c.constraints)
        J, time = ca.jacobian(rows.rate, v), kinematics.symbols.time
        moving = ca.vertcat(q, time)
        return any(ca.depends_on(rows.phi[k], time) and ca.depends_on(J[k, :], moving) for k in range(rows.phi.numel()))

    def _sided(self, e: SmallMotion, N: Vector, q: Vector, v: Vector | None, side: bool) -> list[Vector]:
        """Forces, damping and stiffness, with rates that rest on one side."""
        v = self.signals.steady(q) if v is None else v
        slips = self.call(e.touching, q, e.multipliers(), 1.0, v)[2].ravel()
        lam = e.multipliers(shares=np.where(slips == 0, float(side), slips > 0))
        by = self.slopes(e, e.slopes, ("v", "q"), q, lam, 1.0, v)
        return [N.T @ self.call(e.static, q, lam, 1.0, v)[0], *(N.T @ by[name][0] @ N for name in ("v", "q"))]

    def _usual_outputs(self) -> tuple[str, ...]:
        """The coordinates, those that others give too, but none that is itself what excites; and the declared outputs."""
        variables = self.c.flat.variables
        prescribed = {name for name, x in self.c.kinematics.dependents.items() if not x.terms}
        others = [x.name for x in self.scene.own_outputs if not x.name.startswith("der(") and x.name not in prescribed]
        declared = [name for name, variable in variables.items() if variable.is_output]
        told = [x.name for x in self.scene.outputs if stem(x.name) in declared]
        kept = {self.scene.signals[name] for name in self.scene.kept}
        return tuple(name for name in dict.fromkeys((*self.signals.names, *(x for x in others if x not in told), *told))
                     if name not in kept)

    def _about_start(self, e: SmallMotion, pace: float) -> Linearization:
        """The exact derivatives of the motion there. Time goes on, whatever `pace` says of it at rest: supports have their rates
        and accelerations."""
        q, v = self.start
        moves = bool(np.delete(v, self.signals.places).any())
        if not moves:
            self.require_rest(e, pace)
        if e.holds.contacts or e.holds.rubs:
            if pace and not moves and (held := holds_at(self.resting(e, pace).equations(), q)) is not None:
                return self.linear_at(e, q, v, held[0].multipliers, pace, True, grip=held[1])
            self._require_free(e, q, v)
        free = e.multipliers(shares=self._shares(e, q, v))
        R = self.call(e.static, q, free, 1.0, v)[0].ravel()
        here, _ = self.tangent(e, q, free, 1.0, v)
        M, rows = here.M, here.rates
        lam = np.asarray(-np.linalg.pinv(rows.T, rcond=1e-9) @ R) if e.m else np.zeros(0)
        left = float(np.abs(R + rows.T @ lam).max(initial=0.0))
        is_rest = left <= _BALANCED * float(np.abs(R).max(initial=0.0)) and not moves and not self._is_timed_by_rows
        if (e.m or (moves and self.turned.names)) and not is_rest:
            return about_motion(self, e, (q, v, free), pace)
        if moves and (turned := in_turning_axes(self, e, (q, v, free), pace)) is not None:
            return turned
        try:
            a = None if is_rest else np.asarray(-np.linalg.solve(M, R), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise no_mass() from None
        return self.linear_at(e, q, v, np.concatenate([lam, free[e.m:]]), 1.0, is_rest, a)

    def _shares(self, e: SmallMotion, q: Vector, v: Vector) -> Vector:
        """Of friction, which way it slips; half way where it does not."""
        slips = self.call(e.touching, q, e.multipliers(), 1.0, v)[2].ravel()
        return np.where(slips == 0, 0.5, slips > 0)

    def _require_free(self, e: SmallMotion, q: Vector, v: Vector) -> None:
        """Raises LagError L0916 where contacts or friction hold a part of what moves."""
        grip = balance(self.resting(e, 1.0).equations().look(q), 0.0).grip
        sticking = [k for k in grip.sticking if self._shares(e, q, v)[k] == 0.5]
        if names := [*(e.holds.contacts[k] for k in grip.pressing), *(e.holds.rubs[k] for k in sticking)]:
            fail("L0916", "not supported yet: a linearisation about a point that is no equilibrium, where contacts or friction "
                 f"hold: {', '.join(names)}", self.c.flat.span,
                 "linearise about the equilibrium found from there: --about equilibrium")

    def modes(self, about: str, mass_normalised: bool) -> Modes:
        """Natural modes about "equilibrium" or "start"; where ways of moving meet, those of each. Raises LagError, RunError."""
        if signals := self.scene.flowing:
            fail("L0916", f"not supported yet: natural modes of scenes with first-order states: {', '.join(signals.values())}",
                 self.c.flat.span, "lag linearize tells the eigenvalues, lag response what frequencies do")
        if about == "equilibrium":
            e = self.equations()
            linears = self._linears(e, self.pace(e))
        else:
            linears = {"": self.linearize(about, (), ())}
        found = {way: find_modes(linear, self.names, self.signals.kept_places, mass_normalised, self.mechanism)
                 for way, linear in linears.items()}
        return modes_of_ways(found) if len(found) > 1 else found[""]

    @cached_property
    def closing(self) -> Callable[[Vector], Vector]:
        """Gives a position whose loops are closed, of one a little beside it; the same where there are none, or none is found."""
        loops = any(row.is_holonomic for row in self.c.constraints.rows)
        statics = self.resting(self.equations(), 0.0).statics() if loops else None

        def closed(q: Vector) -> Vector:
            found = None if statics is None else onto_constraints(statics, q, np.full(q.size, True))
            return q if found is None else found

        return closed

    @property
    def mechanism(self) -> Mechanism | None:
        """What can be drawn of the scene, of coordinates that are no discrete variables, its loops closed where a position is a
        little beside them; None in space."""
        if self.c.flat.space.is_spatial:
            return None
        frames, places = self.places
        values = {p.name: float(x) for p, x in zip(self.scene.parameters, self.p, strict=True)}
        closed, spread = self.closing, self.signals.spread
        return build_mechanism(self.c.kinematics.graph, frames, lambda q: np.asarray(places(closed(spread(q))).full()), values)

    def response(self, excitations: Sequence[str] | None, outputs: Sequence[str] | None, about: str,
                 frequencies: Sequence[float] | None, span: tuple[float, float] | None, points: int) -> Response:
        """Raises LagError L0718 where nothing excites."""
        linear = self.linearize(about, excitations, outputs)
        model = self.c.kinematics.graph.model
        if not linear.excitations:
            fail("L0718", "nothing excites this scene: it has no input, and no load depends on time", None,
                 "name what does with --from: a force (P.force[2]), or the place of a frame that hangs on the ground (road.y)")
        own = {c.name: c.unit for c in (*self.scene.coordinates, *self.scene.outputs)}
        units = tuple(own[name] if name in self.scene.turned else _unit(model, name)
                      for name in (*linear.outputs, *linear.excitations))
        return find_response(linear, frequencies, span, points, units)


def _unit(model: "FlatModel", name: str) -> str:
    """Of a variable without one, such as the `to` of a Motion, that of what an equation sets equal to it."""
    unit = unit_of(model, observe(model, name))
    equal = [e.left for e in model.constraints if isinstance(e.right, Ref) and e.right.name == name]
    bound = [model.variables[x.name].binding for x in equal if isinstance(x, Ref)]
    return unit or next((x for x in (unit_of(model, node) for node in (*equal, *bound) if node is not None) if x), "")
