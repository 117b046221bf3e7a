"""The nodes of the syntax tree: what a `.lag` file says, nothing of what it means."""

from dataclasses import dataclass
from typing import TypeAlias

from lagrangia.diagnostics import Source, Span

# ------------------------------------------------------------------ expressions


@dataclass(frozen=True, slots=True)
class Number:
    value: float
    unit: str | None
    span: Span
    is_integer: bool = False


@dataclass(frozen=True, slots=True)
class String:
    value: str
    span: Span


@dataclass(frozen=True, slots=True)
class Boolean:
    value: bool
    span: Span


@dataclass(frozen=True, slots=True)
class Part:
    """One step of a dotted name, with its subscripts: `link[2]`."""

    name: str
    subscripts: tuple["Expression", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Reference:
    parts: tuple[Part, ...]
    span: Span

    def __str__(self) -> str:
        return self.span.text


@dataclass(frozen=True, slots=True)
class Unary:
    operator: str  # "-", "+", "not"
    operand: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class Binary:
    operator: str  # + - * / ^ == <> < <= > >= and or
    left: "Expression"
    right: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class IfExpression:
    """`if c then a else b`; elseif branches are nested."""

    condition: "Expression"
    then: "Expression"
    otherwise: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class Call:
    function: str
    arguments: tuple["Expression", ...]
    named: tuple[tuple[str, "Expression"], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Array:
    items: tuple["Expression", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Iterator:
    name: str
    range: "Expression | None"
    span: Span


@dataclass(frozen=True, slots=True)
class Comprehension:
    """`{e for i in r}`, or with a function `sum(e for i in r)`."""

    function: str  # "" makes an array
    body: "Expression"
    iterators: tuple[Iterator, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Range:
    start: "Expression"
    step: "Expression | None"
    stop: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class Whole:
    """The subscript `:`."""

    span: Span


Expression: TypeAlias = (
    Number | String | Boolean | Reference | Unary | Binary | IfExpression | Call | Array | Comprehension | Range | Whole
)

# ------------------------------------------------------------------ declarations


@dataclass(frozen=True, slots=True)
class Argument:
    """One modification: `each phi(start = 1)`, `k = 3`."""

    prefixes: frozenset[str]  # "each", "final"
    name: str
    arguments: tuple["Argument", ...]
    value: Expression | None
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class Declaration:
    prefixes: frozenset[str]
    type_name: str
    type_span: Span
    name: str
    dimensions: tuple[Expression, ...]
    arguments: tuple[Argument, ...]
    binding: Expression | None
    condition: Expression | None
    description: str
    is_protected: bool
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class Extends:
    type_name: str
    arguments: tuple[Argument, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Equality:
    left: Expression
    right: Expression
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class CallEquation:
    """A call that stands as an equation or a statement: `connect(a, b)`, `assert(...)`."""

    call: Expression
    span: Span


@dataclass(frozen=True, slots=True)
class EnergyTerm:
    kind: str  # "kinetic", "potential", "dissipation"
    value: Expression
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class WorkTerm:
    """`work force on position`: the generalised force is force . d(position)/dq."""

    force: Expression
    position: Expression
    description: str
    span: Span


@dataclass(frozen=True, slots=True)
class Assignment:
    target: Expression
    value: Expression
    span: Span


@dataclass(frozen=True, slots=True)
class ForBlock:
    iterators: tuple[Iterator, ...]
    body: tuple["Clause", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class IfBlock:
    """`if c then ... elseif ... else ... end if`; elseif branches are nested in `otherwise`."""

    condition: Expression
    then: tuple["Clause", ...]
    otherwise: tuple["Clause", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class WhenBlock:
    condition: Expression
    body: tuple["Clause", ...]
    span: Span


Clause: TypeAlias = Equality | CallEquation | EnergyTerm | WorkTerm | Assignment | ForBlock | IfBlock | WhenBlock


@dataclass(frozen=True, slots=True)
class Section:
    kind: str  # "equation", "initial", "energy", "algorithm"
    clauses: tuple[Clause, ...]


@dataclass(frozen=True, slots=True)
class ClassDefinition:
    kind: str  # "model", "function", "type", "record", "package"
    is_partial: bool
    name: str
    description: str
    elements: tuple[Declaration | Extends, ...]
    sections: tuple[Section, ...]
    annotation: tuple[Argument, ...]
    span: Span
    name_span: Span


@dataclass(frozen=True, slots=True)
class ImportFile:
    path: str
    span: Span


@dataclass(frozen=True, slots=True)
class Syntax:
    """One file."""

    source: Source
    imports: tuple[ImportFile, ...]
    classes: tuple[ClassDefinition, ...]
