"""What any kind of frame has to satisfy, of frames in the plane: powers and energies do not depend on where they are reckoned."""

import math

import casadi as ca
import numpy as np
import pytest

from lagrangia.algebra.duals import Dual, dot
from lagrangia.base.diagnostics import Source, Span
from lagrangia.frames import planar, planar_inertia, planar_joints
from lagrangia.frames.planar import COMPONENTS, HERE, SIZE, Pose
from lagrangia.frames.planar_joints import Slide
from lagrangia.language.frame_attributes import ATTRIBUTES, as_element, component_named, place_of
from lagrangia.language.tree import FrameRef

RANDOM = np.random.default_rng(3)
AHEAD = (0.7, -1.3)
TWIST, WRENCH = [0.4, -0.9, 1.7], [2.0, 3.0, -0.6]


class Numbers:
    """An algebra of floats and Duals of them, as far as poses ask for one."""

    def call(self, function: str, x: float | Dual) -> float | Dual:
        if isinstance(x, Dual):
            slope = {"sin": math.cos, "cos": lambda a: -math.sin(a)}[function](x.value)
            return Dual(self.call(function, x.value), slope * x.rate)
        return getattr(math, function)(x)


def some_pose() -> Pose:
    return HERE.displaced(RANDOM.uniform(-2, 2, SIZE), Numbers())


def energy(I: list[list[float]], twist: list[float]) -> float:
    return dot(planar_inertia.momentum(I, twist), twist) / 2


def test_power_does_not_depend_on_the_point() -> None:
    there = planar_inertia.moved_twist(TWIST, AHEAD)
    assert dot(planar_inertia.about(WRENCH, AHEAD), TWIST) == pytest.approx(dot(WRENCH, there), rel=1e-14)


def test_a_wrench_about_another_frame_has_the_same_power() -> None:
    here, there = some_pose(), some_pose()
    found = np.array(planar_inertia.wrench_about(ca.DM(WRENCH), here, there)).ravel()
    ahead = [a - b for a, b in zip(here.origin, there.origin, strict=True)]
    assert [float(x) for x in found] == pytest.approx(planar_inertia.about(WRENCH, ahead), rel=1e-14)


def test_energy_does_not_depend_on_the_reference() -> None:
    """T = m v_c^2/2 + I w^2/2 of a body whose centre is at b/m, whichever frame its inertia is moved to."""
    m, centre, I = 2.0, (0.3, -0.2), 0.5
    inertia = planar_inertia.Inertia("f", m, m * centre[0], m * centre[1], I + m * dot(centre, centre))
    local, turn = some_pose(), some_pose()
    own = planar_inertia.no_inertia()
    planar_inertia.add_upper(own, planar_inertia.moved_inertia(inertia, local, turn))
    ahead = turn.to_world([a + b for a, b in zip(local.origin, local.to_world(centre), strict=True)])
    vx, vy, w = planar_inertia.moved_twist(TWIST, ahead)
    assert energy(own, TWIST) == pytest.approx(m * (vx**2 + vy**2) / 2 + I * w**2 / 2, rel=1e-13)
    parent = planar_inertia.no_inertia()
    planar_inertia.add_moved(parent, own, AHEAD)
    assert energy(parent, TWIST) == pytest.approx(energy(own, planar_inertia.moved_twist(TWIST, AHEAD)), rel=1e-13)


def test_the_twist_is_the_rate_of_the_place() -> None:
    moving = Pose(*(Dual(x, r) for x, r in zip((0.3, -0.4), TWIST[:2], strict=True)), Dual(0.0, 0.0), 1.0, 0.0)
    moving = moving.turned(Dual(0.8, TWIST[2]), Numbers())
    ahead = moving.to_world(AHEAD)
    found = moving.moved(ahead).twist
    assert found == pytest.approx(planar_inertia.moved_twist(TWIST, [x.value for x in ahead]), rel=1e-14)


@pytest.mark.parametrize(("kind", "freedom"), [("hinge", 1), ("slider", 1), ("weld", 0)])
def test_gaps_leave_the_freedom_of_the_joint(kind: str, freedom: int) -> None:
    """They vanish however the joint is moved, and are as many as the directions that it holds, along which they do not."""
    a, slide = some_pose(), Slide((0.2, 0.5), (3.0, -4.0), 5.0) if kind == "slider" else None
    b = a
    if kind == "hinge":
        b = a.turned(0.6, Numbers())
    elif slide is not None:
        b = a.moved(a.to_world([o + 0.7 * d for o, d in zip(slide.offset, slide.direction, strict=True)]))
    gaps = planar_joints.gaps(kind, a, b, slide)
    assert len(gaps) == SIZE - freedom
    assert gaps == pytest.approx([0.0] * len(gaps), abs=1e-15)
    if freedom:
        assert planar_joints.coordinate(a, b, slide, is_inverse=False) == pytest.approx(0.7 if slide else 0.6, rel=1e-14)
    h = 1e-6
    slopes = np.array([planar_joints.gaps(kind, a, b.displaced(h * row, Numbers()), slide) for row in np.eye(SIZE)]) / h
    assert np.linalg.matrix_rank(slopes, tol=1e-3) == SIZE - freedom
    forces, drive = RANDOM.uniform(-1, 1, len(gaps)), 0.0  # what holds b does the work that the gaps say
    held = planar_joints.wrench_on_b(kind, a, slide, False, list(forces), drive)
    assert held == pytest.approx(slopes @ forces, abs=1e-5)


def test_attributes_are_made_of_components() -> None:
    def of_frame(name: str, *index: int, is_spatial: bool = False) -> FrameRef:
        return FrameRef("f", name, index, Span(Source("test", "f"), 0, 1), is_spatial)

    assert [place_of(of_frame(name)) for name in ("v", "w")] == ["r", "phi"]
    assert [place_of(of_frame(name, is_spatial=True)) for name in ("v", "w", "omega")] == ["r", None, None]
    assert as_element(of_frame("y")) == ("r", (2,)) == as_element(of_frame("r", 2))
    assert as_element(of_frame("phi")) == ("phi", ()) and as_element(of_frame("z", is_spatial=True)) == ("r", (3,))
    assert {ATTRIBUTES[c.name].unit for c in COMPONENTS if c.is_angle} == {"rad"} == {component_named("bar.center.phi").unit}
    assert {name for name, attribute in ATTRIBUTES.items() if attribute.has_element((2,))} == {"r", "v", "reaction"}
    assert not ATTRIBUTES["r"].has_element((3,)) and not ATTRIBUTES["r"].has_element((1, 1))
    pose = some_pose()
    assert planar.attribute_of(pose, "r") == (pose.x, pose.y)
