"""Small motion of a compiled scene about rest or its start: linearisation, modes, frequency response."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.base.cutting import stem
from lagrangia.base.diagnostics import RunError, fail
from lagrangia.dynamics.constrained_motion import constraint_rows
from lagrangia.language.dimensions import units_of
from lagrangia.language.observables import observe
from lagrangia.language.tree import Ref
from lagrangia.study.at_rest import AtRest
from lagrangia.study.contacts_at_rest import balance, holds_at
from lagrangia.study.linearization import Linearization, no_mass
from lagrangia.study.modes import Modes, find_modes, modes_of_ways
from lagrangia.study.moving import about_motion, in_turning_axes
from lagrangia.study.probes import find_probes, unprobed, usual_probes
from lagrangia.study.response import Response, find_response
from lagrangia.study.small_motion import SmallMotion
from lagrangia.view.mechanism import Mechanism, build_mechanism

if TYPE_CHECKING:
    from lagrangia.language.flat import FlatModel

Vector = NDArray[np.float64]
ABOUT = ("equilibrium", "start")
_GOES_ON = "time goes on there: supports that move have their rates and accelerations of that moment"
_BALANCED = 1e-9  # of the forces at the point


class Study(AtRest):
    """One scene with its numbers: parameters, start values, constant inputs, and the time at which it is looked at."""

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
            return self.timely(linear, e, self.start[1])
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
        return {way: self.timely(linear, e) for way, linear in found.items()}

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
        is_rest = left <= _BALANCED * float(np.abs(R).max(initial=0.0)) and not moves and not self._is_timed_by_rows()
        if (e.m or (moves and self.turned.names)) and not is_rest:
            return about_motion(self, e, (q, v, free), pace)
        if moves and (turned := in_turning_axes(self, e, (q, v, free), pace)) is not None:
            return turned
        try:
            a = None if is_rest else np.asarray(-np.linalg.solve(M, R), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise no_mass() from None
        return self.linear_at(e, q, v, np.concatenate([lam, free[e.m:]]), 1.0, is_rest, a)

    def _is_timed_by_rows(self) -> bool:
        """Whether a loop or an equation knows the time, or its pieces."""
        kinematics = self.c.kinematics
        rows, symbols = constraint_rows(kinematics, self.c.constraints), kinematics.symbols
        modes = [mode.symbol for mode in kinematics.algebra.modes if not mode.of_attitude]
        return bool(ca.depends_on(ca.vertcat(rows.phi, rows.rate), ca.vertcat(symbols.time, symbols.tau, *modes)))

    def _shares(self, e: SmallMotion, q: Vector, v: Vector) -> Vector:
        """Of friction, which way it slips; half way where it does not."""
        slips = self.call(e.touching, q, e.multipliers(), 1.0, v)[2].ravel()
        return np.where(slips == 0, 0.5, slips > 0)

    def _require_free(self, e: SmallMotion, q: Vector, v: Vector) -> None:
        """Raises LagError L0916 where contacts or friction hold a part of what moves."""
        grip = balance(self.resting(e, 1.0).equations().look(q), 0.0).grip
        sticking = [k for k in grip.sticking if self._shares(e, q, v)[k] == 0.5]
        gaps = self.call(e.touching, q, e.multipliers(), 1.0, v)[0].ravel()
        pressing = [k for k in grip.pressing if k not in e.holds.one_way or abs(gaps[k]) <= _BALANCED * self.size]
        if names := [*(e.holds.contacts[k] for k in pressing), *(e.holds.rubs[k] for k in sticking)]:
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
    equal = [e.left for e in model.constraints if isinstance(e.right, Ref) and e.right.name == name]
    bound = [model.variables[x.name].binding for x in equal if isinstance(x, Ref)]
    return next(filter(None, units_of(model, [observe(model, name), *equal, *filter(None, bound)])), "")
