"""Starts that are stated by expressions which are not finite everywhere: nothing crashes, and no digit is lost."""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.compile.pipeline import compile_file
from lagrangia.constraints import assembly

Write = Callable[[str], lag.Model]


def begin(model: lag.Model, **options: object) -> dict[str, float]:
    """All coordinates, rates and outputs at the start."""
    run = model.simulate(stop=1e-9, interval=1e-9, **options)
    names = [c.name for c in (*model.scene.coordinates, *model.scene.rates, *model.scene.outputs)]
    return {name: float(run[name][0]) for name in names}


# ---------------------------------------------------------------- not finite at the guess

ROD = "PointMass A(m = 1); Link l(a = world, b = A.center, L = {L});"
UNBOUNDED = {  # what is stated, and what vanishes then
    "a quotient": (ROD.format(L="1"), "A.center.y/A.center.x = 0.5;", lambda x, y, vx, vy: y - 0.5 * x),
    "a steep quotient": (ROD.format(L="1[km]"), "A.center.x/A.center.y = 1e3;", lambda x, y, vx, vy: x - 1e3 * y),
    "a small rod": (ROD.format(L="1[mm]"), "A.center.y/A.center.x = 0.5;", lambda x, y, vx, vy: y - 0.5 * x),
    "an angle": (ROD.format(L="1"), "atan2(A.center.y, A.center.x) = 2.5;", lambda x, y, vx, vy: x - np.cos(2.5)),
    "rates": (ROD.format(L="1"), "A.center.x = 0.6; A.center.v[2]/(A.center.v[1] - 1) = -2;",
              lambda x, y, vx, vy: vy + 2 * (vx - 1)),
    "a direction": ("PointMass A(m = 1);", "A.center.x/norm(A.center.r) = 0.6; norm(A.center.r) = 2[m];",
                    lambda x, y, vx, vy: abs(x - 1.2) + abs(abs(y) - 1.6)),
    "a logarithm and a root": ("PointMass A(m = 1);",
                               "log(A.center.x/1[m]) = 1; sqrt(A.center.v[2]/1[m/s] - 3) = 2; 1/A.center.y = 5[1/m];",
                               lambda x, y, vx, vy: abs(x - np.e) + abs(vy - 7) + abs(y - 0.2)),
}


@pytest.mark.parametrize("case", UNBOUNDED)
def test_what_is_not_finite_at_the_guess_is_solved_from_beside_it(
    case: str, scene: Write, capfd: pytest.CaptureFixture[str]
) -> None:
    parts, stated, gap = UNBOUNDED[case]
    model = scene(f"model M {parts} initial equation {stated} end M;")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        start = begin(model)
    x, y, vx, vy = (start[f"{a}A.center.{b}{c}"] for a, c in (("", ""), ("der(", ")")) for b in "xy")
    assert abs(gap(x, y, vx, vy)) < 1e-12 * max(1, abs(x), abs(y))
    made = compile_file(model.path)
    found, worst = assembly.begin(made.kinematics, made.initial, made.functions.table).assemble()
    assert worst == -1
    np.testing.assert_allclose(found, [x, y, vx, vy], rtol=1e-9, atol=1e-12)
    assert capfd.readouterr() == ("", "")  # what LAPACK says of NaN goes past Python


@pytest.mark.parametrize(("stated", "told"), [
    ("sqrt(-1 - b.s^2/1[m2]) = 1;", "it has no finite value, or no finite slope"),
    ("b.s/norm({b.s, 1e-3[m]}) = 2;", "it misses by 1"),
])
def test_what_holds_nowhere_is_refused(stated: str, told: str, scene: Write) -> None:
    with pytest.raises(lag.LagError, match=f"L0606.*{told}"):
        begin(scene(f"model M Block b(m = 1, base = world); initial equation {stated} end M;"))


def test_a_direction_that_contradicts_is_told_although_its_slope_is_boundless_at_the_guess(scene: Write) -> None:
    stated = "A.center.x = 1; A.center.y = 1; A.center.x/norm(A.center.r) = 0.9;"
    model = scene(f"model M PointMass A(m = 1); initial equation {stated} end M;")
    with pytest.raises(lag.LagError, match="L0606"):
        begin(model)


def test_an_equation_that_is_the_same_in_all_directions_asks_for_one(scene: Write) -> None:
    text = "model M PointMass p(m = 1%s); initial equation norm(p.center.v) = 2; end M;"
    with pytest.raises(lag.LagError, match=r"L0606.*start 'der\(p.center.x\)' or 'der\(p.center.y\)' elsewhere.*misses by 2"):
        begin(scene(text % ""))
    start = begin(scene(text % ", center(v(start = {0.3, 0.4}))"))
    assert (start["der(p.center.x)"], start["der(p.center.y)"]) == pytest.approx((1.2, 1.6))


QUOTIENTS = {  # both sides of each vanish where the others hold
    "rates of a rod": ("Link l(a = world, b = p.center, L = 1);",
                       "p.center.y/p.center.x = 1; der(p.center.y)/der(p.center.x) = 1;"),
    "a rate that is 0": ("", "der(p.center.x)/der(p.center.y) = 2; der(p.center.x) = 0;"),
    "rates": ("", "der(p.center.x)/der(p.center.y) = 2; der(p.center.x) + der(p.center.y) = 0;"),
    "a direction": ("", "atan2(p.center.y, p.center.x) = 0.5; p.center.x + p.center.y = 0;"),
    "places": ("", "p.center.x/p.center.y = 2; p.center.x + p.center.y = 0;"),
}


@pytest.mark.parametrize("case", QUOTIENTS)
def test_nothing_over_nothing_holds_for_no_value(case: str, scene: Write) -> None:
    parts, stated = QUOTIENTS[case]
    with pytest.raises(lag.LagError, match=r"L0606.*this cannot hold at the start"):
        begin(scene(f"model M PointMass p(m = 1); {parts} initial equation {stated} end M;"))


def test_rates_that_nobody_guessed_are_looked_for_elsewhere(scene: Write) -> None:
    start = begin(scene("model M PointMass p(m = 1); initial equation der(p.center.x)/der(p.center.y) = 2; "
                        "der(p.center.x)^2 + der(p.center.y)^2 = 5[m2/s2]; end M;"))
    assert abs(start["der(p.center.x)"]) == pytest.approx(2)
    assert start["der(p.center.y)"] == pytest.approx(start["der(p.center.x)"] / 2)


# ---------------------------------------------------------------- equations between rates

LAG = "coordinate Real F(unit = \"N\"{start}); Block m(m = 1, base = world{v}); "\
      "AppliedForce push(at = m.center, force = {{F, 0}}); equation 0.2[s]*der(F) = 10 - 4[N.s/m]*m.v - F;"
LAGS = {  # what is stated of F and of the mass; F, its rate and the speed at the start
    "nothing of F": ("", ", v(start = 2)", "", (0, 10, 2)),
    "nothing at all": ("", "", "", (0, 50, 0)),
    "F": (", start = 3", ", v(start = 2)", "", (3, -5, 2)),
    "F, fixed": (", start = 3, fixed = true", "", "", (3, 35, 0)),
    "its rate is to be 0": ("", ", v(start = 2)", "initial equation der(F) = 0;", (2, 0, 2)),
}


@pytest.mark.parametrize("case", LAGS)
def test_an_equation_between_rates_moves_no_place_that_could_stay(case: str, scene: Write) -> None:
    of_f, of_v, more, right = LAGS[case]
    start = begin(scene(f"model M {LAG.format(start=of_f, v=of_v)} {more} end M;"))
    assert [start[name] for name in ("F", "der(F)", "der(m.s)")] == pytest.approx(right, abs=1e-14)


def test_a_lag_runs_from_zero(scene: Write) -> None:
    """Closed form: F and v from the matrix exponential of T F' = 10 - 4 v - F, v' = F."""
    model = scene(f"model M {LAG.format(start='', v=', v(start = 2)')} end M;")
    run = model.simulate(stop=2, tolerance=1e-10)
    roots = np.roots([0.2, 1, 4])  # v - 2.5 = Re c exp(root t), with v = 2 and v' = F = 0 at 0
    c = np.linalg.solve([[1, 1], roots], [-0.5, 0])
    v, F = (sum(c * roots**k * np.exp(2 * roots)).real for k in (0, 1))
    assert run["F"][-1] == pytest.approx(F, abs=1e-9)
    assert run["der(m.s)"][-1] == pytest.approx(2.5 + v, abs=1e-9)


def test_rates_of_things_with_mass_that_nobody_stated_stay_zero_beside_a_massless_one(scene: Write) -> None:
    parts = "coordinate Length n; Block m(m = 1e-6, base = world, s(start = 0.1)), k(m = 1e6, base = world);"
    start = begin(scene(f"model M {parts} equation 5[N.s/m]*(der(n) - m.v - k.v) = 100[N/m]*(m.s - n); end M;"))
    assert (start["n"], start["der(n)"], start["der(m.s)"], start["der(k.s)"]) == (0, pytest.approx(2, rel=1e-14), 0, 0)


def test_what_is_moved_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "m.lag"
    file.write_text(f"model M {LAG.format(start='', v=', v(start = 2)')} initial equation der(F) = 0; end M;"
                    "model N PointMass A(m = 1, center(x(start = 2), y(start = 0))); Link l(a = world, b = A.center, L = 1); "
                    "end N;"
                    f"model O {LAG.format(start='', v=', v(start = 2)')} end O;"
                    "model P Block b(m = 1, base = world, s(start = 1)), u(m = 0, base = world), v(m = 0, base = world), "
                    "w(m = 0, base = world, s(start = 0.8)); Spring s1(k = 10, stretch = u.s), s2(k = 5, stretch = w.s - v.s); "
                    "Damper d1(c = 2, rate = v.v - u.v), d2(c = 1, rate = b.v - w.v); end P;")  # two Maxwell elements in a row
    said = []
    for name in "MNOP":
        assert main(["simulate", str(file), "--model", name, "--at", "0,0.1", "-o", str(tmp_path / "o.csv")]) == 0
        said.append([line for line in capsys.readouterr().out.splitlines() if " begins at " in line])
        assert lag.load(file, model=name).simulate(at=[0, 0.1]).notes == [line.strip() for line in said[-1]]
    assert "F begins at 2 N, not at 0 N" in said[0][0]
    assert "A.center.x begins at 1 m, not at 2 m" in said[1][0]
    assert "v.s begins at 0.8 m, where the forces on it are in balance" in said[3][0]
    assert [len(lines) for lines in said] == [1, 1, 0, 1]


# ---------------------------------------------------------------- equations of accelerations

STEADY = {  # what moves, what is said of its start, and where it begins then
    "a motor against drag": (
        "World world(gravity = {0, 0}); Revolute h(a = world); Body r(m = 0, I = 1.5, center = h.b);"
        "AppliedTorque t(on = h.b, torque = 10 - 2*h.w - 0.1*h.w*abs(h.w));", "der(h.w) = 0;",
        {"h.phi": 0.0, "der(h.phi)": 10 * (np.sqrt(2) - 1)}),
    "a weight on a spring": (
        "Block b(m = 1, base = world, along = {0, 1}); Spring k(k = 100, stretch = b.s);", "der(b.v) = 0;",
        {"b.s": -0.0981, "der(b.s)": 0.0}),
    "a wind that holds a pendulum aside": (
        "PointMass m(m = 1); Link l(a = world, b = m.center, L = 1); AppliedForce w(at = m.center, force = {9.81, 0});",
        "der(m.center.v[1]) = 0; m.center.v[1] = 0;", {"m.center.x": np.sqrt(0.5), "m.center.y": -np.sqrt(0.5)}),
    "a force that changes later": (
        "Block b(m = 1, base = world); Damper d(c = 2, rate = b.v);"
        "AppliedForce f(at = b.center, force = {if time < 1 then 12 else 10, 0});", "der(b.v) = 0;", {"der(b.s)": 6.0}),
}


@pytest.mark.parametrize("case", STEADY)
def test_a_steady_start(case: str, scene: Write) -> None:
    parts, stated, expected = STEADY[case]
    found = begin(scene(f"model M {parts} initial equation {stated} end M;"))
    assert {name: found[name] for name in expected} == pytest.approx(expected, abs=1e-9)


PUSHED = "input Force u; Block b(m = 1, base = world); AppliedForce f(at = b.center, force = {u - 2[N.s/m]*b.v, 0});"


def test_a_steady_start_that_inputs_decide(scene: Write) -> None:
    """v = u/c, by the input of the run."""
    run = scene(f"model M {PUSHED} initial equation der(b.v) = 0; end M;").simulate(inputs={"u": 3.0})
    assert run["b.v"] == pytest.approx(1.5, abs=1e-12)


def test_a_steady_start_that_contacts_decide_is_refused(scene: Write) -> None:
    with pytest.raises(lag.LagError, match=r"L0603.*of accelerations that contacts"):
        scene(f"model M {PUSHED} Stop floor(gap = b.s + 1); initial equation der(b.v) = 0; end M;").scene  # noqa: B018


@pytest.mark.parametrize(("text", "rates"), [
    ("PointMass a(m = 1), b(m = 2); equation a.center.y/a.center.x = 0.5;", ["a.center.v"]),
    ("PointMass a(m = 1), b(m = 2); equation a.center.x/b.center.x = 0.5;", ["a.center.v", "b.center.v"]),
    ("""PointMass a(m = 1), k(m = 0); Spring r(a = world, b = k.center, k = 100, s_rel0 = 0.3);
        Spring s(a = shift(world, {0.4, 0.1}), b = k.center, k = 100, s_rel0 = 0.3), t(a = k.center, b = a.center, k = 70);
        initial equation a.center.x = 1; a.center.y = -0.6;""", ["a.center.v"]),
])
def test_places_step_aside_without_a_speed(text: str, rates: list[str]) -> None:
    """Where equations say nothing (0/0, a spring of no length) the guess moves: rates moved with it, and were kept (0.24 m/s)."""
    run = lag.loads(f"model M {text} end M;").simulate(at=[0.0, 0.1])
    for name in rates:
        assert np.abs(run[name][0]).max() < 1e-12, name


def test_starts_beyond_dead_points_are_told(scene: Write) -> None:
    """A crank told to nine digits, whose link lies along it; one that cannot turn beyond 53 degrees."""
    aligned = scene("""model M
      Revolute h(a = world, phi(start = 3.141592654)), k(a = shift(world, {-1.5, -0.4}), phi(start = 90[deg]), w(start = 1));
      Bar crank(m = 1, L = 0.5, a = h.b), rocker(m = 1, L = 0.4, a = k.b); Link link(L = 1, a = crank.b, b = rocker.b); end M;""")
    (told,) = aligned.simulate(at=[0]).notes
    assert "near a dead point" in told
    assert "der(h.phi) at -1.3e+09 rad/s" in told
    text = """model M Revolute O(a = world, phi(start = %d[deg])), C(a = shift(world, {1.5, 0}), phi(start = 90[deg]));
      Revolute A(a = crank.b), B(a = link.b, b = rocker.b);
      Bar crank(m = 1, L = 1, a = O.b), rocker(m = 1, L = 0.5, a = C.b), link(m = 1, L = 0.7, a = A.b); end M;"""
    crank, rocker = scene(text % 80).simulate(at=[0]).notes
    assert crank.startswith("O.phi begins at 51.75 deg, not at 80 deg")
    assert rocker.startswith("C.phi begins at 125.9 deg, not at 90 deg")
    assert scene(text % 30).simulate(at=[0]).notes == []


@pytest.mark.parametrize("text", [
    """Revolute O(a = world), A(a = crank.b), B(a = coupler.b, b = rocker.b), C(a = shift(world, {1, 0}), phi(start = 75[deg]));
      Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
      Revolute h(a = world, w(start = 1e-6)); PointMass p(m = 1, center = shift(h.b, {0, -1}));
      equation O.phi = 40[deg] + 10[rad/s]*time;""",
    """Revolute a(a = world), b(a = world), h(a = world, w(start = 1e-6)); Disc d(m = 1, r = 0.1, center = a.b);
      Disc e(m = 1, r = 0.1, center = b.b), f(m = 1, r = 0.1, center = h.b);
      initial equation a.w + b.w = 20[rad/s]; a.w = 3*b.w;""",
    """Revolute O(a = world, phi(start = 180[deg], fixed = true), w(start = 1000[rad/s], fixed = true));
      Bar crank(m = 1, L = 0.1, a = O.b), rod(m = 1, L = 0.3, a = A.b); Revolute A(a = crank.b, phi(start = -180[deg]));
      Prismatic s(a = shift(world, {0.2, 0}), along = {1, 0}, s(start = 0), v(start = 0)); Revolute B(a = rod.b, b = s.b);
      PointMass p(m = 1, center = s.b);""",
    """World world(gravity = {0, 0}); Revolute O(a = world, phi(start = 30[deg], fixed = true)), A(a = crank.b);
      Bar crank(m = 1, L = 0.2, a = O.b), rod(m = 1, L = 0.4, a = A.b);
      Prismatic s(a = shift(world, {0.5605, 0}), along = {1, 0}, s(start = 0)); Revolute B(a = rod.b, b = s.b);
      PointMass p(m = 1, center = s.b);"""], ids=["prescribed", "equations", "standing slide", "drawn slide"])
def test_starts_that_hold_as_far_as_they_are_told_are_not_told(text: str, scene: Write) -> None:
    """Rates beside the small one of what they are not bound to; slides stated at 0 of mechanisms that are much larger."""
    assert scene(f"model M {text} end M;").simulate(at=[0]).notes == []


def test_slides_that_begin_elsewhere_are_told(scene: Write) -> None:
    """A hundredth of the crank, and a hundredth of its speed, are not rounding."""
    run = scene("""model M Revolute O(a = world, phi(start = 30[deg], fixed = true), w(start = 1, fixed = true)), A(a = crank.b);
      Bar crank(m = 1, L = 0.2, a = O.b), rod(m = 1, L = 0.4, a = A.b); Revolute B(a = rod.b, b = s.b);
      Prismatic s(a = shift(world, {0.5585, 0}), along = {1, 0}, s(start = 0), v(start = 0));
      PointMass p(m = 1, center = s.b); end M;""").simulate(at=[0])
    assert [said.split(" at ")[0] for said in run.notes] == ["s.s begins", "der(s.s) begins"]
