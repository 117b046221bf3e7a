"""Motion -> CasADi Functions with named inputs and outputs.

For the run time, in the order that runtime/model/model.h states, with everything that depends on parameters alone computed once
(`hoist`: p -> c); for people the same equations as functions of t, q, v, u, p.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.lengths import exact_lengths
from lagrangia.algebra.modes import Mode
from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.records import dataclass
from lagrangia.compile.casadi_instructions import APART
from lagrangia.compile.hoisting import Hoisted, hoist
from lagrangia.compile.mode_places import (
    events_of,
    find_attitudes,
    find_lookups,
    find_pieces,
    find_samplers,
    mode_functions,
)
from lagrangia.compile.requirements import Requirement, find_requirements
from lagrangia.compile.right_hand_side import right_hand_side
from lagrangia.compile.start_functions import start_functions, start_patterns
from lagrangia.constraints.initial import InitialConditions, start_function
from lagrangia.constraints.parameters import all_parameters, default_parameters, scalars
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.constrained_motion import ConstrainedMotion, RegularMotion
from lagrangia.dynamics.delaying import Delaying, find_delaying
from lagrangia.dynamics.guarding import NOT_GUARDED, Guarding, find_guarding
from lagrangia.dynamics.hamilton import Hamilton
from lagrangia.dynamics.held_motion import HeldMotion, Put
from lagrangia.dynamics.impulses import bends_by_inputs, find_kick
from lagrangia.dynamics.jacobians import Jacobian, build_jacobian
from lagrangia.dynamics.joint_loads import settled
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.narrow_places import find_hiding_places, find_narrow_places
from lagrangia.dynamics.negative_inertia import without_negative_inertia
from lagrangia.dynamics.reactions import build_reactions
from lagrangia.dynamics.sampling import Sampling, find_sampling
from lagrangia.dynamics.switches import Switches, find_roots, find_switches, find_thresholds
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.at_one_instant import is_ordered
from lagrangia.language.consequences import speaks_of_contact_forces
from lagrangia.language.events import find_changes
from lagrangia.language.observables import observe
from lagrangia.needs.linear_cost import weigh_linear
from lagrangia.needs.linear_form import LinearForm, find_linear_form
from lagrangia.run.rules import Moment, Taken, decide

# Functions of the state that only constraints ask for, and their results.
_SIGNAL, _CHANGE, _KNOWN = 4, 8, 16  # LAG_SIGNAL, ...
_SEVERAL = {-1: -3, 0: 4, 1: 5}  # of what is so on a level: LAG_SEVERAL, ...
_OF_CONSTRAINTS = {"steer": ["dv"], "residual": ["phi", "rate"], "nearest": ["dq", "dv", "phi", "rate", "energies", "doubt"]}


@dataclass(frozen=True)
class Functions:
    """The functions of runtime/model/model.h by name, and what the run time needs to know about them."""

    table: Mapping[str, ca.Function]
    outputs: tuple[str, ...]
    event_kinds: tuple[int, ...]
    n_power: int
    outputs_need_acceleration: bool
    patterns: Mapping[str, tuple[int, ...]]
    refused: Mapping[str, str]  # solvers that cannot run the scene, and why
    sizes: Mapping[str, int]  # of the matrix of implicit steps
    form: Taken | None  # of a linear scene: whether `auto` takes the solver `linear`
    settled: int  # how many of the hoisted values are: see hoisting.py
    thresholds: tuple[float, ...] = ()  # with which rates are compared where forces jump
    guarding: Guarding = NOT_GUARDED
    requirements: tuple[Requirement, ...] = ()  # in the order of the function's places


def build_functions(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, initial: InitialConditions, hamilton: Hamilton | None,
    outputs: tuple[str, ...], is_implicit: bool = False,
) -> Functions:
    """`outputs` are the names to report besides coordinates and rates; see language/observables.py. `is_implicit`: implicit steps
    are asked for, whose matrix else waits where it is large. Raises LagError L0701."""
    names, y, put, guarding = _observed(kinematics, motion, constraints, outputs)
    motion = without_negative_inertia(kinematics, motion)
    made, modes, required = motion.unsolved or motion, kinematics.algebra.modes, find_requirements(kinematics, motion)
    symbols, multipliers = _multipliers(made)
    energy, jacobian = ca.vertcat(motion.T, motion.V, motion.H), build_jacobian(kinematics, made, is_implicit)
    flow = [hamilton.velocity, hamilton.force] if hamilton else []
    sampling, delaying, kick = find_sampling(kinematics), find_delaying(kinematics), find_kick(kinematics, motion)
    switches = find_switches(motion, delaying.values, bends_by_inputs(kinematics))
    held = HeldMotion(motion, switches, default_parameters(kinematics)[1])
    found, hoisted = _hoisted(settled(motion, switches, {
        "rhs": right_hand_side(kinematics, made, held, made.acceleration, made.source_power, multipliers), "energies": [energy],
        "outputs": [held.outputs(y, put), *switches.hold([guarding.values]), held.outputs(motion.impacts.of_forces, put)],
        **_constrained(kinematics, made, energy, held), "flow": flow, "jacobian": switches.hold(jacobian.values),
        "kick": [kick.rates], "delayed": switches.hold([ca.densify(delaying.values)]), **_watched(motion, switches)}), motion.p)
    t, q, v, a, u, c, d = motion.t, motion.q, motion.v, motion.a, motion.u, hoisted.c, kinematics.algebra.mode_symbols
    state, labels = [t, q, v, u, d, c], ["t", "q", "v", "u", "d", "c"]
    full = [t, q, v, a, symbols, u, ca.vertcat(d, switches.symbols, motion.impacts.impulses, switches.rest_symbols), c]
    table = _functions_of_steps(motion, jacobian, switches, found, d, c) | {
        **_functions_of_parameters(kinematics, motion, hoisted.values), "start": start_function(kinematics, initial),
        **_observing_functions(full, *found["outputs"]),
        "energies": ca.Function("energies", state, found["energies"], labels, ["energies"], APART),
    }
    table |= _functions_of_constraints(motion, found, d, c) | _flow_functions(motion, hamilton, found["flow"], c)
    table |= mode_functions(motion, modes) | _kick_function(state, found["kick"], kick.before)
    table |= (_requirement_function(motion, required) | _sampled_functions(kinematics, motion, initial, sampling)
              | _delay_functions(motion, delaying, [*state[:4], full[-2], c], found["delayed"]))
    patterns, refused, pays = _add_linear(table, kinematics, motion)
    patterns |= {"reset_places": _reset_places(kinematics, motion), **_kept_places(kinematics, motion, switches.edge.numel() > 0)}
    patterns |= start_patterns(table) | _patterns(kinematics, jacobian, switches, modes) | delaying.patterns | guarding.patterns
    refused |= _refusals(jacobian, bool(len(patterns.get("cones", ()))), bool(delaying.stated))
    return Functions(table, names, tuple(kind for _, kind in events_of(modes)), found["rhs"][1].numel(),
                     bool(y.numel()) and ca.depends_on(put([y])[0], ca.vertcat(a, symbols)), patterns, refused, {
        **jacobian.sizes, **guarding.sizes(ca.vertcat(a, symbols)), **_switch_sizes(motion, switches),
        "breaks_rise": int(delaying.rises)}, pays, hoisted.settled, find_thresholds(motion, switches), guarding, required)


def _multipliers(motion: Motion) -> tuple[ca.SX, ca.SX]:
    """Their symbols, and what they are."""
    held = motion.constrained
    return (held.symbols, held.multipliers) if held else (ca.SX(0, 1), ca.SX(0, 1))


def _observed(kinematics: Kinematics, motion: Motion, constraints: Constraints, outputs: tuple[str, ...]
              ) -> tuple[tuple[str, ...], ca.SX, Put, Guarding]:
    """`outputs_of`, and guards with the reactions they ask for."""
    guarding, (names, y, put) = find_guarding(kinematics), outputs_of(kinematics, motion, constraints, outputs)
    return names, y, put, replace(guarding, values=put([guarding.values])[0])


def _observing_functions(full: list[ca.SX], y: ca.SX, guarded: ca.SX, loads: ca.SX) -> dict[str, ca.Function]:
    labels = ["t", "q", "v", "a", "lambda", "u", "d", "c"]
    others = {"guards": guarded, "loads": loads}
    return {"outputs": ca.Function("outputs", full, [y], labels, ["y"])} | {
        name: ca.Function(name, full, [values], labels, ["g"]) for name, values in others.items() if values.numel()}


def _refusals(jacobian: Jacobian, has_cones: bool, is_late: bool) -> dict[str, str]:
    """Solvers that cannot run a scene, and why."""
    implicit = "not supported yet: implicit steps of so many coordinates that all act on each other"
    pirk = "not supported yet: friction in the plane, whose slips stop within its long steps"
    late = dict.fromkeys(("pirk", "erk9"), "not supported yet: something acts late, of which its steps tell too little")
    has_jacobian = bool(jacobian.values) or "jacobian_waits" in jacobian.sizes
    return ({} if has_jacobian else {"implicit": implicit}) | ({"pirk": pirk} if has_cones else {}) | (late if is_late else {})


def build_island_functions(kinematics: Kinematics, motion: Motion) -> Functions:
    """For some coordinates that are run by themselves: what moves them, without energies and outputs."""
    motion = without_negative_inertia(kinematics, motion)
    (_, multipliers), jacobian, modes = _multipliers(motion), build_jacobian(kinematics, motion), kinematics.algebra.modes
    kick = find_kick(kinematics, motion)
    switches = find_switches(motion, None, bends_by_inputs(kinematics))
    held = HeldMotion(motion, switches, default_parameters(kinematics)[1])
    found, hoisted = _hoisted({
        "rhs": right_hand_side(kinematics, motion, held, motion.acceleration, motion.source_power, multipliers),
        **_constrained(kinematics, motion, ca.SX(0, 1), held),
        "jacobian": switches.hold(jacobian.values), "kick": [kick.rates],
        **_watched(motion, switches)}, motion.p)
    d = kinematics.algebra.mode_symbols
    t, q, v, u, c = motion.t, motion.q, motion.v, motion.u, hoisted.c
    state = [t, q, v, u, d, c]
    table = _functions_of_steps(motion, jacobian, switches, found, d, c) | _functions_of_parameters(
        kinematics, motion, hoisted.values) | _functions_of_constraints(motion, found, d, c) | mode_functions(motion, modes)
    table |= _kick_function(state, found["kick"], kick.before)
    patterns, refused, pays = _add_linear(table, kinematics, motion)
    return Functions(table, (), tuple(kind for _, kind in events_of(modes)), found["rhs"][1].numel(), False,
                     patterns | _patterns(kinematics, jacobian, switches, modes),
                     refused, {**jacobian.sizes, **_switch_sizes(motion, switches)}, pays, hoisted.settled)


def _functions_of_parameters(kinematics: Kinematics, motion: Motion, hoisted: ca.SX) -> dict[str, ca.Function]:
    given, mask, p = all_parameters(kinematics, motion.p.numel())
    return {"parameters": ca.Function("parameters", [given, mask], [p], ["given", "mask"], ["p"], APART),
            "hoist": ca.Function("hoist", [motion.p], [hoisted], ["p"], ["c"], APART)}


def _sampled_functions(kinematics: Kinematics, motion: Motion, initial: InitialConditions, sampling: Sampling
                       ) -> dict[str, ca.Function]:
    return start_functions(kinematics, motion, initial) | _sampling_functions(kinematics, motion, sampling)


def _requirement_function(motion: Motion, requirements: Sequence[Requirement]) -> dict[str, ca.Function]:
    """The places of the first requirements of parameters that are not met, or -1: of all but those only told, and of these."""
    first = [ca.SX(-1), ca.SX(-1)]
    for k, x in reversed([*enumerate(requirements)]):
        first[x.only_told] = ca.if_else(x.holds, first[x.only_told], k)
    table = {"requirements": ca.Function("requirements", [motion.p], [*map(ca.densify, first)], ["p"], ["first", "told"])}
    return table if requirements else {}


def _watched(motion: Motion, switches: Switches) -> dict[str, list[ca.SX]]:
    """Results of the functions that tell of events."""
    return {"switches": [switches.values, switches.rates], "resets": [motion.impacts.rates, motion.impacts.wanted],
            "roots": switches.hold(list(find_roots(motion, switches))),
            "looks": [ca.vertcat(find_narrow_places(motion, switches), find_hiding_places(motion, switches))]}


def _switch_sizes(motion: Motion, switches: Switches) -> dict[str, int]:
    return {"n_lengths": switches.lengths, "n_hiding": find_hiding_places(motion, switches).numel()}


def _functions_of_steps(motion: Motion, jacobian: Jacobian, switches: Switches, found: Mapping[str, list[ca.SX]], d: ca.SX,
                        c: ca.SX) -> dict[str, ca.Function]:
    """What steps evaluate, with switches held: they follow the modes in `d`."""
    t, q, v, a, u = motion.t, motion.q, motion.v, motion.a, motion.u
    held_d = ca.vertcat(d, switches.symbols, motion.impacts.impulses, switches.rest_symbols)
    state, labels = [t, q, v, u, held_d, c], ["t", "q", "v", "u", "d", "c"]
    table = {"rhs": ca.Function("rhs", state, found["rhs"], labels, ["a", "power", "lambda"], APART)}
    if "regular" in found:
        table["regular"] = ca.Function("regular", state, found["regular"], labels, ["a", "power", "doubt"])
    if switches.symbols.numel():
        known = d if motion.unsolved is None else held_d  # which is all of it where steps are
        slopes = ca.vertcat(switches.slopes, switches.edge)
        table["switches"] = ca.Function("switches", [t, q, v, a, u, slopes, known, c], found["switches"],
                                        [*labels[:3], "a", "u", "du", "d", "c"], ["g", "rate"])
    if found["roots"][0].numel():
        table["roots"] = ca.Function("roots", state, found["roots"], labels, ["g", "rate"])
    if found["looks"][0].numel():
        table["looks"] = ca.Function("looks", state, found["looks"], labels, ["g"])
    if motion.impacts.places:
        table["resets"] = ca.Function("resets", [t, q, v, u, d, c], found["resets"], labels, ["rate", "wanted"])
    multipliers = motion.constrained.symbols if motion.constrained else ca.SX(0, 1)
    full = [t, q, v, a, multipliers, u, held_d, c]
    return table | _implicit_function(jacobian, found["jacobian"], full, [*labels[:3], "a", "lambda", *labels[3:]])


def _functions_of_constraints(motion: Motion, found: Mapping[str, list[ca.SX]], d: ca.SX, c: ca.SX) -> dict[str, ca.Function]:
    """Those of `_constrained` that were found, but for the accelerations."""
    t, q, v, u = motion.t, motion.q, motion.v, motion.u
    table = {name: ca.Function(name, [t, q, v, u, d, c], found[name], ["t", "q", "v", "u", "d", "c"], results)
             for name, results in _OF_CONSTRAINTS.items() if name in found}
    if "place" in found:
        table["place"] = ca.Function("place", [t, q, u, d, c], found["place"], ["t", "q", "u", "d", "c"], ["dq"])
    return table


def _constrained(kinematics: Kinematics, motion: Motion, energy: ca.SX, moving: HeldMotion) -> dict[str, list[ca.SX]]:
    """Results of the functions that only constraints ask for. `energy`: {T, V, H}, empty where nobody asks for them."""
    held = motion.constrained
    if held is None:
        return {}
    found = {"place": [held.place], "steer": [held.steer], "residual": [held.rows.phi, held.rows.rate]}
    if held.regular is not None:
        x = held.regular
        found["regular"] = [*right_hand_side(kinematics, motion, moving, x.acceleration, x.source_power), x.doubt]
        if x.place.numel():
            found["nearest"] = _nearest(motion, held, x, energy)
    return found


def _nearest(motion: Motion, held: ConstrainedMotion, regular: RegularMotion, energy: ca.SX) -> list[ca.SX]:
    """Corrections onto the constraints, and of the state that has them: residuals and energies."""
    place, pace = motion.q + regular.place, motion.v + regular.steer
    rest = ca.substitute([held.rows.phi, held.rows.rate, energy], [motion.q, motion.v], [place, pace])
    return [regular.place, regular.steer, *rest, regular.doubt]


def _hoisted(groups: Mapping[str, list[ca.SX]], p: ca.SX) -> tuple[dict[str, list[ca.SX]], Hoisted]:
    """`hoist` of groups with names."""
    hoisted = hoist(list(groups.values()), p)
    rest = iter(hoisted.expressions)
    return {name: list(islice(rest, len(group))) for name, group in groups.items()}, hoisted


def _flow_functions(motion: Motion, hamilton: Hamilton | None, flow: list[ca.SX], c: ca.SX) -> dict[str, ca.Function]:
    """Those of symplectic steps."""
    if hamilton is None:
        return {}
    velocity, force = flow
    momentum = ca.densify(motion.momentum)
    return {"momentum": ca.Function("momentum", [motion.q, motion.v, motion.p], [momentum], ["q", "v", "p"], ["Mv"]),
            "velocity": ca.Function("velocity", [motion.q, hamilton.p, c], [velocity], ["q", "p", "c"], ["v"]),
            "force": ca.Function("force", [motion.q, motion.v, c], [force], ["q", "v", "c"], ["dp"])}


def _add_linear(table: dict[str, ca.Function], kinematics: Kinematics,
                motion: Motion) -> tuple[dict[str, tuple[int, ...]], dict[str, str], Taken | None]:
    """The patterns of a linear scene, why the solver `linear` cannot run one that is none, and whether `auto` takes it."""
    if motion.impacts.conditions.numel():
        told = f"{kinematics.graph.model.set_at_events} at events"
        return {}, {"linear": told if motion.impacts.places else "branches of a when end it"}, None
    if kinematics.symbols.attitudes:
        return {}, {"linear": "attitudes turn"}, None
    if kinematics.graph.model.delays:
        return {}, {"linear": f"something acts late ({kinematics.graph.model.delays[0].span})"}, None
    form = find_linear_form(kinematics, motion)
    if not isinstance(form, LinearForm):
        return {}, {"linear": form}, None
    table |= {"linear": form.values, "waves": form.waves}
    return {"linear_pattern": form.pattern}, {}, decide(Moment.LINEAR, weigh_linear(kinematics, motion))


def observer(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, names: tuple[str, ...], has_sides: bool = False
) -> tuple[tuple[str, ...], ca.Function]:
    """Any quantities as a function of t, q, v, u, p; vectors give one row an element."""
    labels, y = _outputs(kinematics, names)
    return labels, observer_of(kinematics, motion, constraints, y, has_sides=has_sides)


def elements_of(kinematics: Kinematics, name: str) -> tuple[str, ...]:
    """The names of the elements of a quantity; its own of a scalar. Raises LagError L0701."""
    return _outputs(kinematics, (name,))[0]


def observer_of(kinematics: Kinematics, motion: Motion, constraints: Constraints, y: ca.SX,
                for_tape: bool = False, has_sides: bool = False) -> ca.Function:
    """Scalars that the kinematics' evaluator has made, (k, 1), as a function of t, q, v, u, p; held values and the references
    of attitudes stand behind u, in the order of their modes. Without calls for a tape. `has_sides`: and of the time and the
    inputs at which modes are as they are at t, which may be their event."""
    y = _solved(with_reactions(ca.substitute(y, kinematics.symbols.tau, ca.SX(1)), kinematics, motion, constraints), motion)
    modes = [mode for mode in kinematics.algebra.modes if not mode.is_kept]
    held = [mode.symbol for mode in kinematics.algebra.modes if mode.is_kept]
    sides = [ca.SX.sym("t_side"), ca.SX.sym("u_side", motion.u.numel() + len(held))] if has_sides else []
    if modes and y.numel():
        found = ca.vertcat(*[m.written if for_tape else m.value for m in modes])
        if sides:
            found = ca.substitute(found, ca.vertcat(motion.t, motion.u), ca.vertcat(sides[0], sides[1][:motion.u.numel()]))
        y = ca.substitute(y, ca.vertcat(*[m.symbol for m in modes]), found)
    return ca.Function("observe", [motion.t, motion.q, motion.v, ca.vertcat(motion.u, *held), motion.p, *sides], [y])


def outputs_of(kinematics: Kinematics, motion: Motion, constraints: Constraints, names: tuple[str, ...]
               ) -> tuple[tuple[str, ...], ca.SX, Put]:
    """Names and values of outputs, with symbols for the reactions that they ask for; and what puts these in."""
    labels, y = _outputs(kinematics, names)
    return labels, y, _putting_reactions(kinematics, motion, constraints)


def _putting_reactions(kinematics: Kinematics, motion: Motion, constraints: Constraints) -> Put:
    """What puts the reactions that have been asked for in the places of their symbols; those that forces feel stay symbols."""
    symbols, values = build_reactions(kinematics, motion.bodies, constraints, motion)

    def put(expressions: Sequence[ca.SX]) -> list[ca.SX]:
        return list(ca.substitute([*expressions], [symbols], [values])) if symbols.numel() else [*expressions]

    return put


def depends_on_forces(kinematics: Kinematics, motion: Motion, name: str) -> bool:
    """Whether a quantity is made of accelerations, multipliers, reactions or contact forces."""
    asked = observe(kinematics.graph.model, name)
    if speaks_of_contact_forces(kinematics.graph.model, asked):
        return True
    _labels, y = _outputs(kinematics, (name,))
    held, reactions = motion.constrained, [x for forces in kinematics.reactions.values() for x in forces]
    reactions += kinematics.forces.values()
    return bool(ca.depends_on(y, ca.vertcat(motion.a, held.symbols if held else ca.SX(0, 1), *reactions)))


def state_space(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, outputs: tuple[str, ...]
) -> tuple[list[ca.SX], list[ca.SX]]:
    """The symbols t, q, v, u, d, p, and in terms of them dv/dt, the outputs, the corrections of q and v onto the constraints."""
    _names, y = _outputs(kinematics, outputs)
    y = _solved(with_reactions(y, kinematics, motion, constraints), motion)
    held = motion.constrained
    zero = ca.SX.zeros(motion.q.numel(), 1)
    place, steer = (held.place, held.steer) if held else (zero, zero)
    d = kinematics.algebra.mode_symbols
    symbols = [motion.t, motion.q, motion.v, motion.u, d, motion.p]
    return symbols, [ca.densify(e) for e in (motion.acceleration, y, place if place.numel() else zero, steer)]


def _solved(y: ca.SX, motion: Motion) -> ca.SX:
    """Outputs with the accelerations and multipliers of the motion put in."""
    if not y.numel():
        return y
    held = motion.constrained
    if held:
        y = ca.substitute(y, held.symbols, held.multipliers)
    return ca.substitute(y, motion.a, motion.acceleration)


def with_reactions(y: ca.SX, kinematics: Kinematics, motion: Motion, constraints: Constraints) -> ca.SX:
    """Outputs with the reactions they ask for worked out."""
    (y,) = _putting_reactions(kinematics, motion, constraints)([y])
    return motion.solution.put([y])[0] if motion.solution else y


def _outputs(kinematics: Kinematics, names: tuple[str, ...]) -> tuple[tuple[str, ...], ca.SX]:
    found: dict[str, Scalar] = {}  # each once: r and r[1] may both be asked for
    for name in names:
        value = kinematics.attitude_named(name)
        value = kinematics.evaluator.value(observe(kinematics.graph.model, name)) if value is None else value
        for label, scalar in scalars(name, value):
            found.setdefault(label, scalar)
    labels, values = tuple(found), list(found.values())
    y = ca.densify(ca.vertcat(*exact_lengths(values))) if values else ca.SX(0, 1)
    tau = kinematics.symbols.tau
    return labels, ca.substitute(y, tau, ca.SX(1)) if values else y


def _implicit_function(jacobian: Jacobian, steps: list[ca.SX], full: list[ca.SX], labels: list[str]) -> dict[str, ca.Function]:
    """The matrix of implicit steps: written out, or as its products with directions."""
    if jacobian.parts:
        return {"jacobian": ca.Function("jacobian", full, steps, labels, ["S0", "S1", "S2"])}
    if not jacobian.tangent:
        return {}
    return {"tangent": ca.Function("tangent", [*full, *jacobian.along], steps, [*labels, "dq", "dv"], ["w", "r"])}


def _kick_function(state: list[ca.SX], found: list[ca.SX], before: ca.SX) -> dict[str, ca.Function]:
    if not found[0].numel():
        return {}
    return {"kick": ca.Function("kick", [*state, before], found, ["t", "q", "v", "u", "d", "c", "before"], ["dv"])}


def _reset_places(kinematics: Kinematics, motion: Motion) -> tuple[int, ...]:
    """Of each reset its event; its kind, with SIGNAL where it is of first-order states alone, CHANGE where its event comes where
    a condition changes to either side, KNOWN where what it sets does not come from the motion; and the coordinate whose rate
    itself is reset, -1 where it is any other."""
    rates = kinematics.symbols.rates
    signals = {rates[state.coordinate].__hash__() for state in kinematics.graph.model.states.values()}
    moving = {rate.__hash__() for rate in rates.values()}
    places = list(motion.impacts.places)
    for k in range(motion.impacts.rates.numel() if signals else 0):
        if symbols_in(motion.impacts.rates[k]) & moving <= signals:
            places[2 * k + 1] |= _SIGNAL
    changes = find_changes(kinematics.graph.model.whens)
    for k in range(len(places) // 2):
        places[2 * k + 1] |= _CHANGE * (places[2 * k] in changes) | _KNOWN * motion.impacts.known[k]
    own = {v.__hash__(): k for k, v in enumerate(motion.v.elements())}
    return tuple(x for k, rate in enumerate(motion.impacts.rates.elements())
                 for x in (*places[2 * k : 2 * k + 2], own.get(rate.__hash__(), -1)))


def _kept_places(kinematics: Kinematics, motion: Motion, has_edge: bool) -> dict[str, tuple[int, ...]]:
    """Events whose conditions ask for forces, the places of discrete variables among the rates, and of events whether they are
    true where rates meet their levels."""
    rates, states = kinematics.symbols.rates, kinematics.graph.model.states.values()
    kept = {rates[state.coordinate].__hash__() for state in states if state.is_kept}
    whens, loaded = kinematics.graph.model.whens, motion.impacts.loaded
    places = {"loaded": tuple(x for k in loaded for x in (k, int(whens[k].comes_at_start)))} if loaded else {}
    places |= {"kept": tuple(k for k, v in enumerate(motion.v.elements()) if v.__hash__() in kept)} if kept else {}
    order = tuple(x for when in whens for x in when.order)
    on_level, several = motion.impacts.on_level, motion.impacts.are_several if has_edge else ()
    if several:
        on_level = tuple(_SEVERAL[x] if some else x for some, x in zip(several, on_level, strict=True))
    return places | ({"on_level": on_level} if on_level else {}) | (
        {"order": order} if is_ordered(whens) else {})


def _patterns(kinematics: Kinematics, jacobian: Jacobian, switches: Switches, modes: list[Mode]) -> dict[str, tuple[int, ...]]:
    """Lists of places that a whole scene and an island have alike."""
    pieces = find_pieces(modes)
    return {"jacobian_pattern": jacobian.pattern, **switches.patterns, "lookups": find_lookups(modes),
            **({"pieces": pieces} if pieces else {}), **find_samplers(modes), **find_attitudes(kinematics, modes)}


def _sampling_functions(kinematics: Kinematics, motion: Motion, sampling: Sampling) -> dict[str, ca.Function]:
    """Held values at first, and from an instant on."""
    if not sampling.places:
        return {}
    state = [motion.t, motion.q, motion.v, motion.u, kinematics.algebra.mode_symbols, motion.p, sampling.fires]
    labels = ["t", "q", "v", "u", "d", "p", "fires"]
    return {"held_first": ca.Function("held_first", [motion.p], [ca.densify(sampling.first)], ["p"], ["held"]),
            "samples": ca.Function("samples", state, [ca.densify(sampling.values)], labels, ["held"])}


def _delay_functions(motion: Motion, delaying: Delaying, state: list[ca.SX], values: list[ca.SX]) -> dict[str, ca.Function]:
    """By how much, what is late as a function of `state`, and what that was before the start."""
    if not delaying.stated:
        return {}
    table = {"lags": ca.Function("lags", [motion.p], [ca.densify(delaying.lags)], ["p"], ["lags"]),
             "delayed": ca.Function("delayed", state, values, ["t", "q", "v", "u", "d", "c"], ["x"])}
    if any(delaying.stated):
        table["before"] = ca.Function("before", [motion.t, motion.p], [ca.densify(delaying.before)], ["t", "p"], ["x"])
    return table
