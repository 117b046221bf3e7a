"""`lag import`: Modelica files become .lag files that run; what has no counterpart is told."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import lagrangia as lag
from lagrangia.command.cli import DONE, FAILED, main
from lagrangia.editor.modelica_import import imported

DRIVE = """within ;
model Drive "Two wheels with a gear"
  extends Modelica.Icons.Example;
  import SI = Modelica.Units.SI;
  parameter SI.Inertia Jmotor(min=0)=0.1 "of the motor"; // kept
  parameter Modelica.SIunits.RotationalDampingConstant damping = 10;
  Modelica.Mechanics.Rotational.Components.Inertia a(J=Jmotor, w(fixed=true, start=3)) annotation (Placement(
        transformation(extent={{-38,-8},{-22,8}})));
  Modelica.Mechanics.Rotational.Components.IdealGear gear(ratio=10, useSupport=true);
  Modelica.Mechanics.Rotational.Components.Inertia b(J=2, phi(fixed=true, start=0), stateSelect=StateSelect.always);
  Modelica.Mechanics.Rotational.Components.Damper damper(d=damping, useHeatPort=false);
  Modelica.Mechanics.Rotational.Components.Fixed fixed;
  Modelica.Blocks.Sources.Sine sine(amplitude=4, freqHz=0.5);
  Modelica.Mechanics.Rotational.Sources.Torque torque annotation (Placement(transformation(extent={{-68,-8},{-52,8}})));
equation
  connect(a.flange_b, gear.flange_a) annotation (Line(points={{-22,0},{-18,0}}));
  connect(gear.flange_b, b.flange_a);
  connect(damper.flange_a, b.flange_b);
  connect(damper.flange_b, fixed.flange);
  connect(gear.support, fixed.flange);
  connect(sine.y, torque.tau) annotation (Line(points={{-81.2,0},{-69.6,0}}, color={0,0,127}));
  connect(torque.flange, a.flange_a);
  annotation (Documentation(info="<html>connect(a; b) \\"text\\"</html>"), experiment(StopTime=1.0, Tolerance=1e-10));
end Drive;
"""


def test_a_drive_train_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("drive.mo").write_text(DRIVE, encoding="utf-8")
    assert main(["import", "drive.mo"]) == 0
    text = Path("drive.lag").read_text(encoding="utf-8")
    assert "// kept" in text and "Placement" not in text and "Icons" not in text and "stateSelect" not in text
    assert main(["format", "--check", "drive.lag"]) == 0
    run = lag.load("drive.lag").simulate(at=[1.0], tolerance=1e-12)
    J = 0.1 * 100 + 2  # of b: J b.w' = 40 sin(pi t) - 10 b.w, from 0.3
    A = np.array([[-10 / J, 40 / J, 0], [0, 0, np.pi], [0, -np.pi, 0]])
    assert run["b.w"][0] == pytest.approx((expm(A) @ [0.3, 0, 1])[0], abs=1e-11)
    assert main(["import", "drive.mo"]) == 2
    assert "is there already" in capsys.readouterr().err


def test_what_has_no_counterpart_is_left_out_and_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "hot.mo"
    heat = "Modelica.Thermal.HeatTransfer.Components.HeatCapacitor hot(C=1,\n    T(start=[1, 2; 3, 4]));\nequation\n"
    file.write_text(DRIVE.replace("equation\n", f"{heat}  connect(hot.port, damper.heatPort);\n", 1), encoding="utf-8")
    assert main(["import", str(file)]) == 1
    told = capsys.readouterr().err
    assert "HeatCapacitor hot(C=1, T(start=[1, 2; 3, 4]));" in told and "connect(hot.port, damper.heatPort);" in told
    assert lag.load(tmp_path / "hot.lag").simulate(stop=0.1)["b.w"][0] == pytest.approx(0.3)


def test_texts_that_cannot_be_imported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = (("a.mo", "model A\n  Real x", "L0105"), ("a.urdf", "<robot/>", "L0730"), ("b.mo", "model A end B;", "L01"))
    for name, text, code in wrong:
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert main(["import", str(tmp_path / name)]) == 2
        assert code in capsys.readouterr().err
    assert not list(tmp_path.glob("*.lag"))


@pytest.mark.parametrize("text", ["", "within;\n", "// nothing\n"])
def test_a_file_without_classes_is_refused(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "empty.mo"
    file.write_text(text)
    assert main(["import", str(file)]) == 2
    assert "it has no class" in capsys.readouterr().err and not (tmp_path / "empty.lag").exists()


def test_units_of_which_all_are_imported() -> None:
    """Other words stay what they are: each one was Real."""
    text = imported("""model C
  import Modelica.Units.SI.*;
  import Modelica.Constants.*;
  parameter Torque T = 3*own.e;
  parameter MomentOfInertia J = 2;
end C;
""").text
    assert "parameter Torque T = 3*own.e;" in text and "parameter Inertia J = 2;" in text


def test_names_that_the_library_itself_uses() -> None:
    """Its own examples name packages from where they stand."""
    found = imported("within Modelica.Mechanics.Translational.Examples;\nmodel A\n  SI.Length x;\n  Components.Mass m(m=1);\n"
                     "  Rotational.Sensors.SpeedSensor s;\n  Sensors.MultiSensor q;\n  Sensors.Other o;\nend A;\n")
    assert "Length x;" in found.text and "Translational.Mass m(m=1);" in found.text and "Rotational.SpeedSensor s;" in found.text
    assert "Translational.MultiSensor q;" in found.text
    assert found.left_out == ("Sensors.Other o;",)


def test_arguments_of_peoples_own_classes_stay() -> None:
    """What means nothing here of the library's components may be a parameter of one's own."""
    text = "model A\n  Own own(mode=2, smoothness=0.5);\nend A;\n"
    assert imported(text).text == text
    assert imported(f"// of mine\nwithin Modelica.Mechanics.Rotational;\n{text}").text == f"// of mine\n\n{text}"


def test_components_go_back_to_modelica(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
                                        ) -> None:
    """What is imported, and written for Modelica with its components, is imported as the same text."""
    monkeypatch.chdir(tmp_path)
    Path("drive.mo").write_text(DRIVE, encoding="utf-8")
    assert main(["import", "drive.mo"]) == 0
    assert main(["export", "drive.lag", "--to", "modelica", "--components", "-o", "back.mo"]) == 0
    back = Path("back.mo").read_text(encoding="utf-8")
    for line in ("Modelica.Mechanics.Rotational.Components.IdealGear gear(",
                 "Modelica.Mechanics.Rotational.Sources.Torque torque;",
                 "Modelica.Blocks.Sources.Sine sine(", "parameter Modelica.Units.SI.Inertia Jmotor("):
        assert line in back
    assert main(["import", "back.mo"]) == 0
    first, again = (Path(name).read_text(encoding="utf-8").partition("\n")[2] for name in ("drive.lag", "back.lag"))
    assert again.removeprefix("// From drive.mo.\n") == first
    inertia = "Rotational.Inertia i(J = 3[g.cm2], phi(start = pi/2));"
    Path("units.lag").write_text(f"model A {inertia} end A;", encoding="utf-8")
    assert main(["export", "units.lag", "--to", "modelica", "--components", "-o", "-"]) == 0
    told = capsys.readouterr().out.replace("3.0000000000000004e-07", "3e-07")
    assert "i(J = 3e-07, phi(start = Modelica.Constants.pi/2))" in told


@pytest.mark.parametrize("text", [
    "Rolling r(r = 1, base = world); PointMass m(m = 1, center = r.center);", "coordinate Length x;",
    "Rotational.FreeWheel f(tau = 1);", "Real x = norm({1, 2});", "energy potential 1[J];", "model T end T;"])
def test_what_modelica_has_no_component_for_is_refused(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.lag").write_text(f"model A {text} end A;", encoding="utf-8")
    assert main(["export", str(tmp_path / "a.lag"), "--to", "modelica", "--components", "-o", "-"]) == 2
    told = capsys.readouterr().err
    assert "L0901" in told and "without --components writes the equations" in told


@pytest.mark.parametrize("text, told", [
    ("parameter Real c = 1; Rotational.Inertia J(J = 1); Rotational.Damper d(d = 2) if c > 1;", "L0210"),
    ("Rotational.Inertia J(J = nope);", "L0204"), ("parameter Real flow = 2; Rotational.Inertia J(J = 1, w(start = flow));",
                                                  "L0901.*the name 'flow', which is a word of Modelica")])
def test_what_is_wrong_is_not_written(text: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.lag").write_text(f"model A {text} end A;", encoding="utf-8")
    assert main(["export", str(tmp_path / "a.lag"), "--to", "modelica", "--components", "-o", "-"]) == 2
    said = capsys.readouterr()
    assert re.search(told, said.err) and not said.out


def test_a_pi_of_ones_own_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "model B parameter Real pi = 3; end B;\nmodel A extends B; Rotational.Inertia J(J = 1, w(start = pi)); end A;\n"
    (tmp_path / "a.lag").write_text(text, encoding="utf-8")
    assert main(["export", str(tmp_path / "a.lag"), "--to", "modelica", "--components", "-o", "-"]) == 0
    assert "w(start = pi)" in capsys.readouterr().out


def test_heat_ports_are_refused_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What there is instead is told; a brake whose temperature would change how it brakes is told of, too."""
    text = """within Modelica.Mechanics.Rotational.Examples;
model Hot
  Modelica.Mechanics.Rotational.Sources.EddyCurrentTorque eddy(
    tau_nominal=100, w_nominal=10,
    alpha20(displayUnit="1/K") = Modelica.Electrical.Machines.Thermal.Constants.alpha20Copper,
    useHeatPort=true);
  Components.Inertia inertia(J=1, w(fixed=true, start=20));
  Components.Damper damper(d=0, useHeatPort=true);
  Components.Fixed fixed;
  Thermal.HeatTransfer.Components.HeatCapacitor heatCapacitor(C=1);
equation
  connect(eddy.flange, inertia.flange_a);
  connect(inertia.flange_b, damper.flange_a);
  connect(damper.flange_b, fixed.flange);
  connect(eddy.heatPort, heatCapacitor.port);
  connect(damper.heatPort, heatCapacitor.port);
end Hot;
"""
    file = tmp_path / "hot.mo"
    file.write_text(text, encoding="utf-8")
    assert main(["import", str(file)]) == 1
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 4 and "heatPort of eddy (its temperature stays T" in told[0]
    assert "heat is not of this language: what a component turns into heat is its lossPower" in told[1]
    assert told[2].endswith("connect(eddy.heatPort, heatCapacitor.port);")
    assert "3.92e-3" in (tmp_path / "hot.lag").read_text(encoding="utf-8")
    x = lag.load(tmp_path / "hot.lag").simulate(at=[0.1], tolerance=1e-12)["inertia.w"][0] / 10
    assert np.log(2 / x) + (4 - x**2) / 2 == pytest.approx(2, abs=1e-10)


def test_sources_and_vehicles_are_imported(tmp_path: Path) -> None:
    text = """within Modelica.Mechanics.Translational.Examples;
model Push
  Translational.Sources.Accelerate accelerate(s(fixed=true, start=2));
  Components.Vehicle vehicle(m=100, J=0, R=0.25, A=1, Cd=0.5, vReg=1e-2, v(fixed=true));
  Modelica.Blocks.Sources.Constant constantAcc(k=1);
equation
  connect(accelerate.flange, vehicle.flangeT);
  connect(constantAcc.y, accelerate.a_ref);
end Push;
"""
    found = imported(text)
    assert not found.left_out and "vReg" not in found.text
    file = tmp_path / "push.lag"
    file.write_text(found.text, encoding="utf-8")
    run = lag.load(file).simulate(at=[1.0], tolerance=1e-12)
    assert [run["vehicle.s"][0], run["vehicle.v"][0]] == pytest.approx([2.5, 1], abs=1e-12)


def test_filters_of_sources_and_older_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A source that is filtered, as Modelica's is unless exact = true, moves exactly here, which is told."""
    text = """model M
      Modelica.Mechanics.Translational.Sources.Position move(FILTER);
      Modelica.Mechanics.Rotational.Components.Brake brake(mue_pos = [0, 0.4], fn_max = 2);
    end M;"""
    for said, code in (("exact = true", DONE), ("exact = false", FAILED), ("f_crit = 20", FAILED), ("", FAILED)):
        (tmp_path / "M.mo").write_text(text.replace("FILTER", said), encoding="utf-8")
        assert main(["import", str(tmp_path / "M.mo"), "-o", str(tmp_path / "M.lag")]) == code
        told = capsys.readouterr()
        assert ("the filter of move (it moves exactly" in told.out + told.err) == (code == FAILED)
        new = (tmp_path / "M.lag").read_text(encoding="utf-8")
        assert "Translational.Position move;" in new.replace("move()", "move") and "mu_pos = [0, 0.4]" in new


def test_names_from_outside_and_exact_sources(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Dots before names go; what moves exactly is written so, whatever it is declared with; a comprehension's pi is its own."""
    (tmp_path / "M.mo").write_text("""model M extends .Modelica.Icons.Example;
      parameter .Modelica.Units.SI.Angle a = 2*.Modelica.Constants.pi;
      .Modelica.Mechanics.Rotational.Components.Inertia i(J = 1, phi(start = a));
    end M;""", encoding="utf-8")
    assert main(["import", str(tmp_path / "M.mo")]) == DONE
    assert lag.load(tmp_path / "M.lag").simulate(stop=1)["i.phi"][0] == pytest.approx(2 * np.pi)
    (tmp_path / "N.lag").write_text("""model N parameter Real x[2] = {pi for pi in 1:2}, y = pi;
      Translational.Speed a[2](each v_ref = x[1]*y), b (v_ref = 1), c;
    end N;""", encoding="utf-8")
    assert main(["export", str(tmp_path / "N.lag"), "--to", "modelica", "--components", "-o", str(tmp_path / "N.mo")]) == DONE
    text = (tmp_path / "N.mo").read_text(encoding="utf-8")
    assert "{pi for pi in 1:2}, y = Modelica.Constants.pi;" in text
    assert "a[2](each exact = true, each v_ref = x[1]*y), b (exact = true, v_ref = 1), c(exact = true);" in text


COUNTS = """model Counts "a relay that counts its switches"
  import Modelica.Mechanics.Rotational.*;
  Components.Inertia load(J=1, w(start=10, fixed=true), phi(start=0, fixed=true));
  Components.Spring spring(c=100);
  Components.Fixed fixed;
  Sources.Torque torque;
  Modelica.Blocks.Sources.RealExpression push(y=if on then 5 else -5);
  Boolean on(start=false, fixed=true);
  discrete Integer n(start=0, fixed=true) "switches";
equation
  when {initial(), load.phi > 0.5, load.phi < -0.5} then
    on = load.phi < 0;
  end when;
  when on then
    n = pre(n) + 1;
  end when;
  connect(load.flange_a, spring.flange_b);
  connect(spring.flange_a, fixed.flange);
  connect(torque.flange, load.flange_b);
  connect(push.y, torque.tau);
end Counts;
"""


def test_events_go_there_and_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Discrete variables; names below an import of all of a package. What sets a rate has no counterpart."""
    monkeypatch.chdir(tmp_path)
    Path("counts.mo").write_text(COUNTS, encoding="utf-8")
    assert main(["import", "counts.mo"]) == 0
    assert main(["export", "counts.lag", "--to", "modelica", "--components", "-o", "back.mo"]) == 0
    assert "Modelica.Blocks.Sources.RealExpression push(" in Path("back.mo").read_text(encoding="utf-8")
    assert main(["import", "back.mo"]) == 0
    first, again = (lag.load(name).simulate(stop=3, interval=3) for name in ("counts.lag", "back.lag"))
    assert first["n"][-1] == again["n"][-1] == 5 and first["load.phi"][-1] == again["load.phi"][-1]
    wrong = "model A Rotational.Inertia J(J = 1); equation when J.phi > 1 then reinit(der(J.phi), 0); end when; end A;"
    Path("a.lag").write_text(wrong, encoding="utf-8")
    assert main(["export", "a.lag", "--to", "modelica", "--components", "-o", "-"]) == 2
    assert "L0901" in capsys.readouterr().err
