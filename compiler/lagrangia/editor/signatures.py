"""What a component or a function takes, while its brackets are open."""

from lagrangia.base.records import dataclass
from lagrangia.editor.meanings import Index, class_named
from lagrangia.editor.surroundings import brackets_at, modified
from lagrangia.editor.telling import heading, unit_of
from lagrangia.language.figures import WORDS
from lagrangia.language.tree import ClassDefinition, Declaration


@dataclass(frozen=True)
class Signature:
    """One line, what it is for, its parameters (the text in the line, and about it), and the number of the one being written."""

    label: str
    about: str
    parameters: tuple[tuple[str, str], ...]
    active: int | None


def signature(index: Index, text: str, offset: int) -> Signature | None:
    """Of the innermost bracket that takes something; None outside of such."""
    owner = index.class_around(offset)
    if owner is None:
        return None
    statement, brackets = brackets_at(text, offset)
    if not brackets:
        return None
    target, last = modified(index, statement, brackets, owner), brackets[-1]
    if target is not None and target[0] is not None:
        return _of_component(index, target[0], last.begun)
    if last.name in WORDS:
        return Signature(WORDS[last.name].usage, "", (), None)
    function = class_named(index.table, last.name, owner.name_span)
    if function is None or function.kind != "function":
        return None
    inputs = [e for e in function.elements if isinstance(e, Declaration) and "input" in e.prefixes]
    return _signature(index, function, inputs, last.argument if last.argument < len(inputs) else None)


def _of_component(index: Index, definition: ClassDefinition, begun: str) -> Signature:
    given = [d for d in index.members(definition).values() if not {"protected", "constant", "final"} & d.prefixes]
    name = begun.partition("=")[0].removeprefix("each ").strip()
    active = next((k for k, declaration in enumerate(given) if declaration.name == name), None)
    return _signature(index, definition, given, active)


def _signature(index: Index, definition: ClassDefinition, taken: list[Declaration], active: int | None) -> Signature:
    parameters = []
    for declaration in taken:
        unit = unit_of(index.table, declaration)
        about = f"{heading(declaration)}{f' [{unit}]' if unit else ''} {declaration.description}".strip()
        parameters.append((declaration.name, about))
    label = f"{definition.name}({', '.join(name for name, _ in parameters)})"
    return Signature(label, definition.description, tuple(parameters), active)
