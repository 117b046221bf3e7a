"""`when` clauses of classes -> events, samplers and guards, and what discrete variables get."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeGuard

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.language.assertions import ending_of
from lagrangia.language.at_one_instant import in_order
from lagrangia.language.breaking import with_breaking
from lagrangia.language.changes import (
    at_change,
    changed,
    events_of_changes,
    variable_of_change,
    variables_of_changes,
)
from lagrangia.language.discrete import (
    Discrete,
    Event,
    bindings_of,
    compared,
    find_discrete,
    is_condition,
    of_own_past,
    refuse_own_past,
)
from lagrangia.language.elsewhen import come_apart, warn_of_both
from lagrangia.language.events import level_of
from lagrangia.language.flat import Equation, Guard, Held, Reset, Sampler, Variable
from lagrangia.language.instances import Scope
from lagrangia.language.names import Names
from lagrangia.language.tree import Array, Call, Clause, Expression, Flat, Ref, Unary, WhenBlock
from lagrangia.language.whole_numbers import WholeNumbers

_SAMPLED = "write: when sample(0, 0.01) then u = ...; end when;"
_AT_EVENTS = ("write: reinit(der(x), value);", "a variable of its own, which keeps its value until the next event, is given it: "
              "n = pre(n) + 1, declared as Integer n(start = 0)")
_Chain = tuple[tuple[WhenBlock, Scope], int, tuple[Flat, ...]]  # the first `when`, the branch, and the conditions before it


class EventClauses:
    """Collects them while classes are read; `read` reads a clause of a section."""

    def __init__(self, names: Names, report: Report, read: Callable[[str, Clause, Scope], None]) -> None:
        self.names, self.report, self.read = names, report, read
        self.samplers: list[Sampler] = []
        self.types: dict[str, str] = {}  # of Integer and Boolean variables
        self.whole = WholeNumbers(self.types, names.made.functions)
        self._integers: list[Flat] = []  # values of Integer variables
        self._events: list[Event] = []
        self._changing: dict[str, Ref] = {}  # those whose change is an event
        self._chains: dict[int, _Chain] = {}  # of each elsewhen, by its id
        self._resets: list[Reset] = []  # of the `when` that is being read
        self._endings: list[tuple[str, Span]] = []  # likewise: what is said where it ends the run
        self._held: list[Held] = []  # likewise

    def __len__(self) -> int:
        """How much was collected."""
        return len(self._events) + len(self.samplers) + len(self.types)

    def add(self, block: WhenBlock, scope: Scope, place: Span) -> None:
        """A `when` with its elsewhen. Raises LagError L0215, L0222, L0225."""
        conditions, (chain, branch, before) = self._conditions(block.condition, scope), self._chain(block, scope)
        is_kept = True  # whether all that the branch behind does is give values, or end the run
        if block.otherwise is not None:
            if any(_is_call(x, "sample") for x in conditions):
                fail("L0222", "elsewhen cannot follow a sampler", block.otherwise.span, "write two of them: when ... end when;")
            self._chains[id(block.otherwise)] = chain, branch + 1, (*before, *conditions)
            self.read("equation", block.otherwise, scope)
            is_kept = all(reset.is_kept for reset in self._resets)
        if any(_is_call(x, "sample") for x in conditions):
            self._add_sampler(block, conditions, scope, place)
            return
        self._resets, self._endings = [], []
        for part in block.body:
            self.read("when", part, scope)
        if self._endings and any(_is_call(x, "initial") for x in conditions):
            fail("L0222", "a run does not end where it begins", self._endings[0][1])
        if not (self._resets or self._endings) and not self.report.errors:
            fail("L0222", "nothing happens here", block.span, "write: reinit(der(x), value);")
        if block.otherwise is not None:
            behind = self._conditions(block.otherwise.condition, scope)
            for first, other in ((x, y) for x in conditions for y in behind if not (isinstance(x, Call) or isinstance(y, Call))):
                warn_of_both(first, other, block.otherwise, self.report, is_kept=is_kept)
        others = (*before, *(x for later in _behind(block) for x in self._conditions(later.condition, scope)))
        may_meet = not all(isinstance(y, Call) or come_apart(x, y) for x in conditions for y in others)
        for condition in conditions:
            self._add_event(Event(condition, tuple(self._resets), scope.instance.path, place, chain, branch=branch), may_meet)

    def _chain(self, block: WhenBlock, scope: Scope) -> _Chain:
        known = self._chains.get(id(block))
        return known if known is not None and known[0][1] is scope else ((block, scope), 0, ())

    def _conditions(self, node: Expression, scope: Scope) -> list[Flat]:
        """Each of {a, b}, and what edge and change say of each; initial() and sample(...) as calls."""
        if isinstance(node, Array):
            return [x for item in node.items for x in self._conditions(item, scope)]
        if _is_call(node, "sample") or _is_call(node, "initial"):
            wanted = 2 if node.function == "sample" else 0
            if len(node.arguments) != wanted or node.named:
                what = f"takes a start and an interval, not {len(node.arguments)} arguments" if wanted else "takes no arguments"
                fail("L0215", f"{node.function} {what}", node.span, _SAMPLED if wanted else "write: when initial() then")
            return [Call(node.function, tuple(self.names.flatten(x, scope) for x in node.arguments), (), node.span)]
        if (_is_call(node, "edge") or _is_call(node, "change")) and len(node.arguments) == 1 and not node.named:
            return [x for inner in self._conditions(node.arguments[0], scope) for x in self._changes(inner, node)]
        condition = self.names.without_known(self.names.flatten(node, scope))
        return [x for part in _elements_of(condition) for x in self._compared(part, node)]

    def _compared(self, condition: Flat, node: Expression) -> list[Flat]:
        """With comparisons of what is whole; n <> pre(n) is change(n)."""
        if (own := of_own_past(condition)) is not None:
            return self._changes(own, Call("change", (node,), (), node.span))
        refuse_own_past([condition])
        return [compared(condition, self.whole)]

    def _changes(self, inner: Flat, node: Call[Expression]) -> list[Flat]:
        """What edge and change say, as `node` does, of a condition or a variable. Raises LagError L0901."""
        if node.function == "edge":
            return [inner]
        if isinstance(inner, Ref):
            self._changing[inner.name] = inner
            return [changed(inner)]
        if not is_condition(inner):
            fail("L0901", "not supported yet: an event where an expression changes", node.span,
                 "give its value to a variable: Integer m = 2*n; when change(m) then ...")
        return [inner, Unary("not", inner, node.span)]

    def _add_event(self, event: Event, may_meet: bool) -> None:
        """With the endings of its branch, which ask the event whether they come where it `may_meet` others of its `when`, and
        where a variable changes: what it was follows at the same instant."""
        may_meet |= variable_of_change(event.condition) is not None
        endings = tuple(Guard(event.condition, text, "end", event.component, span) for text, span in self._endings)
        self.names.guards += endings
        if endings:
            level_of(event.condition)  # which raises where there is none
        if event.resets or (endings and may_meet):
            is_start = _is_call(event.condition, "initial")
            self._events.append(at_change(replace(event, is_start=is_start, endings=endings if may_meet else ())))

    def _add_sampler(self, block: WhenBlock, conditions: Sequence[Flat], scope: Scope, place: Span) -> None:
        call = conditions[0]
        if len(conditions) > 1 or not isinstance(call, Call):
            fail("L0901", "not supported yet: sample(...) beside other events", block.condition.span,
                 f"what is held has instants of its own: {_SAMPLED}")
        self._held = []
        for part in block.body:
            self.read("sample", part, scope)
        if not self._held and not self.report.errors:
            fail("L0222", "nothing is held here", block.span, _SAMPLED)
        start, interval = call.arguments
        self.samplers.append(Sampler(start, interval, tuple(self._held), scope.instance.path, place))

    def declare(self, variables: Sequence[Variable]) -> None:
        """Those that are Integer or Boolean."""
        self.types |= {variable.name: variable.type_name for variable in variables}
        self._integers += (value for variable in variables if variable.type_name == "Integer"
                        for value in (variable.binding, variable.start) if value is not None)

    def are_of(self, side: Flat) -> bool:
        """Whether a side of an equation is an array of Integer or Boolean variables."""
        return isinstance(side, Array) and all(
            self.are_of(x) or (isinstance(x, Ref) and x.name in self.types) for x in side.items)

    def assign(self, kind: str, left: Flat, right: Flat, place: Span) -> None:
        """What a variable is from an instant (kind "sample") or an event ("when") on. Raises LagError L0222, L0232."""
        if not isinstance(left, Ref) or left.index:
            if kind == "sample":
                fail("L0232", "a variable is given the value that it holds, this is none", left.span, _SAMPLED)
            if isinstance(left, Ref):
                fail("L0232", f"the element '{left}' of an array cannot be given a value at an event", left.span,
                     f"declare it as discrete Real {left.name}[n], an array of such variables")
            fail("L0222", "what happens at an event to what moves is said by reinit", left.span, *_AT_EVENTS)
        if self.types.get(left.name) == "Integer":
            self._integers.append(right)
        if kind == "sample":
            self._held.append(Held(left.name, right, place))
        else:
            self._resets.append(Reset(left, right, place, is_kept=True))

    def add_call(self, call: Expression, scope: Scope, span: Span) -> None:
        """reinit and terminate. Raises LagError L0215, L0222."""
        if not isinstance(call, Call) or call.function != "reinit":
            if isinstance(call, Call) and call.function == "terminate":
                self._endings.append((ending_of(call, scope, span, self.names), span))
                return
            if isinstance(call, Call) and call.function == "assert":
                fail("L0222", "what has to hold is said among the equations, and then holds all the time", span,
                     'write: equation assert(x < 1, "too far");')
            fail("L0222", "what happens at an event is said by reinit", span, "write: reinit(der(x), value);")
        if len(call.arguments) != 2 or call.named:
            fail("L0215", f"reinit takes a rate and its value, not {len(call.arguments)} arguments", span,
                 "write: reinit(der(x), value);")
        rate, value = (self.names.flatten(argument, scope) for argument in call.arguments)
        self._resets.append(Reset(rate, value, span))

    def finish(self, variables: Mapping[str, Variable], equations: Sequence[Equation]) -> Discrete:
        """The events, and what keeps discrete variables. Reports L0212, L0231, L0232, L0302."""
        self.whole.find_broken(self._integers, self.report)
        bindings = bindings_of(variables, equations)
        breaking = with_breaking(self._events, variables, bindings, self.whole)
        ordered = in_order(breaking.events, self.samplers, bindings)
        self.samplers = ordered.samplers
        self._changing |= {name: ref for name, ref in ordered.past.items() if name not in self._changing}
        made = variables_of_changes(self._changing, variables, self.types, self._events, self.report) | breaking.variables
        if self.report.errors:
            return Discrete({}, [], [], [])
        last = max((event.rank for event in ordered.events), default=0) + 1
        events = [*ordered.events, *events_of_changes(self._changing, variables, last)]
        self.types |= {name: variable.type_name for name, variable in made.items()}
        found = find_discrete(events, {**variables, **made}, equations, self.whole, self.report)
        return replace(found, variables={**made, **found.variables})


def _behind(block: WhenBlock) -> Iterator[WhenBlock]:
    """The branches behind one."""
    if block.otherwise is not None:
        yield block.otherwise
        yield from _behind(block.otherwise)


def _is_call(node: Expression | Flat, function: str) -> TypeGuard[Call[Any]]:
    return isinstance(node, Call) and node.function == function


def _elements_of(condition: Flat) -> Iterator[Flat]:
    """The scalars of an array, or a scalar itself."""
    for item in condition.items if isinstance(condition, Array) else ():
        yield from _elements_of(item)
    if not isinstance(condition, Array):
        yield condition
