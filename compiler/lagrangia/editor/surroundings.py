"""Where in an unfinished text the cursor is: in which brackets of what, behind a dot, in a unit; read off the words before it."""

import re

from lagrangia.base.records import dataclass
from lagrangia.editor.meanings import Index, class_named
from lagrangia.language.tree import ClassDefinition, Declaration

_SKIPPED = re.compile(r'"(?:[^"\\]|\\.)*"?|//[^\n]*|/\*.*?(?:\*/|$)', re.DOTALL)
_PREFIX = r"(?:(?:parameter|constant|input|output|coordinate|final|discrete|each|inner|outer|replaceable)\s+)*"
_DECLARED = re.compile(rf"^\s*{_PREFIX}(?P<type>[^\W\d][\w.]*)(?![\w.])\s*(?:\[[^\]]*\]\s*)?(?P<rest>[^\W\d].*)$", re.DOTALL)
_NAME_BEFORE = re.compile(r"([^\W\d][\w.]*)\s*(?:\[[^\]]*\])?\s*$")
_SECTION = re.compile(r"^\s*(equation|initial equation|energy|algorithm|drawing|public|protected)\b", re.MULTILINE)
_HEADS = re.compile(
    r"\b(?:equation|energy|algorithm|drawing|then|loop|else|public|protected|model\s+\w+|function\s+\w+)(?=\s)")
NO_TYPES = frozenset("extends if for when elseif else then end equation kinetic potential dissipation work import".split())


@dataclass(frozen=True)
class Bracket:
    """An open ( with what stands before it, and what stands in it so far: the number of the argument, and its beginning."""

    name: str
    start: int
    argument: int
    begun: str  # of the argument where the cursor is


def without_texts(text: str) -> str:
    """The same length, with spaces in place of strings and comments."""
    return _SKIPPED.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def brackets_at(text: str, offset: int) -> tuple[str, list[Bracket]]:
    """The statement up to the cursor, and its open brackets, the outermost first."""
    plain = without_texts(text[:offset])
    start = statement_start(plain)
    opened: list[tuple[str, int]] = []
    for k in range(start, offset):
        if plain[k] in "([{":
            opened.append((plain[k], k))
        elif plain[k] in ")]}" and opened:
            opened.pop()
    found = []
    for sign, k in opened:
        name = _NAME_BEFORE.search(plain[start:k])
        if sign == "(" and name is not None:
            arguments = _split(plain[k + 1 : offset])
            found.append(Bracket(name[1], k, len(arguments) - 1, arguments[-1].lstrip()))
    return plain[start:offset], found


def statement_start(plain: str) -> int:
    """Behind the semicolon, or the word, that ends what is before the last statement of a text without strings and comments."""
    depth = 0
    for k in range(len(plain) - 1, -1, -1):
        depth += (plain[k] in ")]}") - (plain[k] in "([{")
        if plain[k] == ";" and depth <= 0:
            start = k + 1
            break
    else:
        start = 0
    heads = [found.end() for found in _HEADS.finditer(plain, start)]
    return heads[-1] if heads else start


def _split(text: str) -> list[str]:
    """At commas that are in no bracket."""
    parts, depth, last = [], 0, 0
    for k, c in enumerate(text):
        depth += (c in "([{") - (c in ")]}")
        if c == "," and depth == 0:
            parts.append(text[last:k])
            last = k + 1
    return [*parts, text[last:]]


def is_declaring(statement: str) -> str | None:
    """The type of which a statement declares something, or that it extends; None for others."""
    if extended := re.match(r"\s*extends\s+([^\W\d][\w.]*)", statement):
        return extended[1]
    if short := re.match(r"\s*type\s+\w+\s*=\s*([^\W\d][\w.]*)", statement):
        return short[1]
    found = _DECLARED.match(statement)
    if found is None or found["type"] in NO_TYPES or re.match(r"\s*[(.=]", statement[found.end("type") :]):
        return None
    return found["type"]


def modified(index: Index, statement: str, brackets: list[Bracket], owner: ClassDefinition
             ) -> "tuple[ClassDefinition | None, str] | None":
    """The class of which members are given in the innermost bracket, and the name of its type; None where no modification is
    written. The class is None for builtin types."""
    kind = is_declaring(statement)
    if kind is None or not brackets:
        return None
    span = owner.name_span
    definition = class_named(index.table, kind, span)
    for bracket in brackets[1:]:
        declaration = index.members(definition).get(bracket.name) if definition is not None else None
        if declaration is None:
            return None
        kind = declaration.type_name
        definition = class_named(index.table, kind, declaration.type_span)
    return definition, kind


def section_at(text: str, offset: int) -> str:
    """The name of the section; "" among the declarations."""
    plain = without_texts(text[:offset])
    begun = [m.start() for m in re.finditer(r"^\s*(?:partial\s+)?(?:model|function|block|package|record)\s", plain, re.MULTILINE)]
    found = _SECTION.findall(plain[begun[-1] if begun else 0 :])
    return "" if not found or found[-1] in ("public", "protected") else found[-1]


def followed(index: Index, owner: ClassDefinition, names: str) -> "Declaration | ClassDefinition | None":
    """What a dotted name, with or without subscripts, stands for in a class."""
    inside: ClassDefinition | None = owner
    found: Declaration | ClassDefinition | None = None
    for k, part in enumerate(re.sub(r"\[[^\]]*\]", "", names).split(".")):
        if inside is None:
            return None
        found = index.members(inside).get(part)
        if found is None and k == 0 and part == "world":
            found = inside = class_named(index.table, "World", owner.name_span)
        elif found is None:
            return None
        elif isinstance(found, Declaration):
            inside = class_named(index.table, found.type_name, found.type_span)
    return found


