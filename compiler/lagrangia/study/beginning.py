"""Where a scene begins in numbers, how large it is there, and against what its attitudes are told."""

import math
from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Self

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.duals import value_of
from lagrangia.base.checked_values import a_number
from lagrangia.base.diagnostics import fail
from lagrangia.constraints.assembly import Assembly
from lagrangia.constraints.initial import FIXED, GUESS, initial_at, initial_function, start_function
from lagrangia.constraints.newton import start_equations
from lagrangia.language.attitudes import parts_of
from lagrangia.language.consequences import refuse_felt_reactions
from lagrangia.language.delays import refuse_delays
from lagrangia.run.input_pieces import InputTable
from lagrangia.run.request import Values, check_parameters
from lagrangia.study.signal_states import SignalStates
from lagrangia.study.turned import turned_of

if TYPE_CHECKING:
    from lagrangia.compile.pipeline import Compilation

Vector = NDArray[np.float64]


class Beginning:
    """`p`, `u`: parameters and inputs; `is_angle` (n,); `time`: of the start, where None is given."""

    _references: Vector | None = None  # of attitudes, where they are not those of the start

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

    @cached_property
    def signals(self) -> SignalStates:
        """The first-order states."""
        return SignalStates(self.names, self.scene.signals, self.scene.kept)

    @cached_property
    def start(self) -> tuple[Vector, Vector]:
        """Positions and rates, assembled. Raises LagError L0606 when it does not assemble."""
        (q, v), references = self._assembled, self._declared
        return self.turned.centred(q, references)[0], v

    @cached_property
    def _declared(self) -> Vector:
        """References of attitudes as parameters say, (attitudes, 4)."""
        if not self.turned.names:
            return np.zeros((0, 4))
        modes = self.c.functions.table["modes"](self.time, self.p, 0).full().ravel()
        return self.turned.declared(modes, self.scene.patterns["attitudes"][1::2])

    @property
    def references(self) -> Vector:
        """Of attitudes, (attitudes, 4): those of the start, at which nothing is turned, unless others were taken."""
        if self._references is None:
            self._references = self.turned.centred(self._assembled[0], self._declared)[1]
        return self._references

    def centred(self, q: Vector) -> tuple[Self, Vector]:
        """The same where attitudes are told against those of a position, and the position."""
        if not self.turned.names:
            return self, q
        other, _ = copy(self), (self.size, self.signals)
        found, other._references = self.turned.centred(q, self.references)
        return other, found

    def about_point(self, point: Mapping[str, float]) -> Self:
        """The same where attitudes are told against those of a point, which has them by the parts of quaternions."""
        if not self.turned.names:
            return self
        other = copy(self)
        other._references = self.turned.read(point)
        return other

    def advanced(self, q: Vector, v: Vector, moment: float) -> tuple[Self, Vector]:
        """`centred`, after so many seconds at these rates."""
        return self.centred(self.turned.advanced(q, v, moment) if self.turned.names else q + moment * v)

    def point(self, q: Vector, v: Vector) -> dict[str, float]:
        """Positions by their names, and quaternions of attitudes."""
        places = dict(zip(self.names, map(float, self.signals.in_places(q, v)), strict=True))
        if not self.turned.names:
            return places
        return {k: x for k, x in places.items() if k not in self.scene.turned} | self.turned.told(q, self.references)

    @cached_property
    def _assembled(self) -> tuple[Vector, Vector]:
        """The start, at the time that is looked at, with attitudes against those that are declared."""
        table, initial, n = self.c.functions.table, self.c.initial, self.scene.n
        if "initial" in table and self.time != self.scene.start:
            kinematics, motion = self.c.kinematics, self.c.motion
            initial = initial_at(self.time, kinematics, self.c.constraints, motion.momentum if motion.constrained else None,
                                 motion.acceleration)
            table = {**table, "initial": initial_function(kinematics, initial), "start": start_function(kinematics, initial)}
        guess = np.concatenate([x.full().ravel() for x in table["start"](self.p)])
        lost = len(initial.lost)
        others = self.values.lost or (math.nan,) * (2 * lost)
        q = self.turned.from_no_turn(np.array(self.values.q, dtype=float), self._declared)
        given = np.array([*q, *others[:lost], *self.values.v, *others[lost:]])
        is_given = np.isfinite(given)
        guess = np.where(is_given, given, guess)
        if "initial" not in table:
            return guess[:n], guess[n:]
        equations = start_equations(self.c.kinematics, initial, table)
        equations = replace(equations, p=self.p, u=None if equations.u is None else self.u)
        x, worst = Assembly(equations, np.where(is_given, FIXED, np.array(initial.fixed)), guess).assemble()
        if worst >= 0:
            fail("L0606", initial.complaint(worst), initial.residual_spans[worst],
                 "change the parameters it depends on, or the values given with --initial")
        return x[:n], x[n + lost : 2 * n + lost]

    @cached_property
    def places(self) -> tuple[tuple[str, ...], ca.Function]:
        """The frames, and their places as a function of q: (frames, SIZE) in the plane, (frames, 3) of origins in space."""
        k = self.c.kinematics
        poses = k.poses(1)
        numbers_of = attrgetter("origin" if k.graph.model.space.is_spatial else "place")
        flat = [ca.SX(value_of(x)) for pose in poses.values() for x in numbers_of(pose)]
        table = ca.reshape(ca.vertcat(*flat), -1, len(poses)).T
        m = self.c.motion
        modes = k.algebra.modes
        if modes:
            values = iter(self.references.ravel())
            table = ca.substitute(table, ca.vertcat(*[x.symbol for x in modes]),
                                  ca.vertcat(*[next(values) if x.of_attitude else x.value for x in modes]))
        numbers = [ca.SX(self.time), ca.SX(ca.DM(self.p)), ca.SX(ca.DM(self.u))]
        (table,) = ca.substitute([table], [m.t, m.p, m.u], numbers)
        return tuple(poses), ca.Function("places", [m.q], [table])

    @cached_property
    def size(self) -> float:
        """How large the scene is at its start, m; 1 where all is in one point."""
        q, _ = self.start
        places = self.places[1](q).full()[:, : self.c.flat.space.dimensions]
        lengths = np.abs(q[~self.is_angle])
        spread = float(np.ptp(places, axis=0).max(initial=0.0)) if np.isfinite(places).all() else 0.0
        return max(spread, float(lengths.max(initial=0.0))) or 1.0

    @property
    def reach(self) -> Vector:
        """Natural sizes of the coordinates (n,): 1 rad, or the size of the scene in m."""
        return np.where(self.is_angle, 1.0, self.size)

    @cached_property
    def is_preferred(self) -> tuple[bool, ...]:
        """The coordinates that the model starts itself. Attitudes of which it says nothing begin unturned, and are none."""
        attitudes = self.c.kinematics.graph.attitudes.items()
        untold = {part for name, x in attitudes if x.start is None and not x.is_fixed for part in parts_of(name)}
        kinds = self.c.initial.fixed[: self.scene.n]
        return tuple(kind in (GUESS, FIXED) and name not in untold for name, kind in zip(self.names, kinds, strict=True))
