"""What is given to components and read by nothing: a value that would be ignored without a word.

Mostly another value was given in place of the expression that reads it, as in Spring(s_rel0 = 0.1, stretch = block.s).
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cached_property
from typing import Any

from lagrangia.base.diagnostics import Report, Source, Span
from lagrangia.base.records import dataclass
from lagrangia.language.classes import ClassTable
from lagrangia.language.discrete_arrays import variables_of
from lagrangia.language.flat import FlatModel
from lagrangia.language.hinge_angles import frames_behind
from lagrangia.language.instances import Bound, FrameSlot, Instance, Member, Slot
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import (
    Array,
    Binary,
    Call,
    Declaration,
    Expression,
    Field,
    Flat,
    FrameRef,
    IfExpression,
    Ref,
    Reference,
    Time,
    Unary,
)
from lagrangia.language.written_reads import written_reads


@dataclass(frozen=True, eq=False)
class _Reader:
    """An expression in a class, and the variable it is written for."""

    variable: str
    expression: Expression


@dataclass(frozen=True)
class _Class:
    """Of a class and all it extends: names in its sections, conditions and components; which variables' expressions read others;
    and what has no value of its own, so that it must be given."""

    named: frozenset[str]
    readers: Mapping[str, _Reader]
    required: frozenset[str]


def find_unread(model: FlatModel, root: Instance, table: ClassTable) -> Report:
    """A warning for each component that is given a parameter or a port in vain."""
    finder = _Finder(model, root, table)
    for instance in inside(root):
        finder.visit(instance)
    return finder.report


class _Finder:
    def __init__(self, model: FlatModel, root: Instance, table: ClassTable) -> None:
        self.model, self.root, self.table, self.report = model, root, table, Report()
        self.classes: dict[int, _Class] = {}

    def visit(self, instance: Instance) -> None:
        """What the class names itself it reads; of the rest, all expressions of the scene are asked."""
        own = self._class(instance)
        required: frozenset[str] = own.required if instance.definition.kind != "record" else frozenset()
        given = {name: member for name, member in instance.members.items() if isinstance(member, Slot | FrameSlot)
                 and name not in own.named and (isinstance(member, FrameSlot) or name not in required)
                 and (isinstance(member, Slot) or name in own.readers) and self._is_given(instance, member)}
        unread = {name: member for name, member in given.items() if member.path not in self._read
                  and member.path not in self._in_text and not self._is_looked_at(instance, member)}
        if unread:
            verb = "it is" if len(unread) == 1 else "they are"
            what = f"nothing reads {_listed(unread)} of {instance.definition.name} '{instance.path}', though {verb} given"
            places = [value.span for member in unread.values() if (value := self._written(member)) is not None]
            self.report.warning("L0224", what, places[0], *_advice(instance, unread, own.readers))

    @cached_property
    def _read(self) -> set[str]:
        """By energies, equations, starts and outputs, and by what people declare to look at."""
        model, library = self.model, self.table.library_sources
        declared = [slot for instance in (self.root, *inside(self.root)) for slot in instance.members.values()
                    if isinstance(slot, Slot) and slot.declaration.name_span.source not in library]
        shown = [variable for slot in declared for variable in variables_of(slot, model.variables)]
        sides: list[Flat] = [x for e in (*model.constraints, *model.initial_equations) for x in (e.left, e.right)]
        sides += [e.value for e in model.energies] + [x for w in model.works for x in (w.force, w.position)]
        sides += model.looks()
        sides += [x for figure in model.figures for x in figure.expressions()]
        sides += [x for frame in model.frames.values() for x in frame.starts.values()]
        sides += [x for v in shown if v.kind == "variable" and (x := v.binding) is not None]
        sides += [x for v in model.variables.values() if (x := v.start) is not None]
        bindings = {name: v.binding for name, v in model.variables.items()}
        read = {leaf.name for leaf in leaves(sides, bindings) if not isinstance(leaf, Time)}
        read |= {frame for name in read for frame in frames_behind(name)}
        placing = leaves([x for e in model.frame_equations for x in (e.left, e.right)], bindings)
        joined = Counter(leaf.name for leaf in placing if isinstance(leaf, FrameRef))
        read |= {leaf.name for leaf in placing if isinstance(leaf, Ref)}
        return read | {name for name, times in joined.items() if times > 1}  # once, where it is given, places nothing else

    @cached_property
    def _in_text(self) -> frozenset[str]:
        written = written_reads(self.model, (self.root, *inside(self.root)), self.table)
        return written.left_out | written.chosen

    def _is_looked_at(self, record: Instance, member: Slot | FrameSlot) -> bool:
        """A part of a record that the motion changes: as a variable of its own it is there to be looked at."""
        variables = self.model.variables
        bindings = {name: v.binding for name, v in variables.items()}
        bound = bindings.get(member.path) if record.definition.kind == "record" else None
        own = {name for name, v in variables.items() if v.kind != "parameter" and v.binding is None}
        return bound is not None and any(not isinstance(leaf, Ref) or leaf.name in own for leaf in leaves([bound], bindings))

    def _is_given(self, instance: Instance, member: Slot | FrameSlot) -> bool:
        """From outside, in a model of the user's."""
        bound, written = member.binding, self._written(member)
        if bound is None or written is None or written.span.source in self.table.library_sources:
            return False
        if isinstance(member, Slot) and any(v.is_output for v in variables_of(member, self.model.variables)):
            return False
        return bound.scope.instance is not instance and not (isinstance(member, Slot) and member.is_structural)

    def _written(self, member: Slot | FrameSlot) -> Expression | None:
        """What is given alone: of a record that is given as a whole, the argument of its constructor, or None."""
        bound = member.binding
        if bound is None or not isinstance(bound.expression, Field):
            return None if bound is None else bound.expression
        return self._argument(bound.expression, bound.selection)

    def _argument(self, field: Field, selection: Sequence[tuple[int, int]] = ()) -> Expression | None:
        record = self._argument(field.record) if isinstance(field.record, Field) else field.record
        for index, _ in selection:
            record = record.items[index - 1] if isinstance(record, Array) else record
        if not isinstance(record, Call) or (made := self.table.found(record.function, record.span)) is None or (
                made.kind != "record"):
            return None
        return {**dict(zip(self.table.declared(made), record.arguments, strict=False)), **dict(record.named)}.get(field.name)

    def _class(self, instance: Instance) -> _Class:
        key = id(instance.definition)
        if key not in self.classes:
            self.classes[key] = self._look_at(instance)
        return self.classes[key]

    def _look_at(self, instance: Instance) -> _Class:
        named: set[str] = set()
        readers: dict[str, _Reader] = {}
        required = set(instance.members)
        for definition in self.table.lineage(instance.definition):
            named |= set(_names(definition.sections))
            for element in definition.elements:
                if isinstance(element, Declaration) and not isinstance(instance.members.get(element.name), Slot | FrameSlot):
                    named |= set(_names((element.arguments, element.condition, element.dimensions)))
                    continue
                written = ([(element.name, element.binding)] if isinstance(element, Declaration) else
                           [(argument.name, argument.value) for argument in element.arguments])
                for variable, expression in written:
                    if expression is not None:
                        required.discard(variable)
                        readers = dict.fromkeys(_names(expression), _Reader(variable, expression)) | readers
        return _Class(frozenset(named), readers, frozenset(required))


def _advice(instance: Instance, unread: Mapping[str, Slot | FrameSlot], readers: Mapping[str, _Reader]) -> Iterator[str]:
    left = dict(unread)
    for reader in dict.fromkeys(readers[name] for name in unread if name in readers):
        names = [name for name in unread if readers.get(name) is reader]
        other = _binding(instance.members.get(reader.variable))
        if other is None or other.expression is reader.expression:
            yield f"only '{reader.variable}' reads {_listed(names)}, and nothing reads '{reader.variable}'"
            left = {name: member for name, member in left.items() if name not in names}
            continue
        instead = [(name, text) for name in names if (text := _moved(reader.expression, name, unread[name], other))]
        for name, _ in instead:
            del left[name]
        write = "".join(f": write {reader.variable} = {text}" for _, text in instead[:1])
        yield f"'{reader.variable}' is given in place of {_text(reader.expression)}{write}"
    if left:
        them = "it" if len(left) == 1 else "them"
        yield f"leave {_listed(left)} out, or read {them} in what is given" if instance.definition.kind != "record" else (
            f"read {_listed(left)}, or leave {them} out; what has no default, of {instance.definition.name} itself, too")


def _moved(expression: Expression, name: str, member: Slot | FrameSlot, given: Bound) -> str:
    """What is given with the last operand of the expression it replaced, where that operand is the name."""
    value = member.binding
    match expression:
        case Binary("+" | "-" as sign, _, Reference() as last, _) if str(last) == name and value and not value.selection:
            return f"{_text(given.expression, IfExpression)} {sign} {_text(value.expression, Binary | Unary | IfExpression)}"
    return ""


def _text(expression: Expression, bracketed: Any = ()) -> str:
    text = " ".join(expression.span.text.split())
    return f"({text})" if isinstance(expression, bracketed) else text


def inside(root: Instance) -> Iterator[Instance]:
    """All components, of arrays their elements."""
    pending: list[Member] = list(reversed(root.members.values()))
    while pending:
        member = pending.pop()
        if isinstance(member, list):
            pending += reversed(member)
        elif isinstance(member, Instance):
            yield member
            pending += reversed(member.members.values())


def _binding(member: Member | None) -> Bound | None:
    return member.binding if isinstance(member, Slot | FrameSlot) else None


def _names(part: Any) -> Iterator[str]:
    """The first parts of all names in a piece of syntax."""
    if isinstance(part, tuple):
        for item in part:
            yield from _names(item)
    elif isinstance(part, Reference):
        yield part.parts[0].name
        yield from _names(tuple(piece.subscripts for piece in part.parts))
    elif is_dataclass(part) and not isinstance(part, Span | Source):
        for field in fields(part):
            yield from _names(getattr(part, field.name))


def _listed(names: Iterable[str]) -> str:
    *first, last = (f"'{name}'" for name in names)
    return f"{', '.join(first)} and {last}" if first else last
