"""What can be drawn: the words of a drawing section, what they take, and their options.

A place is a frame, or a position of two components, in space of three. Sizes are lengths; those that are left out are symbols, as
large as the picture wants them.
"""

from collections.abc import Mapping

from lagrangia.base.records import dataclass


@dataclass(frozen=True, slots=True)
class Word:
    """`takes`: kinds of its arguments; those from `least` on may be left out, the last may be repeated where it `goes_on`."""

    takes: tuple[str, ...]
    least: int
    usage: str
    goes_on: bool = False


def _word(usage: str, takes: str, least: int | None = None, goes_on: bool = False) -> Word:
    kinds = tuple(takes.split())
    return Word(kinds, len(kinds) if least is None else least, usage, goes_on)


WORDS: Mapping[str, Word] = {
    "line": _word("line(a, b)", "place place"),
    "polyline": _word("polyline(a, b, ...)", "place place", goes_on=True),
    "polygon": _word("polygon(a, b, c, ...)", "place place place", goes_on=True),
    "circle": _word("circle(center, r)", "place length", 1),
    "arc": _word("arc(center, r, from, to)", "place length angle angle"),
    "box": _word("box(center, length, height)", "place length length", 1),
    "zigzag": _word("zigzag(a, b)", "place place"),
    "dashpot": _word("dashpot(a, b)", "place place"),
    "arrow": _word("arrow(at, vector)", "place vector"),
    "curved_arrow": _word("curved_arrow(at, angle or torque)", "place value"),
    "hatch": _word("hatch(at)", "place"),
    "rail": _word("rail(base, slider)", "place place"),
    "gears": _word("gears(a, r_a, b, r_b)", "place length place length"),
    "belt": _word("belt(a, r_a, b, r_b)", "place length place length"),
    "trace": _word("trace(at)", "place"),
    "text": _word("text(at, words)", "place text"),
    "cuboid": _word("cuboid(center, x, y, z)", "place length length length"),
    "cylinder": _word("cylinder(center, r, height)", "place length length", 1),
    "cone": _word("cone(at, r, height)", "place length length"),
    "ball": _word("ball(center, r)", "place length", 1),
}

OF_SPACE = frozenset({"cuboid", "cylinder", "cone", "ball"})

# What may follow by name, and of which kind it is.
OPTIONS: Mapping[str, str] = {
    "label": "text", "fill": "text", "style": "text", "along": "vector", "of": "value", "size": "number", "offset": "number",
    "angle": "angle",
}
CHOICES: Mapping[str, tuple[str, ...]] = {
    "fill": ("none", "white", "grey", "black"),
    "style": ("normal", "thick", "thin", "dashed", "round"),
}
