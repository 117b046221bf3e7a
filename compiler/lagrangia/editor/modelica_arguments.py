"""Arguments of the Modelica Standard Library's components that ours do not have: they are left out, and told.

Texts are lists of words, with spaces and comments as words of their own.
"""

from collections.abc import Collection, Iterator, Sequence
from functools import cache

from lagrangia.language.component_library import library_package
from lagrangia.language.tree import ClassDefinition, Declaration, Extends

WAY = "@"  # stands before the ways in which blocks start
# Those start values are ours, too; those of outputs but where states are told from them.
_OF_TABLES = frozenset({f"{WAY}Extrapolation.LastTwoPoints", f"{WAY}Smoothness.LinearSegments"})
_AS_OURS = frozenset({"NoInit", "InitialState", "InitialOutput"})
_PREFIXES = frozenset({"each", "final", "redeclare", "replaceable"})
_USUAL = {("Translational.ElastoGap", "n"): 1.0}  # the power of how far it is compressed
_WITHOUT = frozenset({"withFeedForward", "useReset", "useSet", "tableOnFile"})  # inputs that there are where these are true
_OPENING, _CLOSING = ("(", "[", "{"), (")", "]", "}")
# Arguments of the library's components without a meaning here:
_IDLE = frozenset("useHeatPort stateSelect animation phi_nominal s_nominal nominal startForward startBackward mode "
                  "stuck locked vReg exact f_crit w_small v_small strict limiter homotopyType".split())
_RENAMED = {"freqHz": "f", "mue_pos": "mu_pos"}  # arguments, as they were called before version 4
_Span = tuple[int, int]  # of an argument: its first word, and the comma or bracket behind it


def is_said(word: str) -> bool:
    """Whether it is neither space nor a comment."""
    return not (word.isspace() or word.startswith(("//", "/*")))


def arguments(words: Sequence[str], opening: int) -> list[_Span]:
    """Of the bracket that opens at a place."""
    found, depth, begin = list[_Span](), 0, opening + 1
    for k in range(opening, len(words)):
        depth += (words[k] in _OPENING) - (words[k] in _CLOSING)
        if depth == 0 or (depth == 1 and words[k] == ","):
            found.append((begin, k))
            begin = k + 1
        if depth == 0:
            break
    return found


def without_idle(words: Sequence[str]) -> list[str]:
    """Without arguments that mean nothing here, as stateSelect = StateSelect.always, and others by their names here."""
    found, gone = list(words), set[int]()
    for opening, bracket in enumerate(words):
        if bracket != "(" or opening in gone:
            continue
        spans, going = arguments(words, opening), list[_Span]()
        for first, last in spans:
            places = [k for k in range(first, last) if is_said(words[k]) and words[k] not in _PREFIXES][:2]
            if len(places) == 2 and words[places[0]] in _IDLE and words[places[1]] in ("=", "("):  # startForward(fixed = true)
                going.append((first, last))
            elif len(places) == 2 and words[places[1]] == "=":
                found[places[0]] = _RENAMED.get(words[places[0]], words[places[0]])
        gone |= _places(words, spans, going)
    return [word for k, word in enumerate(found) if k not in gone]


def without_unknown(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """The words of a statement without them, and what is told of each."""
    gone, told = set[int](), list[str]()
    for at, name in enumerate(words):
        if at in gone or not _members(name):
            continue
        for component, opening in _modified(words, at):
            spans, going = arguments(words, opening), list[_Span]()
            for first, last in spans:
                argument = [word for word in words[first:last] if is_said(word) and word not in _PREFIXES]
                if not argument or argument[0] in _members(name):
                    continue
                going.append((first, last))
                if not _is_usual(name, argument):
                    text = "".join(word.removeprefix(WAY) for word in words[first:last] if is_said(word) or word.isspace())
                    told.append(f"{' '.join(text.split())} of {component} ({name} has no '{argument[0]}')")
            gone |= _places(words, spans, going)
    return [word for k, word in enumerate(words) if k not in gone], told


def _is_usual(name: str, argument: Sequence[str]) -> bool:
    """Whether an argument, `name = value`, says what ours do; what is computed is not known."""
    if len(argument) != 3 or argument[1] != "=":
        return False
    if argument[0] == "initType" and argument[2].startswith(WAY):
        way = argument[2].rpartition(".")[2]
        return way in _AS_OURS and not (name == "Blocks.PI" and way == "InitialOutput")
    if argument[2] in _OF_TABLES:
        return True
    if argument[0] in _WITHOUT:
        return argument[2] == "false"
    try:
        return float(argument[2]) == _USUAL.get((name, argument[0]))
    except ValueError:
        return False


def _modified(words: Sequence[str], at: int) -> Iterator[tuple[str, int]]:
    """What is modified behind the type at a place: a component's name, or the type's own, and where its bracket opens. Within
    brackets, as behind `redeclare`, it is one component."""
    before = next((word for word in reversed(words[:at]) if is_said(word)), "")
    is_class = before in ("extends", "=", "constrainedby")
    is_one = is_class or any(word in _OPENING for word in words[:at])
    depth, component, last = 0, words[at] if is_class else "", words[at]
    is_open = is_class  # whether a bracket may follow: not behind the name's `if`, `=` and `constrainedby`
    for k in range(at + 1, len(words)):
        word = words[k]
        if word == "(" and depth == 0 and is_open and component:
            yield component, k
        depth += (word in _OPENING) - (word in _CLOSING)
        is_end = depth == 0 and word in ("=", "constrainedby", "if")
        if depth < 0 or (is_one and (is_end or (depth == 0 and word == ","))):
            return
        if depth == 0 and is_said(word):
            if last in (words[at], ",", "]") and not component and (word[:1].isalpha() or word[:1] == "_"):
                component, is_open = word, True
            elif word == ",":
                component, is_open = "", False
            elif word not in ("]", ")"):
                is_open = is_open and not is_end
            last = word


def _places(words: Sequence[str], spans: Sequence[_Span], going: Collection[_Span]) -> set[int]:
    """The places of arguments that go out of a bracket, with one comma each: behind what stays, or else before it. Comments stay,
    with the ends of their lines."""
    gone, is_kept = set[int](), False
    for first, last in spans:
        if (first, last) not in going:
            is_kept = True
            continue
        gone |= {k for k in range(first, last) if not words[k].startswith(("//", "/*")) and not words[k - 1].startswith("//")}
        if is_kept:
            gone.add(first - 1)
        elif words[last] == ",":
            gone |= {last} | ({last + 1} if words[last + 1].isspace() else set())
    return gone


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
