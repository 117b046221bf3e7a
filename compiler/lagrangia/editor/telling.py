"""What is told of a class or a declaration where the cursor is: its kind, type, unit, default, value, and what it is for."""

from collections.abc import Iterator

from lagrangia.base.diagnostics import LagError
from lagrangia.editor.meanings import Index, Meaning, Occurrence
from lagrangia.editor.reading import Reading
from lagrangia.language.classes import ClassTable
from lagrangia.language.compiled_numbers import values_as_declared
from lagrangia.language.frame_attributes import WORDS
from lagrangia.language.tree import Argument, ClassDefinition, Declaration, LiteralDefinition, String

_MOST_VALUES = 6
_ORDER = ("parameter", "constant", "input", "output", "coordinate", "discrete", "final")


def unit_of(table: ClassTable, declaration: Declaration) -> str:
    """As declared, by itself or by its type; "" where there is none."""
    try:
        base = table.base_type(declaration.type_name, declaration.type_span)
    except LagError:
        base = None
    arguments: tuple[Argument, ...] = (*declaration.arguments, *(base.attributes if base is not None else ()))
    units = [argument.value.value for argument in arguments if argument.name == "unit" and isinstance(argument.value, String)]
    return units[0] if units else ""


def heading(declaration: Declaration) -> str:
    """`parameter Stiffness k = 3`."""
    prefixes = " ".join(prefix for prefix in _ORDER if prefix in declaration.prefixes)
    sizes = ", ".join(dimension.span.text for dimension in declaration.dimensions)
    value = f" = {_one_line(declaration.binding.span.text)}" if declaration.binding is not None else ""
    return f"{prefixes}{' ' if prefixes else ''}{declaration.type_name} {declaration.name}{f'[{sizes}]' if sizes else ''}{value}"


def told_of(reading: Reading, found: Occurrence) -> str:
    """In Markdown."""
    index = reading.index
    assert index is not None
    node = found.meaning.node
    if isinstance(node, ClassDefinition):
        return "\n\n".join(_of_class(index, node))
    if isinstance(node, Declaration):
        return "\n\n".join(_of_declaration(reading, index, found, node))
    if isinstance(node, LiteralDefinition):
        return "\n\n".join(filter(None, [f"```lag\n{found.meaning.name}\n```", node.description, f"*{found.meaning.place}*"]))
    return f"```lag\nfor {found.meaning.name}\n```"


def _of_class(index: Index, definition: ClassDefinition) -> Iterator[str]:
    yield f"```lag\n{'partial ' if definition.is_partial else ''}{definition.kind} {definition.name}\n```"
    if definition.description:
        yield definition.description
    rows = [row for declaration in index.members(definition).values() if (row := _row(index.table, declaration))]
    rows += [f"- `{inner.name}`: {inner.description}" for inner in definition.classes]
    rows += [f"- `{literal.name}`: {literal.description}" for literal in definition.literals]
    if rows:
        yield "\n".join(rows)
    yield f"*{definition.name_span}*"


def _row(table: ClassTable, declaration: Declaration) -> str:
    if "protected" in declaration.prefixes:
        return ""
    unit = unit_of(table, declaration)
    value = f" = {_one_line(declaration.binding.span.text)}" if declaration.binding is not None else ""
    words = f": {declaration.description}" if declaration.description else ""
    return f"- `{declaration.type_name} {declaration.name}{value}`{f' [{unit}]' if unit else ''}{words}"


def _of_declaration(reading: Reading, index: Index, found: Occurrence, node: Declaration) -> Iterator[str]:
    yield f"```lag\n{heading(node)}\n```"
    if node.description:
        yield node.description
    unit = unit_of(index.table, node)
    facts = [f"unit {unit}"] if unit else []
    if node.binding is not None and "parameter" in node.prefixes:
        facts.append(f"default {_one_line(node.binding.span.text)}")
    if value := _value(reading, found):
        facts.append(f"value {value}")
    if facts:
        yield ", ".join(facts)
    if node.type_name == "Frame":
        yield f"a frame: {WORDS}"
    yield f"*{node.name_span}*"


def _value(reading: Reading, found: Occurrence) -> str:
    """As declared in the model that is run, where it is a number there."""
    flat = reading.flat
    if flat is None or flat.name != found.owner.name:
        return ""
    variable = flat.variables.get(_path(found))
    if variable is None or variable.kind not in ("parameter", "input"):
        return str(flat.structural[name]) if (name := _path(found)) in flat.structural else ""
    values = values_as_declared(flat, variable)
    if None in values or len(values) > _MOST_VALUES:
        return ""
    text = ", ".join(f"{value:.6g}" for value in values)
    return f"{f'{{{text}}}' if variable.shape else text}{f' {variable.unit}' if variable.unit else ''}"


def _path(found: Occurrence) -> str:
    """The full name in the model: with what stands before it in a reference, or with the component that it modifies."""
    source = found.span.source
    before = source.text[: found.span.start]
    start = len(before)
    while start and (before[start - 1].isalnum() or before[start - 1] in "_.[]"):
        start -= 1
    for element in found.owner.elements:
        if isinstance(element, Declaration):
            for argument in element.arguments:
                if argument.name_span.start == found.span.start and argument.name_span.source is source:
                    return f"{element.name}.{argument.name}"
    return before[start:] + found.meaning.name


def _one_line(text: str) -> str:
    return " ".join(text.split())


def described(meaning: Meaning) -> str:
    """In a few words."""
    return meaning.node.description if meaning.node is not None else ""
