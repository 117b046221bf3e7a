"""Arguments of the Modelica Standard Library's components that ours do not have: they are left out, and told."""

from collections.abc import Iterator, Sequence
from functools import cache

from lagrangia.language.component_library import library_package
from lagrangia.language.tree import ClassDefinition, Declaration, Extends

_PREFIXES = frozenset({"each", "final", "redeclare", "replaceable"})
_USUAL = {"n": "1"}  # of ElastoGap: the power of how far it is compressed
_OPENING, _CLOSING = ("(", "[", "{"), (")", "]", "}")
# How blocks start: those start values are ours, too; those of outputs but where states are told from them.
_AS_OURS = frozenset({"NoInit", "InitialState", "InitialOutput"})


def without_unknown(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """The words of a declaration without them, and what is told of each."""
    at = next((k for k, word in enumerate(words) if _members(word)), None)
    if at is None:
        return list(words), []
    gone, told, name = set[int](), list[str](), ""
    for component, first, last in _arguments(words, at):
        said = [word for word in words[first:last] if not word.isspace() and word not in _PREFIXES]
        name = said[0] if said else ""
        if not name or name in _members(words[at]):
            continue
        is_usual = said[1:] == ["=", _USUAL.get(name)]
        gone |= _with_a_comma(words, first, last)
        if not (is_usual or (name == "initType" and _starts_as_ours(words[at], said[-1].rpartition(".")[2]))):
            told.append(f"{' '.join(''.join(words[first:last]).split())} of {component} ({words[at]} has no '{name}')")
    return [word for k, word in enumerate(words) if k not in gone], told


def _starts_as_ours(component: str, way: str) -> bool:
    return way in _AS_OURS and not (component == "Blocks.PI" and way == "InitialOutput")


def _arguments(words: Sequence[str], at: int) -> Iterator[tuple[str, int, int]]:
    """Of the components that are declared behind their type: a component's name, and where each of its arguments begins and
    ends. Within brackets, as behind `redeclare`, it is one component."""
    is_alone = any(word in _OPENING for word in words[:at])
    depth, component, begin = 0, "", None
    for k in range(at + 1, len(words)):
        word = words[k]
        if begin is not None and depth == 1 and word in (",", ")"):
            yield component, begin, k
            begin = k + 1 if word == "," else None
        depth += (word in _OPENING) - (word in _CLOSING)
        if depth < 0 or (depth == 0 and (word in ("=", "constrainedby", "if") or (is_alone and word == ","))):
            return
        if depth == 0 and (word[:1].isalpha() or word[:1] == "_"):
            component = word
        elif word == "(" and depth == 1 and component:
            begin = k + 1


def _with_a_comma(words: Sequence[str], first: int, last: int) -> set[int]:
    """The places of an argument, and of the comma that stands behind it, or else before it."""
    if words[last] == ",":
        if words[first - 1] == "(":  # nothing stands before the next one
            last += next((k for k, word in enumerate(words[last + 1 :]) if not word.isspace()), 0)
        return set(range(first, last + 1))
    return set(range(first - 1 if words[first - 1] == "," else first, last))


@cache
def _members(name: str) -> frozenset[str]:
    """What a component of ours has, by its full name; nothing for what is none of the packages of the Modelica library."""
    package, _, inner = name.partition(".")
    found = library_package(package) if inner and package in ("Rotational", "Translational", "Blocks") else None
    if found is None:
        return frozenset()
    classes = {one.name: one for outer in found.classes for one in outer.classes}
    return frozenset(_names(classes[inner], classes)) if inner in classes else frozenset()


def _names(definition: ClassDefinition, classes: dict[str, ClassDefinition]) -> Iterator[str]:
    for element in definition.elements:
        if isinstance(element, Declaration):
            yield element.name
        elif isinstance(element, Extends) and element.type_name in classes:
            yield from _names(classes[element.type_name], classes)
