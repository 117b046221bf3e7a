"""`dataclass` of the standard library, but that the methods of a class are written when one of them is first called.

Writing them takes 0.6 ms for each class, a third of what importing the compiler takes, and most classes have no instance in a
process. Of those that have some, the standard library tells the fields; what puts them into a new instance is written here, in
one text a class, and takes half the time of calls of object.__setattr__.
"""

import dataclasses
import inspect
from collections.abc import Callable, Sequence
from functools import partial
from reprlib import recursive_repr
from threading import RLock
from types import MemberDescriptorType
from typing import TYPE_CHECKING, Any

__all__ = ["dataclass"]
_DATA = ("__dataclass_fields__", "__match_args__")
_WRITTEN = (*_DATA, "__dataclass_params__")
_MADE = object()  # in place of a value that a factory makes
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
            self.written.__doc__ = self.written.__doc__ or self.cls.__name__  # else a signature would be worked out
            dataclasses.dataclass(init=False, repr=False, eq=False)(self.written)
            if self.written is not self.cls:
                there = self.written.__dict__
                for name in (name for name in _WRITTEN if name in there and name not in self.cls.__dict__):
                    setattr(self.cls, name, there[name])
            if "__init__" in self.names:
                self.cls.__init__ = _init(self.cls, self.frozen)  # type: ignore[misc]
            if self.frozen:
                _refuse_changes(self.cls)
            self.names = []


def _init(cls: type, frozen: bool) -> Any:
    """Slots are filled by their descriptors, other fields of what is frozen through its dictionary."""
    scope: dict[str, Any] = {"_made": _MADE}
    given, body, has_dictionary = ["self"], list[str](), False
    for field in dataclasses.fields(cls):
        name, value = field.name, field.name
        has_factory = field.default_factory is not dataclasses.MISSING
        if has_factory:
            scope[f"_make_{name}"] = field.default_factory
            value = f"_make_{name}() if {name} is _made else {name}" if field.init else f"_make_{name}()"
        elif not field.init:
            continue  # what the class has, or what comes after
        if field.init:
            scope[f"_given_{name}"] = _MADE if has_factory else field.default
            is_needed = not has_factory and field.default is dataclasses.MISSING
            given.append(name if is_needed else f"{name}=_given_{name}")
        slot = getattr(cls, name, None)
        if isinstance(slot, MemberDescriptorType):
            scope[f"_set_{name}"] = slot.__set__
            body.append(f"_set_{name}(self, {value})")
        elif frozen:
            has_dictionary = True
            body.append(f"_own[{name!r}] = {value}")
        else:
            body.append(f"self.{name} = {value}")
    lines = [*(["_own = self.__dict__"] if has_dictionary else []), *body]
    lines += ["self.__post_init__()"] if hasattr(cls, "__post_init__") else []
    text = "\n  ".join([f" def __init__({', '.join(given)}):", *(lines or ["pass"])])
    exec(f"def write({', '.join(scope)}):\n{text}\n return __init__", {}, found := dict[str, Any]())
    made = found["write"](**scope)
    made.__qualname__ = f"{cls.__qualname__}.__init__"
    return made


def _refuse_changes(cls: Any) -> None:
    names = frozenset(field.name for field in dataclasses.fields(cls))

    def __setattr__(self: object, name: str, value: object) -> None:
        if type(self) is cls or name in names:
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        super(cls, self).__setattr__(name, value)

    def __delattr__(self: object, name: str) -> None:
        if type(self) is cls or name in names:
            raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
        super(cls, self).__delattr__(name)

    cls.__setattr__, cls.__delattr__ = __setattr__, __delattr__



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
