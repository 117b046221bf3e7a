"""The tree of Instances that a model is made of (instantiation.py), with the modifications that apply to them.

A modification is kept with the scope it was written in (`Bound`), so that names in it mean what they mean there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any, Protocol, TypeAlias

from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.language.classes import ENUMERATION, ClassTable
from lagrangia.language.frame_attributes import Space
from lagrangia.language.tree import ClassDefinition, Clause, Declaration, Expression, Flat, Reference

DISCRETE_TYPES = frozenset({"Integer", "Boolean"})  # of what events may give values
STRUCTURAL_TYPES = DISCRETE_TYPES | {"String", ENUMERATION}


def held_port(frames: Sequence[str]) -> str | None:
    """The frame of a component that its reaction acts on: b of a and b, the center that a base carries, else the last one; None
    with fewer than two."""
    if {"base", "center"} <= set(frames):
        return "center"
    return "b" if {"a", "b"} <= set(frames) else frames[-1] if len(frames) > 1 else None


Iterators: TypeAlias = Mapping[str, "int | Flat"]  # integers as such, and any other values


@dataclass(frozen=True)
class Scope:
    """Where names are looked up: an instance, and the loop variables in force."""

    instance: "Instance"
    iterators: Iterators = field(default_factory=dict)

    def bind(self, name: str, value: int | Flat) -> "Scope":
        """The same scope with a value for one more iterator."""
        return Scope(self.instance, {**self.iterators, name: value})


@dataclass(frozen=True)
class Bound:
    """An expression with its scope. `selection` holds (index, size) for each array of components it is dealt out over; what is
    for `each` is not dealt out where it is as a whole what one element takes."""

    expression: Expression
    scope: Scope
    selection: tuple[tuple[int, int], ...] = ()
    is_each: bool = False


@dataclass(frozen=True)
class Modification:
    """A tree of modifications as it applies to one member."""

    value: Bound | None = None
    children: Mapping[str, "Modification"] = field(default_factory=dict)
    is_each: bool = False
    is_final: bool = False
    span: Span | None = None
    redeclared: "Redeclared | None" = None
    is_left_out: bool = False  # break
    was_each: bool = False  # of an array around that of the component
    is_below: bool = False  # said of a part of what was given a value as a whole thereafter


@dataclass(frozen=True)
class Redeclared:
    """What takes the place of something replaceable, and where that was said."""

    declaration: Declaration
    span: Span


NOTHING = Modification()


@dataclass(eq=False)
class Slot:
    """A variable of a builtin type."""

    path: str
    declaration: Declaration
    base: str
    attributes: Mapping[str, Bound]
    binding: Bound | None
    scope: Scope
    dimensions: tuple[int, ...] = ()
    is_final: bool = False
    enumeration: str = ""  # the full name of its type

    @property
    def is_structural(self) -> bool:
        """Integer, Boolean and String parameters and all constants are known when the scene is compiled."""
        prefixes = self.declaration.prefixes
        return "constant" in prefixes or ("parameter" in prefixes and self.base in STRUCTURAL_TYPES)


@dataclass(eq=False)
class FrameSlot:
    """A frame: a declared port, or an instance of a class that extends Frame."""

    path: str
    span: Span
    starts: Mapping[str, Bound]
    fixed: frozenset[str]
    binding: Bound | None
    owner: "Instance"


@dataclass(eq=False)
class Instance:
    """A class at its place in a model, with its members."""

    path: str
    definition: ClassDefinition
    span: Span
    members: dict[str, "Member"] = field(default_factory=dict)
    clauses: list[tuple[str, Clause]] = field(default_factory=list)
    frame: FrameSlot | None = None
    parent: "Instance | None" = None
    absent: set[str] = field(default_factory=set)  # conditional components that are not there, and what `break` left out
    outer: set[str] = field(default_factory=set)  # members that belong to a component around this one
    inner: set[str] = field(default_factory=set)  # members that components inside may name as theirs
    classes: dict[str, "ReplacedClass"] = field(default_factory=dict)  # local classes that were redeclared
    protected: set[str] = field(default_factory=set)  # members that only the class itself, and what extends it, may name
    description: str = ""  # of its declaration
    joined_to: Bound | None = None  # of a connector: another one

    def child_path(self, name: str) -> str:
        """The full name of a member."""
        return f"{self.path}.{name}" if self.path else name


@dataclass(frozen=True)
class ReplacedClass:
    """What stands for a local class, and what modifies it."""

    type_name: str
    type_span: Span
    modification: Modification


Member: TypeAlias = Slot | FrameSlot | Instance | list[Any]


def key_of(declaration: Declaration) -> str:
    """By which a member is found: what is inner and outer is two, and its name the outer one (Modelica 3.6, section 5.4)."""
    return inner_key(declaration.name) if {"inner", "outer"} <= declaration.prefixes else declaration.name


def inner_key(name: str) -> str:
    """Of the inner one of two."""
    return f"inner {name}"


def outside(table: ClassTable, span: Span, owner: Instance | None) -> Span:
    """Where people look for what stands at `span`: for the inside of a library component, its declaration."""
    while owner is not None and span.source in table.library_sources:
        span, owner = owner.span, owner.parent
    return span


def is_absent(node: Expression, scope: Scope) -> bool:
    """Whether a name leads through a component that is not there."""
    if not isinstance(node, Reference):
        return False
    member: Any = scope.instance
    for part in node.parts:
        if isinstance(member, list):
            member = member[0] if member else None
        if not isinstance(member, Instance):
            return False
        if part.name in member.absent:
            return True
        member = member.members.get(part.name)
    return False


class StructuralValues(Protocol):
    """Evaluates what must be known at compile time (names.py)."""

    space: Space  # that the scene is taken for

    def integer(self, expression: Expression, scope: Scope, what: str, hint: str = "") -> int:
        """The integer that an expression must be. Raises LagError L0210."""
    def boolean(self, expression: Expression, scope: Scope, what: str, *hints: str) -> bool:
        """The truth value that an expression must be. Raises LagError L0210."""
    def shape(self, bound: Bound) -> tuple[int, ...]:
        """The sizes of what is bound. Raises LagError."""
    def known(self, bound: Bound) -> Expression | None:
        """The value of what is bound, where it is known when the scene is compiled. Raises LagError."""
    def begin(self, root: Instance) -> None:
        """Names are looked up in an instance whose members are being made."""
    def count_of_literals(self, node: Reference) -> int | None:
        """How many values an enumeration has; None for what is none."""
