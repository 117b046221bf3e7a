"""What may stand where the cursor is: classes, members, parameters, ports, attributes, functions, units, words."""

import re
from collections.abc import Iterator
from typing import Literal

from lagrangia.base.records import dataclass
from lagrangia.editor.meanings import Index, class_named, lineage
from lagrangia.editor.surroundings import brackets_at, followed, modified, section_at
from lagrangia.editor.telling import heading, unit_of
from lagrangia.language.attributes import ATTRIBUTES as VARIABLE_ATTRIBUTES
from lagrangia.language.classes import BUILTIN_TYPES
from lagrangia.language.figures import WORDS
from lagrangia.language.frame_attributes import ABOUT_Z, ATTRIBUTES, PLANE, REACTIONS, SPACE
from lagrangia.language.functions import FRAME_FUNCTIONS, FUNCTIONS
from lagrangia.language.tree import ClassDefinition, Declaration
from lagrangia.language.units import known_units

Kind = Literal["class", "type", "function", "variable", "port", "property", "keyword", "unit"]
_UNIT = re.compile(r"(?:^|[^\w.\])])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*\[([^\]\n]*)$")
_UNIT_TEXT = re.compile(r'\b(?:unit|displayUnit)\s*=\s*"([^"\n]*)$')
_DOTTED = re.compile(r"([^\W\d][\w.]*(?:\[[^\]\n]*\][\w.]*)*)\.\w*$")
_NEAR = 1_000  # characters before the cursor in which these are looked for: each may begin at any of them
_BETWEEN_DECLARATIONS = ("parameter", "constant", "input", "output", "coordinate", "discrete", "final", "extends", "equation",
                         "initial equation", "energy", "drawing", "annotation", "public", "protected", "end")
_IN_SECTIONS = {"equation": ("connect", "for", "if", "when", "initial equation", "energy", "drawing", "annotation", "end"),
                "initial equation": ("equation", "energy", "drawing", "annotation", "end"),
                "energy": ("kinetic", "potential", "dissipation", "work", "drawing", "annotation", "end"),
                "algorithm": ("for", "while", "if", "end"), "drawing": ("for", "if", "annotation", "end")}
_OF_FRAMES = {name: space.attributes[name] for space in (SPACE, PLANE) for name in sorted(space.of_any_frame)
              if name not in (ABOUT_Z, "attitude")}  # whichever the scene will be in
_OUTSIDE = ("model", "partial model", "function", "type", "import")


@dataclass(frozen=True)
class Proposal:
    """A word that may stand there, with what it is."""

    label: str
    kind: Kind
    detail: str = ""
    about: str = ""


def proposals(index: Index, text: str, offset: int) -> list[Proposal]:
    """All that may stand there; what is typed already is for the editor to compare."""
    before = text[text.rfind("\n", 0, offset) + 1 : offset]
    near = before[-_NEAR:]
    if _UNIT.search(near) or _UNIT_TEXT.search(near):
        return [Proposal(unit, "unit") for unit in known_units()]
    if before.count('"') % 2 or "//" in before:
        return []
    owner = index.class_around(offset)
    if owner is None:
        return [Proposal(word, "keyword") for word in _OUTSIDE]
    if dotted := _DOTTED.search(near):
        return list(_members_of(index, owner, dotted[1]))
    return list(dict.fromkeys(_in_class(index, owner, text, offset)))


def _in_class(index: Index, owner: ClassDefinition, text: str, offset: int) -> Iterator[Proposal]:
    statement, brackets = brackets_at(text, offset)
    target = modified(index, statement, brackets, owner)
    if target is not None and "=" not in brackets[-1].begun:
        yield from _arguments(index, *target)
        return
    section = section_at(text, offset)
    begins = re.fullmatch(r"\s*(?:(?:parameter|constant|input|output|coordinate|final)\s+)*\w*", statement) is not None
    if begins and not section:
        words = _BETWEEN_DECLARATIONS if re.fullmatch(r"\s*\w*", statement) else ()
        yield from (Proposal(word, "keyword") for word in words)
        yield from _types(index)
        return
    if begins:
        yield from (Proposal(word, "keyword") for word in _IN_SECTIONS.get(section, ()))
    if section == "drawing":
        yield from (Proposal(name, "function", word.usage) for name, word in WORDS.items())
    yield from (_member(index, declaration) for declaration in index.members(owner).values())
    yield Proposal("world", "variable", "the ground")
    yield Proposal("time", "variable", "in s")
    yield from (Proposal(name, "function") for name in (*FUNCTIONS, *FRAME_FUNCTIONS))
    yield from (Proposal(c.name, "function", c.kind, c.description) for c in _classes(index) if c.kind == "function")


def _classes(index: Index) -> Iterator[ClassDefinition]:
    yield from {**index.table.library, **index.table.user}.values()


def _types(index: Index) -> Iterator[Proposal]:
    yield from (Proposal(name, "type", "builtin") for name in sorted(BUILTIN_TYPES))
    for definition in _classes(index):
        if definition.kind != "function" and not definition.is_partial:
            kind: Kind = "type" if definition.kind == "type" else "class"
            yield Proposal(definition.name, kind, definition.kind, definition.description)


def _member(index: Index, declaration: Declaration) -> Proposal:
    unit = unit_of(index.table, declaration)
    kind: Kind = "port" if declaration.type_name == "Frame" else "variable"
    return Proposal(declaration.name, kind, f"{heading(declaration)}{f' [{unit}]' if unit else ''}", declaration.description)


def _members_of(index: Index, owner: ClassDefinition, names: str) -> Iterator[Proposal]:
    found = followed(index, owner, names) or index.class_or_package(names, owner.name_span)
    kind = found.type_name if isinstance(found, Declaration) else found.name if found is not None else ""
    definition = found if isinstance(found, ClassDefinition) else class_named(index.table, kind, owner.name_span)
    if kind in ("Frame", "World"):
        yield from (Proposal(name, "property", a.unit) for name, a in _OF_FRAMES.items())
    if isinstance(found, ClassDefinition) and found.name != "World":
        yield from _of_class(index, found)
    elif definition is not None:
        visible = [d for d in index.members(definition).values() if "protected" not in d.prefixes]
        yield from (_member(index, declaration) for declaration in visible)
        if sum(declaration.type_name == "Frame" for declaration in visible) > 1:
            yield from (Proposal(name, "property", ATTRIBUTES[name].unit) for name in REACTIONS)


def _of_class(index: Index, definition: ClassDefinition) -> Iterator[Proposal]:
    """Behind the name of a package its classes and constants, behind that of an enumeration its values."""
    yield from (Proposal(literal.name, "variable", definition.name, literal.description) for literal in definition.literals)
    inside = [c for base in lineage(index.table, definition) for c in base.classes]
    inside += [c for name, c in index.table.user.items() if name.rpartition(".")[0] == definition.name]
    for one in {c.name_span: c for c in inside}.values():
        kind: Kind = "function" if one.kind == "function" else "type" if one.kind == "type" else "class"
        yield Proposal(one.name.rpartition(".")[2], kind, one.kind, one.description)
    yield from (_member(index, d) for d in index.members(definition).values() if "constant" in d.prefixes)


def _arguments(index: Index, definition: ClassDefinition | None, kind: str) -> Iterator[Proposal]:
    """What can be given to a component, or to a variable of a builtin type."""
    if definition is None or definition.kind == "type":
        names = _OF_FRAMES.keys() if kind == "Frame" else VARIABLE_ATTRIBUTES
        yield from (Proposal(name, "property", f"of {kind}") for name in sorted(names))
        return
    for declaration in index.members(definition).values():
        if not {"protected", "constant", "final"} & declaration.prefixes:
            yield _member(index, declaration)
