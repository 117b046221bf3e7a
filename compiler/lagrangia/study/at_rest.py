"""Statics of a compiled scene in numbers: where it rests, what holds there, and how it moves beside."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.checked_values import MOST_STARTS, a_count_within
from lagrangia.base.diagnostics import RunError, fail
from lagrangia.constraints.singular_positions import told
from lagrangia.dynamics.equilibrium import Rest, find_all, find_rest
from lagrangia.dynamics.freedom import repeated_rows
from lagrangia.frames.joints import all_reactions, reaction_ports
from lagrangia.language.dimensions import units_of
from lagrangia.language.observables import observe
from lagrangia.study.contacts_at_rest import Grip, find_all_held, find_held
from lagrangia.study.equilibria import Equilibria, Equilibrium
from lagrangia.study.linearization import Linearization
from lagrangia.study.modes import stability_of_ways
from lagrangia.study.motion_numbers import MotionNumbers
from lagrangia.study.rest_equations import forces_of_grip, told_grip
from lagrangia.study.small_motion import SmallMotion
from lagrangia.view.statics import told_shares

if TYPE_CHECKING:
    pass

Vector = NDArray[np.float64]
Held = tuple[Rest, Grip | None]  # a position of rest, and what holds there beside constraints
_FROM = 24  # places from which positions of rest are looked for
_LARGE = 40  # coordinates: above, the usual search is from few starts


class AtRest(MotionNumbers):
    """Positions of rest of one scene."""

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
        """Positions of rest from the start and from `starts` - 1 other places, as many as suit the scene for None.
        Raises LagError L0702."""
        usual = _FROM if self.scene.n <= _LARGE else 3
        most = usual if starts is None else a_count_within("number of starts", starts, 1, MOST_STARTS)
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
        found, is_reached = self.all_rests(e, pace, most)
        if len(found) == 1:
            self.linears_at(e, *found[0], pace)  # there is nothing else to tell where it fails
        if found and (linears := self._linears_told(e, *found[0], pace)[0]):
            notes += [x for x in self.timely(next(iter(linears.values())), e).notes if x.startswith("warning")]
        units = {name: (rate if name != own.name else own).unit for name, own, rate in
                 zip(self.signals.names, self.scene.coordinates, self.scene.rates, strict=True)}
        told = [*outputs, *(name for name in asked if name in graph.model.variables)]
        units |= dict(zip(told, units_of(graph.model, [observe(graph.model, name) for name in told]), strict=True))
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
        eigenvalues = [complex(x) for linear in (linears or {}).values() if linear.barred is None for x in linear.eigenvalues]
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
