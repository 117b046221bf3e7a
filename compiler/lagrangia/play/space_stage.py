"""A drawing in space -> what a page makes its solids and lines of at any moment, as stage.py does it in the plane."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangia.compile.instructions import tape_of
from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.animation import spelt
from lagrangia.draw.values import States
from lagrangia.language.flat import Figure
from lagrangia.play.stage import MOST_HANDLES, Stage, require_short_tables
from lagrangia.solids.orbit import told_form, told_whole
from lagrangia.solids.rows import Asked, build_rows
from lagrangia.solids.seen import LOADS, LONGEST_ARROW, SHOWN, Given, Looked, look, rods_of, stage_of, words_of
from lagrangia.solids.shapes import BRAKE, HALF_HELIX, RADIUS_OF_HELIX, TURNS_OF_HELIX, box, cylinder, sphere, turns_of

_FORMS = {"box": box(1, 1, 1), "cylinder": cylinder(1, 1), "cone": cylinder(1, 1, 0), "sphere": sphere(1)}


def build_space_stage(c: Compilation, figures: Sequence[Figure], states: States, names: Mapping[str, str],
                      traces: Sequence[str]) -> Stage:
    """The sizes of symbols, and what is seen as a whole, are those that suit the motion of `states`. Raises LagError."""
    require_short_tables(c)
    looked = look(c, figures, states)
    rows = looked.rows
    pairs = [(asked, g) for asked, g in zip(rows.asked, looked.given, strict=True) if g.poses]
    ways = [asked.places[0].start for asked, g in pairs if g.figure.word == "trace"]
    data = {
        **told_whole(stage_of(c, looked, states.t[0], names, traces)), "longest": LONGEST_ARROW,
        "helix": [HALF_HELIX, RADIUS_OF_HELIX], "brake": BRAKE,
        "forms": {name: told_form(solid) for name, solid in _FORMS.items()},
        "figures": [_figure(asked, g, looked) for asked, g in pairs if g.figure.word in SHOWN],
        "rods": [[rows.frames[a].start, rows.frames[b].start] for a, b in rods_of(c, looked)],
        "names": [{"words": spelt(words), "at": [place.start for place in rows.asked[k].places]}
                  for k, words in words_of(c, looked.given, names)],
        "frames": [at.start for frame, at in rows.frames.items() if frame not in looked.grounded][:MOST_HANDLES],
        "traces": ways + [rows.frames[frame].start for frame in traces],
    }
    return Stage(tape_of(build_rows(c, figures, for_tape=True).function), data)


def _figure(asked: Asked, g: Given, looked: Looked) -> dict[str, Any]:
    """As seen.py's Given has it, rows instead of numbers."""
    hinged = g.hinge is not None
    turns = 0 if g.figure.word != "zigzag" else TURNS_OF_HELIX if hinged else turns_of(g.poses[0][0], g.poses[1][0], g.symbol)
    return {"word": g.figure.word, "at": [place.start for place in asked.places], "n": [_ends(at) for at in asked.numbers],
            "o": {name: _ends(at) for name, at in asked.options.items()}, "fill": g.choice("fill", "none"), "shade": g.shade,
            "line": g.stroke, "ground": g.is_ground, "measure": g.measure, "is_load": g.measure in LOADS,
            "greatest": looked.greatest.get(g.measure, 0.0), "turns": turns, "hinged": hinged}


def _ends(rows: slice) -> list[int]:
    return [rows.start, rows.stop]
