"""What constraints leave: linear ones no multiplier, others their rank, and the freedom that is told."""

from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.reference import integrate
from lagrangia.compile.instructions import tape_of
from lagrangia.run.interpret import evaluate, evaluate_each
from lagrangia.run.request import check_values

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
Write = Callable[[str], lag.Model]


# ---------------------------------------------------------------- linear ones

SHAFTS = "Revolute p(a = world), q(a = shift(world, {1, 0})); "\
         "Disc P(m = 1, r = 0.1, center = p.b), Q(m = 1, r = 0.2, center = q.b);"
RACK = "Block t(m = 1, base = world); Revolute p(a = world); Disc P(m = 1, r = 0.1, center = p.b);"
ARM = "Revolute p(a = world), q(a = l.b); Bar l(m = 1, L = 1, a = p.b), k(m = 1, L = 1, a = q.b);"
LINEAR = {
    "rolling": ("Rolling p(r = 0.1, base = world); Disc P(m = 1, r = 0.1, center = p.center);", "p.s", lambda phi, t: -0.1 * phi),
    "gear": (SHAFTS + "Gear gear(r_a = 0.1, r_b = 0.2, a = p.b, b = q.b, carrier = world);", "q.phi", lambda phi, t: -phi / 2),
    "belt": (SHAFTS + "Belt belt(r_a = 0.1, r_b = 0.2, a = p.b, b = q.b, carrier = world);", "q.phi", lambda phi, t: phi / 2),
    "rack": (RACK + "Rack rack(r = 0.1, s = t.s, phi = p.phi);", "t.s", lambda phi, t: 0.1 * phi),
    "motion": (ARM + "Motion motor(of = q.phi, to = 0.3*sin(2[rad/s]*time));", "q.phi", lambda phi, t: 0.3 * np.sin(2 * t)),
}


@pytest.mark.parametrize("name", LINEAR)
def test_a_linear_tie_leaves_no_multiplier(name: str, scene: Write) -> None:
    text, given, law = LINEAR[name]
    model = scene(f"model M {text} end M;")
    assert model.coordinate_names == ("p.phi",)
    assert model.scene.sizes["n_multipliers"] == 0
    assert model.scene.notes["dependent"] == [given]
    run = model.simulate(stop=1, interval=0.1, initial={"p.phi": 0.4, "der(p.phi)": 1})
    np.testing.assert_allclose(run[given], law(run["p.phi"], run.time), atol=1e-14)


def test_a_linear_equation_said_twice_is_named(scene: Write) -> None:
    model = scene(f"model M {LINEAR['gear'][0]} equation p.phi = -2*q.phi; end M;")
    assert model.freedom["degrees_of_freedom"] == 1
    (told,) = model.freedom["repeated"]
    assert "repeats in part what others already impose" in told
    assert "scene.lag:1:" in told


TWIN = "Bar twin(m = 1, L = 0.4);"
MOTIONLESS = {  # one bar that swings, and an equation that no motion changes
    "a rod between the ends of a bar": "Link rod(L = 0.4, a = bar.a, b = bar.b);",
    "a rod between places of a bar": "Link rod(L = 0.4, a = bar.center, b = shift(bar.center, {0, 0.4}));",
    "a bar welded at both ends": f"{TWIN} Weld one(a = bar.a, b = twin.a), two(a = bar.b, b = twin.b);",
}


@pytest.mark.parametrize("name", MOTIONLESS)
def test_what_no_motion_changes_is_left_out(name: str, scene: Write) -> None:
    """Its slopes are rounding, which no accelerations can be divided by."""
    swinging = "Revolute hinge(a = world, phi(start = 0.7)); Bar bar(m = 1, L = 0.4, a = hinge.b);"
    model, alone = (scene(f"model M {swinging} {more} end M;") for more in (MOTIONLESS[name], ""))
    assert model.scene.sizes["n_multipliers"] == 0
    assert len(model.freedom["repeated"]) == 1
    runs = [each.simulate(stop=1, interval=0.1, tolerance=1e-11) for each in (model, alone)]
    np.testing.assert_allclose(runs[0]["hinge.phi"], runs[1]["hinge.phi"], atol=1e-10)


def test_what_repeats_is_asked_again_with_other_parameters(scene: Write) -> None:
    """A gear said twice, and a bar welded at both ends: with other ratios and lengths they fight."""
    gears = scene(f"""model M {LINEAR['gear'][0]} parameter Real again = 2; equation p.phi = -again*q.phi; end M;""")
    welds = scene(f"""model M Revolute hinge(a = world); Bar bar(m = 1, L = 0.4, a = hinge.b);
      {MOTIONLESS['a bar welded at both ends']} end M;""")
    for model, wrong, right in ((gears, {"again": 3}, {"again": 2}), (welds, {"twin.L": 0.5}, {"twin.L": 0.5, "bar.L": 0.5})):
        with pytest.raises(lag.LagError, match="it misses by"):
            model.simulate(stop=0.1, parameters=wrong)
        model.simulate(stop=0.1, parameters=right)


# ---------------------------------------------------------------- freedom

FREEDOM = {  # degrees of freedom, coordinates that are left, multipliers
    "andrews_squeezer": (1, 7, 6),
    "atwood": (1, 1, 0),
    "crank_press": (1, 3, 2),
    "ellipse_trammel": (1, 3, 2),
    "four_bar": (1, 3, 2),
    "gear_train": (1, 1, 0),
    "incline_disc": (1, 1, 0),
    "n_four_bars": (1, 5, 4),
    "pantograph": (2, 4, 2),
    "parallelogram": (1, 4, 4),
    "rolling_disc": (1, 1, 0),
    "scissor_lift": (1, 7, 6),
    "skate": (2, 3, 1),
    "slider_crank": (1, 3, 2),
}


@pytest.mark.parametrize("name", FREEDOM)
def test_degrees_of_freedom(name: str) -> None:
    model = lag.load(EXAMPLES / f"{name}.lag")
    scene, freedom = model.scene, model.freedom
    assert (freedom["degrees_of_freedom"], scene.n, scene.sizes["n_multipliers"]) == FREEDOM[name]
    assert freedom["degrees_at_start"] == FREEDOM[name][0]
    assert bool(freedom["repeated"]) == (name == "parallelogram")


def test_a_redundant_loop_is_named() -> None:
    (told,) = lag.load(EXAMPLES / "parallelogram.lag").freedom["repeated"]
    assert "hook[3] - bar[3] - eye[3]" in told


FLAT = """model M
  Revolute O(a = world), A(a = crank.b), B(a = coupler.b, b = rocker.b), C(a = shift(world, {1, 0}));
  Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 1, L = 1, a = A.b), rocker(m = 1, L = 0.4, a = C.b);
end M;"""


def test_a_start_in_a_singular_position_is_told(scene: Write) -> None:
    """A parallelogram lying flat may open two ways."""
    notes = scene(FLAT).freedom
    assert notes["degrees_of_freedom"] == 1
    assert notes["degrees_at_start"] == 2


def test_a_stretched_guess_is_no_reason_to_refuse(scene: Write) -> None:
    """Two bars of 1 m to a point at 1.2 m, guessed in line."""
    model = scene("""model M
      Revolute h(a = world), k(a = b.b, b = c.a), e(a = shift(world, {1.2, 0}), b = c.b);
      Bar b(m = 1, L = 1, a = h.b), c(m = 1, L = 1);
    end M;""")
    assert model.freedom["problem"] == ""
    assert model.freedom["degrees_of_freedom"] == 0
    run = model.simulate(stop=1, interval=0.5)
    np.testing.assert_allclose(np.abs(run["h.phi"]), np.arccos(0.6), atol=1e-12)


# ---------------------------------------------------------------- others


def test_a_skate_keeps_to_its_edge_and_keeps_its_energy() -> None:
    run = lag.load(EXAMPLES / "skate.lag").simulate(tolerance=1e-10)
    across = np.array([-np.sin(run["skate.center.phi"]), np.cos(run["skate.center.phi"])])
    np.testing.assert_allclose((run["skate.center.v"].T * across).sum(axis=0), 0, atol=1e-12)
    assert np.ptp(run.energy.total) < 1e-8 * np.abs(run.energy.kinetic).max()


def test_a_rod_that_grows_does_work(scene: Write) -> None:
    """A rheonomic constraint: phi L^2 changes by gravity alone, and the energy account closes with the work of the drive."""
    run = scene("""model M
      PointMass ball(m = 2, center(x(start = 0.6), y(start = -0.8)));
    equation
      distance(world, ball.center) = 1[m] + 0.2[m]*sin(3[rad/s]*time);
    end M;""").simulate(stop=4, interval=0.1, tolerance=1e-11)
    x, y = run["ball.center.x"], run["ball.center.y"]
    np.testing.assert_allclose(np.hypot(x, y), 1 + 0.2 * np.sin(3 * run.time), atol=1e-12)
    assert np.ptp(run.energy.work) > 1
    energy = run.energy
    np.testing.assert_allclose(energy.total - energy.total[0] + energy.dissipated - energy.work, energy.residual, atol=1e-9)
    np.testing.assert_allclose(run.energy.residual, 0, atol=1e-8)


MASSLESS = """model M
  Revolute O(a = world, phi(start = 40[deg], fixed = true)), C(a = shift(world, {{1, 0}}), phi(start = 75[deg]));
  Bar crank(m = 1, L = 0.4, a = O.b), rocker(m = 1.5, L = 0.8, a = C.b);
  {coupler}
end M;"""


LADDER = """model Ladder
  parameter Integer n = 4; parameter Mass m[2*n+1];
  Revolute foot[n+1](each phi(start = 90[deg])), left[n](each phi(start = -90[deg])), right[n];
  Bar crank[n+1](m = m[1:n+1], each L = 1), coupler[n](m = m[n+2:2*n+1], each L = 1);
equation
  for i in 1:n+1 loop connect(foot[i].a, shift(world, {i, 0})); connect(foot[i].b, crank[i].a); end for;
  for i in 1:n loop
    connect(left[i].a, crank[i].b); connect(left[i].b, coupler[i].a);
    connect(right[i].a, crank[i+1].b); connect(right[i].b, coupler[i].b);
  end for;
initial equation
  foot[1].phi = 90[deg]; foot[1].w = -1;
end Ladder;"""


def ladder(scene: Write, masses: np.ndarray) -> lag.Model:
    values = ", ".join(map(repr, masses.tolist()))
    return scene(LADDER.replace("n = 4", f"n = {len(masses) // 2}").replace("m[2*n+1]", f"m[2*n+1] = {{{values}}}"))


def test_a_ladder_of_uneven_masses_is_as_exact_as_a_pendulum(scene: Write) -> None:
    """All cranks turn alike: sum(m_crank/3 + m_coupler) phi'' = -g sum(m_crank/2 + m_coupler) cos phi; folded flat on the way."""
    n = 12
    masses = 10 ** np.random.default_rng(3).uniform(-9, 9, 2 * n + 1)
    cranks, couplers = masses[: n + 1].sum(), masses[n + 1 :].sum()
    run = ladder(scene, masses).simulate(stop=2, interval=0.1, tolerance=1e-12)
    pull = -9.81 * (cranks / 2 + couplers) / (cranks / 3 + couplers)
    phi, _ = integrate(lambda t, q, v: pull * np.cos(q), [np.pi / 2], [-1], run.time)
    assert phi[0].min() < -np.pi / 4
    for k in range(1, n + 2):
        np.testing.assert_allclose(run[f"foot[{k}].phi"], phi[0], rtol=0, atol=1e-10)


@pytest.mark.parametrize("span", [0, 9], ids=["even", "uneven"])
def test_what_a_loop_costs_does_not_grow_with_their_number(span: int, scene: Write) -> None:
    def cost(n: int) -> int:
        masses = 10 ** np.random.default_rng(n).uniform(-span, span, 2 * n + 1)
        return int(ladder(scene, masses).scene.notes["acceleration_nodes"])

    first, second, third = map(cost, (4, 8, 16))
    assert third - second == pytest.approx(2 * (second - first), rel=0.1)


def test_what_a_rope_costs_does_not_grow_with_its_pulleys(scene: Write) -> None:
    """Equal masses are even, wherever they hang: one pulley on the line between its neighbours has a slope of zero."""
    def cost(n: int) -> int:
        weights = "".join(f"PointMass w{k}(m = 1, center(x(start = {k}), y(start = -1)), center = rope.pulley[{k}]);"
                          for k in range(1, n + 1))
        rope = f"Rope rope(n = {n}, L = {2 * 2**0.5 + n - 1}, a = world, b = shift(world, {{{n + 1}, 0}}));"
        return int(scene(f"model Hung {rope} {weights} end Hung;").scene.notes["acceleration_nodes"])

    first, second, third = map(cost, (8, 16, 32))
    assert third - second == pytest.approx(2 * (second - first), rel=0.1)


def test_a_massless_bar_in_a_loop_is_a_link(scene: Write) -> None:
    """M is singular with the bar's coordinate, which the loop alone gives."""
    bar = "Revolute A(a = crank.b), B(a = coupler.b, b = rocker.b); Bar coupler(m = 0, L = 1, a = A.b);"
    first, second = (scene(MASSLESS.format(coupler=coupler)).simulate(stop=2, interval=0.1, tolerance=1e-11)
                     for coupler in (bar, "Link rod(L = 1, a = crank.b, b = rocker.b);"))
    np.testing.assert_allclose(first["O.phi"], second["O.phi"], atol=1e-8)
    np.testing.assert_allclose(first["C.w"], second["C.w"], atol=1e-7)


def test_what_is_integrated_needs_no_mass(scene: Write) -> None:
    """An integral and a filter of a coordinate that swings, beside a loop: der(i) = s, der(w) = (s - w)/tau."""
    model = scene("""model M
      Block b(m = 1, base = world, s(start = 1));
      Spring c(k = 4, stretch = b.s);
      Revolute h(a = world, phi(start = 0.3)), k(a = rod.b); Bar rod(m = 1, L = 1, a = h.b);
      Bar arm(m = 1, L = 1, a = k.b);
      PointOnLine eye(line = world, point = arm.b);
      coordinate Real i(unit = "m.s", start = 0, fixed = true);
      coordinate Length w(start = 0, fixed = true);
    equation
      der(i) = b.s; der(w) = (b.s - w)/0.5[s];
    end M;""")
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(stop=5, interval=0.1, tolerance=1e-10, solver=solver)
        t = run.time
        np.testing.assert_allclose(run["b.s"], np.cos(2 * t), atol=1e-8)
        np.testing.assert_allclose(run["i"], np.sin(2 * t) / 2, atol=1e-8)
        # w' + 2 w = 2 cos 2t
        np.testing.assert_allclose(run["w"], (np.cos(2 * t) + np.sin(2 * t) - np.exp(-2 * t)) / 2, atol=1e-8)
        assert np.abs(run.energy.residual).max() < 1e-7


def test_a_mass_is_taken_away_when_the_run_begins(scene: Write) -> None:
    """The formulas compiled for a bar of 1 kg divide by its mass, if not in steps: the run goes over to others, and to those in
    which there is none where it is 0."""
    bar = "Revolute A(a = crank.b), B(a = coupler.b, b = rocker.b); Bar coupler(m = 1, L = 1, a = A.b);"
    model = scene(MASSLESS.format(coupler=bar))
    assert model.suited(check_values(model.scene)) is model
    assert model.suited(check_values(model.scene, {"coupler.m": 0.5})) is model
    assert model.suited(check_values(model.scene, {"coupler.m": 1e-12})).formulas.for_any_mass
    assert "coupler.m" in (model.suited(check_values(model.scene, {"coupler.m": 0})).formulas.massless or ())
    run = model.simulate(stop=2, interval=0.1, tolerance=1e-11, parameters={"coupler.m": 0})
    pull = run["A.reaction"]
    link = scene(MASSLESS.format(coupler="Link rod(L = 1, a = crank.b, b = rocker.b);"))
    other = link.simulate(stop=2, interval=0.1, tolerance=1e-11)
    np.testing.assert_allclose(run["O.phi"], other["O.phi"], atol=1e-8)
    np.testing.assert_allclose(pull, other["rod.reaction"], atol=1e-6)


@pytest.mark.parametrize("m", [1e-9, 1e9])
def test_a_mass_far_from_the_declared_one_costs_no_digits(m: float, scene: Write) -> None:
    """As with that mass declared, for which other formulas were compiled."""
    bar = "Revolute A(a = crank.b), B(a = coupler.b, b = rocker.b); Bar coupler(m = {}, L = 1, a = A.b);"
    runs = [scene(MASSLESS.format(coupler=bar.format(declared))).simulate(
        stop=2, interval=0.1, tolerance=1e-11, parameters={"coupler.m": m}) for declared in (1, m)]
    np.testing.assert_allclose(runs[0]["O.phi"], runs[1]["O.phi"], atol=1e-9)


def test_a_tape_in_python_gives_what_casadi_gives() -> None:
    x = ca.SX.sym("x", 3)
    a, b, c = (x[k] for k in range(3))
    one = [ca.sqrt(a), ca.sin(b), ca.cos(a), ca.tan(b), ca.asin(c), ca.acos(c), ca.atan(a), ca.exp(b), ca.log(a), ca.sinh(b),
           ca.cosh(b), ca.tanh(b), ca.asinh(b), ca.acosh(a), ca.atanh(c), ca.erf(b), ca.floor(b), ca.ceil(b), ca.fabs(b),
           ca.sign(b)]
    two = [a + b, a - b, a * b, a / b, -a, a**2, 2 * a, 1 / a, a**c, a**1.5, ca.atan2(a, b), ca.fmin(a, b), ca.fmax(a, b),
           ca.fmod(a, c), ca.if_else(a < b, a, c), ca.if_else(ca.logic_or(a <= b, a == c), a, b), ca.if_else(a != b, a, b),
           ca.if_else(ca.logic_and(a > b, ca.logic_not(c > a)), a, b), ca.copysign(a, b)]
    function = ca.Function("all", [x], [ca.vertcat(*one, *two)])
    for numbers in ([1.7, -0.4, 0.3], [2.5, 0.9, -0.6]):
        (found,) = evaluate(tape_of(function), numbers)
        np.testing.assert_allclose(found, function(numbers).full().ravel(), rtol=1e-14)
    many = np.array([[1.7, 2.5, 1.1], [-0.4, 0.9, 0.2], [0.3, 0.3, 0.3]])
    (found_each,) = evaluate_each(tape_of(function), [many[0], many[1], 0.3])
    for k in range(3):
        found = [np.broadcast_to(x, 3)[k] for x in found_each]
        np.testing.assert_allclose(found, function(many[:, k]).full().ravel(), rtol=1e-14)
    for bad in (a / b, 1 / b, ca.sqrt(b - 1), ca.log(b)):
        tape = tape_of(ca.Function("bad", [x], [bad]))
        assert np.isnan(evaluate(tape, [1, 0, 0])[0][0])
        assert np.isnan(evaluate_each(tape, [1, np.array([2.0, 0.0]), 0])[0][0]).tolist() == [False, True]


def test_rates_that_do_not_go_together_are_told_as_rates(scene: Write) -> None:
    """A slider crank at its dead centre, whose piston shall move: the loop closes, its rates do not."""
    model = scene("""model Dead World world(gravity = {0, 0});
      Revolute O(a = world, phi(start = 0, fixed = true)), pin(a = crank.b, b = rod.a), wrist(a = rod.b, b = slide.center);
      Bar crank(m = 1, L = 0.1, a = O.b), rod(m = 0.5, L = 0.3);
      Block slide(m = 2, base = world, s(start = 0.4), v(start = 1, fixed = true)); end Dead;""")
    with pytest.raises(lag.LagError, match=r"the rates that are stated at the start do not go together in the loop.* by 1 "):
        model.simulate(stop=0.1)
    assert "do not go together" in model.freedom["problem"]


@pytest.mark.parametrize(("equation", "place"), [
    ("floor(p.center.x/1[m]) + p.center.x/1[m] = 2.5", 1.5),
    ("(if p.center.x > 1 then 1 else 0) + p.center.x/1[m] = 2.5", 1.5),
    ("mod(p.center.x/1[m], 2) = 0.5", 2.5),
])
def test_what_is_linear_between_jumps_gives_no_coordinate(equation: str, place: float, scene: Write) -> None:
    """x + floor(x) = 2.5 gave x = 2.5, with floor(x) as it is at x = 0."""
    model = scene(f"model M PointMass p(m = 1, center(x(start = 2.3))); equation {equation}; end M;")
    assert model.simulate(at=[1])["p.center.x"][0] == pytest.approx(place, abs=1e-12)


def test_jumps_that_leave_no_place_are_told(scene: Write) -> None:
    with pytest.raises(lag.LagError, match="L0606"):
        scene("model M PointMass p(m = 1); equation sign(p.center.x) + p.center.x/1[m] = -0.5; end M;").simulate(at=[1])
