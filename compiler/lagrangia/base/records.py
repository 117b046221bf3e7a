"""`dataclass` of the standard library, but that the methods of a class are written when one of them is first called.

Writing them takes 0.6 ms for each class, a third of what importing the compiler takes, and most classes have no instance in a
process.
"""

import dataclasses
import inspect
from collections.abc import Callable, Sequence
from functools import partial
from reprlib import recursive_repr
from threading import RLock
from typing import TYPE_CHECKING, Any

__all__ = ["dataclass"]
_DATA = ("__dataclass_fields__", "__match_args__")
_WRITTEN = ("__init__", *_DATA, "__dataclass_params__", "__setattr__", "__delattr__")
_lock = RLock()  # of threads that use a class for the first time together

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls: type | None = None, /, *, slots: bool = False, frozen: bool = False, eq: bool = True, order: bool = False
                  ) -> Any:
        """With these options of dataclasses.dataclass; classes with an order are made at once."""

        def prepare(cls: type) -> type:
            if order:
                return dataclasses.dataclass(cls, slots=slots, frozen=frozen, eq=eq, order=True)
            made = _with_slots(cls) if slots else cls
            _Pending(made, cls, frozen).stand_in(eq)
            return made

        return prepare if cls is None else prepare(cls)


class _Pending:
    """What stands in for the methods and data of a class, and puts them in their places. `written`: the class that the standard
    library writes them for; they are moved where it is another one."""

    def __init__(self, cls: type, written: type, frozen: bool) -> None:
        self.cls, self.written, self.frozen = cls, written, frozen
        self.names: list[str] = []

    def stand_in(self, eq: bool) -> None:
        """Where the class does not define them itself."""
        defined = {**self.cls.__dict__}
        if "__eq__" in defined and defined["__hash__"] is None:
            del defined["__hash__"]
        for name in ("__init__", *_DATA):
            if name not in defined:
                setattr(self.cls, name, _Attribute(self, name) if name in _DATA else self.method(name, self.write))
                self.names.append(name)
        rest = {"__repr__": _repr, **({"__eq__": _eq} if eq else {}), **({"__hash__": _hash} if eq and self.frozen else {})}
        for name, write in rest.items():
            if name not in defined:
                setattr(self.cls, name, self.method(name, partial(self.put, name, write)))
        if eq and not self.frozen and "__hash__" not in defined:
            self.cls.__hash__ = None  # type: ignore[assignment]

    def method(self, name: str, write: Callable[[], None]) -> Any:
        """Calls what takes its place."""

        def call(*arguments: Any, **named: Any) -> Any:
            write()
            return getattr(self.cls, name)(*arguments, **named)

        return call

    def put(self, name: str, write: Callable[[type], Any]) -> None:
        """In the place of what stood in for it."""
        setattr(self.cls, name, write(self.cls))

    def write(self) -> None:
        """What instances need to be made. Once."""
        with _lock:
            if not self.names:
                return
            for name in self.names:
                delattr(self.cls, name)
            dataclasses.dataclass(frozen=self.frozen, repr=False, eq=False)(self.written)
            if self.written is not self.cls:
                there = self.written.__dict__
                for name in (name for name in _WRITTEN if name in there and name not in self.cls.__dict__):
                    setattr(self.cls, name, there[name])
            self.names = []


def _repr(cls: type) -> Any:
    names = [field.name for field in dataclasses.fields(cls) if field.repr]

    @recursive_repr()
    def __repr__(self: object) -> str:
        return f"{type(self).__qualname__}({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"

    return __repr__


def _eq(cls: type) -> Any:
    one, other = (_listed(whose, [field.name for field in dataclasses.fields(cls) if field.compare]) for whose in ("a", "b"))
    return eval(f"lambda a, b: {one} == {other} if a.__class__ is b.__class__ else NotImplemented")


def _hash(cls: type) -> Any:
    names = [field.name for field in dataclasses.fields(cls) if (field.compare if field.hash is None else field.hash)]
    return eval(f"lambda a: hash({_listed('a', names)})")


def _listed(whose: str, names: Sequence[str]) -> str:
    return f"({''.join(f'{whose}.{name}, ' for name in names)})"


class _Attribute:
    """One of the class that is written with its methods."""

    def __init__(self, pending: _Pending, name: str) -> None:
        self.pending, self.name = pending, name

    def __get__(self, instance: object, owner: type) -> Any:
        self.pending.write()
        return getattr(owner, self.name)


def _with_slots(cls: type) -> type:
    """The class with a slot for each field, but those that its bases have."""
    inherited = {name for base in cls.__mro__[1:] for name in getattr(base, "__slots__", ())}
    names = [name for name in inspect.get_annotations(cls) if name not in inherited]
    members = {name: value for name, value in cls.__dict__.items() if name not in (*names, "__dict__", "__weakref__")}
    made = type(cls)(cls.__name__, cls.__bases__, {**members, "__slots__": tuple(names), "__setstate__": _set_state})
    made.__qualname__ = cls.__qualname__
    return made


def _set_state(self: object, state: tuple[object, dict[str, object]]) -> None:
    """Of a copy, or what was pickled: frozen classes refuse the usual way."""
    for name, value in state[1].items():
        object.__setattr__(self, name, value)
