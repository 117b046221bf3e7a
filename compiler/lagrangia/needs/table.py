"""What this scene needs of all that a general simulation does, and what it does not: the reason, the place, the cost.

Costs are operations of the accelerations, counted by building them without the thing in question.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property

import casadi as ca

from lagrangia.algebra.modes import Mode
from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.constraints.initial import InitialConditions
from lagrangia.constraints.partition import is_too_large
from lagrangia.constraints.rows import Constraints, moved_in_time
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.motion import Motion, build_motion, count_nodes, inertial_force
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.graph import Coordinate
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.planes import Plane
from lagrangia.language.moving_inputs import rate_inputs
from lagrangia.language.observables import observe
from lagrangia.needs.along_axes import Skipped, skipped_along_axes
from lagrangia.needs.conditions import find_corners
from lagrangia.needs.dependence import changes
from lagrangia.needs.islands import MOST_COORDINATES, find_islands
from lagrangia.needs.momenta import constant_momenta
from lagrangia.needs.origins import is_linear, place_of_nonlinear_term, place_of_time, place_of_world
from lagrangia.needs.spectrum import Spectrum, find_spectrum
from lagrangia.run.runtime import Solver
from lagrangia.run.scene import Scene

_MOST_COUNTED = 60  # coordinates: in larger scenes nothing is built a second time only to be counted
_MOST_NAMES = 4


@dataclass(frozen=True)
class Need:
    """`place` is the source line that decides; `cost` is of what is needed, `saving` of what is not."""

    what: str
    is_needed: bool
    why: str
    place: str = ""
    cost: str = ""
    saving: str = ""


@dataclass(frozen=True)
class _Parts:
    kinematics: Kinematics
    constraints: Constraints
    energies: Energies
    motion: Motion
    initial: InitialConditions
    scene: Scene
    given: ca.DM | None

    @property
    def symbols_of_time(self) -> ca.SX:
        return ca.vertcat(self.motion.t, *[mode.symbol for mode in self.modes])

    @property
    def modes(self) -> list[Mode]:
        """What changes at times: references of attitudes, which steps move along, do not."""
        return [mode for mode in self.kinematics.algebra.modes if not mode.of_attitude]

    @cached_property
    def moved(self) -> list[tuple[str, Span]]:
        """Frames and coordinates that are moved in time."""
        supports = [(edge.child, edge.span) for edge in self.kinematics.graph.edges if edge.moves_with_time]
        return supports + moved_in_time(self.kinematics, self.constraints)

    @cached_property
    def inertia(self) -> ca.SX:
        """M v."""
        [momentum], v = self.kinematics.unturned([self.motion.momentum]), self.motion.v
        return momentum - ca.substitute(momentum, v, ca.SX.zeros(v.numel()))

    @cached_property
    def turning(self) -> list[Coordinate]:
        """The coordinates on whose values M depends; of many, whether there is one."""
        motion, coordinates, inertia = self.motion, list(self.kinematics.graph.coordinates), self.inertia
        if not coordinates:
            return []
        if len(coordinates) > _MOST_COUNTED:
            return coordinates[:1] if changes(inertia, [motion.q], inertia)[0] else []
        felt = changes(inertia, ca.vertsplit(motion.q), inertia)
        return [coordinate for coordinate, is_felt in zip(coordinates, felt, strict=True) if is_felt]

    def operations(self, energies: Energies) -> int | None:
        """Operations of the accelerations of the same scene with other energies; None where counting would take too long."""
        if self.scene.n > _MOST_COUNTED:
            return None
        return self.count(build_motion(self.kinematics, energies, self.constraints).acceleration)

    def count(self, acceleration: ca.SX) -> int:
        return count_nodes([ca.SX(acceleration)], [self.kinematics.algebra.state, self.motion.t])


def find_needs(
    kinematics: Kinematics, constraints: Constraints, energies: Energies, motion: Motion, initial: InitialConditions,
    scene: Scene, given: ca.DM | None = None,
) -> tuple[Need, ...]:
    """The table of needs, read off the equations. `given`: all parameters, where they are not as declared; only what is told
    of the rates at the start depends on their values."""
    parts = _Parts(kinematics, constraints, energies, motion, initial, scene, given)
    sections = (_space, _forces, _mass, _constraints, _time, _numerics, _products)
    return tuple(need for section in sections for need in section(parts))


# -------------------------------------------------------------------- forces


def _space(parts: _Parts) -> Iterable[Need]:
    """Of a scene in space, the statement that says so."""
    graph = parts.kinematics.graph
    found, plane = graph.model.found, graph.plane
    if not found.space.is_spatial:
        return
    yield Need("space", True, f"three dimensions, since {found.why}", _line(found.span))
    if isinstance(plane, Plane):
        yield Need("motion across a plane", False, "all that turns does so about parallel axes, and nothing shifts along them: "
                   "the equations are those of the plane", _line(plane.span), saving="three of six numbers a body")
    elif plane is not None:
        yield Need("motion across a plane", True, plane.why, _line(plane.span))
    if parts.scene.n <= _MOST_COUNTED:
        yield from map(_along_axes, skipped_along_axes(parts.kinematics, parts.energies, parts.motion, parts.count))


def _along_axes(skipped: Skipped) -> Need:
    """What products of zeros save where axes, centres and inertias are special, beside a tree that could have any."""
    whole, general = skipped.operations
    saved = f"{max(0, general - whole)} of {general} operations"
    needing, count = [name for name, _ in skipped.needing], skipped.count
    if not needing:
        return Need(skipped.what, False, f"all {count} are {skipped.otherwise}" if count > 1 else f"it is {skipped.otherwise}",
                    saving=saved)
    others = count - len(needing)
    why = f"; {others} of {count} {'is' if others == 1 else 'are'} {skipped.otherwise}" if others else ""
    why += f"; what falls away all the same saves {saved}" if general > whole else ""
    return Need(skipped.what, True, _few(needing) + why, _line(skipped.needing[0][1]))


def _forces(parts: _Parts) -> Iterable[Need]:
    energies, motion = parts.energies, parts.motion
    whole = parts.count(motion.acceleration)
    without = parts.operations(replace(energies, dissipation=()))
    yield _listed("dissipation", [(t.component, t.statement.span) for t in energies.dissipation], "no component states one",
                  _share(whole, without), "dD/dv, its power and its quadrature")
    gravity = ca.vertcat(*scalars_of(parts.kinematics.symbols.values["world.gravity"]))
    heavy = [t for t in energies.potential if ca.depends_on(ca.SX(t.value), gravity)]
    nothing = ca.SX.zeros(gravity.numel())
    light = tuple(replace(t, value=ca.substitute([ca.SX(t.value)], [gravity], [nothing])[0]) for t in energies.potential)
    world = place_of_world(parts.kinematics)
    is_off = all(isinstance(x, float) and x == 0 for x in parts.kinematics.symbols.compiled.get("world.gravity", (None,)))
    weights = _listed("gravity", [(t.component, t.statement.span) for t in heavy],
                      "world.gravity is zero" if is_off else "nothing has weight",
                      _share(whole, parts.operations(replace(energies, potential=light)) if heavy else whole), "the weights")
    yield replace(weights, place=str(world)) if world and (heavy or is_off) else weights
    yield _listed("sources", [(w.statement.component, w.statement.span) for w in energies.loads], "no force or torque is applied",
                  _share(whole, parts.operations(replace(energies, loads=()))), "the virtual work of applied forces")
    yield _coriolis(parts)


def _coriolis(parts: _Parts) -> Need:
    """What T gives besides M dv/dt: looked for in T alone, where no spring or damper hides it."""
    motion, what = parts.motion, "Coriolis terms"
    alone = replace(parts.energies, potential=(), loads=())
    force = inertial_force(parts.kinematics, alone, motion.bodies, motion.q, motion.v)
    force, momentum = parts.kinematics.unturned([force, motion.momentum])
    of_place, of_rate = changes(force, [motion.q, motion.v], momentum) if parts.scene.n else (False, False)
    if not (of_place or of_rate):
        return Need(what, False, "no inertial force depends on position or rates", saving="dM/dt v - dT/dq")
    if parts.turning:
        return Need(what, True, "M changes with position: centrifugal and Coriolis forces", str(parts.turning[0].span),
                    _coriolis_cost(parts))
    free = next((c for c in parts.kinematics.graph.coordinates if c.attitude), None)
    if free is not None and not parts.moved:
        return Need(what, True, f"the axes of '{free.attitude}' turn along: w x dT/dw", str(free.span), _coriolis_cost(parts))
    why = f"prescribed motion gives inertial forces that depend on {'rates' if of_rate else 'position'}"
    return Need(what, True, why, str(parts.moved[0][1]) if parts.moved else "", _coriolis_cost(parts) if of_rate else "")


def _coriolis_cost(parts: _Parts) -> str:
    """Of the terms with rates, in the equations without dampers and loads."""
    motion = parts.motion
    if parts.scene.n > _MOST_COUNTED:
        return ""
    calm = build_motion(parts.kinematics, replace(parts.energies, dissipation=(), loads=()), parts.constraints).acceleration
    whole = parts.count(motion.acceleration)
    cost = parts.count(calm) - parts.count(ca.substitute(calm, motion.v, ca.SX.zeros(motion.v.numel())))
    return _share(whole, whole - cost)


# -------------------------------------------------------------------- inertia


def _mass(parts: _Parts) -> Iterable[Need]:
    motion, names = parts.motion, parts.kinematics.graph.coordinates
    ways = ", ".join(f"{way} {count}" for way, count in motion.nodes.items())
    timed = bool(names) and changes(parts.inertia, [parts.symbols_of_time], parts.inertia)[0]
    place = str(parts.turning[0].span) if parts.turning else str(parts.moved[0][1]) if timed and parts.moved else ""
    shown = _few([c.name for c in parts.turning]) if len(names) <= _MOST_COUNTED else "position"
    why = f"M depends on {shown}" if parts.turning else "M depends on time" if timed else "M is constant"
    yield Need("refactorising M", bool(parts.turning) or timed, why, place, saving="a factorisation in every evaluation")
    yield Need("M as a matrix", motion.way not in ("tree", "constrained along the tree"), f"operations by each way: {ways}")
    floating = [(root.frame, parts.kinematics.graph.model.frames[root.frame].span)
                for root in parts.kinematics.graph.roots if not root.is_ground]
    yield _listed("floating coordinates", floating, "every body is joined to the ground", "", "three coordinates a body")


# -------------------------------------------------------------------- constraints


def _constraints(parts: _Parts) -> Iterable[Need]:
    held, rows = parts.motion.constrained, parts.constraints.rows
    spans = [(row.loop.around if row.loop else row.span.text, row.span) for row in rows]
    usual = held.regular if held and held.regular and held.regular.place.numel() else held
    nodes = count_nodes([usual.place, usual.steer], [parts.kinematics.algebra.state, parts.motion.t]) if usual else 0
    yield _listed("constraints", spans, "the graph is a tree", _counted(len(rows), "row"), "multipliers in every evaluation")
    yield _multipliers(parts)
    yield _listed("projection", spans[:1], "nothing can drift off", f"{nodes} operations a correction", "two corrections a step")
    yield _dependence(parts)
    asked = parts.scene.sizes["outputs_need_acceleration"]
    yield Need("multipliers as results", bool(held) and bool(asked), "outputs ask for them or for accelerations" if held and asked
               else "no output asks for them" if held else "there are none")
    yield from _given_coordinates(parts)
    repeated = [(row.loop.around if row.loop else row.span.text, row.span) for row in parts.constraints.repeated]
    yield Need("repeated equations", False, f"left out: {_few([name for name, _ in repeated])}" if repeated
               else "none repeats another", str(repeated[0][1]) if repeated else "")


def _multipliers(parts: _Parts) -> Need:
    """Whether the accelerations are solved for together with multipliers, or in independent coordinates alone."""
    held, names, what = parts.motion.constrained, parts.kinematics.graph.coordinates, "multipliers in steps"
    if held is None:
        return Need(what, False, "there are no constraints")
    if held.partition is None:
        if "independent coordinates" in parts.motion.counted:
            why = "independent coordinates would save too little"
        elif is_too_large(len(names), len(parts.constraints.rows)):
            why = "not supported yet: independent coordinates of so many that move freely"
        else:
            why = ("only linkages of pairs of links, with no more freedom than constraints, are brought down to independent "
                   "coordinates")
        return Need(what, True, why, cost=_counted(len(parts.constraints.rows), "unknown"))
    less, whole, *_ = sorted(parts.motion.counted.values())
    given = _few([names[k].name for k in held.partition.independent])
    why = f"solved for {given}; the others follow from there" if given else "all follows from what is prescribed"
    return Need(what, False, why, saving=f"{whole - less} of {whole} operations")


def _given_coordinates(parts: _Parts) -> Iterable[Need]:
    """Coordinates that equations give: in terms of others, or of time and parameters alone."""
    places = {name: row.span for name, row in parts.constraints.givers.items()} | dict(parts.moved)
    given = [c.name for c in parts.kinematics.graph.dependent_coordinates]
    known = [name for name in given if not parts.kinematics.dependents[name].terms]
    tied = [name for name in given if name not in known]
    moved = {name for name, _ in parts.moved}
    timed, fixed = [name for name in known if name in moved], [name for name in known if name not in moved]
    words = [f"given functions of time: {_few(timed)}"] * bool(timed) + [f"held in place: {_few(fixed)}"] * bool(fixed)
    yield Need("linear loops", False, f"substituted: {_few(tied)}" if tied else "there are none",
               str(parts.constraints.givers[tied[0]].span) if tied else "",
               saving=f"{_counted(len(tied), 'coordinate')} and as many multipliers" if tied else "")
    yield Need("prescribed coordinates", False, "; ".join(words) or "there are none",
               str(places[(timed + fixed)[0]]) if known else "", saving=_counted(len(known), "coordinate") if known else "")


def _dependence(parts: _Parts) -> Need:
    """What only constraints that nearly repeat each other ask of the solution of the equations."""
    held, what = parts.motion.constrained, "dependent constraints"
    if held is None:
        return Need(what, False, "there are no constraints")
    if held.regular is None:
        return Need(what, True, "the mass matrix is singular or uneven: the equations are solved with a regularised matrix")
    whole, less = parts.count(parts.motion.acceleration), parts.count(held.regular.acceleration)
    return Need(what, False, "looked for in every evaluation: only near singular positions are the equations regularised",
                saving=f"{whole - less} of {whole} operations")


# -------------------------------------------------------------------- time


def _time(parts: _Parts) -> Iterable[Need]:
    yield _listed("moving supports", parts.moved, "nothing is moved in time", "", "dr/dt of every frame, and their power")
    timed = ca.depends_on(parts.motion.acceleration, parts.symbols_of_time)
    yield Need("explicit time", timed, "t stands in the accelerations" if timed else "t does not stand in the accelerations",
               _line(place_of_time(parts.kinematics)) if timed else "")
    modes = parts.modes
    conditions, delays = _counted(parts.scene.sizes["n_events"], "condition"), parts.kinematics.graph.model.delays
    told = [f"{conditions} on time"] * bool(modes) + ["what breaks at an event breaks again a delay later"] * bool(delays)
    place = place_of_time(parts.kinematics, is_event=True) if modes else delays[0].span if delays else None
    yield Need("time events", bool(told), ", ".join(told) or "nothing switches", _line(place) if told else "",
               saving="restarts, and the search for switching times")
    yield _state_events(parts)
    yield _islands(parts)


def _state_events(parts: _Parts) -> Need:
    sizes, model = parts.scene.sizes, parts.kinematics.graph.model
    whens = [when for when in model.whens if when.resets]
    conditions = sizes["n_switches"] - 3 * sizes["n_whens"]
    found = [f"{_counted(conditions, 'condition')} on the state in the forces"] if conditions else []
    corners = find_corners(parts.energies, parts.motion) if conditions and parts.scene.n <= _MOST_COUNTED else ()
    if corners:
        told = dict.fromkeys(f"{corner.component or 'a force of its own'}: {corner.decided_by}" for corner in corners)
        found[0] += f" ({_few(list(told))}), held in each step: where one changes, the run goes back to the place"
    found += [f"{_counted(len(whens), 'event')} at which {model.set_at_events}"] if whens else []
    place = whens[0].span if whens else corners[0].span if corners else None
    return Need("state events", bool(found), ", ".join(found) or "forces bend and jump nowhere",
                _line(place) if place else "", saving="a look at conditions after each step, and restarts")


def _islands(parts: _Parts) -> Need:
    """Whether coordinates that do not interact are run apart."""
    scene, refusal = parts.scene, parts.scene.refused.get("islands")
    count = len(find_islands(parts.motion)) if scene.n <= MOST_COORDINATES else 0
    apart = f"{count} groups of coordinates do not interact" if count > 1 else ""
    if refusal is not None:
        return Need("islands", False, f"{apart}, but run together: {refusal}" if apart else refusal)
    if scene.sizes.get("solver") == Solver.ISLANDS:
        return Need("islands", True, f"{apart}: each is run with its own solver and steps")
    return Need("islands", False, f"{apart}, but run together: steps of their own would hardly pay")


# -------------------------------------------------------------------- numerics


def _numerics(parts: _Parts) -> Iterable[Need]:
    yield _integrator(parts)
    yield _further_swings(parts.scene)
    is_small = parts.scene.n <= _MOST_COUNTED
    spectrum = find_spectrum(parts.kinematics, parts.motion, parts.initial, parts.given) if is_small else None
    yield _stiffness(spectrum, parts.scene)


def _integrator(parts: _Parts) -> Need:
    """Steps are needed where matrix exponentials cannot be used."""
    scene, what = parts.scene, "integrator"
    if not scene.n:
        return Need(what, False, "nothing moves that is not prescribed")
    if "linear" in scene.refused:
        return Need(what, True, scene.refused["linear"], _line(_place_of_refusal(parts)))
    return Need(what, False, "the equations are linear in q and v",
                saving="every step: the matrix exponential is exact (solver linear)")


def _further_swings(scene: Scene) -> Need:
    """Steps after half a swing, where what swings must swing back the same way."""
    what, freedom = "further swings", scene.n - scene.sizes["n_multipliers"]
    if scene.sizes["is_swing"]:
        return Need(what, False, "one degree of freedom and energy is kept: it swings back the way it came",
                    saving="all steps after the second moment of rest (auto)")
    if not scene.n:
        return Need(what, False, "nothing moves that is not prescribed")
    flow = scene.refused.get("conservative", "") if freedom == 1 else "its constraints repeat each other"
    return Need(what, True, "it has more than one degree of freedom" if freedom > 1 else flow)


def _place_of_refusal(parts: _Parts) -> Span | None:
    """What makes the equations other than linear ones with constant coefficients."""
    if whens := parts.kinematics.graph.model.whens:
        return whens[0].span
    if parts.constraints.rows:
        return parts.constraints.rows[0].span
    if parts.turning:
        return parts.turning[0].span
    if is_linear(parts.kinematics, parts.motion, parts.motion.h):
        return parts.moved[0][1] if parts.moved else None
    return place_of_nonlinear_term(parts.kinematics, parts.energies, parts.motion)


def _stiffness(spectrum: Spectrum | None, scene: Scene) -> Need:
    if spectrum is None:
        return Need("implicit steps", False, "not looked at before the run: the run time watches for stiffness")
    rates = f"at the start rates from {spectrum.slowest:.3g} to {spectrum.fastest:.3g} 1/s"
    if not spectrum.is_stiff(scene.stop - scene.start):
        return Need("implicit steps", False, rates, saving="Jacobians and their factorisation")
    return Need("implicit steps", True, f"{rates}, the fastest die away", cost="Jacobians and their factorisation")


# -------------------------------------------------------------------- what is reported


def _products(parts: _Parts) -> Iterable[Need]:
    scene, energies = parts.scene, parts.energies
    names, variables = [column.name for column in scene.outputs], parts.kinematics.graph.model.variables
    declared = [variables[name].span for name in names if name in variables]
    yield Need("outputs", bool(names), _few(names) if names else "none is asked for", _line(declared[0] if declared else None),
               cost="a call in each row, none in steps")
    flows, sources = scene.sizes["n_power"] > 0, [t.statement.span for t in energies.dissipation]
    sources += [load.statement.span for load in energies.loads] + [span for _, span in parts.moved]
    yield Need("energy quadrature", flows, "power flows in or out" if flows else "T + V is constant",
               _line(sources[0] if sources and flows else None), saving="two integrals in every step")
    yield from _momenta(parts)
    spans = [(loop or span.text, span) for loop, span in
             zip(parts.initial.residual_loops, parts.initial.residual_spans, strict=True)]
    yield _listed("assembly", spans, "start values are given or zero", _counted(len(spans), "equation"),
                  "Newton steps at the start")
    yield _inputs(parts)
    yield Need("compilation", True, f"{scene.notes['rhs_operations']} operations in the right-hand side; kept in the cache, "
               "parameters change without it")


def _momenta(parts: _Parts) -> Iterable[Need]:
    """Those that nothing changes, for people: what runs does not lean on them."""
    if parts.motion.constrained is not None or parts.scene.n > _MOST_COUNTED:
        return
    if found := constant_momenta(parts.kinematics, parts.motion, parts.given):
        constant = f"constant {'between events ' if parts.kinematics.graph.model.whens else ''}"
        yield Need("changing momenta", False, f"{constant}{'is that' if len(found) == 1 else 'are those'} {_few(found)}")


def _inputs(parts: _Parts) -> Need:
    motion, kinematics = parts.motion, parts.kinematics
    model = kinematics.graph.model
    inputs = [v for v in model.variables.values() if v.kind == "input" and v.name not in rate_inputs(model)]
    if not inputs:
        return Need("inputs", False, "nothing comes from outside")
    acts = ca.vertcat(motion.acceleration, motion.dissipated_power, motion.source_power)
    values = [kinematics.evaluator.value(observe(model, column.name)) for column in parts.scene.own_outputs]
    read = ca.vertcat(*[ca.SX(x) for value in values for x in scalars_of(value)])
    u = ca.vertcat(motion.u, *[mode.symbol for mode in kinematics.algebra.modes if mode.of_input is not None])
    is_moving, is_read = ca.depends_on(acts, u), ca.depends_on(read, u)
    who = "the motion depends" if is_moving else "outputs alone depend" if is_read else "nothing depends"
    return Need("inputs", is_moving or is_read, f"{who} on {_few([v.name for v in inputs])}", str(inputs[0].span))


# -------------------------------------------------------------------- words


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _line(span: Span | None) -> str:
    return "" if span is None else str(span)


def _few(names: list[str]) -> str:
    shown = list(dict.fromkeys(names))
    return ", ".join(shown[:_MOST_NAMES]) + (f" and {len(shown) - _MOST_NAMES} more" if len(shown) > _MOST_NAMES else "")


def _share(whole: int, without: int | None) -> str:
    return "" if without is None else f"{max(0, whole - without)} of {whole} operations"


def _listed(what: str, found: list[tuple[str, Span]], otherwise: str, cost: str = "", saved: str = "") -> Need:
    """A need for each of which there is a name and a place, or none at all."""
    if not found:
        return Need(what, False, otherwise, saving=saved)
    return Need(what, True, _few([name or "what the scene itself says" for name, _ in found]), str(found[0][1]), cost)
