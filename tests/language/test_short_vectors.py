"""Vectors of two components in a scene in space: z is taken as 0, and that is told where people state them."""

import pytest

SCENE = """model Cart
  Frame at;
  Block block(m = 1, base = at, along = {1, 0});
end Cart;
model Swing
  World world(gravity = {0, 0, -9.81});
  Revolute hinge(a = world, axis = {0, 1, 0});
  Bar bar(m = 1, L = 1, a = hinge.b);
  <statement>
end Swing;
"""


@pytest.mark.parametrize(
    ("statement", "told"),
    [
        ("AppliedForce pull(at = bar.b, force = {1, 2});", "'pull.force'"),
        ("BodyForce push[2](each at = bar.b, each force = {1, 2});", "'push[1].force'"),
        ("AxialSpring spring(a = world, b = bar.b, k = 1, along = {0, 1});", "'spring.along'"),
        ("Force up[dimensions] = {1[N], 2[N]}; AppliedForce pull(at = bar.b, force = up);", ""),
        ("AppliedForce pull(at = bar.b, force = {1, 2, 0});", ""),
        ("AppliedForce pull(at = bar.b, force = {0, 0});", ""),
        ("AxialSpring spring(a = world, b = bar.b, k = 1);", ""),
        ("Spring spring(a = shift(world, {1, 2}), b = bar.b, k = 1);", ""),
        ("Cart cart(at = bar.b);", ""),
        ("Weld weld(a = bar.b, offset = {0.5, 0.5});", ""),
    ],
)
def test_two_components_where_space_has_three_are_told(scene, statement: str, told: str) -> None:
    notes = [x for x in scene(SCENE.replace("<statement>", statement)).warnings if "L0306" in x]
    assert len(notes) == bool(told)
    assert not told or (told in notes[0] and "its z is taken as 0" in notes[0] and "gravity" in notes[0])


def test_a_plane_has_two(scene) -> None:
    text = SCENE.replace("(gravity = {0, 0, -9.81})", "").replace(", axis = {0, 1, 0}", "")
    assert not scene(text.replace("<statement>", "AppliedForce pull(at = bar.b, force = {1, 2});")).warnings
