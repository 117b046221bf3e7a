"""`lag import`: arguments that our components have under no name, starts of blocks, and conversions of units."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.editor.modelica_import import imported

UNITS = """model Units
  import Modelica.Units.Conversions.from_deg;
  import pi = Modelica.Constants.pi;
  parameter Modelica.Units.SI.AngularVelocity w0 = Modelica.Units.Conversions.from_rpm(60);
  parameter Real k(unit = "N.m/rad", displayUnit = "N.m/deg") = 2*pi;
  Modelica.Mechanics.Rotational.Components.Inertia i(J = 3.6/Modelica.SIunits.Conversions.to_kmh(1),
    phi(start = from_deg(10 + 20), fixed = true), w(start = w0, fixed = true));
  Modelica.Mechanics.Rotational.Components.Spring s(c = k);
  Modelica.Mechanics.Rotational.Components.Fixed f(phi0 = 2*from_deg(5));
equation
  connect(i.flange_b, s.flange_a);
  connect(s.flange_b, f.flange);
end Units;
"""
BLOCKS = """model Control
  import Modelica.Blocks.*;
  Modelica.Blocks.Sources.Trapezoid t(amplitude = 10, rising = 0.2, width = 0.3, falling = 0.1, period = 1, nperiod = 2,
    offset = -1, startTime = 0.1);
  Continuous.FirstOrder lag1(T = 0.5, k = 2, initType = Modelica.Blocks.Types.Init.InitialOutput, y_start = 3);
  Modelica.Mechanics.Translational.Sources.Force force, slow;
  Modelica.Mechanics.Translational.Components.Mass m(m = 2), n(m = 1);
equation
  connect(t.y, force.f);
  connect(force.flange, m.flange_a);
  connect(t.y, lag1.u);
  connect(lag1.y, slow.f);
  connect(slow.flange, n.flange_a);
end Control;
"""


def test_conversions_of_units_are_written_out(tmp_path: Path) -> None:
    (tmp_path / "units.mo").write_text(UNITS, encoding="utf-8")
    assert main(["import", str(tmp_path / "units.mo")]) == 0
    run = lag.load(tmp_path / "units.lag").simulate(at=[1.0], tolerance=1e-12)
    w = np.sqrt(2 * np.pi)
    found = np.pi / 18 + np.pi / 9 * np.cos(w) + 2 * np.pi / w * np.sin(w)
    assert run["i.phi"][-1] == pytest.approx(found, abs=1e-11)


def test_blocks_start_as_they_are_told(tmp_path: Path) -> None:
    """The areas of two trapezoids; and the lag takes what is left of the areas: y' = (2 u - y)/T."""
    (tmp_path / "control.mo").write_text(BLOCKS, encoding="utf-8")
    assert main(["import", str(tmp_path / "control.mo")]) == 0
    run = lag.load(tmp_path / "control.lag").simulate(at=[3.0], tolerance=1e-11)
    assert run["m.v"][-1] == pytest.approx((2 * 10 * 0.45 - 3) / 2, abs=1e-10)
    assert run["n.v"][-1] == pytest.approx(2 * (2 * 10 * 0.45 - 3) + 0.5 * (3 - run["lag1.y"][-1]), abs=1e-9)


@pytest.mark.parametrize(("declared", "left", "told"), [
    ("Translational.Components.ElastoGap g(c = 1, n = 1, d = 2)", "Translational.ElastoGap g(c = 1, d = 2)", []),
    ("Translational.Components.ElastoGap g(c = 1, n = 1.5)", "Translational.ElastoGap g(c = 1)", ["n = 1.5 of g"]),
    ("Rotational.Components.Clutch a(fn_max = 2, w_small = 1), b(fn_max = 1, foo(x = 1, y = {1, 2}))",
     "Rotational.Clutch a(fn_max = 2), b(fn_max = 1)", ["foo(x = 1, y = {1, 2}) of b"]),
    ("Translational.Components.ElastoGap g(c = 1, n = 1.0)", "Translational.ElastoGap g(c = 1)", []),
    ("Translational.Components.Mass g(m = 1, n = 1)", "Translational.Mass g(m = 1)", ["n = 1 of g"]),
    ("Rotational.Components.Inertia a(J = 1, x = 2, y = 3) if is_on, b(z = 1, J = 1)",
     "Rotational.Inertia a(J = 1) if is_on, b(J = 1)", ["x = 2 of a", "y = 3 of a", "z = 1 of b"]),
    ("Rotational.Components.Inertia a(J = 2, // kg.m2, (of all\n phi(start = 1), /* w */ w(start = 3) /* at rest */)",
     "Rotational.Inertia a(J = 2, // kg.m2, (of all\n phi(start = 1), /* w */ w(start = 3) /* at rest */)", []),
    ("Rotational.Components.Inertia a(/* of */ J = 2, // kg.m2\n x = 1 /* at rest */)",
     "Rotational.Inertia a(/* of */ J = 2// kg.m2\n /* at rest */)", ["x = 1 of a"]),
    ("Rotational.Components.Inertia a(J = 2, // kg.m2\n stateSelect /* of */ = StateSelect.prefer)",
     "Rotational.Inertia a(J = 2// kg.m2\n /* of */)", []),
])
def test_arguments_that_ours_have_not_are_told(declared: str, left: str, told: list[str]) -> None:
    found = imported(f"model M Modelica.Mechanics.{declared}; end M;")
    assert f"{left};" in found.text and [x.partition(" (Trans")[0].partition(" (Rota")[0] for x in found.left_out] == told


@pytest.mark.parametrize(("block", "way", "is_told"), [
    ("PI", "InitialState", False), ("PI", "InitialOutput", True), ("Integrator", "InitialOutput", False),
    ("SecondOrder", "SteadyState", True), ("FirstOrder", "NoInit", False),
])
def test_starts_that_are_not_ours_are_told(block: str, way: str, is_told: bool) -> None:
    found = imported(f"model M Modelica.Blocks.Continuous.{block} b(initType = Modelica.Blocks.Types.Init.{way}, k = 1); end M;")
    assert f"Blocks.{block} b(k = 1);" in found.text and bool(found.left_out) == is_told


@pytest.mark.parametrize(("statement", "kept"), [
    ("Continuous.FirstOrder b(k = 1, initType = if x then Types.Init.SteadyState else Types.Init.NoInit);", "b(k = 1);"),
    ("Continuous.FirstOrder b(k = 1, initType = Types.Init.SteadyState // NoInit\n);", "b(k = 1// NoInit\n);"),
    ("extends Continuous.FirstOrder(k = 1, initType = Types.Init.SteadyState);", "extends Blocks.FirstOrder(k = 1);"),
    ("A a(b(initType = Types.Init.NoInit));", "// left out: A a("), ("parameter Types.Init b;", "// left out: parameter"),
    ("parameter Types.Init b = Types.Init.NoInit;", "// left out: parameter"),
    ("parameter Real x = Conversions.from_deg(u = 30);", "// left out: parameter"),
    ("function f = Conversions.from_deg;", "// left out: function"), ("extends Conversions.from_deg;", "// left out: extends"),
])
def test_what_cannot_be_written_is_told(statement: str, kept: str) -> None:
    for package, around in {"Continuous.": "Blocks.", "Types.": "Blocks.", "Conversions.": "Units."}.items():
        statement = statement.replace(package, f"Modelica.{around}{package}")
    found = imported(f"model M {statement} end M;")
    assert kept in found.text and len(found.left_out) == 1


def test_a_name_pi_of_the_text_is_not_that_of_the_library() -> None:
    found = imported("model M constant Real pi = Modelica.Constants.pi; Real x = Modelica.Units.Conversions.from_deg(pi); end M;")
    assert "pi = 3.141592653589793; Real x = (3.141592653589793/180*(pi));" in found.text and not found.left_out


def test_arguments_beside_a_redeclaration_are_those_of_others() -> None:
    found = imported("""package P
      partial model A
        replaceable Modelica.Mechanics.Rotational.Components.Spring s(c = 1)
          constrainedby Modelica.Mechanics.Rotational.Interfaces.PartialCompliant;
        Modelica.Mechanics.Rotational.Components.Inertia b(J = 1);
      end A;
      model B
        extends A(redeclare Modelica.Mechanics.Rotational.Components.SpringDamper s(c = 1, d = 2, m = 1), b(J = 4));
      end B;
    end P;""")
    assert "Rotational.SpringDamper s(c = 1, d = 2), b(J = 4));" in found.text and len(found.left_out) == 1
    assert "constrainedby Rotational.Compliant;" in found.text


def test_what_means_nothing_here_may_have_any_value() -> None:
    found = imported("""model M
        Modelica.Blocks.Nonlinear.Limiter l(homotopyType = Modelica.Blocks.Types.LimiterHomotopy.NoHomotopy, uMax = 2);
        end M;""")
    assert "Blocks.Limiter l(uMax = 2);" in found.text and not found.left_out


def test_what_follows_on_the_line_of_what_is_left_out_stays() -> None:
    gone = "Modelica.Blocks.Discrete.Sampler s;"
    found = imported(f"model M {gone} Real x = 1; {gone} /* of\n two */ Real y; {gone} // more\n Real z = x; end M;")
    assert len(found.left_out) == 3
    rest = [line.partition("//")[0].strip() for line in found.text.splitlines()]
    assert [line for line in rest if line] == ["model M", "Real x = 1;", "/* of", "two */ Real y;", "Real z = x; end M;"]
