"""Names of the source -> symbols on paper: tilt.phi becomes phi where no other phi is about, hinge[2].phi phi_2, s1.k k_s1."""

import re
from collections.abc import Iterable, Mapping
from itertools import chain, count

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.paper.layout import LETTERS, Name

_ATTRIBUTES = {"force": ("F", ""), "torque": ("M", ""), "s_rel0": ("s", "0"), "phi_rel0": ("phi", "0"), "gravity": ("g", ""),
               "omega": ("omega", "")}
_AXES, _OF_BODIES = {"1": "x", "2": "y", "3": "z"}, ("I",)  # of vectors; moments about the axes of a body
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")
GREEK = {shown: name for name, shown in LETTERS.items() if not name.startswith("script ")} | {"ϕ": "phi", "ϵ": "epsilon"}
_VARIANTS = {"varphi": "phi", "varepsilon": "epsilon"}  # which stand on paper by themselves
LETTERS_OF_PAGES = ("T", "V", "D", "L", "E", "H", "W")  # energies, D, the Lagrangian, Jacobi's integral, virtual work


@dataclass(frozen=True)
class Wanted:
    """A symbol that needs a name on paper. `is_load` names are called after a component of one letter."""

    source: str
    is_load: bool = False
    is_function: bool = False  # of time: printed with (t)


def name_all(wanted: Iterable[Wanted], given: Mapping[str, str], others: Iterable[Name] = ()) -> dict[str, Name]:
    """A name for each source name, all different, and different from `others`; `given` are those that the user chose (source ->
    text).

    Raises LagError L0711 for a chosen name that is no name, or stands for two things, or for a source name that is unknown.
    """
    wanted, kept = list(wanted), {(x.base, x.sub) for x in others}
    given = {source: _plain(text) for source, text in given.items()}
    _check(wanted, given, kept)
    names = {source: _split(text) for source, text in given.items()}
    names |= _own_names([item.source for item in wanted if "." not in item.source and item.source not in names],
                        kept | set(names.values()))
    rest = [item for item in wanted if item.source not in names]
    for level in range(3):
        groups: dict[tuple[str, str], list[Wanted]] = {}
        for item in rest:
            groups.setdefault(_candidate(item, level, rest), []).append(item)
        taken = kept | set(names.values())
        unique = {items[0].source: key for key, items in groups.items() if len(items) == 1 and key not in taken}
        names |= unique
        rest = [item for item in rest if item.source not in unique]
    names |= {item.source: (item.source, "") for item in rest}
    functions = {item.source for item in wanted if item.is_function}
    return {source: Name(base, sub, 0, "t" if source in functions else "") for source, (base, sub) in names.items()}


def own_letters(sources: Iterable[str], given: Mapping[str, str], taken: Iterable[Name]) -> dict[str, Name]:
    """The letters that the pages bring along, by those that the user chose instead; what a scene calls so is its own.

    Raises LagError L0711 for what is no name, or stands for something else.
    """
    known, kept = set(sources), {(x.base, x.sub) for x in taken}
    chosen = {letter: _plain(text) for letter, text in given.items() if letter in LETTERS_OF_PAGES and letter not in known}
    for text in chosen.values():
        _check_name(text)
        if _split(text) in kept or list(chosen.values()).count(text) > 1 or (text in LETTERS_OF_PAGES and text not in chosen):
            fail("L0711", f"--names: '{text}' would stand for two things", None)
    return {letter: Name(*_split(text)) for letter, text in chosen.items()}


def _plain(text: str) -> str:
    """A name as people write it, in the letters of the source: \\theta_1 and θ_1 are theta_1, x_{cm} is x_cm."""
    text = re.sub(r"\\([A-Za-z]+)", r"\1", re.sub(r"\{(\w+)\}", r"\1", text))
    base, *rest = "".join(GREEK.get(c, c) for c in text).split("_")
    return "_".join([_VARIANTS.get(base, base), *rest])


def _check_name(text: str) -> None:
    if not _NAME.fullmatch(text):
        fail("L0711", f"--names: '{text}' is no name", None, "letters and digits, with _ before a subscript: theta or θ, x_1")


def _own_names(sources: list[str], taken: set[tuple[str, str]]) -> dict[str, tuple[str, str]]:
    """Of names without a path: themselves, but k1 and k_1 as they are written, and t, which is the time, t_1."""
    found: dict[str, tuple[str, str]] = {}
    shared = [_split(source) for source in sources]
    for source, short in zip(sources, shared, strict=True):
        choices = chain([short] if shared.count(short) == 1 else [], [(source, "")], ((source, str(k)) for k in count(1)))
        found[source] = next(x for x in choices if x not in taken)
        taken = taken | {found[source]}
    return found


def own_name(letter: str, sub: str, others: Iterable[Name]) -> Name:
    """A name that the pages bring along: in script where one of the others, which are of the scene, has the letter."""
    is_taken = any(name.base == letter for name in others)
    return Name(f"script {letter}" if is_taken else letter, sub)


def is_own(source: str, name: Name) -> bool:
    """Whether a name without a path stands on paper as one expects it."""
    return "." in source or (name.base, name.sub) in (_split(source), (source, ""))


def _check(wanted: list[Wanted], given: Mapping[str, str], kept: set[tuple[str, str]]) -> None:
    known = [item.source for item in wanted]
    for source, text in given.items():
        if source not in known:
            hints = filter(None, [suggest(source, known)])
            fail("L0711", f"--names: there is no symbol '{source}' in the equations", None, *hints)
        _check_name(text)
    texts = {text: _split(text) for text in given.values()}
    shown = [_split(text) for text in given.values()]
    twice = [text for text, name in texts.items() if shown.count(name) > 1 or name in kept]
    others = [text for text in texts if text in known and text not in given and "." not in text]
    if twice or others:
        fail("L0711", f"--names: '{(twice or others)[0]}' would stand for two things", None)


def _candidate(item: Wanted, level: int, rest: list[Wanted]) -> tuple[str, str]:
    """The shorter names come first: the attribute alone, with its component, with its whole path."""
    path, attribute, axis = _parts(item.source)
    base, sub = _ATTRIBUTES.get(attribute) or _split(attribute)
    last = _last(path)
    if item.is_load and re.fullmatch(r"[A-Za-z]\d*", last):
        base, sub = _split(last)
        return base, _joined(sub, axis)
    if level == 0:
        return base, _joined(sub, axis)
    if level == 1:
        return base, _joined(sub, _component(item, rest), axis)
    return base, _joined(sub, path.replace(".", " ").replace("[", "").replace("]", ""), axis)


def _component(item: Wanted, rest: list[Wanted]) -> str:
    """The component's last name; of an array's elements the number alone, when the others with the attribute are of the array."""
    path, attribute, _ = _parts(item.source)
    last = _last(path)
    match = re.fullmatch(r"(\w+)\[(\d+)\]", last)
    if match:
        others = {_last(p) for p, a, _ in (_parts(other.source) for other in rest) if a == attribute}
        if all(re.fullmatch(rf"{match[1]}\[\d+\]", other) for other in others):
            return match[2]
        return f"{match[1]}{match[2]}"
    return last


def _last(path: str) -> str:
    """The component that a path ends with; the port of a floating body is the body."""
    parts = path.split(".")
    return parts[-2] if len(parts) > 1 and parts[-1] in ("center", "at", "on") else parts[-1]


def _parts(source: str) -> tuple[str, str, str]:
    """Path, attribute, and the axis of an element of a vector."""
    path, _, attribute = source.rpartition(".")
    match = re.fullmatch(r"(\w+)\[(\d)\]", attribute)
    if match is None:
        return path, attribute, ""
    return path, match[1], match[2] if match[1] in _OF_BODIES else _AXES.get(match[2], match[2])


def _split(text: str) -> tuple[str, str]:
    """k1 -> (k, 1), s_rel0 -> (s, rel0), speed -> (speed, "")."""
    base, _, sub = text.partition("_")
    match = re.fullmatch(r"([A-Za-z]|[A-Za-z]*[a-z]{2,})(\d+)", base)
    if match:
        base, sub = match[1], _joined(match[2], sub)
    if re.fullmatch(r"[A-Za-z][a-z]", base) and base not in LETTERS:
        base, sub = base[0], _joined(base[1], sub)  # ks is k_s
    element = re.fullmatch(r"(\w+)\[([\d,]+)\]", base)
    return (element[1], _joined(element[2].replace(",", " "), sub)) if element else (base, sub.replace("_", " "))


def _joined(*parts: str) -> str:
    return " ".join(part for part in parts if part)
