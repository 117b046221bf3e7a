"""What the text of people's own classes reads though the flat model does not: in branches and components that are left out, and
elements that are picked by what is known when the scene is compiled."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from lagrangia.base.records import dataclass
from lagrangia.language.classes import ClassTable
from lagrangia.language.flat import FlatModel
from lagrangia.language.instances import FrameSlot, Instance, Slot
from lagrangia.language.mentions import reached
from lagrangia.language.syntax_parts import parts_of
from lagrangia.language.tree import (
    Array,
    Binary,
    Boolean,
    Call,
    ClassDefinition,
    Comprehension,
    Declaration,
    Equality,
    Expression,
    ForBlock,
    IfBlock,
    IfExpression,
    Number,
    Range,
    Ref,
    Reference,
    Unary,
    Whole,
)

_KNOWN_BEFOREHAND = ("size", "ndims", "String")  # of which the flat model has what they give


@dataclass(frozen=True)
class Written:
    """Full names of what stands in text that may be left out, and of arrays whose elements are picked by other than literals."""

    left_out: frozenset[str]
    chosen: frozenset[str]


@dataclass(frozen=True)
class _Place:
    """Whether text may be left out, and the iterators around it: whether they run over literal numbers alone."""

    may_be_left_out: bool
    iterators: Mapping[str, bool]


def written_reads(model: FlatModel, instances: Iterable[Instance], table: ClassTable) -> Written:
    """Of their classes, but for those of the library; through what variables are bound to."""
    left_out, chosen = set[str](), set[str]()
    for instance in instances:
        for definition in table.lineage(instance.definition):
            if definition.span.source not in table.library_sources:
                for name, place in _references(definition):
                    for member in _meant(name, instance) if name.parts[0].name not in place.iterators else ():
                        if place.may_be_left_out:
                            left_out.add(member.path)
                        if not all(_is_literal(s, place.iterators, table) for part in name.parts for s in part.subscripts):
                            chosen.add(member.path)
    bindings = {name: variable.binding for name, variable in model.variables.items()}
    through = reached([x for name in left_out if (x := bindings.get(name)) is not None], bindings)
    return Written(frozenset(left_out | {node.name for node in through if isinstance(node, Ref)}), frozenset(chosen))


def _references(definition: ClassDefinition) -> Iterator[tuple[Reference, _Place]]:
    """All names but in annotations, and those that equations give values."""
    pending: list[tuple[Any, _Place]] = [((definition.elements, definition.sections), _Place(False, {}))]
    while pending:
        node, place = pending.pop()
        parts = parts_of(node)
        match node:
            case IfBlock() | IfExpression():
                pending.append((node.condition, place))
                parts, place = iter((node.then, node.otherwise)), _Place(True, place.iterators)
            case Declaration():
                parts = iter((node.dimensions, node.arguments, node.binding, node.constraining))
                place = _Place(node.condition is not None, {})
            case ForBlock() | Comprehension():
                runs = {i.name: i.range is not None and _is_literal(i.range, place.iterators) for i in node.iterators}
                place = _Place(place.may_be_left_out, {**place.iterators, **runs})
            case Call() if node.function in _KNOWN_BEFOREHAND:
                place = _Place(True, place.iterators)
            case Equality(Reference() as target, right, _, _):
                parts = iter((*(part.subscripts for part in target.parts), right))
            case Reference():
                yield node, place
        pending += [(part, place) for part in parts]


def _meant(name: Reference, instance: Instance) -> Iterator[Slot | FrameSlot]:
    """The variables and frames that a name can mean: of arrays of components those of each, of a record all that it has."""
    found: list[Any] = [instance]
    for part in name.parts:
        owners = [one for one in _each(found) if isinstance(one, Instance)]
        found = [member for one in owners if (member := one.members.get(part.name)) is not None]
    while found:
        member = found.pop()
        if isinstance(member, Slot | FrameSlot):
            yield member
        elif isinstance(member, list):
            found += member
        elif member.definition.kind == "record":
            found += member.members.values()


def _each(members: list[Any]) -> Iterator[Any]:
    for member in members:
        if isinstance(member, list):
            yield from _each(member)
        else:
            yield member


def _is_literal(node: Expression | None, iterators: Mapping[str, bool], table: ClassTable | None = None) -> bool:
    """Whether a subscript or a range is written out: with numbers, values of enumerations, and iterators over such."""
    match node:
        case Number() | Boolean() | Whole() | None:
            return True
        case Unary() | Binary() | Range() | Array():
            return all(_is_literal(part, iterators, table) for part in _operands(node))
        case Reference((one,), _):
            return not one.subscripts and iterators.get(one.name, False)
        case Reference(parts, span):
            kind = table.found(".".join(part.name for part in parts[:-1]), span) if table is not None else None
            return kind is not None and bool(kind.literals)
    return False


def _operands(node: Any) -> tuple[Expression | None, ...]:
    match node:
        case Unary():
            return (node.operand,)
        case Binary():
            return node.left, node.right
        case Range():
            return node.start, node.step, node.stop
    return tuple(node.items)
