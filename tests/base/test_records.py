"""Classes whose methods are written at first use behave as those of the standard library."""

import copy
import dataclasses
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any

import pytest

from lagrangia.base import records

Decorator = Callable[..., Any]


def classes(dataclass: Decorator) -> dict[str, Any]:
    """The same classes by either decorator."""

    @dataclass(frozen=True)
    class Point:
        x: int
        y: int = 3

    @dataclass(frozen=True)
    class Named(Point):
        name: str = dataclasses.field(default="n", compare=False)
        notes: list[int] = dataclasses.field(default_factory=list, repr=False)

        def __post_init__(self) -> None:
            object.__setattr__(self, "size", self.x + self.y)

    @dataclass
    class Open:
        k: int = 0

    @dataclass(frozen=True, eq=False)
    class Unlike:
        k: int

    own = {"__annotations__": {"k": int}, "__eq__": lambda *_: True, "__hash__": lambda _: 5, "__repr__": lambda _: "own"}
    found = {"Point": Point, "Named": Named, "Open": Open, "Unlike": Unlike, "Own": dataclass(frozen=True)(type("Own", (), own))}
    return found | with_slots(dataclass)


def with_slots(dataclass: Decorator) -> dict[str, Any]:
    @dataclass(frozen=True, slots=True)
    class Slotted:
        a: int
        b: int = 2

    @dataclass(frozen=True, slots=True)
    class Longer(Slotted):
        c: tuple[int, ...] = ()

    return {"Slotted": Slotted, "Longer": Longer}


def raised(work: Callable[[], object]) -> tuple[type, str]:
    with pytest.raises((TypeError, AttributeError)) as caught:
        work()
    return caught.type, str(caught.value)


def shown(cls: dict[str, Any]) -> list[object]:
    """What tells one decorator from another."""
    point, named, slotted, longer = cls["Point"](1), cls["Named"](1, name="a"), cls["Slotted"](1), cls["Longer"](1, c=(4,))
    kind = cls["Longer"]
    match longer:
        case kind(a, _, c):
            matched = a, c
    return [
        repr([point, named, slotted, longer, cls["Open"](), cls["Own"](1)]), matched, named.size,
        point == cls["Point"](1), point != cls["Point"](2), point == named, named == cls["Named"](1, name="b"),
        cls["Unlike"](1) == cls["Unlike"](1), cls["Own"](1) == 7, hash(point), hash(slotted), hash(longer), hash(cls["Own"](1)),
        copy.copy(longer) == longer, copy.deepcopy(named) == named, dataclasses.replace(longer, a=9) == kind(9, c=(4,)),
        dataclasses.asdict(named), [f.name for f in dataclasses.fields(cls["Named"])], kind.__match_args__,
        kind.__slots__, hasattr(longer, "__dict__"), cls["Named"](1).notes is cls["Named"](1).notes,
        raised(lambda: setattr(point, "x", 4)), raised(lambda: setattr(longer, "c", ())), raised(cls["Point"]),
        raised(lambda: hash(cls["Open"]())), raised(lambda: hash(cls["Point"]([]))), point == 1,
    ]


def test_all_that_can_be_seen_is_that_of_the_standard_library() -> None:
    assert shown(classes(records.dataclass)) == shown(classes(dataclasses.dataclass))


@records.dataclass(frozen=True)
class Kept:
    """For a process that unpickles it."""

    x: int
    y: tuple[int, ...] = ()


@records.dataclass(frozen=True, slots=True)
class KeptInSlots:
    """Likewise."""

    x: int


def test_what_is_unpickled_was_never_called() -> None:
    """In another process, where no method was written yet."""
    text = pickle.dumps([Kept(1, (2,)), Kept(1, (2,)), KeptInSlots(3), KeptInSlots(3)])
    code = (f"import sys, pickle; sys.path[:0] = {sys.path!r}; a, b, c, d = pickle.loads({text!r}); "
            "print(a == b, c == d, hash(a) == hash(b), a, c)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True True True Kept(x=1, y=(2,)) KeptInSlots(x=3)\n"


def test_threads_that_are_first_together_all_get_instances() -> None:
    for _ in range(20):
        point, found, together = classes(records.dataclass)["Point"], [], threading.Barrier(4)

        def make(point: Any = point, found: list[Any] = found, together: threading.Barrier = together) -> None:
            together.wait()
            found.append(point(1, 2))

        threads = [threading.Thread(target=make) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert found == [point(1, 2)] * 4


def test_the_first_instances_and_later_ones_are_filled_alike() -> None:
    """Before and after what fills them is written, and where arguments are wrong."""
    @records.dataclass(frozen=True)
    class Row:
        a: int
        b: int = 2
        c: list[int] = dataclasses.field(default_factory=list)
        e: list[int] = dataclasses.field(default_factory=list, init=False)

    def of(*given: int, **named: Any) -> dict[str, Any]:
        row = Row(*given, **named)
        with pytest.raises(dataclasses.FrozenInstanceError):
            row.a = 1  # type: ignore[misc]
        return {**row.__dict__}

    first = [of(1), of(1, 3), of(b=1, a=2), of(1, c=[4])]
    assert first[0] == {"a": 1, "b": 2, "c": [], "e": []} and first[3]["c"] == [4]
    filled = Row.__init__
    assert Row(1).c is not Row(1).c and Row.__init__ is filled
    for _ in range(records._FEW):
        Row(1)
    assert Row.__init__ is not filled
    assert [of(1), of(1, 3), of(b=1, a=2), of(1, c=[4])] == first[:4]
    for given, named in (((), {}), ((1, 2, [], 4), {}), ((1,), {"a": 1}), ((1,), {"d": 1}), ((1,), {"f": 1})):
        @records.dataclass
        class Again:
            a: int
            b: int = 2
            c: int = 3
            d: list[int] = dataclasses.field(default_factory=list, init=False)

        with pytest.raises(TypeError):
            Again(*given, **named)  # type: ignore[arg-type]


def test_a_field_that_no_argument_fills_is_the_class_s_or_comes_after() -> None:
    @records.dataclass
    class Later:
        a: int
        d: int = dataclasses.field(default=7, init=False)
        after: int = dataclasses.field(init=False)

    assert Later(1).d == 7 and not hasattr(Later(1), "after")
