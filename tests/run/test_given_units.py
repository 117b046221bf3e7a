"""Values that are given to a scene have units as in a text: what has another one is refused, what fits is converted."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main

SCENE = """model M
  parameter Real c = 3, d = 2[m], e = 2*d, part = 0.5;
  parameter Integer n = 3;
  parameter AngularVelocity w = 1;
  constant Real k = 2;
  input Real u = 1;
  Block b(m = 1, base = world, s(start = d));
  Revolute r(a = b.center);
  Bar bar(m = 1, L = n*1[m], a = r.b);
  output Real z = k + 1[1], y = c*n*k + w*1[s] + u + part + e/1[m], where = b.s, rest = b.s;
  annotation(experiment(StopTime = 0.001));
end M;"""


@pytest.mark.parametrize(("option", "value", "message"), [
    ("-p", "c=3[m]", "it is in m, but no unit is declared"), ("-p", "n=3[m]", "'n' is in 1, this is in m"),
    ("-p", "k=3[s]", "s and rad (or no unit) cannot be added"), ("-p", "d=3[s]", "it is in s, but m is wanted"),
    ("-p", "w=3[Hz]", "turns and radians a second are 6.28 apart"), ("-p", "e=3[N]", "no unit is declared"),
    ("--initial", "r.w=3[Hz]", "turns and radians a second are 6.28 apart"), ("-u", "u=3[m]", "no unit is declared"),
])
def test_a_unit_that_does_not_fit_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str, value: str,
                                             message: str) -> None:
    (tmp_path / "m.lag").write_text(SCENE)
    for command in (["simulate"], ["sweep", "--outputs", "final(b.s)"]):
        if command == ["simulate"] or value[0] not in "nk":
            assert main([*command, str(tmp_path / "m.lag"), option, value, "-o", str(tmp_path / "m.csv")]) == 2
            assert message in capsys.readouterr().err
    assert not (tmp_path / "m.csv").exists()


@pytest.mark.parametrize(("option", "value", "column", "right"), [
    ("-p", "d=3[mm]", "where", 0.003), ("-p", "part=30[%]", "y", 3*3*2 + 1 + 1 + 0.3 + 4),
    ("-p", "c=30[deg]", "y", math.pi + 6.5), ("-p", "w=60[rpm]", "y", 18 + 2*math.pi + 1 + 0.5 + 4), ("-p", "c=4", "y", 24 + 6.5),
])
def test_what_fits_is_converted(tmp_path: Path, option: str, value: str, column: str, right: float) -> None:
    (tmp_path / "m.lag").write_text(SCENE)
    assert main(["simulate", str(tmp_path / "m.lag"), option, value, "-o", str(tmp_path / "m.csv")]) == 0
    names, row = (tmp_path / "m.csv").read_text().splitlines()[:2]
    assert float(row.split(",")[names.split(",").index(column)]) == pytest.approx(right, abs=1e-12)


def test_bounds_are_in_the_unit_of_what_is_measured(scene: Callable[[str], lag.Model]) -> None:
    model = scene(SCENE)
    with pytest.raises(lag.LagError, match="it is in s, but m is wanted"):
        model.measure("first_time(b.s > 1[s])")
    for bound in ("b.s > 1[mm]", "rest > 1[mm]"):  # an output Real that is bound to a length
        assert model.measure(f"first_time({bound})") == {f"first_time({bound})": 0.0}
    with pytest.raises(lag.LagError, match="no unit is declared"):
        model.measure("settling_time(b.s, 0.1[m])")


def test_outputs_are_in_the_unit_of_what_they_are_bound_to(scene: Callable[[str], lag.Model]) -> None:
    model = scene("""model M
        Block b(m = 1, base = world, v(start = 1)); Spring s(k = 4, stretch = b.s);
        output Real y = b.s/1[m]; output Real z = 1000*b.s; output Real w = b.s; output Real e; output Real d = der(w);
      equation e = b.s; annotation(experiment(StopTime = 1)); end M;""")
    assert [c.unit for c in model.scene.outputs] == ["", "", "m", "m", "m/s"]
    right = math.asin(0.6)/2
    for bound in ("y > 0.3", "z > 300", "w > 300[mm]", "e > 30[cm]"):
        assert model.measure(f"first_time({bound})") == {f"first_time({bound})": pytest.approx(right, abs=1e-9)}
    for bound, why in (("y > 0.3[m]", "no unit is declared"), ("z > 300[mm]", "no unit is declared"), ("w > 1[s]", "m is wanted"),
                       ("d > 1[m]", "m/s is wanted"), ("der(y) > 1[m/s]", "1/s is wanted")):
        with pytest.raises(lag.LagError, match=why):
            model.measure(f"first_time({bound})")


# -------------------------------------------------------------------- remainders


@pytest.mark.parametrize("expression", ["rem(b.s, 1[s])", "div(b.s, 1[s])", "mod(b.s, 1[s])", "max(b.s, 1[s])",
                                        "atan2(b.s, 1[s])", "norm({b.s, 1[s]})",
                                        "rem(b.s, 1[m]) + 1[s]", "div(b.s, 1[m]) + 1[m]"])
def test_remainders_are_of_like_quantities(scene: Callable[[str], lag.Model], expression: str) -> None:
    with pytest.raises(lag.LagError) as error:
        scene(f"model M Block b(m = 1, base = world); output Real y = {expression}; end M;")
    assert {x.code for x in error.value.diagnostics} == {"L0304"}


def test_remainders_have_the_units_of_what_is_divided(scene: Callable[[str], lag.Model]) -> None:
    model = scene("""model M Block b(m = 1, base = world, s(start = -2.5)); output Length y = rem(b.s, 1[m]), z = rem(b.s, 2);
      output Real n = div(b.s, 0.7[m]); output Length half = div(b.s, 2)*1[m]; end M;""")
    run = model.simulate(stop=0.01)
    assert [run[name][0] for name in ("y", "z", "n", "half")] == [-0.5, -0.5, -3.0, -1.0]


# -------------------------------------------------------------------- inertias

TURNED = """model M
  parameter Angle al = 0.3, be = 0.7;
  parameter Real R[3,3] = {{cos(al)*cos(be), -sin(al), cos(al)*sin(be)},
    {sin(al)*cos(be), cos(al), sin(al)*sin(be)}, {-sin(be), 0, cos(be)}};
  parameter Inertia D[3,3] = {{0.1, 0, 0}, {0, 0.23, 0}, {0, 0, 0.33}};
  Spherical h(a = world, w(start = {1, 0.2, 0.1}));
  Body b(m = 1, I = %s, center = h.b);
end M;"""


@pytest.mark.parametrize("changed", [{}, {"al": 0.4}])
def test_turned_inertias_are_symmetric_within_rounding(scene: Callable[[str], lag.Model], changed: dict[str, float]) -> None:
    product = "R*D*transpose(R)"
    turned, same = (scene(TURNED % I).simulate(stop=1, tolerance=1e-12, parameters=changed)
                    for I in (product, f"0.5*({product} + transpose({product}))"))
    for name in ("h.w[1]", "h.w[2]", "h.w[3]"):
        np.testing.assert_allclose(turned[name], same[name], atol=1e-12)


def test_inertias_that_are_not_symmetric_are_refused(scene: Callable[[str], lag.Model]) -> None:
    model = scene(TURNED % "R*D*transpose(R)")
    for name in ("D[1,2]", "b.I[1,2]"):
        with pytest.raises(lag.LagError, match="not symmetric"):
            model.simulate(parameters={name: 0.01})
    with pytest.raises(lag.LagError, match="not symmetric"):
        scene(TURNED % "R*D*transpose(R) + {{0, 1e-9, 0}, {0, 0, 0}, {0, 0, 0}}")


def test_inertias_of_sweeps_and_prepared_runs_are_looked_at(scene: Callable[[str], lag.Model]) -> None:
    """As those of single runs."""
    model = scene(TURNED % "D")
    table = model.simulate_many(parameters={"D[1,2]": [0.01, 0.01, 0.4], "D[2,1]": [0.01, 0, 0.4]}, together=True, stop=0.1)
    assert table.failures == {1: "the inertia 'b.I' is not symmetric", 2: "the inertia 'b.I' is negative about an axis"}
    run = model.prepare(parameters={"D[1,2]": 0, "D[2,1]": 0}, stop=0.1)
    run((), (0.01, 0.01))
    for given, told in (((0.01, 0), "not symmetric"), ((0.4, 0.4), "negative about an axis")):
        with pytest.raises(lag.LagError, match=told):
            run((), given)
