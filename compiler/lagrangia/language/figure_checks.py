"""What a word of a drawing section takes, looked at with the dimensions of a flat model."""

from typing import Any, Protocol

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.language.elements import length
from lagrangia.language.figures import CHOICES, OF_SPACE, OPTIONS, WORDS
from lagrangia.language.flat import Figure, FlatModel, is_frame, places_of
from lagrangia.language.tree import Array, Flat, FrameRef, Number, Ref, String
from lagrangia.language.units import ONE, Dimension, dimension

_METRE = dimension(m=1)


class Dimensions(Protocol):
    """What tells dimensions of expressions: dimensions.py."""

    model: FlatModel

    def expect(self, node: Flat, wanted: Dimension, what: str) -> None:
        """Raises LagError where an expression has another dimension."""

    def quantity(self, node: Flat) -> Any:
        """What is known of an expression. Raises LagError."""

    def check_frame(self, node: Flat) -> None:
        """Raises LagError where a frame is shifted by what is no length."""


def check_figure(known: Dimensions, figure: Figure) -> None:
    """The arguments and options of a word. Raises LagError."""
    word, space = WORDS[figure.word], known.model.space
    if figure.word in OF_SPACE and not space.is_spatial:
        fail("L0229", f"'{figure.word}' is drawn in space, and this scene lies in the plane", figure.span,
             "in the plane there are box and circle")
    kinds, given = word.takes, figure.arguments
    is_found = not given and "of" in figure.options and kinds == ("place", "place")
    if (len(given) < word.least and not is_found) or (len(given) > len(kinds) and not word.goes_on):
        fail("L0215", f"{figure.word} does not take {len(given)} argument{'s' if len(given) != 1 else ''}", figure.span,
             f"write: {word.usage}")
    for k, node in enumerate(given):
        _check_argument(known, figure.word, kinds[min(k, len(kinds) - 1)], node, word.goes_on)
    for name, node in figure.options.items():
        if name not in OPTIONS:
            fail("L0229", f"what is drawn has no '{name}'", node.span,
                 suggest(name, OPTIONS) or f"it has {', '.join(OPTIONS)}")
        _check_argument(known, name, OPTIONS[name], node)


def _check_argument(known: Dimensions, what: str, kind: str, node: Flat, may_be_many: bool = False) -> None:
    if kind == "text":
        _check_text(what, node)
    elif kind == "place":
        for place in places_of(node) if may_be_many else (node,):
            _check_place(known, place)
    elif kind == "vector":
        _check_vector(known, node)
    else:
        if what == "curved_arrow" and kind == "value" and known.model.space.is_spatial and _length(known, node) == 3:
            known.quantity(node)  # a torque in space
            return
        if _length(known, node) is not None:
            fail("L0303", "one number is needed here", node.span)
        told = {"length": (_METRE, "a length"), "angle": (ONE, "an angle"),
                "number": (ONE, f"'{what}', in sizes of a symbol,")}
        if kind in told:
            known.expect(node, *told[kind])
        known.quantity(node)


def _check_vector(known: Dimensions, node: Flat) -> None:
    if _length(known, node) != known.model.space.dimensions:
        count, example = _sizes(known)
        fail("L0303", f"a vector of {count} components is needed here", node.span, f"write {{{example}}}")
    known.quantity(node)


def _length(known: Dimensions, node: Flat) -> int | None:
    def size(ref: Ref) -> int | None:
        return dict(enumerate(known.model.variables[ref.name].shape)).get(len(ref.index))

    return None if is_frame(node) else length(node, size)


def _check_place(known: Dimensions, node: Flat) -> None:
    if is_frame(node):
        known.check_frame(node)
    elif _length(known, node) != known.model.space.dimensions:
        count, example = _sizes(known)
        fail("L0221", f"a place is a frame, or a position of {count} components", node.span,
             f"as bar.a, bar.a.r or shift(bar.a, {{{example}}})")
    else:
        known.expect(node, _METRE, "a position")


def _check_text(what: str, node: Flat) -> None:
    """A text of one's own, or names whose symbols are written; a fixed word, where one is chosen."""
    if what in CHOICES:
        if not isinstance(node, String) or node.value not in CHOICES[what]:
            fail("L0229", f"'{what}' is one of {', '.join(CHOICES[what])}", node.span,
                 f'write: {what} = "{CHOICES[what][-1]}"')
        return
    for item in node.items if isinstance(node, Array) else (node,):
        if not isinstance(item, String | Ref | FrameRef | Number):
            fail("L0229", "a label is a text, or the name of what it stands for", item.span,
                 'write: label = "P", or label = k')


def _sizes(known: Dimensions) -> tuple[str, str]:
    return ("three", "x, y, z") if known.model.space.is_spatial else ("two", "x, y")
