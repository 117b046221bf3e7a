"""Small motion of a compiled scene in numbers: its equations, their derivatives, and what changes them with time."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.pointers import Pointer
from lagrangia.dynamics.constrained_motion import constraint_rows
from lagrangia.dynamics.equilibrium import onto_constraints
from lagrangia.study.beginning import Beginning
from lagrangia.study.contacts_at_rest import Grip
from lagrangia.study.corners_at_rest import BARRED, BENT, bends_at
from lagrangia.study.linearization import Given, Linearization, TangentParts, barred_by, linearization, tangent_of, with_signals
from lagrangia.study.probes import Probe
from lagrangia.study.rest_equations import Resting, told_grip
from lagrangia.study.small_motion import DIRECTIONS, SmallMotion, build_small_motion

Vector = NDArray[np.float64]
_STEADY = 1e-9
_MOMENTS = (0.37, 1.71, 0.0123)
_STOPPED = ("warning[L0740]: the coefficients of small motion change with time, which was stopped at {:g} s: what moves supports "
            "or loads may make it stable or unstable, and frequencies are of that moment; lag simulate has the motion itself")
_PASSING = ("warning[L0740]: the coefficients of small motion change with time, which goes on, and are those of {:g} s: what "
            "moves supports or loads may make it stable or unstable; lag simulate has the motion itself")


class MotionNumbers(Beginning):
    """The equations of small motion of one scene, with its parameters, inputs and time."""

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
        columns = seeds[0].shape[1] if seeds else 0
        return self._pointer(function, columns).matrices(*state, self.time if time is None else time, pace, given, self.p, *seeds)

    @cached_property
    def _pointers(self) -> dict[tuple[int, int], tuple[ca.Function, Pointer]]:
        return {}

    def _pointer(self, function: ca.Function, columns: int) -> Pointer:
        """Of the function, or of all columns of its last argument."""
        key = function.__hash__(), columns
        if key not in self._pointers:
            last = function.n_in() - 1
            whole = function.map(function.name(), "serial", columns, list(range(last)), []) if columns else function
            self._pointers[key] = function, Pointer(whole)  # a function that is gone leaves its hash to another one
        return self._pointers[key][1]

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

    @cached_property
    def closing(self) -> Callable[[Vector], Vector]:
        """Gives a position whose loops are closed, of one a little beside it; the same where there are none, or none is found."""
        loops = any(row.is_holonomic for row in self.c.constraints.rows)
        statics = self.resting(self.equations(), 0.0).statics() if loops else None

        def closed(q: Vector) -> Vector:
            found = None if statics is None else onto_constraints(statics, q, np.full(q.size, True))
            return q if found is None else found

        return closed

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
        barred = None if parts.grazed is None else barred_by(parts.grazed, tangent)
        notes = (*told_grip(e, grip), *([] if barred is None else [BARRED]))
        found = replace(linearization(tangent, given), notes=notes, barred=barred)
        return with_signals(found, self.scene.signals) if self.signals.states else found

    def timely(self, linear: Linearization, e: SmallMotion, v: Vector | None = None) -> Linearization:
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
