"""lag bench: references, errors, the peers' results and what is said of them."""

import json
import math
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import yaml

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.bench.measure import Point, Skipped, all_solvers, measure
from lagrangia.bench.peers import Solver, Unsuitable
from lagrangia.bench.problem import Problem, build_problem
from lagrangia.bench.reference import NoReference, find_reference
from lagrangia.bench.table import as_json, as_text, duel, front, seconds_at
from lagrangia.command.cli import main
from lagrangia.run.request import Request

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES, CASES = ROOT / "models" / "examples", ROOT / "tests" / "cases"
PEERS = {"casadi": True, "scipy": True, "heyoka": find_spec("heyoka") is not None}


# -------------------------------------------------------------------- references


def test_the_reference_agrees_with_published_digits() -> None:
    """Andrews' squeezer: the test set's solution at 0.03 s, which our case files hold to 14 digits."""
    problem = build_problem(lag.load(EXAMPLES / "andrews_squeezer.lag"), Request(stop=0.03), points=1)
    reference = find_reference(problem)
    case = yaml.safe_load((CASES / "testset_andrews_squeezer.yaml").read_text(encoding="utf-8"))
    (row,) = [row for row in case["runs"]["Andrews"] if float(row["t"]) == 0.03]
    names = {"O.phi": "beta", "F.phi": "Theta", "B.phi": "gamma", "G.phi": "Phi", "A5.phi": "delta", "H.phi": "Omega",
             "A7.phi": "epsilon"}
    exact = np.array([[float(row[names[name]]) for name in problem.model.coordinate_names]])
    assert problem.error(reference.positions, exact) < 1e-12
    assert 0 < reference.error < 1e-12


def test_the_reference_of_a_linear_scene_is_its_closed_form(tmp_path: Path) -> None:
    file = tmp_path / "oscillator.lag"
    file.write_text("model One Block b(m = 2, base = world, s(start = 0.3)); Spring k(k = 18, stretch = b.s); end One;")
    problem = build_problem(lag.load(file), Request(stop=7.0), points=4)
    exact = 0.3 * np.cos(3 * np.array(problem.times))[:, None]
    assert problem.error(find_reference(problem).positions, exact) < 3e-16 * 21


def test_pieces_meet_at_events() -> None:
    """The quarter car's bump begins at 0.5 s and ends at 0.6 s."""
    problem = build_problem(lag.load(EXAMPLES / "quarter_car.lag"), Request(stop=1.0), points=3)
    assert [round(piece.end, 12) for piece in problem.pieces] == [0.5, 0.6, 1.0]
    assert [piece.times for piece in problem.pieces] == [problem.times[:1], (), problem.times[1:]]


def test_a_stiff_scene_gets_its_reference_by_an_implicit_method(tmp_path: Path) -> None:
    """m x'' + c x' + k x = 0, so damped that explicit steps would be 1e-6 s long: x is the sum of its two exponentials."""
    file = tmp_path / "door.lag"
    file.write_text("""model Door Block b(m = 1, base = world, s(start = 0.3));
      SpringDamper k(k = 1[MN/m], c = 2[MN.s/m], stretch = b.s); end Door;""")
    problem = build_problem(lag.load(file), Request(stop=2.0), points=4)
    fast = 1e6 + math.sqrt(1e12 - 1e6)
    slow = 1e6 / fast
    exact = 0.3 * fast * np.exp(-slow * np.array(problem.times)) / (fast - slow)
    reference = find_reference(problem, seconds=20.0)
    assert "Radau" in reference.how
    assert problem.error(reference.positions, exact[:, None]) < 1e-11


def test_the_reference_of_a_scene_with_corners_is_its_closed_form(tmp_path: Path) -> None:
    """A ball that falls from 1 m on a stiff floor and back, again and again: half swings below, parabolas above."""
    path = tmp_path / "ball.lag"
    path.write_text("""model Ball
  Prismatic x(a = world, along = {0, 1}, s(start = 1)); PointMass b(m = 1, center = x.b);
  GeneralSpring k(a = world, b = x.b, V = if x.s < 0 then 1000*x.s^2/2 else 0);
  annotation(experiment(StopTime = 3));
end Ball;""")
    problem = build_problem(lag.load(path))
    reference = find_reference(problem)
    g, w = 9.81, math.sqrt(1000)
    fall, hit = math.sqrt(2 / g), math.sqrt(2 * g)
    below = (2 * math.pi - 2 * math.atan2(hit, g / w)) / w  # s = -g/w2 + g/w2 cos(w t) - hit/w sin(w t) until it is 0 again
    heights = []
    for t in problem.times:
        phase = t % (2 * fall + below)
        inside = phase - fall
        heights.append(1 - g * phase**2 / 2 if inside < 0 else
                       -g / w**2 + g / w**2 * math.cos(w * inside) - hit / w * math.sin(w * inside) if inside < below else
                       1 - g * (phase - 2 * fall - below) ** 2 / 2)
    error = float(np.abs(reference.positions[:, 0] - heights).max())
    assert error < 1e-8
    assert error < 100 * reference.error


def test_impulses_that_peers_would_not_know_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "pushed.lag"
    path.write_text("""model Pushed Frame table = shift(world, {1[m]*ramp(time, 0.5, 1), 0});
      Revolute h(a = table); PointMass p(m = 1, center = shift(h.b, {0, -1})); end Pushed;""")
    with pytest.raises(LagError, match="L0909"):
        build_problem(lag.load(path))


def test_a_reference_that_takes_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lagrangia.bench.reference.find_spec", lambda _: None)  # no SciPy
    problem = build_problem(lag.load(CASES / "stiff_spring_pendulum.lag"), Request(stop=1000.0))
    with pytest.raises(NoReference, match="too long"):
        find_reference(problem, seconds=0.3)


def test_what_sticks_has_no_reference(scene: Callable[[str], lag.Model]) -> None:
    """The integrators of others take shorter and shorter steps there."""
    model = scene("""model Stopping
      Block b(m = 2, base = world, s(start = 0.95));
      Spring k(k = 50, stretch = b.s);
      DryFriction f(F = 5, rate = b.v);
    end Stopping;""")
    with pytest.raises(NoReference, match="too long"):
        find_reference(build_problem(model, Request(stop=10.0)), seconds=0.5)


# -------------------------------------------------------------------- solvers


def available(problem: Problem) -> list[Solver]:
    return [s for s in all_solvers() if s.version is not None and s.name not in problem.model.scene.refused]


LONG_TO_COMPILE = ("casadi:rosenbrock", "casadi:cvodes", "casadi:adams", "scipy:Radau")


@pytest.mark.parametrize(("scene", "left_out"), [
    ("double_pendulum", ()), ("quarter_car", LONG_TO_COMPILE), ("four_bar", LONG_TO_COMPILE)])
def test_every_solver_converges_to_the_reference(scene: str, left_out: tuple[str, ...]) -> None:
    """On a smooth scene, one with events and one with a closed loop, whose equations take long to compile for some."""
    problem = build_problem(lag.load(EXAMPLES / f"{scene}.lag"), Request(stop=0.8), points=4)
    reference = find_reference(problem)
    for solver in (s for s in available(problem) if s.name not in left_out):
        errors = [point.error for point in measure(problem, reference, [solver], (1e-4, 1e-9), 1) if isinstance(point, Point)]
        assert len(errors) == 2, solver.name
        assert errors[1] < 2e-6, solver.name
        assert errors[1] < max(errors[0] / 10, 1e-13), solver.name  # linear is exact at any tolerance


@pytest.mark.skipif(not PEERS["heyoka"], reason="heyoka is not installed")
def test_expressions_of_heyoka_have_the_values_of_casadi() -> None:
    import heyoka

    from lagrangia.bench.heyoka_peer import translate

    t, y = ca.SX.sym("t"), ca.SX.sym("y", 2)
    a, b = y[0], y[1]
    terms = [ca.sin(a), ca.cos(b), ca.tan(a), ca.asin(a), ca.acos(a), ca.atan(b), ca.atan2(a, b), ca.sinh(a), ca.cosh(a),
             ca.tanh(b), ca.exp(a), ca.log(b), ca.sqrt(b), a**3, a**2, b**a, 1 / b, a / b, -a, 2 * a, ca.fabs(-a), ca.fmin(a, b),
             ca.fmax(a, b), ca.sign(-a), ca.if_else(a < b, a, b), ca.if_else(ca.logic_and(a < b, a <= 0), a, b),
             ca.if_else(ca.logic_not(a == b), t, a), ca.if_else(ca.logic_or(a > b, b != a), b, t), ca.erf(a)]
    function = ca.Function("terms", [t, y], [ca.vertcat(*terms)])
    variables = heyoka.make_vars("y0", "y1")
    evaluate = heyoka.cfunc(translate(function, [[heyoka.expression(0.7)], variables]), list(variables))
    for values in ([0.3, 0.9], [0.8, 0.2]):
        np.testing.assert_allclose(evaluate(values), np.array(function(0.7, values)).ravel(), rtol=1e-14)


@pytest.mark.skipif(not PEERS["heyoka"], reason="heyoka is not installed")
def test_what_heyoka_lacks_is_said() -> None:
    from lagrangia.bench.heyoka_peer import translate

    x = ca.SX.sym("x")
    with pytest.raises(Unsuitable, match="lacks the operation"):
        translate(ca.Function("f", [x], [ca.floor(x)]), [[0.5]])


def test_a_solver_that_is_not_installed_is_skipped() -> None:
    problem = build_problem(lag.load(EXAMPLES / "pendulum.lag"), Request(stop=0.1))
    missing = Solver("other", "no-such-package-of-anybody", lambda *_: pytest.fail("it is not to be prepared"))
    assert list(measure(problem, find_reference(problem), [missing])) == [Skipped("other", "not installed")]


# -------------------------------------------------------------------- tables


POINTS = [Point("a", 1e-2, 1.0, 1e-2), Point("a", 1e-4, 2.0, 1e-4), Point("a", 1e-6, 1.5, 1e-5), Point("a", 1e-8, 4.0, 1e-8),
          Point("b", 1e-2, 3.0, 1e-6), Point("b", 1e-4, math.inf, math.inf)]


def test_the_front_holds_what_nothing_beats() -> None:
    assert [point.seconds for point in front(POINTS[:4])] == [1.0, 1.5, 4.0]


def test_seconds_at_an_error_lie_between_the_points() -> None:
    assert seconds_at(POINTS[:4], 1e-1) == 1.0
    assert seconds_at(POINTS[:4], 1e-5) == pytest.approx(1.5)
    assert seconds_at(POINTS[:4], 10**-3.5) == pytest.approx(math.sqrt(1.5))
    assert seconds_at(POINTS[:4], 1e-9) is None
    assert seconds_at([Point("a", 1e-1, 0.1, 4.7), *POINTS[:4]], 1e-2) == 1.0


def test_the_duel_takes_the_fastest_of_each_side() -> None:
    rows = {round(math.log10(error)): (own, other) for error, own, other in duel(POINTS, ["b"], floor=1e-7)}
    assert set(rows) == {-3, -4, -5, -6}
    own, other = rows[-6]
    assert own is not None and other is not None
    assert (own.seconds, round(other.seconds, 3)) == (3.0, round(1.5 * (4 / 1.5) ** (1 / 3), 3))
    assert any(line.split()[:1] == ["1e-06"] for line in as_text(POINTS, ["b"], 1e-7))
    assert json.loads(as_json(POINTS, {}))["points"][-1]["error"] is None


# -------------------------------------------------------------------- the command


def test_the_command_writes_table_and_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                              capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = ["bench", str(EXAMPLES / "chain.lag"), "-p", "n=2", "-p", "link[1].m=2[kg]", "--stop", "0.5", "--repeat", "1",
                 "--tolerances", "1e-5,1e-8", "--solvers", "erk,casadi:erk", "--points", "2", "--plot", "work.png"]
    assert main([*arguments, "-o", "work.json"]) == 0
    said = capsys.readouterr().out
    assert "2 coordinates, 0 to 0.5 s, 2 output times" in said
    written = json.loads(Path("work.json").read_text())
    assert [(p["solver"], p["tolerance"]) for p in written["points"]] == [
        ("erk", 1e-5), ("erk", 1e-8), ("casadi:erk", 1e-5), ("casadi:erk", 1e-8)]
    assert all(0 < p["error"] < 1e-3 and p["seconds"] > 0 for p in written["points"])
    assert Path("work.png").stat().st_size > 10_000
    assert main([*arguments, "-o", "work.csv"]) == 0
    assert Path("work.csv").read_text().startswith("solver,tolerance,seconds,error\nerk,1e-05,")


@pytest.mark.parametrize(("options", "said"), [
    (["--solvers", "heyokaa"], "error[L0704]: there is no solver 'heyokaa' to be measured\n   = did you mean 'heyoka'?"),
    (["--solvers", ""], "error[L0704]: there is no solver '' to be measured"),
    (["--tolerances", "1e-6,0"], "error[L0702]: the tolerance must lie between 0 and 1, not 0"),
    (["--tolerances", "tight"], "error[L0706]: 'tight' after --tolerances is no number"),
    (["--tolerances", "nan"], "error[L0702]: the tolerance must lie between 0 and 1, not nan"),
    (["--repeat", "0"], "error[L0702]: --repeat must be a number from 1 to 100000, not 0"),
    (["--points", "-3"], "error[L0702]: --points must be a number from 1 to 100000, not -3"),
    (["--stop", "-1"], "error[L0702]: the stop time -1 must be later than the start time 0"),
    (["-o", "work.txt"], "error[L0004]: 'work.txt' is no table that can be written"),
    (["--plot", "work.txt"], "error[L0004]: 'work.txt' is no picture that can be drawn"),
    (["-p", "M=3"], "error[L0701]: the scene has no parameter 'M'"),
    (["--model", "Other"], "has no model 'Other'"),
])
def test_wrong_options(options: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", str(EXAMPLES / "pendulum.lag"), *options]) == 2
    assert said in capsys.readouterr().err


def test_a_scene_whose_reference_cannot_be_had_fails_with_advice(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "explosion.lag"
    file.write_text("""model Explosion
      coordinate Length s(start = 1); Velocity v(start = 2) = der(s);
    energy kinetic 1[kg]*v^2/2; potential -2[J/m3]*s^3;
    end Explosion;""")
    assert main(["bench", str(file), "--stop", "3", "--solvers", "erk"]) == 1
    assert "no reference for the errors: it cannot be continued beyond t = 1; choose a shorter time" in (
        capsys.readouterr().err)
