"""`when change(n)`: an event where a discrete variable gets another value (Modelica 3.6, section 3.7.5).

n.before, a variable of its own, is n as it was; the event comes where both differ, and makes them equal.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

from lagrangia.base.diagnostics import Report
from lagrangia.language.discrete import Event
from lagrangia.language.events import are_alike
from lagrangia.language.flat import Reset, Variable
from lagrangia.language.mentions import rebuilt
from lagrangia.language.tree import Binary, Call, Flat, Ref


def before(ref: Ref) -> Ref:
    """What n was when it last changed."""
    return Ref(f"{ref.name}.before", (), ref.span)


def is_before(name: str, variables: Collection[str]) -> bool:
    """Whether it is what one of the variables was."""
    stem, _, last = name.rpartition(".")
    return last == "before" and stem in variables


def changed(ref: Ref) -> Flat:
    """That it is another one by now."""
    sides = ref, before(ref)
    return Binary("or", Binary(">", *sides, ref.span), Binary("<", *sides, ref.span), ref.span)


def variable_of_change(condition: Flat) -> Ref | None:
    """The variable whose change a condition is."""
    match condition:
        case Binary("or", Binary(">", Ref() as ref, _), _) if are_alike(condition, changed(ref)):
            return ref
    return None


def at_change(event: Event) -> Event:
    """What happens where n changes: pre(n) is n.before."""
    ref = variable_of_change(event.condition)
    if ref is None:
        return event

    def meant(node: Flat) -> Flat | None:
        is_own = isinstance(node, Call) and node.function == "pre" and are_alike(node.arguments[0], ref)
        return before(ref) if is_own else None

    resets = tuple(replace(reset, value=rebuilt(reset.value, meant)) for reset in event.resets)
    return replace(event, resets=resets)


def events_of_changes(changing: Mapping[str, Ref], variables: Mapping[str, Variable], rank: int) -> Iterator[Event]:
    """How each n.before begins, as what is held did before any instant, and follows, behind all others."""
    for ref in changing.values():
        begun = Call("pre", (ref,), (), ref.span) if variables[ref.name].kind == "held" else ref
        first, later = (Reset(before(ref), value, ref.span, is_kept=True) for value in (begun, ref))
        component = ref.name.rpartition(".")[0]
        yield Event(Call("initial", (), (), ref.span), (first,), component, ref.span, (ref.name, "start"), is_start=True)
        yield Event(changed(ref), (later,), component, ref.span, (ref.name, "change"), rank=rank)


def variables_of_changes(changing: Mapping[str, Ref], variables: Mapping[str, Variable], types: Mapping[str, str],
                         kept: Sequence[Event], report: Report) -> dict[str, Variable]:
    """Each n.before. Reports L0901 for what does not change at events alone."""
    found = {}
    given = {x.rate.name for event in kept for x in event.resets if x.is_kept and isinstance(x.rate, Ref)}
    for name, ref in changing.items():
        if name not in types and name not in given and variables[name].kind != "held":
            report.error("L0901", "not of this language: an event where what moves changes, which it does all the time", ref.span,
                         "compare it with something, as x > 1; change(n) is of what events give its value")
            continue
        own = variables[name]
        found[before(ref).name] = Variable(
            before(ref).name, "variable", (), own.unit, own.display_unit, None, None, False, None, None, False,
            f"{name} as events of its changes know it", own.span, type_name=own.type_name)
    return found
