"""Two joints about one direction between the same bodies, put together beside each other or the wrong way round."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lagrangia.base.diagnostics import LagError
from lagrangia.model import Model

AXIS, GRAVITY, TIME = np.array([0.3, 0.7, -0.2]), np.array([1, -2, -9.81]), 0.3


def braces(x: np.ndarray) -> str:
    return "{" + ", ".join(repr(float(part)) for part in x) + "}"


def joint(first: str, second: str, own: Rotation, tmp_path: Path) -> Model:
    """The second one beside the first, its own frames turned."""
    angle = float(np.linalg.norm(own.as_rotvec()))
    about = f"{angle!r}, {braces(own.as_rotvec() if angle else AXIS)}"
    scene = tmp_path / "scene.lag"
    scene.write_text(f"""model S
  World world(gravity = {braces(GRAVITY)});
  Body b(m = 1.5, I = {{0.2, 0.19, 0.15}});
  {first} j(a = world, b = shift(b.center, {{0.1, 0.2, 0}}), axis = {braces(AXIS)});
  {second} k(a = turn(shift(world, {{1, -0.4, 0.3}}), {about}), b = turn(shift(b.center, {{1.1, -0.2, 0.3}}), {about}),
    {'along' if second == 'Prismatic' else 'axis'} = {braces(own.inv().apply(AXIS))});
end S;
""")
    return Model(scene)


@pytest.mark.parametrize("own", [Rotation.identity(), Rotation.from_rotvec([0.4, -1.9, 0.7])], ids=["same", "turned"])
@pytest.mark.parametrize(("first", "second"), [("Cylindrical", "Cylindrical"), ("Cylindrical", "Prismatic"),
                                               ("Cylindrical", "Revolute"), ("Revolute", "Cylindrical")])
def test_parallel_joints_slide_where_both_do_and_never_turn(first: str, second: str, own: Rotation, tmp_path: Path) -> None:
    """s = (g . e) t^2/2 from where it was guessed, or rest."""
    run = joint(first, second, own, tmp_path).simulate(at=[0, TIME], tolerance=1e-10)
    along = AXIS / np.linalg.norm(AXIS)
    slid = GRAVITY @ along * TIME**2 / 2 if second in ("Cylindrical", "Prismatic") and first != "Revolute" else 0.0
    place = np.array([-0.1, -0.2, 0]) + np.outer([0, slid], along)
    assert run["b.center.r"] == pytest.approx(place, abs=1e-12)
    assert run["b.center.w"] == pytest.approx(np.zeros((2, 3)), abs=1e-12)


@pytest.mark.parametrize("kind", ["Revolute", "Cylindrical", "Prismatic"])
@pytest.mark.parametrize("axis", [np.array([0, 0, 1]), AXIS], ids=["upright", "oblique"])
def test_ends_that_are_always_half_a_turn_from_each_other_do_not_close(kind: str, axis: np.ndarray, tmp_path: Path) -> None:
    """What must vanish of a hinge does for an axis that points the other way, too."""
    word, scene = "along" if kind == "Prismatic" else "axis", tmp_path / "scene.lag"
    scene.write_text(f"""model S
  World world(gravity = {braces(GRAVITY)});
  {kind} j(a = world, {word} = {braces(axis)});
  Body b(m = 1.5, I = {{0.2, 0.19, 0.15}}, center = j.b);
  {kind} k(a = world, b = turn(j.b, 180[deg], {braces(np.cross(axis, [1, 0, 0]))}), {word} = {braces(axis)});
end S;
""")
    with pytest.raises(LagError, match=r"L0410.*the loop world - k - j - world cannot close: its ends are half a turn"):
        Model(scene)


def test_a_cross_whose_end_is_turned_round_has_its_angle(tmp_path: Path) -> None:
    """Its axes are square either way: half a turn about the first is told by its own angle."""
    scene = tmp_path / "scene.lag"
    scene.write_text(f"""model S
  World world(gravity = {braces(GRAVITY)});
  Universal j(a = world);
  Body b(m = 1, I = {{1, 1.2, 1.4}}, center = shift(j.b, {{0, 0, -1}}));
  Universal k(a = world, b = turn(j.b, 180[deg], {{1, 0, 0}}));
end S;
""")
    run = Model(scene).simulate(at=[0, TIME])
    turned = (run["k.phi_a"] - run["j.phi_a"] + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(turned) == pytest.approx([np.pi, np.pi], abs=1e-6)


def test_a_balance_gives_the_angle_that_a_cross_which_repeats_others_mentions(tmp_path: Path) -> None:
    """A hinge beside the cross, with no mass between them: springs say how they share, and the second cross changes nothing.
    'Free variables' of CasADi were told as a bug."""
    found = []
    for second in ("", "Universal k(a = r.b, b = turn(j.b, 180[deg], {1, 0, 0}));"):
        scene = tmp_path / f"scene{len(second)}.lag"
        scene.write_text(f"""model S
  World world(gravity = {braces(GRAVITY)});
  Revolute r(a = world, axis = {{1, 0, 0}});
  Universal j(a = r.b);
  Body b(m = 1, I = {{1, 1.2, 1.4}}, center = shift(j.b, {{0, 0, -1}}));
  {second}
energy
  potential 10[N.m]*r.phi^2/2 + 20[N.m]*(j.phi_a - 0.2)^2/2;
end S;
""")
        found.append(Model(scene).simulate(at=[0, TIME], tolerance=1e-10))
    alone, beside = found
    for name in ("r.phi", "j.phi_a", "j.phi_b"):
        assert beside[name] == pytest.approx(alone[name], abs=1e-8)
    assert 10 * beside["r.phi"] == pytest.approx(20 * (beside["j.phi_a"] - 0.2), abs=1e-8)
    assert np.abs(beside["k.phi_a"] - beside["j.phi_a"]) == pytest.approx([np.pi, np.pi], abs=1e-6)


@pytest.mark.parametrize(("kind", "way"), [("Revolute", "a"), ("Universal", "a"), ("Universal", "b")])
def test_half_a_turn_about_an_oblique_axis_is_told_by_one_angle(kind: str, way: str, tmp_path: Path) -> None:
    """Both stood a quarter of a turn off, that of the joint that carries the body as well."""
    first, second, scene = braces(AXIS), "{0.7, -0.3, 0}", tmp_path / "scene.lag"
    axes = f"axis_a = {first}, axis_b = {second}"
    scene.write_text(f"""model S
  World world(gravity = {braces(GRAVITY)});
  {kind} j(a = world, {axes if kind == "Universal" else f"axis = {first}"});
  Body b(m = 1, I = {{1, 1.2, 1.4}}, center = shift(j.b, {{0.2, 0, -1}}));
  Universal k(a = world, b = turn(j.b, 180[deg], {first if way == "a" else second}), {axes});
end S;
""")
    run = Model(scene).simulate(at=[0])
    carrying = ["j.phi"] if kind == "Revolute" else ["j.phi_a", "j.phi_b"]
    other = "b" if way == "a" else "a"
    assert [run[name][0] for name in [*carrying, f"k.phi_{other}"]] == pytest.approx([0] * (len(carrying) + 1), abs=1e-9)
    assert abs(run[f"k.phi_{way}"][0]) == pytest.approx(np.pi, abs=1e-8)


@pytest.mark.parametrize("size", [0.001, 1.0])
def test_a_steep_law_beside_a_loop_takes_nothing_out_of_it(size: float, tmp_path: Path) -> None:
    """Slopes of 1e10 make those of the other loop no rounding: a slider crank, its start by the law of cosines."""
    scene = tmp_path / "scene.lag"
    scene.write_text(f"""model S
  World world;
  Prismatic p(a = world, along = {{1, 0, 0}}, s(start = 1.2[mm], fixed = true));
  Body c(m = 1, I = {{1, 1, 1}}, center = p.b);
  Prismatic f(a = world, along = {{0, 0, 1}});
  Body b(m = 1, I = {{1, 1, 1}}, center = f.b);
  Prismatic g(a = shift(p.b, {{0, 0, 1[mm]*(p.s/1[mm])^5}}), along = {{1, 0, 0}}, b = f.b);
  Revolute crank(a = shift(world, {{0, 3, 0}}), axis = {{1, 0.2, 0.3}}, phi(start = 0.7, fixed = true));
  Spherical s1(a = shift(crank.b, {{0, {0.2 * size!r}, 0}}));
  Body rod(m = 1, I = {{1, 1, 1}}, center = shift(s1.b, {{0, {0.5 * size!r}, 0}}));
  Prismatic q(a = shift(world, {{{0.1 * size!r}, 3, 0}}), along = {{0, 1, 0.1}}, s(start = {1.2 * size!r}));
  Body slider(m = 1, I = {{1, 1, 1}}, center = q.b);
  Universal u(a = shift(s1.b, {{0, {size!r}, 0}}), b = q.b, axis_a = {{0, 0, 1}}, axis_b = {{1, 0, 0}});
end S;
""")
    run = Model(scene).simulate(at=[0])
    axis, along = np.array([1, 0.2, 0.3]), np.array([0, 1, 0.1])
    pin = Rotation.from_rotvec(0.7 * axis / np.linalg.norm(axis)).apply([0, 0.2, 0]) - [0.1, 0, 0]
    there = pin @ along / np.linalg.norm(along)
    assert run["q.s"][0] == pytest.approx(size * (there + np.sqrt(1 - pin @ pin + there**2)), rel=1e-9)
    assert run["f.s"][0] == pytest.approx(1.2**5 * 1e-3, rel=1e-9)


def test_turns_at_the_start_do_not_feel_rounding_either(tmp_path: Path) -> None:
    """A plane, a screw the other way round and a cylinder about one axis, from frames that are turned: nothing moves, and all
    joints stand at 0. The start's equations moved what only their last digits feel, and did not close."""
    fixed, own = Rotation.from_rotvec([1.05, -0.19, -0.48]), Rotation.from_rotvec([1.35, 0.93, 0.03])
    place = np.array([0.8, 0.2, -0.6])

    def ends(x: list[float]) -> list[str]:
        seen = own.apply(fixed.inv().apply(np.array(x) - place))
        frames = [("world", np.array(x), fixed), ("b.center", seen, own)]
        return [f"turn(shift({name}, {braces(at)}), {float(turn.magnitude())!r}, {braces(turn.as_rotvec())})"
                for name, at, turn in frames]

    (a, b), (c, d), (e, f) = ends([0.25, 0.43, -0.45]), ends([0.9, -0.77, 0.48]), ends([0.12, -0.18, 0.08])
    scene = tmp_path / "scene.lag"
    scene.write_text(f"""model S
  World world(gravity = {braces(GRAVITY)});
  Body b(m = 1.5, I = {{0.2, 0.19, 0.15}});
  PlanarJoint j(a = {a}, b = {b});
  Screw k(a = {d}, b = {c}, axis = {{0, 0, 1}}, pitch = 0.7);
  Cylindrical l(a = {e}, b = {f}, axis = {{-0.85, -0.8, -0.29}});
end S;
""")
    run = Model(scene).simulate(at=[0, TIME])
    assert run["b.center.r"] == pytest.approx(np.array([place, place]), abs=1e-10)


def test_a_row_that_vanishes_wherever_a_loop_closes_holds_nothing(tmp_path: Path) -> None:
    """Two planes in one direction and a cylinder about another: only the body between the planes moves."""
    turn, scene = "0.7, {1, 2, -1}", tmp_path / "scene.lag"
    scene.write_text(f"""model S
  World world;
  Body b(m = 1, I = {{0.2, 0.19, 0.15}});
  Body c(m = 1, I = {{0.2, 0.19, 0.15}});
  PlanarJoint j(a = turn(world, {turn}), b = turn(b.center, {turn}));
  PlanarJoint k(a = turn(shift(b.center, {{0.3, 0.1, -0.2}}), {turn}), b = turn(c.center, {turn}));
  Cylindrical l(a = turn(shift(c.center, {{0.2, 0.1, 0.5}}), {turn}), b = turn(shift(world, {{0.5, 0.2, 0.3}}), {turn}),
    axis = {{0.45, 0.7, 0.21}});
end S;
""")
    assert Model(scene).freedom["degrees_of_freedom"] == 3
