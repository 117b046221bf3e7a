"""Drawing sections: whose are read when, what an heir draws, and that all of the library draws."""

from pathlib import Path

import pytest

from lagrangia.base.folders import data_folder
from lagrangia.compile.pipeline import flatten_file
from lagrangia.language.classes import build_class_table
from lagrangia.language.component_library import drawn_library, library
from lagrangia.language.dimensions import check_dimensions
from lagrangia.language.tree import ClassDefinition

SCENE = """
model Fan
  parameter Length tip = 0.1 "as drawn";
  parameter Integer blades = 3;
  Frame hub;
drawing
  for i in 1:blades loop
    line(hub, shift(turn(hub, i*120[deg]), {tip, 0}));
  end for;
end Fan;
model Guarded extends Fan; drawing circle(hub, tip); end Guarded;
model Bare extends Fan; drawing end Bare;
model Wider extends Fan(tip = 0.2); end Wider;
model Scene
  parameter Length R = 1 "of the cage, which nothing but the picture reads";
  Revolute axle(a = world);
  Disc rotor(m = 1, r = 0.2, center = axle.b);
  Fan fan(hub = rotor.center); Wider wider(hub = rotor.center);
  Guarded guarded(hub = rotor.center); Bare bare(hub = rotor.center);
drawing
  if fan.blades > 2 then circle(world, R); else hatch(world); end if;
end Scene;
"""
# They say where things are, or tie numbers: nothing of theirs can be seen.
UNSEEN = {"Capstan", "Free", "World", "Planar", "Motion", "Coupler", "TorsionStop", "PlanarJoint"}
WITHOUT_PLACE = "signals.lag"  # numbers that act on each other
MODELS = [c for file in drawn_library() for c in file.classes
          if c.kind == "model" and not c.is_partial and Path(c.span.source.name).name != WITHOUT_PLACE]


def words(path: Path, is_drawn: bool) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for figure in flatten_file(path, is_drawn=is_drawn)[1].figures:
        found.setdefault(figure.component, []).append(figure.word)
    return found


def test_a_drawing_of_its_own_stands_in_place_of_what_is_inherited(tmp_path: Path) -> None:
    path = tmp_path / "scene.lag"
    path.write_text(SCENE)
    own = {"": ["circle"], "fan": ["line"] * 3, "guarded": ["circle"], "wider": ["line"] * 3}
    assert words(path, is_drawn=False) == own, "people's drawings are checked with all else they write"
    drawn = words(path, is_drawn=True)
    assert {name: drawn[name] for name in own} == own
    assert drawn.keys() - own == {"axle", "rotor"}
    assert flatten_file(path)[1].warnings == (), "a picture reads what it is made of"


def test_the_library_is_read_without_its_drawings() -> None:
    assert {s.kind for file in library() for c in file.classes for s in c.sections} == {"initial", "equation", "energy"}
    assert [c.name for file in library() for c in file.classes] == [c.name for file in drawn_library() for c in file.classes]


@pytest.mark.parametrize("definition", MODELS, ids=lambda c: c.name)
def test_every_component_draws(definition: ClassDefinition) -> None:
    lineage = build_class_table(drawn_library(), []).lineage(definition)
    assert any(s.kind == "drawing" and s.clauses for c in lineage for s in c.sections) == (definition.name not in UNSEEN)


def test_drawings_of_the_library_keep_to_dimensions() -> None:
    seen = set()
    for path in sorted((data_folder("models") / "examples").glob("*.lag")):
        seen |= {figure.word for figure in check_dimensions(flatten_file(path, is_drawn=True)[1]).figures}
    assert {"box", "zigzag", "dashpot", "rail", "hatch", "arrow", "curved_arrow", "gears", "circle"} <= seen
