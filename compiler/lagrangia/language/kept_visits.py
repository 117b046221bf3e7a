"""What components of a scene brought into the flat model when it was flattened last: brought again where all is as it was.

That follows from the component itself, which is kept (kept_components.py), and from what the names in its declaration stand for.
What asks for a value that is put in from elsewhere, or for what is made once for a whole scene, is visited each time.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.language.instances import Instance, Member, Slot
from lagrangia.language.stamps import LISTS, SETS, TABLES, state_of
from lagrangia.language.tree import Call, Declaration, Reference

_ONCE = ("delays", "turned", "lookups", "packages")  # in a scene, of names.py
_WRITTEN = "written"  # likewise: constants, by full names
_MADE: Mapping[str, type] = {**dict.fromkeys((*LISTS, "joined", "connections"), list),
                               **dict.fromkeys((*TABLES, "repeats", _WRITTEN), dict),
                               **dict.fromkeys(SETS, set)}


@dataclass(frozen=True)
class _Visit:
    """What a component brought, and what the names in its declaration stood for."""

    component: Member
    named: Mapping[str, Member | None]
    brought: Mapping[str, Any]
    operations: int

    def is_good(self, root: Instance) -> bool:
        """Whether the names stand for the same."""
        return all(_is_same(old, root.members.get(name), root) for name, old in self.named.items())


class KeptVisits:
    """Of the last scene that was flattened with these, by the ids of components."""

    def __init__(self) -> None:
        self.last: dict[int, _Visit] = {}
        self.now: dict[int, _Visit] = {}

    def begin(self) -> None:
        """The components of a scene are visited."""
        self.last, self.now = self.now, {}

    def visit(self, flat: Any, root: Instance, component: Member, declaration: Declaration, visit: Callable[[], None]) -> None:
        """Puts into a flattening what a component brings."""
        known = self.last.get(id(component))
        if known is not None and known.is_good(root):
            flat.names.work.spend(known.operations, declaration.name_span)
            _put(flat, known.brought)
        else:
            known = _visited(flat, root, component, declaration, visit)
        if known is not None:
            self.now[id(component)] = known


def _visited(flat: Any, root: Instance, component: Member, declaration: Declaration, visit: Callable[[], None]) -> _Visit | None:
    """None where not all that it does can be done again by adding the same."""
    before, state, spent = _collected(flat), _state(flat), flat.names.work.operations
    for name, kind in _MADE.items():
        setattr(_owner(flat, name), name, kind())
    flat.names.inside = f"{declaration.name}.", f"{declaration.name}["
    visit()
    flat.names.inside = ("",)
    brought = {name: found for name, found in _collected(flat).items() if found}
    for name, items in before.items():
        setattr(_owner(flat, name), name, items)
    is_all = _state(flat) == state
    _put(flat, brought)
    if not is_all:
        return None
    named = {name: root.members.get(name) for name in set(_names((declaration.arguments, declaration.binding)))}
    return _Visit(component, named, brought, flat.names.work.operations - spent)


def _owner(flat: Any, name: str) -> Any:
    return flat.names if name == _WRITTEN else flat


def _collected(flat: Any) -> dict[str, Any]:
    return {name: getattr(_owner(flat, name), name) for name in _MADE}


def _put(flat: Any, brought: Mapping[str, Any]) -> None:
    for name, items in brought.items():
        whole = getattr(_owner(flat, name), name)
        (whole.extend if _MADE[name] is list else whole.update)(items)


def _state(flat: Any) -> tuple[int, ...]:
    """Grows where something is wrong, or something is asked for that is the scene's."""
    return *state_of(flat), flat.names.asked, *(len(getattr(flat.names, name)) for name in _ONCE)


def _is_same(old: Member | None, new: Member | None, root: Instance) -> bool:
    """Whether a name that stood for one thing stands for the same in flat expressions, as it now stands for another."""
    if isinstance(old, Slot) and isinstance(new, Slot):
        return not (old.is_structural or new.is_structural) and _look(old) == _look(new)
    is_ground = isinstance(old, Instance) and isinstance(new, Instance) and old.span is new.span is root.span
    return old is new or is_ground


def _look(slot: Slot) -> tuple[Any, ...]:
    """What can be seen of a variable where it is named."""
    one = slot.declaration
    return slot.base, slot.dimensions, slot.enumeration, one.prefixes, one.type_name, one.annotation


def _names(part: Any) -> Iterable[str]:
    """The first parts of all names in a piece of syntax, of functions as well."""
    stack = [part]
    while stack:
        x = stack.pop()
        if isinstance(x, tuple):
            stack.extend(x)
        elif hasattr(x, "__match_args__") and not isinstance(x, Span):
            if isinstance(x, Reference):
                yield x.parts[0].name
            elif isinstance(x, Call):
                yield x.function.partition(".")[0]
            stack.extend(getattr(x, name) for name in x.__match_args__)
