"""What labels say: the symbols of `lag equations` for what figures name."""

import re
from collections.abc import Mapping, Sequence

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.draw.page import Words
from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Array, Binary, Flat, FrameRef, Number, Ref, String, Time
from lagrangia.paper.layout import LETTERS, Name
from lagrangia.paper.notation import Wanted, name_all

_MOST = 200  # names that are told from each other: more would not be read
_COMMA = (", ", False, False)


def label_all(model: FlatModel, labels: Sequence[Flat | None], chosen: Mapping[str, str]) -> list[Words | None]:
    """The words of each label; `chosen` are symbols of one's own, {"tilt.phi": "theta"}. Raises LagError L0711."""
    parts = [[_followed(model, item) for item in _items(label)] for label in labels]
    coordinates = [v.name for v in model.variables.values() if v.kind == "coordinate"]
    sources = {part.name: part for found in parts for part in found if isinstance(part, Ref)}
    if len(sources) > _MOST and not chosen:
        return [None] * len(labels)
    wanted = {name: Wanted(name) for name in coordinates if len(coordinates) <= _MOST}
    wanted |= {name: _wanted(model, name) for name in sources}
    for name in chosen:
        if name not in wanted:
            fail("L0711", f"--names: nothing that is called '{name}' stands in the picture", None,
                 *filter(None, [suggest(name, wanted)]))
    names = name_all(wanted.values(), chosen, [Name("t")])
    return [_words([_pieces(part, names) for part in found]) for found in parts]


def _items(label: Flat | None) -> Sequence[Flat]:
    return () if label is None else label.items if isinstance(label, Array) else (label,)


def _followed(model: FlatModel, node: Flat) -> Flat:
    """Through parameters and variables that only hand another one on: s1.k, bound to k1, is k1."""
    while isinstance(node, Ref) and isinstance(binding := model.variables[node.name].binding, Ref):
        node = binding
    return node


def _wanted(model: FlatModel, name: str) -> Wanted:
    variable = model.variables[name]
    if variable.kind in ("parameter", "coordinate"):
        return Wanted(name)
    read = leaves([variable.binding] if variable.binding is not None else [], {n: v.binding for n, v in model.variables.items()})
    moves = [isinstance(leaf, FrameRef) or (isinstance(leaf, Ref) and model.variables[leaf.name].kind == "coordinate")
             for leaf in read]
    is_in_time = any(isinstance(leaf, Time) for leaf in read) and not any(moves)
    return Wanted(name, True, is_in_time or variable.kind == "input")


def _pieces(part: Flat, names: Mapping[str, Name]) -> list[tuple[str, bool, bool]]:
    match part:
        case String(text, _):
            return [(text, False, False)]
        case Ref(name, index, _):
            return _shown(names[name], "".join(f"{k}" for k in index))
        case FrameRef():
            return [(str(part), False, False)]
        case Number(value):
            return [(f"{value:g}", False, False)]
        case Binary():
            return [(part.span.text, False, False)]
    return []


def _shown(name: Name, index: str) -> list[tuple[str, bool, bool]]:
    base = LETTERS.get(name.base, name.base)
    sub = " ".join(filter(None, (name.sub, index)))
    sub = re.sub(r"[A-Za-z]+", lambda word: LETTERS.get(word[0], word[0]), sub)
    found = [(base, True, False)] + ([(sub, not sub.replace(" ", "").isdigit(), True)] if sub else [])
    return found + ([(f"({name.argument})", True, False)] if name.argument else [])


def _words(found: Sequence[list[tuple[str, bool, bool]]]) -> Words | None:
    pieces: list[tuple[str, bool, bool]] = []
    for part in found:
        pieces += [_COMMA, *part] if pieces and part else part
    return Words(tuple(pieces)) if pieces else None
