"""table(x, xs, ys): in time two or three numbers a segment, elsewhere a sum that grows with its points."""

from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.compile.pipeline import compile_file
from lagrangia.native.build import find_compiler

Scene = Callable[[str], lag.Model]
XS, YS = [-1.0, 0.2, 0.5, 2.0, 2.25], [3.0, -1.0, -2.0, 4.0, 4.0]
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def listed(values: object) -> str:
    return "{" + ", ".join(repr(float(x)) for x in np.ravel(values)) + "}"


def test_along_a_coordinate(scene: Scene) -> None:
    """Value, rate and force of a potential, beside NumPy's, at points, between them and beyond their ends."""
    text = f"""model Track
      parameter Real xs[5] = {listed(XS)}; parameter Real high = 4;
      Block block(m = 1, base = world);
      output Real height = table(block.s/1[m], xs, {{3, -1, -2, high, 4}});
      output Real climb = der(height);
      energy potential 2[J]*table(block.s/1[m], xs, {{3, -1, -2, high, 4}});
    end Track;"""
    model = scene(text)
    motion, functions = model.compilation.motion, model.functions()
    outputs = functions["outputs"]
    slopes = np.diff(YS) / np.diff(XS)
    for s in (-3, -1, -0.4, 0.2, 0.3, 0.5, 1.9999, 2.0, 2.1, 2.25, 7):
        k = np.searchsorted(XS, s, side="right") - 1
        slope = slopes[k] if 0 <= k < len(slopes) else 0.0
        values = {"q": [s], "v": [1.5], "p": model.parameter_values(), "a": [0.7]}
        found = outputs.call({name: values[name] for name in values if name in outputs.name_in()})
        assert np.array(found["y"]).ravel() == pytest.approx([np.interp(s, XS, YS), 1.5 * slope], abs=1e-14)
        force = ca.Function("force", [motion.q, motion.v, motion.t, motion.p], [motion.acceleration])
        assert float(force(s, 0, 0, values["p"])) == pytest.approx(-2 * slope, abs=1e-14)


TIMED = """model Timed
  parameter Real amplitude = 2; parameter Real xs[4] = {0, 1, 1.5, 3}; parameter Real ys[4] = {0, 2, -1, 0.5};
  Block a(m = 1, base = world), b(m = 1, base = world), c(m = 1, base = world), d(m = 1, base = world);
  AppliedForce fa(at = a.center, force = {table(2*time - 0.5, xs, ys), 0});
  AppliedForce fb(at = b.center, force = {table(2*time - 0.5, xs, {0, amplitude, -1, 0.5}), 0});
  AppliedForce fc(at = c.center, force = {table(2*time - 0.5, xs, {0, 2, -2, 0.5}), 0});
  AppliedForce fd(at = d.center, force = {table(2*time - 0.5, xs, {0, 2, -1, b.s*1[N/m]}), 0});
  output Real v[4] = {a.v, b.v, c.v, d.v};
end Timed;"""


@needs_compiler
@pytest.mark.parametrize("amplitude", [2.0, 5.0])
def test_in_time(amplitude: float, scene: Scene) -> None:
    """Each from its own numbers, also where two differ by one of them; of the last one an entry moves."""
    model = scene(TIMED)
    assert model.scene.sizes["n_modes"] < model.scene.sizes["n_events"] + 12
    end = 1.5
    result = model.simulate(at=[end], tolerance=1e-11, parameters={"amplitude": amplitude})
    t = np.linspace(0, end, 300_001)
    for name, ys in {"a": [0, 2, -1, 0.5], "b": [0, amplitude, -1, 0.5], "c": [0, 2, -2, 0.5]}.items():
        force = np.interp(2 * t - 0.5, [0, 1, 1.5, 3], ys)
        assert result[f"{name}.v"][-1] == pytest.approx(np.trapezoid(force, t), abs=1e-9)
    assert abs(result["d.v"][-1] - result["a.v"][-1]) > 1e-3


T = 0.7
PERIODIC = {
    "if mod(time/1[s], T) < 0.3*T then 2[N] else -1[N]": ([0, 0.3 * T, 0.3 * T, T], [2, 2, -1, -1]),
    "if mod(time/1[s] - 0.1, T) >= 0.2 then 2[N] else -1[N]": ([0, 0.1, 0.1, 0.3, 0.3, T], [2, 2, -1, -1, 2, 2]),
    "1[N]*table(mod(time/1[s], T), {0, 0.2, 0.35, 0.7}, {1, 3, -1, 0})": ([0, 0.2, 0.35, T], [1, 3, -1, 0]),
    "1[N]*table(time/1[s] - T*floor(time/T/1[s]), {0.1, 0.2, 0.5}, {1, 3, -1})": ([0, 0.1, 0.2, 0.5, T], [1, 1, 3, -1, -1]),
    "1[N]*table(mod(-2*time/1[s], 2*T), {0, 0.4, 0.9, 1.4}, {1, 3, -1, 1})": ([0, 0.25, 0.5, T], [1, -1, 3, 1]),
}


@needs_compiler
@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
@pytest.mark.parametrize("force", PERIODIC)
def test_what_comes_again_meets_its_corners(force: str, solver: str, scene: Scene) -> None:
    """Of a pattern of period T: its area is the velocity, to rounding. Beside it, a pendulum that is no part of it."""
    model = scene(f"""model Again
      parameter Real T = {T};
      Block a(m = 1, base = world); AppliedForce f(at = a.center, force = {{{force}, 0}});
      Revolute pin(a = world); Bar bar(m = 1, L = 1, a = pin.b);
    end Again;""")
    end, (corners, values) = 5.03, PERIODIC[force]
    t = np.concatenate([T * k + np.array(corners) for k in range(8)])
    forces = np.tile(values, 8).astype(float)
    last = np.searchsorted(t, end)
    there = forces[last - 1] + (forces[last] - forces[last - 1]) * (end - t[last - 1]) / (t[last] - t[last - 1])
    area = np.trapezoid([*forces[:last], there], [*t[:last], end])
    result = model.simulate(at=[end], tolerance=1e-6, solver=solver)
    assert result["der(a.s)"][-1] == pytest.approx(area, abs=1e-12)


@needs_compiler
def test_a_road_of_many_points(scene: Scene) -> None:
    """A profile in time moves a support; every corner of it is an event."""
    xs = np.linspace(0, 2, 501)
    ys = 0.01 * np.sin(xs * xs * 5)
    text = f"""model Road
      parameter Real xs[501] = {listed(xs)}; parameter Real ys[501] = {listed(ys)};
      Block car(m = 3, base = world);
      Frame road = shift(world, {{1[m]*table(time/1[s], xs, ys), 0}});
      AxialSpring spring(k = 300, a = road, b = car.center);
      annotation(experiment(StopTime = 2));
    end Road;"""
    model = scene(text)
    result = model.simulate(at=[2.0], tolerance=1e-12)
    assert result.statistics.events == 499  # its ends are none
    q, v, w = 0.0, 0.0, 10.0
    for x, step, y, slope in zip(xs, np.diff(xs), ys, np.diff(ys) / np.diff(xs), strict=False):
        assert x >= 0
        e, f = q - y, v - slope  # about the line, the motion is that of a free oscillator
        c, s = np.cos(w * step), np.sin(w * step)
        q, v = y + slope * step + e * c + f / w * s, slope - e * w * s + f * c
    assert result["car.s"][-1] == pytest.approx(q, abs=1e-12)


@pytest.mark.parametrize(("x", "growth"), [("block.s/1[m]", 4.2), ("time/1[s]", 1.05)])
def test_operations_grow_no_faster_than_points(x: str, growth: float, tmp_path: Path) -> None:
    counts = []
    for n in (50, 200):
        points = np.arange(n)
        text = f"""model Track
          parameter Real xs[{n}] = {listed(points)}; parameter Real ys[{n}] = {listed(np.sin(points))};
          Block block(m = 1, base = world), car(m = 2, base = world);
          Frame road = shift(world, {{block.s, 1[m]*table({x}, xs, ys)}});
          Spring spring(k = 5, a = road, b = car.center);
        end Track;"""
        (tmp_path / "scene.lag").write_text(text, encoding="utf-8")
        counts.append(compile_file(tmp_path / "scene.lag").scene.notes["rhs_operations"])
    assert counts[1] < growth * counts[0]


@needs_compiler
def test_points_in_time_are_events_though_a_value_moves(scene: Scene) -> None:
    text = """model Moving
      Block a(m = 1, base = world);
      AppliedForce f(at = a.center, force = {table(time, {0.2, 0.5, 0.9}, {0, 1[N] + sin(1[rad/s]*time)*1[N], a.s*1[N/m]}), 0});
    end Moving;"""
    model = scene(text)
    result = model.simulate(stop=1.2, tolerance=1e-10, initial={"der(a.s)": 1})
    assert result.statistics.events == 3
    assert result.statistics.energy_residual < 1e-9


def test_points_that_parameters_make_fall(scene: Scene) -> None:
    """Each of the lines is one of the table: of the points, the first that x is less than counts."""
    text = """model Falling
      parameter Real middle = 0.4;
      Block a(m = 1, base = world);
      output Real y = table(a.s/1[m], {0.2, middle, 0.5}, {1, 2, -1});
    end Falling;"""
    model = scene(text)
    outputs = model.functions()["outputs"]
    for s in np.linspace(0, 1, 101):
        found = outputs.call({"q": [s], "p": model.parameter_values({"middle": 0.7})})["y"]
        assert -1 <= float(found) <= 2


@pytest.mark.parametrize("points", ["{0.5 + p, 1, 1}", "{0.5 + p, 1, 0.7}"])
def test_points_that_do_not_rise(points: str, scene: Scene) -> None:
    with pytest.raises(lag.LagError, match="L0303"):
        scene(f"""model Equal
          parameter Real p = 0; Block a(m = 1, base = world);
          AppliedForce f(at = a.center, force = {{table(time/1[s], {points}, {{0, 1, 1}})*1[N], 0}});
        end Equal;""")


def test_a_long_table_is_not_written_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for n, code in ((5, 0), (101, 2)):
        table = f"table(block.s/1[m], {listed(range(n))}, {listed(range(n))})"
        text = f"model Track Block block(m = 1, base = world); energy potential 2[J]*{table}; end Track;"
        (tmp_path / "scene.lag").write_text(text, encoding="utf-8")
        assert main(["equations", str(tmp_path / "scene.lag")]) == code
        assert ("L0712" in capsys.readouterr().err) == bool(code)


GAS = """model Gas "An offset slider crank under the pressure of a gas: a force that bends along the stroke, in a closed loop"
  parameter Length r = 40[mm], L = 130[mm], e = 12[mm];
  Revolute O(a = world, phi(start = 0.5, fixed = true), w(start = 30, fixed = true)), pin(a = crank.b, b = rod.a),
           wrist(a = rod.b, b = piston.center);
  Bar crank(m = 0.6, L = r, a = O.b), rod(m = 0.4, L = L);
  Body fly(m = 5, I = 0.02, center = O.b);
  Block piston(m = 0.35, base = shift(world, {0, e}), along = {1, 0}, s(start = 0.16));
  AppliedForce gas(at = piston.center,
    force = {table(piston.s, {90[mm], 110[mm], 140[mm], 170[mm]}, {0[N], -40[N], -150[N], -900[N]}), 0});
  TorsionDamper load(a = world, b = O.b, c = 0.004);
end Gas;"""


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10, 1e-11])
def test_bends_of_a_force_in_a_loop_are_no_rounding(scene: Scene, tolerance: float) -> None:
    """Steps over bends were taken for steps beside singular positions: 1.3e-4 rad at 1e-8, 2e-5 at 1e-11."""
    run = scene(GAS).simulate(at=[1.0], tolerance=tolerance)
    assert run["O.phi"][-1] == pytest.approx(35.71498118, abs=max(700 * tolerance, 3e-8))
    assert run.statistics.tolerance_missed == 0


def test_energies_are_known_where_all_rows_lie_at_rest(scene: Scene) -> None:
    """An oscillator with a soft and a hard side, rows at its turning points alone: the account was measured by its own errors."""
    model = scene("""model Bilinear World world(gravity = {0, 0}); Block b(m = 1, base = world, s(start = 1));
      AppliedForce f(at = b.center, force = {table(b.s, {-1, 0, 1}, {2500[N], 0[N], -1[N]}), 0}); end Bilinear;""")
    run = model.simulate(at=[3.204424506661589, 6.408849013323178], tolerance=1e-10)
    assert run.warnings == []
    assert run.statistics.energy_size > 0.1
