"""The nodes of the syntax tree: what a `.lag` file says, nothing of what it means.

Operators, calls, conditions and arrays are generic in their children: an `Expression` as written, or a `Flat` one, whose names
are resolved, whose loops are unrolled and whose structural values are put in (names.py).
"""

from dataclasses import replace
from typing import Generic, Literal, TypeAlias, TypeVar

from lagrangia.base.diagnostics import Source, Span
from lagrangia.base.records import dataclass

E = TypeVar("E", covariant=True)

# ------------------------------------------------------------------ expressions


@dataclass(frozen=True, slots=True)
class Number:
    """A number, with its unit where one is written."""

    value: float
    unit: str | None
    span: Span
    is_integer: bool = False


@dataclass(frozen=True, slots=True)
class String:
    """A text in quotes."""

    value: str
    span: Span


@dataclass(frozen=True, slots=True)
class Boolean:
    """true or false."""

    value: bool
    span: Span


@dataclass(frozen=True, slots=True)
class EnumerationLiteral:
    """One of the values of an enumeration, the first with the ordinal 1."""

    type_name: str
    name: str
    ordinal: int
    span: Span
    names: tuple[str, ...]  # of all of them


@dataclass(frozen=True, slots=True)
class Part:
    """One step of a dotted name, with its subscripts: `link[2]`."""

    name: str
    subscripts: tuple["Expression", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Reference:
    """A name of one or more parts, each with its indices."""

    parts: tuple[Part, ...]
    span: Span

    def __str__(self) -> str:
        return self.span.text


@dataclass(frozen=True, slots=True)
class Unary(Generic[E]):
    """An operator before what it acts on."""

    operator: str  # "-", "+", "not"
    operand: E
    span: Span


@dataclass(frozen=True, slots=True)
class Binary(Generic[E]):
    """An operator between two operands."""

    operator: str  # + - * / ^ == <> < <= > >= and or
    left: E
    right: E
    span: Span


@dataclass(frozen=True, slots=True)
class IfExpression(Generic[E]):
    """`if c then a else b`; elseif branches are nested."""

    condition: E
    then: E
    otherwise: E
    span: Span


@dataclass(frozen=True, slots=True)
class Call(Generic[E]):
    """A function of arguments, some of them by name."""

    function: str
    arguments: tuple[E, ...]
    named: tuple[tuple[str, E], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Array(Generic[E]):
    """{a, b, ...}."""

    items: tuple[E, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Matrix:
    """[a, b; c, d]: rows one below the other, of what stands side by side in each."""

    rows: tuple[tuple["Expression", ...], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Results:
    """(a, b) on the left side of what gives several results; None for one that is left out."""

    items: tuple["Expression | None", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Result:
    """One of the results of a call, counted from 0: made where several are taken."""

    call: "Expression"
    output: int
    span: Span


@dataclass(frozen=True, slots=True)
class Field:
    """What a record has under a name: made where a record is given as a whole."""

    record: "Expression"
    name: str
    span: Span


@dataclass(frozen=True, slots=True)
class Made:
    """What a call of a function gives that nobody wrote: a part of a record, by its default, of the parts that are given."""

    call: "Expression"
    own: "ClassDefinition"
    span: Span


@dataclass(frozen=True, slots=True)
class Last:
    """The subscript `end`."""

    span: Span


@dataclass(frozen=True, slots=True)
class Iterator:
    """i in 1:n, of loops and sums."""

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
    """start : step : stop."""

    start: "Expression"
    step: "Expression | None"
    stop: "Expression"
    span: Span


@dataclass(frozen=True, slots=True)
class Whole:
    """The subscript `:`."""

    span: Span


# ------------------------------------------------------------------ leaves of flat expressions


@dataclass(frozen=True, slots=True)
class Ref:
    """A variable, or with `index` an element of an array variable."""

    name: str
    index: tuple[int, ...]
    span: Span

    def __str__(self) -> str:
        return self.name + (f"[{','.join(map(str, self.index))}]" if self.index else "")


@dataclass(frozen=True, slots=True)
class FrameRef:
    """A frame (attribute "") or one of its attributes (frame_attributes.py), in space if it `is_spatial`; `index` picks an
    element of a vector."""

    name: str
    attribute: str
    index: tuple[int, ...]
    span: Span
    is_spatial: bool = False

    def __str__(self) -> str:
        text = f"{self.name}.{self.attribute}" if self.attribute else self.name
        return text + (f"[{','.join(map(str, self.index))}]" if self.index else "")


@dataclass(frozen=True, slots=True)
class Local:
    """An input, output or local variable of a function."""

    name: str
    span: Span


@dataclass(frozen=True, slots=True)
class Time:
    """The variable `time`."""

    span: Span


Node: TypeAlias = Number | String | Boolean | EnumerationLiteral | Unary[E] | Binary[E] | IfExpression[E] | Call[E] | Array[E]
Expression: TypeAlias = (
    Node["Expression"] | Reference | Comprehension | Range | Whole | Matrix | Results | Result | Field | Made | Last)
Flat: TypeAlias = Node["Flat"] | Ref | FrameRef | Local | Time

# ------------------------------------------------------------------ declarations

EnergyKind: TypeAlias = Literal["kinetic", "potential", "dissipation"]


@dataclass(frozen=True, slots=True)
class Argument:
    """One modification: `each phi(start = 1)`, `k = 3`."""

    prefixes: frozenset[str]  # "each", "final"
    name: str
    arguments: tuple["Argument", ...]
    value: Expression | None
    span: Span
    name_span: Span
    redeclared: "Declaration | None" = None  # what takes the place of a replaceable component or class
    is_left_out: bool = False  # break: an inherited component that is not taken over


@dataclass(frozen=True, slots=True)
class Constraining:
    """constrainedby: what all that takes the place of something replaceable has to have, modified."""

    type_name: str
    arguments: tuple[Argument, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Declaration:
    """A component or variable with its type, modifications, binding and description."""

    prefixes: frozenset[str]
    type_name: str
    type_span: Span
    name: str
    dimensions: tuple[Expression, ...]
    arguments: tuple[Argument, ...]
    binding: Expression | None
    condition: Expression | None
    description: str
    span: Span
    name_span: Span
    annotation: tuple[Argument, ...] = ()
    constraining: Constraining | None = None
    kind: str = ""  # "model", "package", ... of a class that a redeclaration puts in the place of another one


@dataclass(frozen=True, slots=True)
class Extends:
    """A class that another one takes over, modified."""

    type_name: str
    arguments: tuple[Argument, ...]
    span: Span
    dimensions: tuple[Expression, ...] = ()  # type X = Real[3]
    prefixes: frozenset[str] = frozenset()  # connector X = input Real


@dataclass(frozen=True, slots=True)
class Equality:
    """left = right."""

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
    """A kinetic, potential or dissipated energy, or work, that a class states."""

    kind: EnergyKind
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
    """target := value, in functions."""

    target: Expression
    value: Expression
    span: Span


@dataclass(frozen=True, slots=True)
class ForBlock:
    """Clauses for each value of the iterators."""

    iterators: tuple[Iterator, ...]
    body: tuple["Clause", ...]
    span: Span


@dataclass(frozen=True, slots=True)
class WhileBlock:
    """while condition loop ... end while, in functions."""

    condition: Expression
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
    """Clauses at the moment at which a condition becomes true."""

    condition: Expression
    body: tuple["Clause", ...]
    span: Span
    otherwise: "WhenBlock | None" = None  # elsewhen


Clause: TypeAlias = Equality | CallEquation | EnergyTerm | WorkTerm | Assignment | ForBlock | WhileBlock | IfBlock | WhenBlock


@dataclass(frozen=True, slots=True)
class Section:
    """Clauses under their keyword."""

    kind: str  # "equation", "initial", "energy", "algorithm", "drawing"
    clauses: tuple[Clause, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class LiteralDefinition:
    """A value of an enumeration."""

    name: str
    description: str
    span: Span
    annotation: tuple[Argument, ...] = ()


@dataclass(frozen=True, slots=True)
class ClassDefinition:
    """A class with its elements and sections."""

    kind: str  # "model", "function", "type", "record", "package", "connector", "block"
    is_partial: bool
    name: str
    description: str
    elements: tuple[Declaration | Extends, ...]
    sections: tuple[Section, ...]
    annotation: tuple[Argument, ...]
    span: Span
    name_span: Span
    classes: tuple["ClassDefinition", ...] = ()  # that stand in it
    imports: tuple["Import", ...] = ()
    prefixes: frozenset[str] = frozenset()  # "replaceable", "encapsulated", "protected", ...
    literals: tuple[LiteralDefinition, ...] = ()  # of an enumeration
    constraining: Constraining | None = None


@dataclass(frozen=True, slots=True)
class ImportFile:
    """import "FILE"."""

    path: str
    span: Span


@dataclass(frozen=True, slots=True)
class Import:
    """import A.B; import C = A.B; import A.{b, c}; import A.*: by short names (all of them under "*") what they stand for."""

    names: tuple[tuple[str, str], ...]
    span: Span
    annotation: tuple[Argument, ...] = ()


@dataclass(frozen=True, slots=True)
class Syntax:
    """One file."""

    source: Source
    imports: tuple[ImportFile, ...]
    classes: tuple[ClassDefinition, ...]
    named: tuple[Import, ...] = ()  # imports of names, for all its classes
    within: str | None = None  # the package that it belongs to
    annotations: tuple[Argument, ...] = ()  # of statements and extends clauses


def over(first: tuple[Argument, ...], second: tuple[Argument, ...]) -> tuple[Argument, ...]:
    """Arguments of one modification where those of another one stand under them: what the first says wins."""
    below = {argument.name: argument for argument in second}
    given = {argument.name for argument in first}
    merged = tuple(argument if (under := below.get(argument.name)) is None or argument.redeclared or under.redeclared else
                   replace(argument, arguments=over(argument.arguments, under.arguments),
                           value=argument.value if argument.value is not None else under.value) for argument in first)
    return merged + tuple(argument for argument in second if argument.name not in given)
