"""Assertions and ends of runs -> numbers that are 0 or more as long as a run goes on, and what their conditions compare."""

from collections.abc import Iterator, Mapping

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import as_expression, symbols_in
from lagrangia.algebra.with_casadi import operations_in
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import scalars
from lagrangia.dynamics.levels import EDGE, JUMPS, Levels, Meetings, Steps, level_of_parts
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.events import level_of, without_not
from lagrangia.language.flat import FlatModel, Guard
from lagrangia.language.mentions import children
from lagrangia.language.tree import Call, Flat, FrameRef, Ref

KINDS: Mapping[str, int] = {"error": 0, "warning": 1, "end": 2}  # LAG_GUARD_ERROR, ...
OF_PARAMETERS = 4  # LAG_GUARD_OF_PARAMETERS: the motion does not decide it
HOLDS_ON_LEVEL, BREAKS_ON_LEVEL = 8, 16  # LAG_GUARD_...: where rates that resets have set meet what they are compared with
EVENTS = 32  # LAG_GUARD_EVENTS: times 1 + that event which tells whether it has come
_MOST_SHOWN = 8  # quantities of one condition


@dataclass(frozen=True)
class Guarding:
    """`values` (guards + shown,): each guard's number, then what people are told beside them; `shown` has of each guard the names
    of these."""

    values: ca.SX
    shown: tuple[tuple[str, ...], ...]
    kinds: tuple[int, ...]

    @property
    def patterns(self) -> dict[str, tuple[int, ...]]:
        """Lists of places of LagModel."""
        return {"guard_kinds": self.kinds} if self.kinds else {}

    def sizes(self, accelerations: ca.SX) -> dict[str, int]:
        """Those of LagModel; `accelerations`: symbols that a state does not tell of."""
        if not self.kinds:
            return {}
        needs = ca.depends_on(self.values, accelerations)
        return {"n_guards": len(self.kinds), "n_seen": sum(map(len, self.shown)), "guards_need_acceleration": int(needs)}


NOT_GUARDED = Guarding(ca.SX(0, 1), (), ())


def find_guarding(kinematics: Kinematics) -> Guarding:
    """Raises LagError L0225 for what is never decided anew: what is neither a parameter nor moves."""
    model, tau = kinematics.graph.model, kinematics.symbols.tau
    values, seen, shown, kinds = [], [], [], []
    steps, events = Steps(kinematics), {guard: k for k, when in enumerate(model.whens) for guard in when.endings}
    for guard in model.guards:
        meetings = Meetings(kinematics)
        is_by_event = guard in events
        g = ca.SX(1) if is_by_event else _level(kinematics, guard, meetings, steps)
        told = dict(_shown(kinematics, guard))
        is_constant = not ca.depends_on(g, _following(kinematics)) and kinematics.algebra.changing.isdisjoint(symbols_in(g))
        if guard.kind == "end" and is_constant and not is_by_event:
            fail("L0225", "this is true or false for good, and no event", guard.condition.span.within(guard.span),
                 "compare what moves, as x > 1")
        values.append(g)
        shown.append(tuple(told))
        seen += [ca.substitute(as_expression(x), tau, ca.SX(1)) for x in told.values()]
        by_itself = (OF_PARAMETERS if is_constant else 0) + _on_level(guard, meetings)
        kinds.append(KINDS[guard.kind] + (EVENTS * (1 + events[guard]) if is_by_event else by_itself))
    return Guarding(ca.densify(ca.vertcat(ca.SX(0, 1), *values, *seen)), tuple(shown), tuple(kinds))


def _on_level(guard: Guard, meetings: Meetings) -> int:
    """What it is where rates meet what they are compared with; 0: what its number says."""
    is_true = meetings.on_level()
    return 0 if is_true < 0 else BREAKS_ON_LEVEL if is_true == (guard.kind == "end") else HOLDS_ON_LEVEL


def _level(kinematics: Kinematics, guard: Guard, meetings: Meetings, steps: Steps) -> ca.SX:
    """0 or more as long as the run goes on, also where both sides of a comparison are equal. Raises LagError L0225 where it
    jumps in a way that is not taken apart."""
    sign = -1 if guard.kind == "end" else 1
    return as_expression(sign * (_level_of_condition(kinematics, guard, meetings, steps) - EDGE / 2))


def _level_of_condition(kinematics: Kinematics, guard: Guard, meetings: Meetings, steps: Steps) -> ca.SX:
    """Positive where it is true, else 0 or negative."""
    value, tau = kinematics.evaluator.value, kinematics.symbols.tau

    def expression(node: Flat) -> ca.SX:
        return as_expression(ca.substitute(as_expression(value(node)), tau, ca.SX(1)))

    others = list[ca.SX]()  # what is compared, but for what changes at events alone

    def level_of_part(part: Flat) -> ca.SX:
        difference = expression(level_of(part))
        meetings.note(part, difference)
        others.extend([] if steps.decide(difference) else [difference])
        return steps.level(part, difference)

    moving = ca.vertcat(kinematics.symbols.time, kinematics.algebra.state, _following(kinematics))
    g = level_of_parts(without_not(guard.condition), level_of_part)
    if operations_in(ca.vertcat(ca.SX(0, 1), *others)).isdisjoint(JUMPS) or symbols_in(moving).isdisjoint(symbols_in(g)):
        return g
    level = Levels(steps.beside(moving), edge=EDGE).of(expression(guard.condition))
    if level is None:
        fail("L0225", "this changes where something in it jumps, in a way that is not taken apart",
             guard.condition.span.within(guard.span), "compare with <, <=, > or >= in it, not with == or <>")
    return level


def _following(kinematics: Kinematics) -> ca.SX:
    """Symbols of what follows from the state: accelerations, and the forces of joints and contacts that were asked for."""
    forces = [*kinematics.forces.values(), *(f for wrench in kinematics.reactions.values() for f in wrench)]
    return ca.vertcat(ca.SX(0, 1), *kinematics.symbols.accelerations.values(), *forces)


def _shown(kinematics: Kinematics, guard: Guard) -> Iterator[tuple[str, Scalar]]:
    """The quantities that a condition names, with their elements."""
    count = 0
    for node in _named(guard.condition):
        inner = node.arguments[0] if isinstance(node, Call) else node
        name = f"der({inner})" if isinstance(node, Call) else str(node)
        for found in scalars(name, kinematics.evaluator.value(node)):
            count += 1
            if count > _MOST_SHOWN:
                return
            yield found


def _named(node: Flat) -> Iterator[Flat]:
    if isinstance(node, Ref | FrameRef) or (isinstance(node, Call) and node.function == "der"
                                            and isinstance(node.arguments[0], Ref | FrameRef)):
        if not isinstance(node, FrameRef) or node.attribute:
            yield node
        return
    for inner in children(node):
        yield from _named(inner)


def is_of_parameters(kind: int) -> bool:
    """Whether the motion does not decide a guard of that kind."""
    return bool(kind & OF_PARAMETERS)


def tell_guards(model: FlatModel, guarding: Guarding) -> list[dict[str, object]]:
    """For people: as text, as the scene outlives the source it points at."""
    return [{"text": guard.text, "place": str(guard.span), "condition": guard.condition.span.text, "kind": guard.kind,
             "component": guard.component, "seen": list(names), "is_of_parameters": is_of_parameters(kind),
             "excerpt": guard.span.excerpt}
            for guard, names, kind in zip(model.guards, guarding.shown, guarding.kinds, strict=True)]
