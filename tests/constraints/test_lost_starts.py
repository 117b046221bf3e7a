"""Start values of coordinates that others give: of cut joints, and of those that linear constraints give."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.constraints import assembly
from lagrangia.fmu import export as fmu
from lagrangia.fmu.variables import build_fmu_model

Write = Callable[[str], lag.Model]

FOUR_BAR = """model FourBar
  Revolute A(a = world, {A}), B(a = crank.b, b = coupler.a, {B}), C(a = coupler.b, b = rocker.b, {C}),
           D(a = shift(world, {{2, 0}}), b = rocker.a, {D});
  Bar crank(m = 1, L = 0.5, a = A.b), coupler(m = 1, L = 2), rocker(m = 1, L = 1.5);
end FourBar;"""
ROUGH = {"A": "phi(start = 60[deg])", "B": "phi(start = -0.5)", "C": "phi(start = 1)", "D": "phi(start = 100[deg])"}

START = {"A": 1, "B": -0.4, "C": 0.95, "D": 1.6}  # each within what the loop lets its joint reach


def four_bar(**starts: str) -> str:
    """Joints in the order of the loop; those left out have no start."""
    return FOUR_BAR.format(**dict.fromkeys("ABCD", "") | starts).replace(", )", ")")


def begin(model: lag.Model, **options: object) -> dict[str, float]:
    run = model.simulate(stop=1e-9, interval=1e-9, **options)
    return {name: float(run[name][0]) for name in run.names}


def require_closed(start: dict[str, float]) -> None:
    """The rocker's end, by either way round the loop: a check that knows nothing of cuts."""
    A, B, C, D = (start[f"{name}.phi"] for name in "ABCD")
    by_crank = 0.5 * np.exp(1j * A) + 2 * np.exp(1j * (A + B))
    assert abs(by_crank - (2 + 1.5 * np.exp(1j * D))) < 1e-12
    assert math.remainder(A + B + C - D, 2 * math.pi) == pytest.approx(0, abs=1e-12)


def cut(model: lag.Model) -> set[str]:
    return set(model.compilation.graph.cut_coordinates)


@pytest.mark.parametrize("joint", "ABCD")
def test_one_guess_holds_whichever_joint_has_it(joint: str, scene: Write) -> None:
    """A loop is cut at a joint that nobody guessed."""
    value = START[joint]
    model = scene(four_bar(**{joint: f"phi(start = {value})"}))
    assert f"{joint}.phi" not in cut(model)
    start = begin(model)
    assert start[f"{joint}.phi"] == value
    require_closed(start)


@pytest.mark.parametrize("joint", "ABCD")
@pytest.mark.parametrize("fixed", [", fixed = true", ""])
def test_one_rate_holds_whichever_joint_has_it(joint: str, fixed: str, scene: Write) -> None:
    start = begin(scene(four_bar(**{"A": "phi(start = 1)", joint: f"phi(start = {START[joint]}), w(start = 2{fixed})"})))
    assert start[f"der({joint}.phi)"] == pytest.approx(2, rel=1e-13)
    require_closed(start)


@pytest.mark.parametrize("joint", "ABCD")
def test_a_fixed_value_holds_where_every_joint_has_a_start(joint: str, scene: Write) -> None:
    """One of them is cut all the same."""
    text = f"phi(start = {START[joint]}, fixed = true), w(start = 3, fixed = true)"
    model = scene(four_bar(**ROUGH | {joint: text}))
    assert cut(model) <= {"A.phi", "B.phi", "C.phi", "D.phi"} and len(cut(model)) == 1
    start = begin(model)
    assert start[f"{joint}.phi"] == pytest.approx(START[joint], abs=1e-12)
    assert start[f"der({joint}.phi)"] == pytest.approx(3, abs=1e-11)
    require_closed(start)


def test_a_guess_of_the_cut_joint_chooses_the_assembly(scene: Write) -> None:
    """Crank held, all the others guessed near one of the two assemblies."""
    found = {}
    for sign in (1, -1):
        held = begin(scene(four_bar(A="phi(start = 1, fixed = true)", D=f"phi(start = {sign * 1.6})")))
        near = {k: f"phi(start = {held[f'{k}.phi'] + 0.05})" for k in "BCD"}
        again = begin(scene(four_bar(**near | {"A": "phi(start = 1, fixed = true)"})))
        found[sign] = again["C.phi"]
        assert again["C.phi"] == pytest.approx(held["C.phi"], abs=1e-11)
    assert found[1] * found[-1] < 0


def test_a_guess_of_the_cut_joint_counts_among_others(scene: Write) -> None:
    """Guesses that cannot all hold: the nearer the guess of the cut joint is to what the others say, the nearer it comes out."""
    starts = [begin(scene(four_bar(**ROUGH | {"C": f"phi(start = {guess})"})))["C.phi"] for guess in (0.95, 1.1, 1.25)]
    assert starts == sorted(starts)
    assert starts[-1] - starts[0] > 0.05


def test_values_given_for_a_run_hold_for_the_cut_joint(scene: Write) -> None:
    model = scene(four_bar(**ROUGH))
    (name,) = cut(model)
    start = begin(model, initial={name: 0.95, f"der({name})": -2})
    assert (start[name], start[f"der({name})"]) == pytest.approx((0.95, -2), abs=1e-11)
    require_closed(start)
    again = begin(model)
    assert again[name] != pytest.approx(0.95, abs=1e-3)


def test_a_value_for_a_joint_without_start_says_what_to_do(scene: Write) -> None:
    model = scene(four_bar(A="phi(start = 1)", B="phi(start = 0)", D="phi(start = 1.5)"))
    with pytest.raises(lag.LagError, match=r"'C\.phi' follows from the coordinates.*\n.*declare a start for 'C\.phi'"):
        model.simulate(initial={"C.phi": 1})


def test_the_command_takes_a_cut_joint_with_its_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "m.lag"
    file.write_text(four_bar(**ROUGH))
    out = tmp_path / "m.csv"
    assert main(["simulate", str(file), "--stop", "1e-9", "-o", str(out), "--initial", "C.phi=54[deg]"]) == 0
    names, first = (line.split(",") for line in out.read_text().splitlines()[:2])
    assert float(first[names.index("C.phi")]) == pytest.approx(math.radians(54), abs=1e-12)
    assert main(["simulate", str(file), "-o", str(out), "--initial", "C.phi=nan"]) == 2
    assert "finite" in capsys.readouterr().err


def test_fixed_values_that_cannot_hold_point_at_one_of_them(scene: Write) -> None:
    model = scene(four_bar(**ROUGH | {"C": "phi(start = 0.8, fixed = true)"}))  # the least is 0.8411
    with pytest.raises(lag.LagError, match="this cannot hold at the start"):
        model.simulate()


def test_both_implementations_agree(scene: Write) -> None:
    for starts in (ROUGH, ROUGH | {"C": "phi(start = 1.1, fixed = true), w(start = 2)"}, ROUGH | {"B": "w(start = 1)"}):
        made = scene(four_bar(**starts)).compilation
        x, worst = assembly.begin(made.kinematics, made.initial, made.functions.table).assemble()
        names = [c.name for c in (*made.graph.coordinates, *made.initial.lost)]
        assert worst == -1
        assert made.initial.lost
        start = begin(scene(four_bar(**starts)))
        np.testing.assert_allclose([start[name] for name in names], x[: len(names)], rtol=1e-9, atol=1e-9)
        rates = [start[f"der({name})"] for name in names]
        np.testing.assert_allclose(rates, x[len(names) :], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("L", [1e-6, 1e6])
def test_a_cut_slider_keeps_its_fixed_start(L: float, scene: Write) -> None:
    """Two slides on a ladder of length 5 L: 3 and 4, or 4 and 3."""
    start = begin(scene(f"""model Ladder
      Prismatic x(a = world, along = {{1, 0}}, s(start = {4 * L}, fixed = true)),
                y(a = world, along = {{0, 1}}, s(start = {2 * L}));
      PointMass p(m = 1, center = x.b), q(m = 2, center = y.b);
    equation
      distance(p.center, q.center) = {5 * L};
    end Ladder;"""))
    assert start["x.s"] == 4 * L
    assert start["y.s"] == pytest.approx(3 * L, rel=1e-12)


GEARS = """model Gears
  Revolute a(a = world{a}), b(a = shift(world, {{3, 0}}){b});
  Disc p(m = 1, r = 1, center = a.b), q(m = 4, r = 2, center = b.b);
  Gear mesh(a = p.center, b = q.center, carrier = world, r_a = 1, r_b = 2);
end Gears;"""


@pytest.mark.parametrize("joint", "ab")
@pytest.mark.parametrize("fixed", [", fixed = true", ""])
def test_a_gear_starts_where_either_wheel_is_put(joint: str, fixed: str, scene: Write) -> None:
    start = begin(scene(GEARS.format(**{"a": "", "b": ""} | {joint: f", phi(start = 1{fixed}), w(start = 3{fixed})"})))
    assert (start[f"{joint}.phi"], start[f"der({joint}.phi)"]) == pytest.approx((1, 3), rel=1e-13)
    assert start["der(a.phi)"] == pytest.approx(-2 * start["der(b.phi)"], rel=1e-13)


def test_guesses_of_both_wheels_are_weighed_and_a_fixed_one_holds(scene: Write) -> None:
    both = begin(scene(GEARS.format(a=", phi(start = 1)", b=", phi(start = 1)")))
    assert -0.5 < both["b.phi"] < 1 and both["a.phi"] == pytest.approx(-2 * both["b.phi"], rel=1e-12)
    for fixed, other in (("a", "b"), ("b", "a")):
        start = begin(scene(GEARS.format(**{fixed: ", phi(start = 1, fixed = true)", other: ", phi(start = 1)"})))
        assert start[f"{fixed}.phi"] == pytest.approx(1, rel=1e-13)


def test_two_fixed_wheels_that_do_not_mesh_are_refused(scene: Write) -> None:
    model = scene(GEARS.format(a=", phi(start = 1, fixed = true)", b=", phi(start = 1, fixed = true)"))
    with pytest.raises(lag.LagError, match="this cannot hold at the start"):
        model.simulate()


def test_a_fixed_rate_holds_beside_heavy_parts(scene: Write) -> None:
    """A light crank, a heavy rocker, and the rate stated for the crank."""
    text = four_bar(A="phi(start = 1), w(start = 2, fixed = true)").replace("rocker(m = 1", "rocker(m = 1e6")
    assert begin(scene(text))["der(A.phi)"] == 2


def test_a_fixed_start_and_an_initial_equation_for_one_coordinate_are_refused(scene: Write) -> None:
    with pytest.raises(lag.LagError, match="L0601"):
        scene("""model M
          Revolute h(a = world, phi(start = 1, fixed = true)); Bar p(m = 1, L = 1, a = h.b);
        initial equation
          h.phi = 2;
        end M;""")


@pytest.mark.parametrize("guess", [-1, 0.3, 1, 1.3, 3])
def test_a_guess_out_of_reach_is_moved(guess: float, scene: Write) -> None:
    """The rocker guessed where crank and coupler, stretched, do not reach it; nobody guessed them."""
    start = begin(scene(four_bar(D=f"phi(start = {guess})")))
    require_closed(start)
    assert start["D.phi"] * guess > 0


def test_a_sweep_over_the_start_of_a_cut_joint_says_what_to_do(scene: Write) -> None:
    model = scene(four_bar(**ROUGH))
    with pytest.raises(lag.LagError, match="make it a parameter"):
        model.simulate_many(initial={"C.phi": [0.9, 1.0]})


def test_an_fmu_begins_where_the_cut_joint_is_fixed(scene: Write) -> None:
    model = scene(four_bar(**ROUGH | {"C": "phi(start = 0.95, fixed = true)"}))
    found = build_fmu_model(model)
    start = begin(model)
    names = [c.name for c in (*model.scene.coordinates, *model.scene.rates)]
    np.testing.assert_allclose(found.state_start, [start[name] for name in names], atol=1e-13)
    assert len(found.nominal) == 2 * model.scene.n


def test_an_fmu_without_a_mass_has_formulas_for_it(scene: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = scene(four_bar(A="phi(start = 1)"))
    exported: list[lag.Model] = []
    monkeypatch.setattr(fmu, "export_fmus", lambda model, *_: exported.append(model))
    model.export_fmu(tmp_path / "m.fmu")
    model.export_fmu(tmp_path / "m.fmu", parameters={"coupler.m": 0})
    assert [m.formulas.for_any_mass for m in exported] == [False, True]


PRESCRIBED = """model M
  Revolute A(a = world, {start}); Bar p(m = 1, L = 1, a = A.b);
  Motion m(of = A.phi, to = 2[rad/s]*time);
end M;"""


@pytest.mark.parametrize(("start", "gap"), [("w(start = 5, fixed = true)", "3 (m/s or rad/s)"),
                                            ("phi(start = 5, fixed = true)", "5 (m or rad)")])
def test_a_fixed_start_beside_a_prescribed_motion_is_refused(start: str, gap: str, scene: Write) -> None:
    model = scene(PRESCRIBED.format(start=start))
    assert f"misses by {gap}" in model.freedom["problem"]
    with pytest.raises(lag.LagError, match="this cannot hold at the start"):
        model.simulate()


def test_a_guess_beside_a_prescribed_motion_is_moved(scene: Write) -> None:
    start = begin(scene(PRESCRIBED.format(start="phi(start = 0.5), w(start = 5)")))
    assert (start["A.phi"], start["der(A.phi)"]) == pytest.approx((0, 2), abs=1e-12)


def test_rates_of_a_loop_that_contradict_name_it(scene: Write) -> None:
    """Crank and rocker turn at rates that the coupler forbids."""
    model = scene(four_bar(A="phi(start = 1, fixed = true), w(start = 2, fixed = true)", D="w(start = 0, fixed = true)"))
    assert "the loop world - A - crank" in model.freedom["problem"]
    assert "(m/s or rad/s)" in model.freedom["problem"]


def test_two_cut_joints_beside_many_coordinates_begin(scene: Write) -> None:
    """Their rates are two below eight others: 'bug: Mismatching number of rows'."""
    text = four_bar(**ROUGH).replace("end FourBar;", """
      Revolute a(a = shift(world, {5, 0}), phi(start = 1)), b(b = long.a, phi(start = -0.5)),
        c(a = long.b, b = short.b, phi(start = 1)), d(a = shift(world, {7, 0}), b = short.a, phi(start = 1.75));
      Bar drive(m = 1, L = 0.5, a = a.b), long(m = 1, L = 2), short(m = 1, L = 1.5);
      Revolute hinge[8](each a = shift(world, {9, 0})); Bar bar[8](each m = 1, each L = 1);
    equation
      connect(drive.b, b.a);
      for i in 1:8 loop connect(hinge[i].b, bar[i].a); end for;
    end FourBar;""")
    model = scene(text)
    assert len({*model.scene.lost} & {"C.phi", "c.phi"}) == 2 and len(model.coordinate_names) >= 8
    require_closed(begin(model))
