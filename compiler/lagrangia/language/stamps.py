"""What the first of elements that are alike brings into the flat model, stamped out for the others.

What it brought is written as one expression of Python in which names begin with a path that is not known yet; evaluated once for
each element, it makes what flattening would: names in its class lead into the element itself, and what was written outside it
means the same for all, but for what is dealt out.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import compress, islice
from typing import Any, Protocol

from lagrangia.base.diagnostics import LagError, Report, Span
from lagrangia.base.records import dataclass
from lagrangia.language.alike_elements import Alike
from lagrangia.language.flat import Energy, Equation, Figure, Frame, FrameEquation, Variable, Work
from lagrangia.language.instances import Bound, FrameSlot, Instance, Member, Slot
from lagrangia.language.space_values import is_fitted
from lagrangia.language.tree import Array, Binary, Call, Flat, FrameRef, IfExpression, Ref, Unary

_MADE = (Ref, FrameRef, Unary, Binary, IfExpression, Call, Array, Variable, Frame, FrameEquation, Equation, Energy, Work, Figure)
_NAMES = frozenset({"name", "component"})  # of these classes: full names
_DEEPEST = 40  # nested brackets: Python reads 200
LISTS = ("frame_equations", "equations", "energies", "works", "initial", "figures")
TABLES = ("variables", "frames", "structural", "components", "flanges")
SETS = ("ends", "inputs")
_CHECKED = ("variables", "frame_equations", "equations", "energies", "works")  # by what looks at dimensions
_OTHERS = ("joined", "connections", "events", "guards")  # what brings these is flattened one by one


class Names(Protocol):
    """What values mean (names.py)."""

    delays: dict[str, Any]
    turned: dict[str, Any]

    def flatten_bound(self, bound: Bound, shape: tuple[int, ...] = ()) -> Flat:
        """A value as it is in the flat model. Raises LagError."""


class Flattening(Protocol):
    """What flattening.py collects, under the names above."""

    report: Report
    at_rest: Span | None
    repeats: dict[int, object]

    @property
    def names(self) -> Names:
        """What values mean."""

    def fitted(self, value: Flat, slot: Slot) -> Flat:
        """What a variable is bound to, as the space has it."""

    def bound_frame(self, slot: FrameSlot) -> FrameEquation:
        """The equation of a port that is given one. Raises LagError."""


class _TooDeepError(Exception):
    """Brackets that Python does not read."""


def stamp(flat: Flattening, elements: Alike, visit: Callable[[Member], None]) -> list[Member]:
    """Visits the first element, and adds what the others bring; returns those that have to be visited as well."""
    first, *others = elements
    told, before = state_of(flat), {name: len(getattr(flat, name)) for name in (*LISTS, *TABLES)}
    kept = {name: set(getattr(flat, name)) for name in SETS}
    visit(first)
    if state_of(flat) != told:
        return others
    brought = {name: list(islice(_listed(getattr(flat, name)), before[name], None)) for name in before}
    brought |= {name: sorted(getattr(flat, name) - kept[name]) for name in SETS}
    writer = _Writer(first, elements)
    try:
        make = writer.lambda_of(brought)
    except _TooDeepError:
        return others
    add = {name: getattr(flat, name).extend if name in LISTS else getattr(flat, name).update for name in brought}
    are_repeats = writer.all_have_units(x for _, x in brought["variables"])
    repeated = {name: [not own for own in writer.own[name]] for name in _CHECKED} if are_repeats else {}
    for k, element in enumerate(others, 2):
        try:
            found = make(f"{elements.stem}{k}", k, [_at(element, way) for way in writer.ports], flat)
        except LagError:  # in what is dealt out to it: told where it is visited
            return others[k - 2 :]
        for name, items in zip(brought, found, strict=True):
            add[name](items)
            if name in repeated:
                new = compress([x[1] for x in items] if name in TABLES else items, repeated[name])
                flat.repeats.update([(id(x), x) for x in new])
    return []


def state_of(flat: Flattening) -> tuple[int, ...]:
    """Grows where something is wrong, or is brought that is not stamped out."""
    return (len(flat.report.diagnostics), len(flat.names.delays), len(flat.names.turned),
            *(len(getattr(flat, name)) for name in _OTHERS), flat.at_rest is not None)


def _listed(items: Any) -> Any:
    return items.items() if isinstance(items, Mapping) else items


def _at(element: Member, way: tuple[str | int, ...]) -> Any:
    found: Any = element
    for part in way:
        found = found[part] if isinstance(part, int) else found.members[part] if part else found.frame
    return found


@dataclass
class _Writer:
    """Text that makes what the first element brought, where names begin with `p`, of another index `i`."""

    first: Member
    elements: Alike

    def __post_init__(self) -> None:
        self.mark, self.begin = self.elements.mark, f"{self.elements.stem}{self.elements.mark}"
        self.known: dict[str, Any] = {cls.__name__: cls for cls in _MADE}
        self.numbers: dict[int, str] = {}
        self.names: dict[str, str] = {}  # how full names end, and what they are called
        self.slots, self.frames = dict[str, Slot](), dict[str, tuple[FrameSlot, tuple[str | int, ...]]]()
        self.within: set[int] = set()
        self.own: dict[str, list[bool]] = {name: [] for name in _CHECKED}  # of each item, whether it was made of what is dealt
        self.is_own = False
        self.ports: list[tuple[str | int, ...]] = []  # ways to frames that are given what is dealt out
        for slot, way in self._walk(self.first, ()):
            if isinstance(slot, Slot):
                self.slots[slot.path] = slot
            else:
                self.frames[slot.path] = slot, way

    def _walk(self, member: Any, way: tuple[str | int, ...]) -> Iterator[tuple[Slot | FrameSlot, tuple[str | int, ...]]]:
        if isinstance(member, list):
            for k, item in enumerate(member):
                yield from self._walk(item, (*way, k))
        elif isinstance(member, Instance):
            self.within.add(id(member))
            if member.frame is not None:
                yield member.frame, (*way, "")
            for name, inner in member.members.items():
                yield from self._walk(inner, (*way, name))
        else:
            yield member, way

    def lambda_of(self, brought: Mapping[str, list[Any]]) -> Callable[..., Any]:
        """Of the path, the index, frames on the ways `ports`, and the flattening: what another element brings. Raises
        _TooDeepError."""
        text = ", ".join(f"({''.join(f'{self.noted(x, name)}, ' for x in items)})" for name, items in brought.items())
        names = "".join(f"{name} := p + {end!r}, " for end, name in self.names.items())  # one string each: found by what it is
        found: Callable[..., Any] = eval(f"lambda p, i, slots, flat: ({names}({text}))[-1]", self.known)
        return found

    def all_have_units(self, variables: Iterable[Variable]) -> bool:
        """Whether the dimensions of none follow from what may be another value in another element."""
        return not any(x.kind == "variable" and not x.unit and (x.binding is None or self.mark.deals(self.slots[x.name].binding))
                       for x in variables)

    def noted(self, x: Any, where: str) -> str:
        self.is_own = False
        text = self.item(x)
        if where in self.own:
            self.own[where].append(self.is_own)
        return text

    def item(self, x: Any) -> str:
        if isinstance(x, tuple):  # of a table
            name, value = x
            return f"({self.name(name)}, {self.item(value) if isinstance(value, _MADE) else self.constant(value)})"
        if isinstance(x, str):
            return self.name(x)
        if isinstance(x, Variable):
            slot = self.slots[x.name]
            return self.made(x, binding=self.value(x.binding, slot.binding, slot.dimensions, slot),
                             start=self.value(x.start, slot.attributes.get("start")))
        if isinstance(x, Frame):
            bounds = self.frames[x.name][0].starts
            starts = [f"{name!r}: {self.value(value, bounds[name])}" for name, value in x.starts.items()]
            return self.made(x, starts=f"{{{', '.join(starts)}}}")
        if isinstance(x, FrameEquation) and isinstance(x.left, FrameRef) and x.left.name in self.frames:
            port, way = self.frames[x.left.name]
            if port.binding is not None and x.left.span is port.binding.expression.span:
                return self.port(x, port.binding, way)
        return self.text(x)

    def port(self, x: FrameEquation, binding: Bound, way: tuple[str | int, ...]) -> str:
        if self.mark.deals(binding):
            self.is_own = True
            self.ports.append(way)
            return f"flat.bound_frame(slots[{len(self.ports) - 1}])"
        return self.made(x, right=self.value(x.right, binding))

    def value(self, flat: Flat | None, bound: Bound | None, shape: tuple[int, ...] = (), slot: Slot | None = None) -> str:
        """What was given to a frame, or to a variable, whose `slot` may be otherwise in space."""
        if flat is None or bound is None:
            return "None"
        if self.mark.deals(bound):
            self.is_own = True
            text = f"flat.names.flatten_bound({self.constant(self.mark)}.dealt({self.constant(bound)}, i), {shape})"
            if slot is not None and is_fitted(slot.declaration):
                text = f"flat.fitted({text}, {self.constant(slot)})"
            return text
        return self.text(flat) if id(bound.scope.instance) in self.within else self.constant(flat)

    def made(self, x: Any, **known: str) -> str:
        """With texts for some of its parts."""
        parts = [known[name] if name in known else self.name(part) if name in _NAMES else self.text(part)
                 for name in x.__match_args__ for part in (getattr(x, name),)]
        return f"{type(x).__name__}({', '.join(parts)})"

    def text(self, x: Any, depth: int = 0) -> str:
        """Of an expression, or what is made of some."""
        return self.changed(x, depth) or self.constant(x)

    def changed(self, x: Any, depth: int = 0) -> str | None:
        """None where it is the same for all."""
        if depth > _DEEPEST:
            raise _TooDeepError
        if isinstance(x, tuple):
            parts = [self.changed(item, depth + 1) for item in x]
            made = [part or self.constant(item) for part, item in zip(parts, x, strict=True)]
            return f"({''.join(f'{part}, ' for part in made)})" if any(parts) else None
        if isinstance(x, Mapping):
            found = {key: self.changed(item, depth + 1) for key, item in x.items()}
            pairs = (f"{key!r}: {part or self.constant(x[key])}" for key, part in found.items())
            return f"{{{', '.join(pairs)}}}" if any(found.values()) else None
        if not isinstance(x, _MADE):
            return None
        names = x.__match_args__
        parts = [self.renamed(getattr(x, n)) if n in _NAMES else self.changed(getattr(x, n), depth + 1) for n in names]
        made = [part or self.constant(getattr(x, n)) for part, n in zip(parts, names, strict=True)]
        return f"{type(x).__name__}({', '.join(made)})" if any(parts) else None

    def name(self, name: str) -> str:
        return self.renamed(name) or self.constant(name)

    def renamed(self, name: str) -> str | None:
        """None for what is not in the element."""
        begin = self.begin
        is_inside = name.startswith(begin) and name[len(begin) : len(begin) + 1] in ("]", ",")
        return self.names.setdefault(name[len(begin) :], f"n{len(self.names)}") if is_inside else None

    def constant(self, x: Any) -> str:
        if id(x) not in self.numbers:
            self.numbers[id(x)] = f"k{len(self.numbers)}"
            self.known[self.numbers[id(x)]] = x
        return self.numbers[id(x)]
