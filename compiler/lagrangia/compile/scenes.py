"""Functions -> Scene: names, units, defaults and tapes, as plain data."""

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import casadi as ca

from lagrangia.algebra.modes import Mode
from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.diagnostics import fail
from lagrangia.compile.functions import Functions, build_island_functions, elements_of
from lagrangia.compile.hoisted_tapes import tapes_of
from lagrangia.compile.instructions import count_operations, tape_of
from lagrangia.constraints.initial import InitialConditions, find_idle_starts
from lagrangia.constraints.parameters import find_odd_inertias, places_of_inertias, scalars
from lagrangia.constraints.rows import Constraints
from lagrangia.constraints.several_starts import find_several_starts
from lagrangia.constraints.virtual_forces import find_idle_displacements
from lagrangia.dynamics.double_roots import touching_notes
from lagrangia.dynamics.guarding import is_of_parameters, tell_guards
from lagrangia.dynamics.hamilton import is_separable
from lagrangia.dynamics.idle_events import find_idle_events
from lagrangia.dynamics.idle_lines import find_idle_lines
from lagrangia.dynamics.idle_statements import find_idle_equations, find_idle_statements
from lagrangia.dynamics.impacts import Impacts
from lagrangia.dynamics.jumping_energies import find_jumping_energies
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.negative_inertia import tell_unlooked, written_inertias
from lagrangia.dynamics.switches import corners_remain, counts_whole_numbers
from lagrangia.frames.graph import ComponentGraph, Coordinate
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.attitudes import parts_of
from lagrangia.language.changes import is_before
from lagrangia.language.consequences import place_of_felt_reactions
from lagrangia.language.dimensions import units_of, units_of_given
from lagrangia.language.events import kept_by
from lagrangia.language.flat import FlatModel, Variable, When, rate_of
from lagrangia.language.folding import numbers_of
from lagrangia.language.observables import observe
from lagrangia.language.parameter_readers import find_readers
from lagrangia.language.stepwise import find_stepwise
from lagrangia.language.tree import Array, Flat
from lagrangia.native.c_code import jet_tape, usual_rhs
from lagrangia.native.narrow import may_be_narrow, may_hide
from lagrangia.native.tapes import Tape
from lagrangia.needs.islands import MOST_COORDINATES, MOST_ISLANDS, find_islands, island_motion, weigh_islands
from lagrangia.run.rules import Moment, decide
from lagrangia.run.runtime import Solver
from lagrangia.run.scene import Column, Parameter, Scene

_MANY_VARIABLES = 5000  # from which on what reads parameters is looked for when somebody asks: see model.py


def build_scene(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, initial: InitialConditions, functions: Functions,
    is_still: bool, flow: str, no_momenta: str,
) -> Scene:
    """`flow`: why it does not keep its energy, `no_momenta`: why it has no conservative steps; "" where it does and has."""
    model, graph, attitudes = kinematics.graph.model, kinematics.graph, kinematics.symbols.attitudes
    tapes = tapes_of(functions)
    coordinates = tuple(Column(c.name, c.unit, c.display_unit, c.description) for c in graph.coordinates)
    states = {state.coordinate: model.variables[name] for name, state in model.states.items()}
    rates = tuple(_rate_column(c, states.get(c.name)) for c in graph.coordinates)
    outputs = _columns(graph, functions.outputs)
    started = (*graph.coordinates, *initial.lost)
    kinds = {unit: k + 1 for k, unit in enumerate(sorted({c.unit for c in started} - {"rad"}))} | {"rad": 0}
    slots = {c.name: k for k, c in enumerate(graph.coordinates)}
    aliases = {v.name: len(slots) + slots[of] for v in model.variables.values() if (of := rate_of(v)) in slots and of is not None}
    turning = ((v.name, of) for v in model.variables.values() if (of := rate_of(v)) in attitudes and of is not None)
    aliases |= {f"{name}[{k}]": len(slots) + slots[part] for name, of in turning for k, part in enumerate(parts_of(of), 1)}
    experiment = model.experiment
    parameters = _parameters(model, "parameter", kinematics.symbols.compiled)
    inputs = _parameters(model, "input", {})
    sizes = _sizes(len(coordinates), len(parameters), len(inputs), len(kinematics.algebra.modes), functions, motion, tapes) | {
        "n_outputs": len(outputs), "n_initial": initial.residuals.numel(), "n_initial_positions": initial.n_positions,
        "n_lost": len(initial.lost), "outputs_need_acceleration": int(functions.outputs_need_acceleration),
        "is_separable": int(not no_momenta and not attitudes and is_separable(motion)),
        "is_swing": int(not flow and not attitudes and _is_of_one_freedom(motion)),
    } | _repetition(kinematics, motion)
    return _with_series(Scene(
        name=model.name, description=model.description, structural=dict(model.structural),
        coordinates=coordinates, rates=rates, outputs=outputs, parameters=parameters, inputs=inputs, aliases=aliases,
        start=experiment.start, stop=experiment.stop, tolerance=experiment.tolerance, interval=experiment.interval,
        sizes=sizes, patterns=functions.patterns, tapes=tapes, islands=(), unevenness=_unevenness(motion),
        tables=tuple(kinematics.algebra.index.tables),
        coordinate_kind=tuple(kinds[c.unit] for c in started), fixed=tuple(map(int, initial.fixed)),
        event_kind=functions.event_kinds, initial_places=_initial_places(initial), lost=_lost_starts(model, initial),
        notes=_notes(motion, tapes)
        | {"form": functions.form.why if functions.form else "", "thresholds": [*functions.thresholds]}
        | _freedom(kinematics, motion, constraints, is_still) | _told(kinematics, constraints, initial, functions, motion.impacts)
        | ({"guards": tell_guards(model, functions.guarding)} if model.guards else {}),
        refused={**functions.refused, **({"conservative": no_momenta} if no_momenta else {}), **_refusals(kinematics)},
    ))


def _refusals(kinematics: Kinematics) -> dict[str, str]:
    """Solvers that no attitudes have, and why."""
    name = next(iter(kinematics.symbols.attitudes), "")
    return {} if not name else {
        "adams": f"not supported yet: its past slopes are told against a reference of the attitude '{name}' that each step moves",
        "conservative": f"not supported yet: no positions belong to the momenta of the attitude '{name}'",
        "linear": f"the attitude '{name}' turns",
        "islands": f"not supported yet: islands of scenes with attitudes as coordinates ('{name}')",
    }


def _rate_column(coordinate: Coordinate, state: Variable | None) -> Column:
    if state is not None:
        return Column(coordinate.rate_name, state.unit, state.display_unit, state.description)
    shown = _per_second(coordinate.display_unit) if coordinate.display_unit else ""
    return Column(coordinate.rate_name, _per_second(coordinate.unit), shown, "")


def _is_of_one_freedom(motion: Motion) -> bool:
    """Where no constraint repeats others; else there are more than told here."""
    return bool(motion.q.numel() - (motion.constrained.multipliers.numel() if motion.constrained else 0) == 1)


def divide(scene: Scene, kinematics: Kinematics, motion: Motion, initial: InitialConditions) -> Scene:
    """The scene with its islands, each as a scene of its own, where there are some."""
    reason, groups = _whole(motion, kinematics.graph.model, kinematics.algebra.modes)
    if not all(is_of_parameters(kind) for kind in scene.patterns.get("guard_kinds", ())):
        reason = "not supported yet: islands of scenes with assertions of the motion, or terminate"
    if reason:
        return replace(scene, refused={**scene.refused, "islands": reason})
    motions = [island_motion(kinematics, motion, groups, k) for k in range(len(groups))]
    islands = tuple((group, _island_scene(scene, kinematics, part, group)) for group, part in zip(groups, motions, strict=True))
    form = decide(Moment.ISLANDS, weigh_islands(kinematics, motions, initial, groups))
    if form.takes is not Solver.ISLANDS:
        return replace(scene, islands=islands)
    return replace(scene, islands=islands, sizes={**scene.sizes, "solver": int(Solver.ISLANDS)},
                   notes={**scene.notes, "form": form.why})


def _whole(motion: Motion, model: FlatModel, modes: Sequence[Mode]) -> tuple[str, list[tuple[int, ...]]]:
    """Why a scene is not divided; its islands."""
    if motion.q.numel() > MOST_COORDINATES:
        return f"not supported yet: islands of more than {MOST_COORDINATES} coordinates", []
    if motion.impacts.conditions.numel():
        return f"not supported yet: islands of scenes in which {model.set_at_events} at events", []
    if motion.felt is not None:
        return "not supported yet: islands of scenes whose forces feel reactions", []
    if model.samplers:
        return "not supported yet: islands of scenes with values that are held between instants", []
    if model.delays:
        return "not supported yet: islands of scenes with delays", []
    if any(mode.of_attitude for mode in modes):
        return "not supported yet: islands of scenes with attitudes as coordinates", []
    groups = find_islands(motion)
    if len(groups) > MOST_ISLANDS:
        return f"not supported yet: more than {MOST_ISLANDS} islands", []
    return "" if len(groups) > 1 else "all its coordinates interact" if groups else "it has no coordinates", groups


def _island_scene(scene: Scene, kinematics: Kinematics, motion: Motion, group: tuple[int, ...]) -> Scene:
    held = motion.constrained
    rows = [held.rows.phi, held.rows.rate, held.rows.bias] if held else []
    events = [motion.impacts.conditions, motion.impacts.gaps, motion.impacts.wanted]
    everything = ca.vertcat(motion.h, motion.momentum, motion.acceleration, motion.dissipated_power, motion.source_power, *rows,
                            *events)
    used = symbols_in(everything)
    is_kicked = "kick" in scene.tapes  # by modes that may stand in no equation
    asked = {id(mode.arguments) for mode in kinematics.algebra.modes if mode.is_filled_in and mode.symbol.__hash__() in used}
    modes = [mode for mode in kinematics.algebra.modes
             if is_kicked or mode.symbol.__hash__() in used or id(mode.arguments) in asked]  # of a table all
    algebra = replace(kinematics.algebra, modes=modes)
    functions = build_island_functions(replace(kinematics, algebra=algebra), motion)
    tapes = tapes_of(functions)
    given = scene.sizes["n_parameters"], scene.sizes["n_inputs"]
    sizes = _sizes(len(group), *given, len(algebra.modes), functions, motion, tapes) | _repetition(kinematics, motion)
    fixed = tuple(scene.fixed[k] for k in (*group, *(len(scene.coordinate_kind) + k for k in group)))
    return _with_series(replace(
        scene, coordinates=tuple(scene.coordinates[k] for k in group), rates=tuple(scene.rates[k] for k in group), outputs=(),
        aliases={}, sizes=sizes, coordinate_kind=tuple(scene.coordinate_kind[k] for k in group), fixed=fixed,
        event_kind=functions.event_kinds, initial_places=(), notes=_notes(motion, tapes), patterns=functions.patterns,
        refused=functions.refused, tapes=tapes, islands=(), unevenness=None, lost={},
    ))


def _sizes(n: int, n_parameters: int, n_inputs: int, n_modes: int, functions: Functions, motion: Motion, tapes: dict[str, Tape]
           ) -> dict[str, int]:
    """Those of LagModel that a whole scene and an island have alike."""
    found = {
        "n": n, "n_parameters": n_parameters, "n_hoisted": tapes["hoist"].out_sizes[0], "n_inputs": n_inputs,
        "n_modes": n_modes, "n_events": len(functions.event_kinds), "n_power": functions.n_power, **_of_switches(functions),
        **_of_constraints(motion), **functions.sizes, "rhs_cost": count_operations(usual_rhs(tapes)),
        "n_whens": motion.impacts.conditions.numel(), "n_resets": motion.impacts.rates.numel(),
        "n_roots": functions.table["roots"].numel_out(0) if "roots" in functions.table else 0,
        "n_looks": functions.table["looks"].numel_out(0) if "looks" in functions.table else 0,
        "n_rubs": len(functions.patterns.get("rubs", ())) // 3, "n_rests": len(functions.patterns.get("rests", ())),
        "n_cones": len(functions.patterns.get("cones", ())) // 2, "n_lookups": len(functions.patterns["lookups"]) // 2,
        "has_corners": int(corners_remain(motion)), "may_hide": int(may_hide(usual_rhs(tapes))),
        "may_be_narrow": int(may_be_narrow(usual_rhs(tapes))),
        "conditions_may_hide": int(motion.impacts.may_hide(motion.t) or counts_whole_numbers(motion)),
        "n_loaded": len(motion.impacts.loaded),
        "shares_bend": int(motion.felt is not None), "is_steady": int(_is_steady(functions)),
        "carries_in_time": int(_carries_in_time(functions)),
    }
    if "held" in functions.patterns:
        found |= {"n_held": len(functions.patterns["held"]) // 3, "n_samplers": len(functions.patterns["samplers"])}
    if "stated" in functions.patterns:
        found |= {"n_delays": len(functions.patterns["stated"]), "is_steady": 0}
    if "attitudes" in functions.patterns:
        found["n_attitudes"] = len(functions.patterns["attitudes"]) // 2
    if "kept" in functions.patterns:
        found["n_kept"] = len(functions.patterns["kept"])
    if "pieces" in functions.patterns:
        found["n_pieces"] = len(functions.patterns["pieces"]) // 4
    found["jacobian_cost"] = _jacobian_cost(tapes, found["n_colours"])
    return found | ({"solver": int(Solver.LINEAR)} if functions.form and functions.form.takes is Solver.LINEAR else {})


def _repetition(kinematics: Kinematics, motion: Motion) -> dict[str, int]:
    """Whether rows of loops may repeat each other wherever they are closed."""
    return {"may_repeat": 1} if kinematics.geometry.by_rates and motion.constrained is not None else {}


def _of_constraints(motion: Motion) -> dict[str, int]:
    held = motion.constrained
    if held is None:
        return {"n_holonomic": 0, "n_multipliers": 0, "loops_know_time": 0}
    return {"n_holonomic": held.rows.phi.numel(), "n_multipliers": held.multipliers.numel(),
            "loops_know_time": int(ca.depends_on(held.rows.phi, motion.t))}


def _is_steady(functions: Functions) -> bool:
    """Whether neither accelerations nor conditions depend on time; of scenes without conditions nobody asks."""
    asked = [functions.table[name] for name in ("rhs", "switches", "loads") if {"switches", name} <= functions.table.keys()]
    return bool(asked) and not any(f.jac_sparsity(k, f.index_in("t")).nnz() for f in asked for k in range(f.n_out()))


def _carries_in_time(functions: Functions) -> bool:
    """Whether the kinetic energy depends on time, or on inputs; islands have none of their own."""
    energies = functions.table.get("energies")
    return energies is not None and any(0 in energies.jac_sparsity(0, energies.index_in(name)).row() for name in ("t", "u"))


def _of_switches(functions: Functions) -> dict[str, int]:
    switches = functions.table.get("switches")
    if switches is None:
        return {"n_switches": 0, "switches_need_acceleration": 0}
    needs = switches.jac_sparsity(switches.index_out("rate"), switches.index_in("a")).nnz() > 0
    return {"n_switches": switches.numel_out(0), "switches_need_acceleration": int(needs or "loads" in functions.table)}


def _lost_starts(model: FlatModel, initial: InitialConditions) -> dict[str, tuple[int, str]]:
    lost = initial.lost
    found = {c.name: (k, c.unit) for k, c in enumerate(lost)}
    rates = {c.name: (len(lost) + k, _per_second(c.unit)) for k, c in enumerate(lost)}
    found |= {c.rate_name: rates[c.name] for c in lost}
    return found | {v.name: rates[of] for v in model.variables.values() if (of := rate_of(v)) in rates and of is not None}


def _unevenness(motion: Motion) -> Tape | None:
    """How many of the numbers of `evenness` are not above 1."""
    held = motion.constrained
    if held is None or not held.evenness.numel() or not ca.depends_on(held.evenness, motion.p):
        return None
    return tape_of(ca.Function("unevenness", [motion.p], [ca.sum1(ca.logic_not(held.evenness > 1))]))


def _with_series(scene: Scene) -> Scene:
    """With Taylor coefficients of its motion, or the reason why there are none."""
    found = jet_tape(scene.tapes, scene.patterns.get("attitudes", ()))
    if isinstance(found, str):
        return replace(scene, refused={**scene.refused, "taylor": found})
    sizes, patterns, tapes = found
    return replace(scene, sizes={**scene.sizes, **sizes}, patterns={**scene.patterns, **patterns}, tapes={**scene.tapes, **tapes})


def _initial_places(initial: InitialConditions) -> tuple[tuple[str, str], ...]:
    return tuple((initial.complaint(k), span.excerpt) for k, span in enumerate(initial.residual_spans))


def _is_driven(kinematics: Kinematics, motion: Motion) -> bool:
    """Whether a support moves, or a constraint prescribes a motion in time, or a rate."""
    if any(edge.moves_with_time for edge in kinematics.graph.edges):
        return True
    rows = [ca.SX(dependent.constant[0]) for dependent in kinematics.dependents.values()]
    held = motion.constrained
    if held is not None and not ca.substitute(held.rows.rate, motion.v, ca.SX.zeros(motion.v.numel())).is_zero():
        return True
    return bool(rows) and ca.depends_on(ca.vertcat(*rows), motion.t)


def _freedom(kinematics: Kinematics, motion: Motion, constraints: Constraints, is_still: bool) -> dict[str, object]:
    """What is known at once; "freedom" is filled in when somebody asks: see model.py."""
    is_driven = _is_driven(kinematics, motion)
    return {"is_static": is_still and not is_driven, "is_prescribed": is_still and is_driven, "is_driven": is_driven,
            "loops": len(kinematics.graph.closures), "freedom": None,
            "tells_reactions": bool(kinematics.reactions or kinematics.forces),
            "prescribed": [name for name, dependent in kinematics.dependents.items() if not dependent.terms],
            "dependent": [c.name for c in kinematics.graph.dependent_coordinates], **touching_notes(kinematics, constraints),
            "balanced": sorted(row.balanced for row in constraints.all_rows if row.balanced)}


def _told(kinematics: Kinematics, constraints: Constraints, initial: InitialConditions, functions: Functions,
          impacts: Impacts) -> dict[str, object]:
    """As text: the scene outlives the source it points at."""
    model = kinematics.graph.model
    contacts = [_called(model, when) for when in model.whens]
    lines, odd = find_idle_lines(kinematics, initial).diagnostics, find_odd_inertias(kinematics)
    odd.raise_errors()
    idle, jumping = find_idle_statements(kinematics.graph, lines), find_jumping_energies(kinematics)
    found = (*model.warnings, *lines, *idle.diagnostics, *find_idle_equations(constraints).diagnostics, *jumping.diagnostics,
             *tell_unlooked(kinematics).diagnostics, *odd.diagnostics, *find_idle_starts(kinematics).diagnostics,
             *find_several_starts(kinematics, initial, functions.table).diagnostics,
             *find_idle_displacements(kinematics, constraints).diagnostics,
             *find_idle_events(kinematics, constraints, impacts, model.warnings).diagnostics)
    found = tuple(warning for warning in found if warning.code not in model.allowed)
    told, timed = [w.render() for w in found], {w.render(): list(w.interval) for w in found if w.interval is not None}
    files = sorted({os.path.abspath(lookup.path) for lookup in model.lookups})  # wherever it is found again
    required = [x.told for x in functions.requirements]
    kinetic, felt = [str(span) for span in written_inertias(kinematics)], place_of_felt_reactions(model)
    return {"warnings": told, "allowed": list(model.allowed), "contacts": contacts, "files": files, "kinetic": kinetic,
            "felt": str(felt) if felt else "", **({"timed_warnings": timed} if timed else {}),
            **({"samplers": [str(sampler.span) for sampler in model.samplers],
                "held": [held.name for sampler in model.samplers for held in sampler.held]} if model.samplers else {}),
            **({"delays": [str(delay.span) for delay in model.delays]} if model.delays else {}),
            **({"requirements": required} if required else {}), "jumping": [str(w.span) for w in jumping.diagnostics],
            **({"inertias": inertias} if (inertias := places_of_inertias(kinematics)) else {}),
            "attitudes": {name: parts_of(name) for name in kinematics.symbols.attitudes},
            "readers": find_readers(model) if len(model.variables) <= _MANY_VARIABLES else None,
            "signals": {state.coordinate: name for name, state in model.states.items()},
            **({"kept": kept} if (kept := _kept_types(model)) else {}),
            **({"inner": inner} if (inner := _inner(model)) else {}),
            **({"stepwise": stepwise} if (stepwise := find_stepwise(model, functions.outputs)) else {})}


def _inner(model: FlatModel) -> list[str]:
    """The coordinates of discrete variables that are no one's but their events'."""
    return [state.coordinate for state in model.states.values() if state.is_kept and is_before(state.name, model.variables)]


def _kept_types(model: FlatModel) -> dict[str, str]:
    """Real, Integer or Boolean of each discrete variable, by its coordinate."""
    return {state.coordinate: model.variables[name].type_name for name, state in model.states.items() if state.is_kept}


def _notes(motion: Motion, tapes: dict[str, Tape]) -> dict[str, object]:
    n = motion.q.numel()
    nodes = count_operations(usual_rhs(tapes), output=0)
    return {"rhs_operations": count_operations(usual_rhs(tapes)), "acceleration_nodes": nodes, "way": motion.way,
            "ways": motion.counted or {motion.way: nodes}, "nodes_per_coordinate": round(nodes / max(n, 1), 1)}


def _jacobian_cost(tapes: dict[str, Tape], colours: int) -> int:
    """Operations: a function for products with directions is called twice a colour."""
    if "jacobian" in tapes:
        return count_operations(tapes["jacobian"])
    return 2 * colours * count_operations(tapes["tangent"]) if "tangent" in tapes else 0


def _per_second(unit: str) -> str:
    return f"{unit}/s" if unit and unit != "1" else "1/s"


def _columns(graph: ComponentGraph, names: Sequence[str]) -> tuple[Column, ...]:
    """Of outputs: their units, display units and descriptions."""
    model = graph.model
    attitudes = {name: graph.attitudes.get(name.rpartition("[")[0]) for name in names}
    plain = [name for name in names if attitudes[name] is None]
    units = dict(zip(plain, units_of(model, [observe(model, name) for name in plain]), strict=True))
    columns = []
    for name in names:
        variable = model.variables.get(name if name in model.variables else name.partition("[")[0])
        if (attitude := attitudes[name]) is not None:
            described = f"unit quaternion: {attitude.description}" if attitude.description else "unit quaternion"
            columns.append(Column(name, "1", "", described))
        elif variable is not None:
            columns.append(Column(name, units[name], variable.display_unit, variable.description))
        else:
            columns.append(Column(name, units[name], "", ""))
    return tuple(columns)


def columns_of(kinematics: Kinematics, name: str) -> tuple[Column, ...]:
    """The elements of any quantity, as columns of results. Raises LagError L0701."""
    return _columns(kinematics.graph, elements_of(kinematics, name))


def _starts(variable: Variable, source: Flat, values: Sequence[float | None]) -> Sequence[float | None]:
    """Of the elements of an input: what is one number is that of each. Raises LagError L0605."""
    count = math.prod(variable.shape)
    if None in values and not isinstance(source, Array):
        values = numbers_of(source, ()) * count
    if len(values) != count:
        fail("L0605", f"'{variable.name}' has {count} elements, and {len(values)} starts", source.span,
             "give each of them one, or the same to all: each start = ...")
    return values


def _parameters(model: FlatModel, kind: str, compiled_in: Mapping[str, Any]) -> tuple[Parameter, ...]:
    """The scalars of all parameters or inputs, in the order of the flat model."""
    found, units = [], units_of_given(model)
    for variable in (v for v in model.variables.values() if v.kind == kind):
        source = variable.binding if kind == "parameter" else variable.start or variable.binding
        values: Sequence[float | None] = [0.0] * math.prod(variable.shape)
        if source is not None:
            values = numbers_of(source, variable.shape)
        if kind == "input" and source is not None:
            values = _starts(variable, source, values)
        known = scalars(variable.name, compiled_in[variable.name]) if variable.name in compiled_in else [("", None)] * len(values)
        compiled = [x if isinstance(x, float) else None for _, x in known]
        for (name, _), value, number in zip(variable.elements(), values, compiled, strict=True):
            if kind == "input" and value is None:
                fail("L0605", f"the start of the input '{name}' must be a number", variable.span)
            found.append(Parameter(name, units[variable.name], value, variable.minimum, variable.maximum, variable.description,
                                   str(variable.span), number, variable.locked, source is not None))
    return tuple(found)


def _called(model: FlatModel, when: When) -> str:
    what = "the contact" if kept_by(model, when) is not None else f"the event '{when.condition.span.text}'"
    return f"{what} {f'of {when.component} ' if when.component else ''}({when.span})"
