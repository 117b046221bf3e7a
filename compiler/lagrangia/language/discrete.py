"""Discrete variables: `when condition then n = pre(n) + 1; end when;` gives n a value that it keeps until the next event
(Modelica 3.6, section 8.3.5).

Each is a first-order state at rest, der(n) = 0, which the event resets. pre(n) is n before the event; n itself, of another one
that the same `when` gives a value, what it is from there on. `when initial()` says how it begins. Those that are true or false
are the numbers 1 and 0 (truths.py), which are read as conditions.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from functools import partial

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.base.records import dataclass
from lagrangia.language.elements import Size, array_of, dealt_out
from lagrangia.language.events import are_alike
from lagrangia.language.flat import Equation, Guard, Reset, Variable, When
from lagrangia.language.mentions import nodes, read_now, rebuilt
from lagrangia.language.number_checks import CONDITIONS
from lagrangia.language.tree import Array, Binary, Boolean, Call, Expression, Flat, IfExpression, Number, Ref, Reference, Unary
from lagrangia.language.truths import NO, number_of, truth_of
from lagrangia.language.whole_numbers import WholeNumbers

Bindings = Mapping[str, Flat | None]


@dataclass(frozen=True)
class Event:
    """The assignments and resets of one condition, or of `initial()`; `chain` is one for a `when` and its elsewhen."""

    condition: Flat
    resets: tuple[Reset, ...]
    component: str
    span: Span
    chain: object
    is_start: bool = False
    branch: int = 0  # of these
    rank: int = 0  # at an instant: at_one_instant.py
    endings: tuple[Guard, ...] = ()  # of the run, which come with it
    comes_at_start: bool = False  # where its condition is true there


def is_condition(node: Flat) -> bool:
    """Whether it is true or false."""
    return isinstance(node, Boolean) or (isinstance(node, Unary) and node.operator == "not") or (
        isinstance(node, Binary) and node.operator in CONDITIONS)


def compared(condition: Flat, whole: WholeNumbers) -> Flat:
    """A condition with comparisons in place of == and <> of what is whole, as n == 3, and of what is true or false."""
    match condition:
        case Unary("not", operand, span):
            return Unary("not", compared(operand, whole), span)
        case Binary("and" | "or" as operator, left, right, span):
            return Binary(operator, compared(left, whole), compared(right, whole), span)
        case Binary("==" | "<>" as operator, condition, Boolean(value), span) | Binary(
                "==" | "<>" as operator, Boolean(value), condition, span):
            same = compared(condition, whole) if value else Unary("not", compared(condition, whole), span)
        case Binary("==" | "<>" as operator, left, right, span) if is_condition(left) and is_condition(right):
            one, other = compared(left, whole), compared(right, whole)
            neither = Binary("and", Unary("not", one, one.span), Unary("not", other, other.span), span)
            same = Binary("or", Binary("and", one, other, span), neither, span)
        case Binary("==" | "<>" as operator, left, right, span) if not any(whole.broken(x, True) for x in (left, right)):
            same = Binary("and", Binary(">=", left, right, span), Binary("<=", left, right, span), span)
        case _:
            return condition
    return same if operator == "==" else Unary("not", same, span)


def of_own_past(condition: Flat) -> Flat | None:
    """n of n <> pre(n)."""
    if not (isinstance(condition, Binary) and condition.operator == "<>"):
        return None

    def now(node: Flat) -> Flat | None:
        return node.arguments[0] if isinstance(node, Call) and node.function == "pre" else None

    def is_past(node: Flat) -> bool:
        return any(now(x) is not None for x in nodes(node))

    for own, past in ((condition.left, condition.right), (condition.right, condition.left)):
        if is_past(past) and not is_past(own) and are_alike(rebuilt(past, now), own):
            return own
    return None


def refuse_own_past(conditions: Iterable[Flat]) -> None:
    """n > pre(n) and its like say that something changes, which is so at no time but the event's own. Raises LagError L0225."""
    for condition in conditions:
        now = set(read_now([condition], {}))
        for node in nodes(condition):
            if isinstance(node, Call) and node.function == "pre" and isinstance(n := node.arguments[0], Ref) and n.name in now:
                fail("L0225", f"'{n.name}' is pre({n.name}) but at the instant of its event: this never comes true",
                     condition.span, "of what is true or false, change(b) and edge(b) are such events",
                     "for a number, write what happens in the `when` that gives it its value")


def as_numbers(left: Expression, *sides: Flat) -> tuple[Flat, Flat]:
    """Both sides of an equation; where the left one is a Boolean variable, as numbers. Raises LagError L0302."""
    first, second = sides
    named = _named_truth(first) if isinstance(left, Reference) else None
    return (first, second) if named is None else (named, number_of(second, NO))


def signals_of(nodes: Sequence[Expression], ends: Sequence[Flat], span: Span) -> list[Flat]:
    """What the ends of a connection stand for; of Boolean variables, their numbers. Raises LagError L0221 where one alone is."""
    named = [_named_truth(end) if isinstance(node, Reference) else None for node, end in zip(nodes, ends, strict=True)]
    if any(truth is not None for truth in named) and None in named:
        fail("L0221", "connect joins what is alike: one of these is true or false", span,
             "a number of it is if b then 1 else 0, or Blocks.BooleanToReal; a truth value of a number x > 0")
    return [end if truth is None else truth for truth, end in zip(named, ends, strict=True)]


def _named_truth(side: Flat) -> Flat | None:
    """The Boolean variable that a condition is, or the array of some."""
    if isinstance(side, Array) and side.items:
        items = tuple(item for x in side.items if (item := _named_truth(x)) is not None)
        return Array(items, side.span) if len(items) == len(side.items) else None
    return side.left if isinstance(side, Binary) and isinstance(side.left, Ref) else None


@dataclass(frozen=True)
class Discrete:
    """What events give to variables, as events and equations."""

    variables: dict[str, Variable]  # those that `initial()` gives a value: their starts are what was before
    whens: list[When]
    equations: list[Equation]  # der(n) = 0
    initial: list[Equation]


def bindings_of(variables: Mapping[str, Variable], equations: Sequence[Equation]) -> Bindings:
    """What variables stand for, by their declarations or by equations; arrays as their elements, where they can be dealt out."""
    bindings: dict[str, Flat | None] = {name: variable.binding for name, variable in variables.items()}
    elements = dict[str, dict[tuple[int, ...], Flat]]()

    def size(ref: Ref) -> int | None:
        shape = variables[ref.name].shape if ref.name in variables else ()
        return shape[len(ref.index)] if len(shape) > len(ref.index) else None

    for equation in equations:
        for ref, value in _solved(equation.left, equation.right, size):
            if ref.index:
                elements.setdefault(ref.name, {}).setdefault(ref.index, value)
            elif bindings.get(ref.name) is None:
                bindings[ref.name] = value
    for name, variable in ((name, variable) for name, variable in variables.items() if variable.shape):
        whole, found = bindings[name], elements.get(name, {})
        if whole is not None:
            bindings[name] = dealt_out(whole, variable.shape, size)
        elif found and all(index in found for _, index in variable.elements()):
            bindings[name] = array_of(variable.shape, (), found, variable.span)
    return bindings


def _solved(left: Flat, right: Flat, size: Size) -> Iterator[tuple[Ref, Flat]]:
    """The variables and elements that a side of an equation is, as y, y[1] and y[1:2], with what they are."""
    if isinstance(left, Ref):
        yield left, right
    elif isinstance(left, Array) and isinstance(whole := dealt_out(right, (len(left.items),), size), Array):
        for item, value in zip(left.items, whole.items, strict=True):
            yield from _solved(item, value, size)


def meant_by(ref: Ref, bindings: Bindings) -> Flat | None:
    """What a variable, or an element of an array, stands for. Raises LagError L0901 for one of an array of products."""
    value = bindings.get(ref.name)
    for k in ref.index:
        if value is not None and not isinstance(value, Array):
            fail("L0901", f"not supported yet: the element '{ref}' of an array of products at an instant at which these change",
                 ref.span, f"give it to a variable of its own, by an equation: Real x = {ref}")
        value = value and value.items[k - 1]
    return value


def find_discrete(events: Sequence[Event], variables: Mapping[str, Variable], equations: Sequence[Equation],
                  whole: WholeNumbers, report: Report) -> Discrete:
    """Reports L0231, L0232 for what cannot be given a value at an event, or is so in two places, L0212."""
    bound = {side.name for x in equations for side in (x.left if isinstance(x.left, Ref) else x.right,) if isinstance(side, Ref)}
    rates = {str(node.arguments[0]): x.span for x in equations for node in nodes(x.left, x.right)
             if isinstance(node, Call) and node.function == "der"}
    begun, kept = dict[str, Event](), dict[str, Event]()  # the first event that gives a name its value at the start, and later
    for event in events:
        others = begun if event.is_start else kept
        for name, span in ((x.rate.name, x.span) for x in event.resets if x.is_kept and isinstance(x.rate, Ref)):
            _refuse(name, span, variables[name], event, bound, rates, others, report)
            others.setdefault(name, event)
    given = begun | kept
    if report.errors:
        return Discrete({}, [], [], [])
    bindings = bindings_of(variables, equations)
    found = Discrete({}, [], [], [])
    chains = {chain: k for k, chain in enumerate(dict.fromkeys(id(event.chain) for event in events))}
    for event in events:
        resets = _with_new_values(event, bindings)
        if event.is_start:
            names = [x.rate.name for x in resets if x.is_kept and isinstance(x.rate, Ref)]
            found.variables.update({name: replace(variables[name], start=None, is_fixed=False) for name in names})
            found.initial.extend(Equation(x.rate, _at_start(x.value, variables), x.span, event.component) for x in resets)
            continue
        condition = compared(opened(event.condition, bindings), whole)
        order = event.rank, chains[id(event.chain)], event.branch
        found.whens.append(When(condition, resets, event.component, event.span, order, event.endings, event.comes_at_start))
    for name, event in given.items():
        rate = Call("der", (Ref(name, (), event.span),), (), event.span)
        found.equations.append(Equation(rate, Number(0.0, None, event.span), event.span, event.component))
    return found


def _refuse(name: str, span: Span, variable: Variable, event: Event, bound: Set[str], rates: Mapping[str, Span],
            given: Mapping[str, Event], report: Report) -> None:
    if variable.kind == "coordinate" or name in rates:
        rate = name if variable.kind != "coordinate" else f"der({name})"
        report.error("L0231", f"'{name}' moves, and cannot be given a value that it keeps", span,
                     f"to make it jump, write: reinit({rate}, value);")
    elif variable.kind != "variable" or variable.binding is not None or name in bound:
        report.error("L0232", f"'{name}' cannot be given a value at an event: it has one", span,
                     f"declare it without, as Real {name}(start = 0)")
    elif variable.shape:
        report.error("L0232", f"'{name}' cannot be given a value at an event: it is an array", span,
                     f"declare it as discrete Real {name}[n]")
    elif name in given and given[name].chain is not event.chain:
        report.error("L0232", f"'{name}' is given a value in two places", span,
                     "write one `when`: when a then ... elsewhen b then ... end when; or when {a, b} then ...")


def _with_new_values(event: Event, bindings: Bindings) -> tuple[Reset, ...]:
    """The resets of an event, so that all that they read is as before it. Raises LagError L0212."""
    given = {x.rate.name: x for x in event.resets if x.is_kept and isinstance(x.rate, Ref)}
    new = {name: reset.value for name, reset in given.items()}
    if not new:
        return event.resets

    def now(node: Flat, pending: tuple[str, ...]) -> Flat | None:
        if isinstance(node, Call) and node.function == "pre":
            return node
        if not isinstance(node, Ref):
            return None
        name = str(node)
        if name in pending:
            fail("L0212", f"'{name}' follows from itself at this event", given[pending[0]].span,
                 " > ".join((*pending[pending.index(name) :], name)), f"pre({name}) is the value before")
        value = new.get(name)
        if value is None and not new.keys().isdisjoint(read_now([node], bindings)):
            value = meant_by(node, bindings)
        return value and rebuilt(value, partial(now, pending=(*pending, name)))

    def first(reset: Reset) -> tuple[str, ...]:
        return (reset.rate.name,) if reset.is_kept and isinstance(reset.rate, Ref) else ()

    return tuple(replace(x, value=rebuilt(x.value, partial(now, pending=first(x)))) for x in event.resets)


def _at_start(value: Flat, variables: Mapping[str, Variable]) -> Flat:
    """pre(n) is where n starts."""

    def before(node: Flat) -> Flat | None:
        if isinstance(node, Call) and node.function == "pre" and isinstance(inner := node.arguments[0], Ref):
            variable = variables[inner.name]
            if variable.kind in ("variable", "held") and variable.binding is None:
                return variable.start or Number(0.0, None, node.span)
        return None

    return rebuilt(value, before)


def opened(condition: Flat, bindings: Bindings) -> Flat:
    """A condition with those in the places of the Boolean variables that are bound to them, so that contacts are seen."""

    def meant(node: Flat) -> Flat | None:
        if isinstance(node, Binary) and node.operator == ">" and isinstance(node.left, Ref):
            match bindings.get(node.left.name):
                case IfExpression(inner, Number(1.0), Number(0.0)) if node == truth_of(node.left, NO):
                    return opened(inner, bindings)
        return None

    return rebuilt(condition, meant)
