"""Inputs where functions of time may stand: places, prescribed coordinates, energies; in runs, FMUs, studies and exports."""

import importlib.util
import itertools
import math
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from scipy.linalg import expm

import lagrangia as lag
from helpers.fmus import KINDS, VERSIONS, instance_of, unpacked
from lagrangia.command.cli import main
from lagrangia.run.input_pieces import InputTable
from lagrangia.run.request import check_values

ROAD = """model Road
  input Length y;
  Frame road = shift(world, {0, y});
  Prismatic guide(a = world, along = {0, 1});
  PointMass p(m = 2, center = guide.b);
  AxialSpring s(a = road, b = guide.b, k = 100, along = {0, 1});
  AxialDamper d(a = road, b = guide.b, c = 3, along = {0, 1});
end Road;"""
CUBIC = np.array([0.01, 0.2, -0.3, 0.05])  # y(t), the constant first
PARABOLA = np.array([0, 0.1, -0.2, 0])
STOP = 2.0


def model(folder: Path, text: str, **options: object) -> lag.Model:
    (folder / "scene.lag").write_text(text)
    return lag.load(folder / "scene.lag", **options)


def road(t: np.ndarray, order: int = 0, y: np.ndarray = CUBIC) -> np.ndarray:
    return np.polynomial.Polynomial(y).deriv(order)(t) if order else np.polynomial.Polynomial(y)(t)


def exact(t: float, y: np.ndarray = CUBIC) -> np.ndarray:
    """s, s' of 2 s'' + 3 (s' - y') + 100 (s - y) = -2 g from rest, by the exponential of it with 1, t, t^2, t^3 beside."""
    A = np.zeros((6, 6))
    A[0, 1], A[1, 0], A[1, 1] = 1, -50, -1.5
    A[1, 2:] = 50 * y + 1.5 * np.array([y[1], 2 * y[2], 3 * y[3], 0])
    A[1, 2] -= 9.81
    A[3, 2], A[4, 3], A[5, 4] = 1, 2, 3
    return (expm(A * t) @ [0, 0, 1, 0, 0, 0])[:2]


@pytest.mark.parametrize("solver", ["auto", "erk9", "implicit", "taylor", "adams", "casadi:cvodes"])
def test_a_road_as_a_spline(solver: str, tmp_path: Path) -> None:
    """The spline of a cubic is the cubic."""
    t = np.array([0, 0.3, 0.5, 1.1, 1.2, 1.9, 2.0])
    given = (t, {"y": road(t), "der(y)": lag.slopes(t, road(t))})
    run = model(tmp_path, ROAD).simulate(stop=STOP, inputs=given, solver=solver, tolerance=1e-12)
    miss = 1e-8 if solver == "casadi:cvodes" else 1e-11
    assert [run["guide.s"][-1], run["guide.v"][-1]] == pytest.approx(exact(STOP), abs=miss)
    assert run.statistics.energy_residual < 100 * miss


def test_a_constant_with_rates_goes_on_with_them(tmp_path: Path) -> None:
    """y = 0.1 t - 0.2 t^2 from the start of the run, which is not that of the model."""
    run = model(tmp_path, ROAD).simulate(start=1, stop=3, inputs={"der(y)": 0.1, "der(der(y))": -0.4}, tolerance=1e-12)
    assert run["guide.s"][-1] == pytest.approx(exact(2.0, PARABOLA)[0], abs=1e-11)


def test_rates_that_jump_are_impulses(tmp_path: Path) -> None:
    """The support of a pendulum at rest sets off with the speed v: the mass stays where it is, der(phi) = -v/L."""
    scene = model(tmp_path, """model M
      input Length x;
      Revolute hinge(a = shift(world, {x, 0}), phi(start = -90[deg]));
      Frame tip = shift(hinge.b, {0.5, 0});
      PointMass p(m = 3, center = tip);
    end M;""")
    run = scene.simulate(stop=2, at=[0.999, 1 + 1e-9], inputs=([0, 1, 2], {"x": [0, 0, 0.7]}), tolerance=1e-12)
    assert run["der(hinge.phi)"] == pytest.approx([0, -0.7 / 0.5], abs=1e-8)
    run = scene.simulate(stop=1.4, inputs=([0, 1, 2], {"x": [0, 0, 0.7]}), tolerance=1e-12)
    assert run.statistics.energy_residual < 1e-10


FOUR_BAR = """model FourBar
  {drive}
  Revolute o(a = world, phi(start = 1)), p(a = crank.b), q(a = rod.b), e(a = shift(world, {{0.9, 0}}), b = rocker.a);
  Bar crank(m = 1, L = 0.3, a = o.b), rod(m = 1, L = 1, a = p.b), rocker(m = 1, L = 0.8, b = q.b);
  Motion motor(of = o.phi, to = drive);
  output Torque M = motor.reaction;
end FourBar;"""


def test_an_input_drives_a_loop(tmp_path: Path) -> None:
    """As the same function of time: with two rows 1 + 3 t, with one and its rate the same."""
    t = model(tmp_path, FOUR_BAR.format(drive="Angle drive = 1 + 3*time;")).simulate(stop=2, tolerance=1e-11)
    driven = model(tmp_path, FOUR_BAR.format(drive="input Angle drive(start = 0.8);"))
    for given in (([0, 2], {"drive": [1, 7]}), {"drive": 1, "der(drive)": 3}):
        u = driven.simulate(stop=2, inputs=given, tolerance=1e-11)
        for name in ("q.phi", "der(q.phi)", "M"):
            assert u[name] == pytest.approx(t[name], abs=1e-9), name


@pytest.mark.parametrize(("kind", "name"), [("potential", "{u}*s^2/2"), ("kinetic", "({u} - 99[N/m])*1[kg.m/N]*der(s)^2/2")])
def test_energies_with_inputs(kind: str, name: str, tmp_path: Path) -> None:
    """Those of a function of time, with the power that it gives."""
    text = """model M
      {u}
      coordinate Length s(start = 0.1);
    energy
      kinetic 2[kg]*der(s)^2/2;
      {kind} {term};
      potential 10[N/m]*s^2/2;
    end M;"""
    t = model(tmp_path, text.format(u="Stiffness k = 100 + 50*time/1[s];", kind=kind, term=name.format(u="k"))).simulate(
        stop=2, tolerance=1e-12)
    u = model(tmp_path, text.format(u="input Stiffness k;", kind=kind, term=name.format(u="k"))).simulate(
        stop=2, inputs=([0, 2], {"k": [100, 200]}), tolerance=1e-12)
    assert u["s"] == pytest.approx(t["s"], abs=1e-11)
    assert u.energy.work == pytest.approx(t.energy.work, abs=1e-10)
    assert u.statistics.energy_residual < 1e-10


def test_limits_and_constants_of_the_library(tmp_path: Path) -> None:
    """k, c and F of springs, dampers and friction follow an input: m s'' = -k(t) s - c(t) s' as the function of time has it."""
    text = """model M
      {u}
      Prismatic g(a = world, s(start = 0.3));
      PointMass p(m = 2, center = g.b);
      Spring s(stretch = g.s, k = 50[N/m]*u); Damper d(rate = g.v, c = (1 + u)*1[N.s/m]);
      DryFriction f(rate = g.v, F = 0.3[N]*u);
    end M;"""
    t = model(tmp_path, text.format(u="Real u = 1 + time/1[s];")).simulate(stop=2, tolerance=1e-12)
    u = model(tmp_path, text.format(u="input Real u;")).simulate(stop=2, inputs=([0, 2], {"u": [1, 3]}), tolerance=1e-12)
    assert u["g.s"] == pytest.approx(t["g.s"], abs=1e-11)


def test_the_rate_of_an_input_in_a_force(tmp_path: Path) -> None:
    """It was 0, without a word."""
    text = ROAD.replace("  AxialSpring s(a = road, b = guide.b, k = 100, along = {0, 1});\n", "").replace(
        "  AxialDamper d(a = road, b = guide.b, c = 3, along = {0, 1});\n",
        "  AppliedForce f(at = guide.b, force = {0, -100*(guide.s - y) - 3*(guide.v - der(y))});\n").replace(
        "  Frame road = shift(world, {0, y});\n", "")
    t = np.linspace(0, 2, 5)
    run = model(tmp_path, text).simulate(stop=STOP, inputs=(t, {"y": road(t), "der(y)": road(t, 1)}), tolerance=1e-12)
    assert run["guide.s"][-1] == pytest.approx(exact(STOP)[0], abs=1e-11)


def test_python_and_c_have_the_same_pieces(tmp_path: Path) -> None:
    model(tmp_path, ROAD)
    scene = lag.Model(tmp_path / "scene.lag", outputs=("y", "der(y)", "der(der(y))"))
    t, at = np.array([0.2, 0.5, 0.9, 1.4]), np.linspace(0, 2, 30)
    for columns in ({"y": road(t)}, {"y": road(t), "der(y)": np.cos(t)}):
        run = scene.simulate(at=at, inputs=(t, columns))
        values = check_values(scene.scene, inputs=(t, columns))
        found = InputTable(scene.scene, values, 0.0).at(at)
        assert np.array([run[name] for name in ("y", "der(y)", "der(der(y))")]) == pytest.approx(found, abs=1e-12)


def test_studies(tmp_path: Path) -> None:
    """The input and its rate in B, and (k + i w c)/(k - m w^2 + i w c)."""
    scene = model(tmp_path, ROAD)
    linear = scene.linearize(outputs=["guide.s"])
    assert (linear.inputs, linear.excitations) == (("y", "der(y)"), ("y",))
    assert linear.B.tolist() == [pytest.approx([0, 0]), pytest.approx([50, 1.5])]
    response = scene.response(outputs=["guide.s"], frequencies=[0.5, 1.3])
    w = 2 * np.pi * response.frequencies
    assert response.of("guide.s") == pytest.approx((100 + 3j * w) / (100 - 2 * w**2 + 3j * w), rel=1e-12)
    (rest,) = scene.equilibrium(inputs={"y": 0.1})
    assert rest.position["guide.s"] == pytest.approx(0.1 - 2 * 9.81 / 100)


def test_sweeps_and_steps(tmp_path: Path) -> None:
    scene = model(tmp_path, ROAD)
    t = np.linspace(0, 2, 6)
    given = (t, {"y": road(t), "der(y)": road(t, 1)})
    found = scene.simulate_many(parameters={"p.m": [1.0, 2.0]}, outputs=["final(guide.s)"], stop=STOP, inputs=given,
                                tolerance=1e-12)
    assert found["final(guide.s)"][1] == pytest.approx(exact(STOP)[0], abs=1e-10)
    run = scene.start(inputs={"y": float(road(0.0)), "der(y)": float(road(0.0, 1)), "der(der(y))": float(road(0.0, 2))},
                      tolerance=1e-12)
    for k in range(400):
        now = 0.005 * k
        run.set({"y": road(now), "der(y)": road(now, 1), "der(der(y))": road(now, 2)})
        kept = run.save()
        run.step(0.005)
    assert run["guide.s"] == pytest.approx(exact(STOP)[0], abs=1e-7)  # third derivatives are not told
    there = run["guide.s"]
    run.restore(kept)
    run.step(0.005)
    assert run["guide.s"] == there
    run.set({"y": 1.0})
    with pytest.raises(lag.RunError, match=r"'y' moves places, and jumps by 1.39 .* give der\(y\)"):
        run.step(0.005)


def test_exports(tmp_path: Path) -> None:
    """The accelerations by u, u', u'': -(k (s - y) + c (v - y'))/m - g."""
    scene = model(tmp_path, ROAD)
    assert main(["export", str(tmp_path / "scene.lag"), "--to", "python", "-o", str(tmp_path / "scene.py")]) == 0
    spec = importlib.util.spec_from_file_location("scene", tmp_path / "scene.py")
    assert spec is not None and spec.loader is not None
    exported = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(exported)
    p = exported.parameters([x.value or 0.0 for x in scene.scene.parameters])
    wanted = -(100 * (0.3 - 0.1) + 3 * (0.7 - 0.2)) / 2 - 9.81
    assert exported.rhs(0.4, [0.3], [0.7], [0.1, 0.2, 0.9], p) == pytest.approx([wanted])
    assert scene.functions()["rhs"](0.4, 0.3, 0.7, [0.1, 0.2, 0.9], p).full().ravel() == pytest.approx([wanted])
    assert scene.derivatives()["jacobian_u"](0.4, 0.3, 0.7, [0.1, 0.2, 0.9], p).full()[0] == pytest.approx([50, 1.5, 0])


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_fmus(version: str, kind: str, tmp_path_factory: pytest.TempPathFactory, capfd: pytest.CaptureFixture[str]) -> None:
    """Told the input with its rates a hundred times: of a parabola that is all."""
    folder = tmp_path_factory.mktemp("fmu")
    model(folder, ROAD)
    t = np.linspace(0, STOP, 101)
    table = [("time", t), *((name, road(t, k, PARABOLA)) for k, name in enumerate(("y", "der(y)", "der(y,2)")))]
    signals = np.array([*zip(*(x for _, x in table), strict=True)], dtype=[(name, float) for name, _ in table])
    path = str(unpacked(folder / "scene.lag", version))
    run = fmpy.simulate_fmu(path, fmi_type=kind, stop_time=STOP, step_size=0.02, output_interval=0.02, input=signals,
                            relative_tolerance=1e-10, output=["guide.s"])
    miss = 1e-10 if kind == "CoSimulation" else 1e-6
    assert run["guide.s"][-1] == pytest.approx(exact(STOP, PARABOLA)[0], abs=miss)
    capfd.readouterr()
    with pytest.raises(Exception, match="failed with status 3"):  # a logger of ours would stay behind in FMPy, when we are gone
        fmpy.simulate_fmu(path, fmi_type=kind, stop_time=STOP, step_size=0.02, input=signals[["time", "y"]])
    assert version == "3" or "an input that moves a support jumps" in capfd.readouterr().out


def test_a_first_derivative_of_fmi_2_moves_a_road_along_straight_lines(tmp_path: Path) -> None:
    """As a table of the same points does, from row to row."""
    scene, t = model(tmp_path, ROAD), np.linspace(0, STOP, 21)
    straight = scene.simulate(at=[STOP], tolerance=1e-11, inputs=(t, {"y": road(t)}))
    one = instance_of(tmp_path / "scene.lag", "2", "CoSimulation").start({"y": road(t[0])}, tolerance=1e-11)
    for begin, end in itertools.pairwise(t):
        one.set({"y": road(begin)})
        one.fmu.setRealInputDerivatives([one.reference["y"]], [1], [(road(end) - road(begin)) / (end - begin)])
        one.step(begin, end - begin)
    assert one.get("guide.s")[0] == pytest.approx(straight["guide.s"][0], abs=1e-10)
    one.free()


def test_at_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    model(tmp_path, ROAD.replace("input Length y;", "input Length y; input Force F;").replace(
        "end Road", "AppliedForce f(at = guide.b, force = {0, F}); end Road"))
    t = np.array([0, 0.3, 0.5, 1.1, 1.2, 1.9, 2.0])
    rows = [f"{a!r},{b!r}\n" for a, b in zip((1000 * t).tolist(), (1000 * road(t)).tolist(), strict=True)]
    (tmp_path / "road.csv").write_text("t [ms],y [mm]\n" + "".join(rows))
    (tmp_path / "F.csv").write_text("0,0\n0.7,0\n3,0\n")
    assert main("simulate scene.lag --stop 2 --tolerance 1e-12 -u y=road.csv:cubic -u F=F.csv -o out.csv".split()) == 0
    names, *_, last = (tmp_path / "out.csv").read_text().splitlines()
    assert float(dict(zip(names.split(","), last.split(","), strict=True))["guide.s"]) == pytest.approx(exact(STOP)[0], abs=1e-10)
    capsys.readouterr()
    for given, code, what in (("-u y=road.csv:steps", 2, "'y' moves places, and jumps at t = 0.3"),
                              ("-u F=F.csv:cubic", 2, "the input 'F', which moves no places, as a smooth table"),
                              ("-u y=road.csv:cubic -o road.csv", 2, "a result does not take its place")):
        assert main(f"simulate scene.lag {given}".split()) == code
        assert what in capsys.readouterr().err


def test_what_is_refused(tmp_path: Path) -> None:
    scene = model(tmp_path, ROAD)
    with pytest.raises(lag.LagError, match=r"'y' moves places, and jumps at t = 1:"):
        scene.simulate(inputs=([0, 1, 1, 2], {"y": [0, 0, 1, 1]}))
    with pytest.raises(lag.LagError, match=r"a table of 'y' tells its rate, der\(y\), and nothing of der\(der\(y\)\)"):
        scene.simulate(inputs=([0, 1], {"y": [0, 0], "der(der(y))": [1, 1]}))
    with pytest.raises(lag.LagError, match="not supported yet: written equations of places that inputs move"):
        scene.equations()
    with pytest.raises(lag.LagError, match="'cubic' or 'monotone'"):
        lag.slopes([0, 1], [0, 1], "rough")


SLIDER = ("model M input Real u; parameter Real c = 0.2; {}PointMass p(m = 1, center = r.b); "
          "{}annotation(experiment(StopTime = 4)); end M;")
ON_A_FRAME = ("Frame f = shift(world, {{{}*1[m], 0}}); Prismatic r(a = f); ", "")
ON_A_SLIDER = ("Prismatic x(a = world), r(a = x.b); ", "equation x.s = {}*1[m]; ")
TIMES, GIVEN = [0.0, 0.7, 1.3, 2.0, 3.1, 4.0], [-0.8, 0.9, -0.7, 0.6, -0.5, 0.7]
BENDS: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "max(0, u - c)": lambda u, _: np.maximum(0, u - 0.2),
    "max(-0.5, min(0.5, u))": lambda u, _: np.clip(u, -0.5, 0.5),
    "abs(u - 0.3*time/1[s])": lambda u, t: abs(u - 0.3 * t),
    "abs(u^2 - 0.25)": lambda u, _: abs(u * u - 0.25),
    "abs(exp(u) - 1)": lambda u, _: abs(np.exp(u) - 1),
    "(sign(u)*u + abs(c - u))": lambda u, _: abs(u) + abs(u - 0.2),
    "(if u < 0 then -u elseif u < 0.3 then 0 else u - 0.3)": lambda u, _: np.where(u < 0, -u, np.maximum(0, u - 0.3)),
}


@pytest.mark.parametrize("law", BENDS)
def test_what_slides_on_a_support_does_not_mind_where_its_input_bends(law: str, tmp_path: Path) -> None:
    """It goes on as the support began, whatever this does, and its account closes (12 J of 98 J beside a sign)."""
    at, begin = np.linspace(0, 4, 14), np.array([0.0, 1e-4, 2e-4])
    x, first = (BENDS[law](np.interp(t, TIMES, GIVEN), t) for t in (at, begin))
    wanted = x[0] + (-3 * first[0] + 4 * first[1] - first[2]) / 2e-4 * at - x
    for (support, equation), solver in ((ON_A_FRAME, "auto"), (ON_A_SLIDER, "erk"), (ON_A_FRAME, "implicit")):
        text = SLIDER.format(support.format(law), equation.format(law))
        run = model(tmp_path, text).simulate(at=at, inputs=(TIMES, {"u": GIVEN}), solver=solver, tolerance=1e-9)
        np.testing.assert_allclose(run["r.s"], wanted, rtol=0, atol=1e-6, err_msg=solver)
        assert not run.statistics.energy_is_open


SPELLINGS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "max(0, u - c)": lambda u: np.maximum(0, u - 0.2), "max(u - c, 0)": lambda u: np.maximum(0, u - 0.2),
    "-min(0, c - u)": lambda u: np.maximum(0, u - 0.2), "2*max(0, -u)": lambda u: 2 * np.maximum(0, -u),
    "abs(u)": abs, "abs(c - u)": lambda u: abs(u - 0.2), "sign(u)*u": abs, "u*sign(u - c)": lambda u: u * np.sign(u - 0.2),
    "min(0.5, max(0, u - c))": lambda u: np.clip(u - 0.2, 0, 0.5),
    "(if c < u then u - c else 0)": lambda u: np.maximum(0, u - 0.2), "(if -u < 0 then u else 0)": lambda u: np.maximum(0, u),
    "(if u > c then 1 else 0)": lambda u: np.where(u > 0.2, 1.0, 0.0),
}


@pytest.mark.parametrize("law", ["max(0, u - c)", "abs(u)", "-min(0, c - u)", "sign(u)*u", "min(0.5, max(0, u - c))",
                                 "abs(c - u) + 2*max(0, -u)"])
def test_outputs_repeat_bends_of_supports_as_they_are(law: str, tmp_path: Path) -> None:
    """Each bend is held as it was found: the first was 0 where it is 0.8, and -1.2 where it is 0."""
    told = "".join(f"output Real R{k} = {other}; " for k, other in enumerate(SPELLINGS))
    places = "output Length F = f.x; output Length X = p.center.x; "
    scene = model(tmp_path, SLIDER.format(ON_A_FRAME[0].format(law), places + told))
    at, rows = np.array([0, 0.4, 1, 2, 2.9, 3.6, 4]), ([0, 1, 2, 4], {"u": [-1, 1, -1, 1]})
    u = np.interp(at, rows[0], rows[1]["u"])
    run = scene.simulate(at=at, inputs=rows, tolerance=1e-9)
    for k, (name, value) in enumerate(SPELLINGS.items()):
        np.testing.assert_allclose(run[f"R{k}"], value(u), rtol=0, atol=1e-12, err_msg=name)
    f = sum(SPELLINGS[part](u) for part in law.split(" + "))
    np.testing.assert_allclose(run["F"], f, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["X"], f + run["r.s"], rtol=0, atol=1e-12)
    swept = scene.simulate_many(parameters={"c": [0.2, 0.2]}, outputs=["final(F)", "final(R0)"], inputs=rows, tolerance=1e-9)
    np.testing.assert_allclose([swept["final(F)"][0], swept["final(R0)"][0]], [f[-1], 0.8], rtol=0, atol=1e-12)


def test_cubic_inputs_bend_supports_where_they_pass_a_level(tmp_path: Path) -> None:
    """Rows tell rates, too: three times in the second part, as t^3 - 0.16 t does."""
    t, tilt = np.array([-1.0, -0.5, 0.5, 1.0]), 0.16
    rows = {"u": t**3 - tilt * t, "der(u)": 3 * t**2 - tilt}
    at = np.linspace(0, 2, 21)
    wanted = abs(at - 1) * abs((at - 1) ** 2 - tilt)
    scene = model(tmp_path, SLIDER.format(ON_A_FRAME[0].format("abs(u)"), ""))
    run = scene.simulate(at=at, inputs=(t + 1, rows), tolerance=1e-10)
    np.testing.assert_allclose(run["r.s"], wanted[0] + (3 - tilt) * -at - wanted, rtol=0, atol=1e-8)
    found = scene.simulate_many(parameters={"p.m": [1.0, 2.0]}, outputs=["final(r.s)"], stop=2, inputs=(t + 1, rows),
                                tolerance=1e-10)
    np.testing.assert_allclose(found["final(r.s)"], run["r.s"][-1], rtol=0, atol=1e-8)


def test_a_step_that_an_input_sets_strikes_dampers_as_one_in_time_does(tmp_path: Path) -> None:
    text = ("model M input Real u; World world(gravity = {{0, 0}}); "
            "Frame road = shift(world, {{0, 0.05*(if {} then 1 else 0)*1[m]}}); "
            "Block b(m = 2, base = world, along = {{0, 1}}); AxialSpring s(a = road, b = b.center, k = 300, along = {{0, 1}}); "
            "AxialDamper d(a = road, b = b.center, c = 5, along = {{0, 1}}); output Real U = u; end M;")
    scenes = (model(tmp_path, text.format(when)) for when in ("u > -0.4", "time > 0.6"))
    driven, timed = (scene.simulate(at=[0.5, 0.7, 2], inputs=([0, 2], {"u": [-1, 1]}), tolerance=1e-10) for scene in scenes)
    np.testing.assert_allclose(driven["b.s"], timed["b.s"], rtol=0, atol=1e-9)


@pytest.mark.parametrize(("version", "kind"), [*zip(VERSIONS, reversed(KINDS), strict=True)])
def test_fmus_know_where_inputs_bend_supports(version: str, kind: str, tmp_path: Path) -> None:
    """Told the input and its rates between communication points; in Model Exchange by an event indicator."""
    t, u = np.linspace(0, STOP, 101), np.polynomial.Polynomial([-0.3, 0.7, -0.1])
    model(tmp_path, SLIDER.format(ON_A_FRAME[0].format("abs(u)"), ""))
    rows = [*zip(t, u(t), u.deriv()(t), u.deriv(2)(t), strict=True)]
    signals = np.array(rows, dtype=[(name, float) for name in ("time", "u", "der(u)", "der(u,2)")])
    run = fmpy.simulate_fmu(str(unpacked(tmp_path / "scene.lag", version)), fmi_type=kind, stop_time=STOP, step_size=0.02,
                            output_interval=0.02, input=signals, relative_tolerance=1e-10, output=["r.s"])
    assert run["r.s"][-1] == pytest.approx(0.3 - 0.7 * STOP - abs(u(STOP)), abs=1e-9 if kind == "CoSimulation" else 1e-5)


def test_inputs_that_bend_supports_at_unknown_times_are_refused(tmp_path: Path) -> None:
    """Smooth where it is 0, it is not."""
    with pytest.raises(lag.LagError, match="L0914"):
        model(tmp_path, SLIDER.format(ON_A_FRAME[0].format("max(0, sin(u))"), "")).simulate(inputs={"u": 1})
    run = model(tmp_path, SLIDER.format(ON_A_FRAME[0].format("max(0, sin(u))^2"), "")).simulate(inputs={"u": 1}, at=[1])
    assert run["p.center.x"][0] == pytest.approx(math.sin(1) ** 2, abs=1e-9)
