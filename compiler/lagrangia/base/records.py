"""`dataclass` of the standard library, but that the methods of a class are written when it pays, or one of them is first called.

Writing them takes 0.6 ms for each class, a third of what importing the compiler takes, and most classes have no instance in a
process, or a few: these are filled field by field. Of classes with many the standard library tells the fields; what puts them
into a new instance is written here, in one text a class, and takes half the time of calls of object.__setattr__.
"""

import dataclasses
import inspect
from collections.abc import Callable, Sequence
from functools import partial
from reprlib import recursive_repr
from threading import RLock
from types import MemberDescriptorType
from typing import TYPE_CHECKING, Any, ClassVar

__all__ = ["dataclass"]
_DATA = ("__dataclass_fields__", "__match_args__")
_WRITTEN = (*_DATA, "__dataclass_params__")
_MADE = object()  # in place of a value that a factory makes
_FEW = 60  # instances take as long, field by field, as it takes to write what fills them
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
        self.count = 0  # of instances that were filled field by field
        self.few: _Fields | None = None  # their fields

    def stand_in(self, eq: bool) -> None:
        """Where the class does not define them itself."""
        defined = {**self.cls.__dict__}
        if "__eq__" in defined and defined["__hash__"] is None:
            del defined["__hash__"]
        for name in ("__init__", *_DATA):
            if name not in defined:
                setattr(self.cls, name, _Attribute(self, name) if name in _DATA else self.filler())
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

    def filler(self) -> Any:
        """Fills the first instances, as what takes its place does."""

        def __init__(instance: Any, *given: Any, **named: Any) -> None:
            self.count += 1
            if self.count == 1:
                self.few = _plain_fields(self.cls, self.written)
                if self.few is not None and self.frozen:
                    _refuse_changes(self.cls, frozenset((*self.few.names, *self.few.factories)))
            values = self.few.values(given, named) if self.few is not None and self.count <= _FEW else None
            if values is None:  # many instances, or arguments that are wrong
                self.write()
                self.cls.__init__(instance, *given, **named)  # type: ignore[misc]
                return
            put = object.__setattr__ if self.frozen else setattr
            for name, value in values.items():
                put(instance, name, value)
            if hasattr(instance, "__post_init__"):
                instance.__post_init__()

        return __init__

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
                _refuse_changes(self.cls, frozenset(field.name for field in dataclasses.fields(self.cls)))
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


class _Fields:
    """Those of a class that inherits none."""

    def __init__(self, written: type) -> None:
        self.names: list[str] = []  # of arguments
        self.defaults: dict[str, Any] = {}  # of these
        self.factories: dict[str, Callable[[], Any]] = {}
        for name in inspect.get_annotations(written):
            default = written.__dict__.get(name, dataclasses.MISSING)
            field = default if isinstance(default, dataclasses.Field) else None
            if field is None or field.init:
                self.names.append(name)
            if field is not None:
                default = field.default
            if field is not None and field.default_factory is not dataclasses.MISSING:
                self.factories[name] = field.default_factory
            elif default is not dataclasses.MISSING:
                self.defaults[name] = default
        self.known = frozenset(self.names)

    def values(self, given: tuple[Any, ...], named: dict[str, Any]) -> dict[str, Any] | None:
        """Of an instance; None where arguments are missing, too many or unknown."""
        values = dict(zip(self.names, given, strict=False))
        if named:
            values |= named
        if len(values) < len(given) + len(named) or not values.keys() <= self.known:
            return None
        if len(values) < len(self.names):
            values = self.defaults | values
        for name, make in self.factories.items():
            if name not in values:
                values[name] = make()
        return values if self.known <= values.keys() else None


def _plain_fields(cls: type, written: type) -> _Fields | None:
    """None for a class that inherits some, or has a variable of its own. `written` has the defaults."""
    if any("__dataclass_fields__" in base.__dict__ for base in cls.__mro__[1:]):
        return None
    if any(isinstance(x, dataclasses.Field) and not x.init and x.default_factory is dataclasses.MISSING
           for x in written.__dict__.values()):
        return None  # it is the class's, or comes after
    own = inspect.get_annotations(written).values()
    is_usual = not any(getattr(x, "__origin__", x) is ClassVar or (isinstance(x, str) and "ClassVar" in x) for x in own)
    return _Fields(written) if is_usual else None


def _refuse_changes(cls: Any, names: frozenset[str]) -> None:
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
