"""Start values: fixed ones exactly, the others nearest to their guesses in the mass metric; the two implementations agree."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.random_linkages import random_linkage
from lagrangia.command.cli import main
from lagrangia.compile.pipeline import compile_file, read_files
from lagrangia.constraints import assembly

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "models" / "examples"
Write = Callable[[str], lag.Model]


def begin(model: lag.Model, **options: object) -> dict[str, float]:
    """All coordinates and rates at the start."""
    run = model.simulate(stop=1e-9, interval=1e-9, **options)
    names = [c.name for c in (*model.scene.coordinates, *model.scene.rates, *model.scene.outputs)]
    return {name: float(run[name][0]) for name in names}


# ---------------------------------------------------------------- with and without a compiler


def _scenes() -> list[tuple[Path, str]]:
    files = sorted([*EXAMPLES.glob("*.lag"), *(ROOT / "tests" / "cases").glob("*.lag")])
    return [(file, c.name) for file in files for c in read_files(file)[0].classes if c.kind == "model" and not c.is_partial]


@pytest.mark.parametrize(("file", "name"), _scenes(), ids=lambda x: x if isinstance(x, str) else x.stem)
def test_the_run_time_and_the_compiler_assemble_alike(file: Path, name: str) -> None:
    """Every scene with something to solve at the start."""
    try:
        made = compile_file(file, name)
    except lag.LagError:
        pytest.skip("this model is a part of others")
    if "initial" not in made.functions.table:
        pytest.skip("nothing to assemble")
    x, worst = assembly.begin(made.kinematics, made.initial, made.functions.table).assemble()
    assert worst == -1
    if any(c.attitude for c in made.graph.coordinates):
        pytest.skip("the run tells quaternions, not what is solved for: test_attitude_coordinates.py")
    start = begin(lag.Model(file, name))
    names = [c.name for c in (*made.graph.coordinates, *made.initial.lost)]
    found = [start[name] for name in (*names, *(f"der({name})" for name in names))]
    np.testing.assert_allclose(found, x, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", [5, 8, 13, 23, 25, 27, 32, 34, 49, 70])
def test_what_nobody_guessed_is_tried_elsewhere(seed: int, scene: Write) -> None:
    """Linkages of which only the crank's angle is told; none of these closes by going downhill from zero."""
    model = scene(random_linkage(seed, 1 + seed % 4, is_guessed=False))
    made = model.compilation
    x, worst = assembly.begin(made.kinematics, made.initial, made.functions.table).assemble()
    assert worst == -1
    run = model.simulate(at=[0, 1e-3])
    assert run["crank_bearing.phi"][0] == pytest.approx(0.7, abs=1e-12)
    found = [run[name][0] for name in model.coordinate_names]
    np.testing.assert_allclose(found, x[: len(found)], rtol=1e-9, atol=1e-9)


ROCKERS = """model Rockers
  Revolute O(a = world, phi(start = 1.877, fixed = true)), p1(a = l.b, b = c1.a), q1(a = c1.b, b = r1.b),
    o1(a = shift(world, {0.733, -0.102}), phi(start = 64.2[deg])), p2(a = shift(r1.center, {0.18, -0.09}), b = c2.a),
    q2(a = c2.b, b = r2.b), o2(a = shift(world, {1.513, -0.086}), phi(start = 78.7[deg])),
    p3(a = shift(r2.center, {0.122, 0.079}), b = c3.a), q3(a = c3.b, b = r3.b),
    o3(a = shift(world, {2.474, 0.104}), phi(start = 88.7[deg]));
  Bar l(m = 1, L = 0.3, a = O.b), c1(m = 0.7, L = 1.031), r1(m = 0.3, L = 0.718, a = o1.b), c2(m = 0.2, L = 0.968),
    r2(m = 0.4, L = 0.926, a = o2.b), c3(m = 0.8, L = 1.127), r3(m = 2, L = 0.986, a = o3.b);
end Rockers;"""


def test_guesses_are_moved_last_and_the_nearest_way_to_close_is_taken(scene: Write) -> None:
    """A rocker guessed on the wrong side of its bearing; three rockers one behind the other, guessed within 15 degrees."""
    wrong = scene("""model M
  Revolute O(a = world, phi(start = 4.051, fixed = true)); Bar crank(m = 1, L = 0.3, a = O.b);
  Revolute p(a = crank.b, b = coupler.a), q(a = coupler.b, b = rocker.b), o(a = shift(world, {0.58, 0.24}), phi(start = 0.86));
  Bar coupler(m = 1, L = 0.82), rocker(m = 1, L = 1.18, a = o.b);
end M;""")
    assert begin(wrong)["O.phi"] == 4.051
    rockers = scene(ROCKERS)
    for name, guess in (("o1.phi", 64.2), ("o2.phi", 78.7), ("o3.phi", 88.7)):
        assert np.degrees(begin(rockers)[name]) == pytest.approx(guess, abs=15)


# ---------------------------------------------------------------- nearest in the mass metric

PAIR = """model M
  PointMass a(m = {heavy}, center(x(start = 0), y(start = 0))), b(m = 1, center(x(start = 2*{L}), y(start = 0)));
equation
  distance(a.center, b.center) = {L}[m];
end M;"""


@pytest.mark.parametrize("L", [1, 1e-6, 1e6])
@pytest.mark.parametrize("heavy", [1, 9, 1e6])
def test_heavy_things_move_less(heavy: float, L: float, scene: Write) -> None:
    """The common centre of mass stays."""
    start = begin(scene(PAIR.format(heavy=heavy, L=L)))
    assert start["a.center.x"] == pytest.approx(L / (heavy + 1), rel=1e-9)
    assert start["b.center.x"] == pytest.approx(L + L / (heavy + 1), rel=1e-9)
    assert abs(start["a.center.y"]) + abs(start["b.center.y"]) < 1e-12 * L


def test_rates_are_corrected_as_by_an_impact(scene: Write) -> None:
    """Only the component along the rod changes, by an impulse: momentum is kept."""
    text = PAIR.format(heavy=3, L=1).replace("2*1", "1").replace("end M;", """
initial equation
  der(a.center.x) + 0*a.center.x = 4;
end M;""")
    start = begin(scene(text))
    assert start["der(a.center.x)"] == pytest.approx(4)
    free = begin(scene(text.replace("der(a.center.x) + 0*a.center.x = 4;", "")))
    assert free["der(b.center.x)"] == 0
    assert start["der(b.center.x)"] == pytest.approx(4)


def nearest_angles(guess: np.ndarray, L: float) -> tuple[np.ndarray, float]:
    """Two uniform links whose tip is at the height L/2: by search along the one freedom, M taken at the guess."""
    both = np.cos(guess[1])
    M = L**2 * np.array([[5 / 3 + both, 1 / 3 + both / 2], [1 / 3 + both / 2, 1 / 3]])
    first = guess[0] + np.linspace(-0.6, 0.6, 1_200_001)
    second = np.arcsin(0.5 - np.sin(first)) - first
    gap = np.array([first, second]) - guess[:, None]
    distance = np.einsum("ik,ij,jk->k", gap, M, gap)
    return np.array([first[distance.argmin()], second[distance.argmin()]]), float(distance.min())


def test_the_nearest_of_all_solutions_is_taken(scene: Write) -> None:
    """Not only the linearised equations': the guess is far away."""
    start = begin(scene("""model M
      Revolute h(a = world, phi(start = 0.5)), k(a = p.b, phi(start = 0.3));
      Bar p(m = 1, L = 1, a = h.b), q(m = 1, L = 1, a = k.b);
    initial equation
      q.b.y = 0.5;
    end M;"""))
    expected, _ = nearest_angles(np.array([0.5, 0.3]), 1)
    np.testing.assert_allclose([start["h.phi"], start["k.phi"]], expected, atol=2e-6)


def test_what_is_guessed_holds_where_the_others_can_follow(scene: Write) -> None:
    start = begin(scene("""model M
      Revolute h(a = world, phi(start = 0.5)), k(a = p.b);
      Bar p(m = 1e-3, L = 1, a = h.b), q(m = 1e3, L = 1, a = k.b);
    initial equation
      q.b.y = 0.7;
    end M;"""))
    assert start["h.phi"] == 0.5
    assert start["k.phi"] == pytest.approx(np.arcsin(0.7 - np.sin(0.5)) - 0.5, abs=1e-12)


@pytest.mark.parametrize("angle", ["180[deg]", "3.1415926535898", "36180[deg]"])
def test_rates_that_follow_by_rounding_alone_do_not(angle: str, scene: Write) -> None:
    """A rocker whose link lies along the crank: the crank cannot follow, and was sent off at 4e15 rad/s by sin(pi) in doubles."""
    model = scene(f"""model M
      Revolute h(a = world, phi(start = {angle})), k(a = shift(world, {{-1.5, -0.4}}), phi(start = 90[deg]), w(start = 1));
      Bar crank(m = 1, L = 0.5, a = h.b), rocker(m = 1, L = 0.4, a = k.b); Link link(L = 1, a = crank.b, b = rocker.b); end M;""")
    made = model.compilation
    x, worst = assembly.begin(made.kinematics, made.initial, made.functions.table).assemble()
    run = model.simulate(at=[0, 1e-3])
    assert worst == -1
    for rates in (x[2:], [run["h.w"][0], run["k.w"][0]]):
        np.testing.assert_allclose(rates, 0, atol=1e-9)


@pytest.mark.parametrize("ratio", [1e-6, -1e3, 1e6])
def test_positions_and_rates_may_be_far_apart(ratio: float, scene: Write) -> None:
    """Where equations are linear, no step towards their solution is too long: with and without a compiler."""
    model = scene(f"""model M
      World world(gravity = {{0, 0}});
      Block a(m = 1, base = world, s(start = 1, fixed = true), v(start = 2, fixed = true)), b(m = 1, base = world);
    initial equation
      b.s = {ratio}*a.s; b.v = {ratio}*a.v;
    end M;""")
    start, made = begin(model), model.compilation
    x, worst = assembly.begin(made.kinematics, made.initial, made.functions.table).assemble()
    assert worst == -1
    for found in ([start[name] for name in ("a.s", "b.s", "der(a.s)", "der(b.s)")], x):
        np.testing.assert_allclose(found, [1, ratio, 2, 2 * ratio], rtol=1e-12)


# ---------------------------------------------------------------- singular assemblies


def test_a_parallelogram_is_not_folded_flat_for_want_of_a_guess(scene: Write) -> None:
    """Its third kind of joint has no start at all; the hooks keep theirs."""
    text = (EXAMPLES / "parallelogram.lag").read_text()
    without = text.replace("eye[3](each phi(start = 30[deg]))", "eye[3]")
    assert without != text
    model = scene(without)
    assert model.freedom["degrees_at_start"] == 1
    start = begin(model)
    np.testing.assert_allclose([start[f"hook[{k}].phi"] for k in (1, 2, 3)], np.radians(-30), atol=1e-12)


# ---------------------------------------------------------------- other assemblies


def test_both_assemblies_of_a_four_bar_are_named(scene: Write) -> None:
    """The other is the mirror image in the diagonal, and starts near it choose it."""
    notes = lag.load(EXAMPLES / "four_bar.lag").freedom
    (told,) = notes["assemblies"]
    assert "closes in 2 ways: taken A.phi = -8.161 deg, C.phi = 78.76 deg; " in told
    assert "there is A.phi = -112.5 deg, C.phi = -119.4 deg" in told
    assert notes["given_by_loops"] == ["A.phi", "C.phi"]
    text = (EXAMPLES / "four_bar.lag").read_text()
    start = begin(scene(text.replace("75[deg]", "-100[deg]")))
    assert np.degrees(start["A.phi"]) == pytest.approx(-112.5, abs=0.05)


def test_a_third_bar_leaves_one_assembly() -> None:
    """Two bars of a parallelogram may cross; the redundant third one forbids it."""
    assert lag.load(EXAMPLES / "parallelogram.lag").freedom["assemblies"] == []


def test_what_a_loop_does_to_others_is_told() -> None:
    """Crank and rod in line: the slide is on the other side when the rod turns over."""
    (told,) = lag.load(EXAMPLES / "slider_crank.lag").freedom["assemblies"]
    assert "taken pin.phi = 0 deg, guide.s = 0.4 m; there is pin.phi = 180 deg, guide.s = -0.2 m" in told


@pytest.mark.parametrize("L", [1e-6, 1e6])
def test_assemblies_do_not_depend_on_units(L: float, scene: Write) -> None:
    """A slide, a hinge and two bars; twice the cosine of 60 degrees."""
    (told,) = scene(f"""model M
      Revolute h(a = world, phi(start = 60[deg], fixed = true)), k(a = p.b, b = q.a, phi(start = -100[deg])), e(a = s.b, b = q.b);
      Prismatic s(a = world, along = {{1, 0}});
      Bar p(m = 1, L = {L}, a = h.b), q(m = 1, L = {L});
    end M;""").freedom["assemblies"]
    assert "= 0 m" in told
    assert f"s.s = {L:.4g} m" in told


LADDER = """model Ladder
  parameter Integer n = 40;
  Revolute foot[n+1](each phi(start = 70[deg])), left[n](each phi(start = -60[deg])), right[n];
  Bar crank[n+1](each m = 1, each L = 1), coupler[n](each m = 1, each L = 1.3);
equation
  for i in 1:n+1 loop
    connect(foot[i].a, shift(world, {i - 1, 0}));
    connect(foot[i].b, crank[i].a);
  end for;
  for i in 1:n loop
    connect(left[i].a, crank[i].b);
    connect(left[i].b, coupler[i].a);
    connect(right[i].a, crank[i+1].b);
    connect(right[i].b, coupler[i].b);
  end for;
end Ladder;"""


def test_a_long_ladder_closes_from_rough_guesses_and_the_search_is_bounded(scene: Write) -> None:
    """The cranks lean ever farther the longer couplers push them: no guess is right, and each loop closes in two ways."""
    model = scene(LADDER.replace("1.3", "1.001"))
    start = begin(model)
    angles = np.array([start[f"foot[{k}].phi"] for k in range(1, 42)])
    tips = np.arange(41) + np.exp(1j * angles)
    np.testing.assert_allclose(np.abs(np.diff(tips)), 1.001, atol=1e-10)
    assert np.abs(angles - np.radians(70)).max() < 0.5
    assert len(model.freedom["assemblies"]) <= 13


def test_a_run_tells_where_its_loops_were_closed_and_looks_for_no_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The search is for `lag check`, which keeps what it found with the scene."""
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path))
    example = str(EXAMPLES / "four_bar.lag")
    assert main(["simulate", example, "--stop", "0.01", "-o", str(tmp_path / "o.csv")]) == 0
    assert "loops closed at A.phi = -8.161 deg, C.phi = 78.76 deg; `lag check`" in capsys.readouterr().out
    assert lag.load(example).scene.notes["freedom"] is None
    for _ in range(2):
        assert main(["check", example]) == 0
        assert "there is A.phi = -112.5 deg" in capsys.readouterr().out
        assert lag.load(example).scene.notes["freedom"]["degrees_of_freedom"] == 1
    assert main(["simulate", example, "--at", "0.01", "-o", str(tmp_path / "o.csv")]) == 0
    assert "loops closed" not in capsys.readouterr().out  # no row of the start


# ---------------------------------------------------------------- hard starts


@pytest.mark.parametrize("L", [1e-6, 1, 1e6])
@pytest.mark.parametrize("guess", [-170, -90, -20, 20, 90, 170])
def test_a_loop_closes_from_guesses_far_away_at_any_size(guess: float, L: float) -> None:
    """Without gravity or with it: the size of the scene does not matter, nor does a start from the wrong side."""
    model = lag.load(ROOT / "tests" / "cases" / "hard_loops.lag", model="FourBar")
    start = begin(model, parameters={"L": L, "rocker_guess": np.radians(guess)})
    crank, rocker = start["O.phi"], start["C.phi"]
    assert crank == np.radians(40)
    coupler = 1 + 0.8 * np.exp(1j * rocker) - 0.4 * np.exp(1j * crank)
    assert abs(coupler) == pytest.approx(1, abs=1e-12)


def test_fixed_values_that_contradict_name_the_loop_and_its_gap(scene: Write) -> None:
    """Crank and rocker held, their ends 1.4828 m apart where the coupler has 1 m."""
    model = scene("""model M
      Revolute O(a = world, phi(start = 180[deg], fixed = true)), A(a = crank.b), B(a = coupler.b, b = rocker.b),
               C(a = shift(world, {1, 0}), phi(start = 90[deg], fixed = true));
      Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
    end M;""")
    gap = np.hypot(1.4, 0.8) - 1
    told = model.freedom["problem"]
    assert "the loop world - O - crank - A - coupler - B - rocker - C - world cannot close" in told
    assert f"misses by {gap:.3g}" in told
    with pytest.raises(lag.LagError, match="the loop world - O - crank"):
        model.simulate(stop=0.1)


FLAT = """model Flat
  World world(gravity = {0, -9.81});
  Revolute h1(a = world, phi(start = 0, fixed = true), w(start = 1));
  Bar b1(m = 1, L = 0.5, a = h1.b);
  Revolute h2(a = b1.b);
  Bar b2(m = 1, L = 1, a = h2.b);
  Revolute h3(a = b2.b);
  Bar b3(m = 1, L = 0.5, a = h3.b);
  Revolute h4(a = b3.b, b = shift(world, {1, 0}));
end Flat;
"""


def test_a_run_from_a_singular_start_says_what_check_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                          capsys: pytest.CaptureFixture[str]) -> None:
    """Whether a step misses there is a matter of rounding; what is said then is not."""
    (tmp_path / "flat.lag").write_text(FLAT, encoding="utf-8")
    assert main(["check", str(tmp_path / "flat.lag")]) == 0
    said = next(line for line in capsys.readouterr().out.splitlines() if "the start is a singular position" in line)
    run = ["simulate", str(tmp_path / "flat.lag"), "--stop", "0.5", "-o", str(tmp_path / "o.csv")]
    for missed in ([], ["1 step missed the tolerance"]):
        monkeypatch.setattr("lagrangia.command.summary.shortcomings", lambda progress, missed=missed: missed)
        assert main(run) == 0
        assert (said in capsys.readouterr().out.splitlines()) is bool(missed)
    assert main([*run, "--initial", "h1.phi=0.3"]) == 0
    assert "singular position, where" not in capsys.readouterr().out
