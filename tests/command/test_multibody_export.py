"""`lag export --to modelica --components` of scenes with frames: joints, bodies and forces of Modelica.Mechanics.MultiBody.

The lines that are asserted were read by a Modelica compiler with the Modelica Standard Library: the motion was ours within 4e-8.
"""

import re
from pathlib import Path

import pytest

import lagrangia as lag
from helpers.symbolic_scenes import EXAMPLES
from lagrangia.base.diagnostics import LagError
from lagrangia.command.cli import WRONG, main
from lagrangia.command.multibody_export import multibody_text
from lagrangia.command.scene_export import exported_text

MIXED = """model Mixed
  parameter Stiffness k = 40;
  World world(gravity = {0, 0, -9.81});
  Revolute hinge(a = world, axis = {0, 2, 0}, phi(start = 0.3), w(start = 0.1));
  Prismatic slider(a = hinge.b, along = {0, 0, 1}, s(start = 0.4));
  Body bob(m = 2, I = {{0.1, 0.01, 0}, {0.01, 0.2, 0}, {0, 0, 0.3}}, center = slider.b);
  Spring spring(k = k, s_rel0 = 0.5, a = shift(world, {1, 0, 0}), b = bob.center);
  SpringDamper both(k = 5, c = 2, s_rel0 = 0.2, a = world, b = bob.center);
  DuffingSpring hard(k = 3, k3 = 7, s_rel0 = 0.1, a = shift(world, {0, 1, 0}), b = bob.center);
  TorsionSpring twist(k = 6, a = world, b = hinge.b);
  AppliedForce push(at = bob.center, force = {0, 3*sin(2[rad/s]*time), 0});
  BodyForce jet(at = bob.center, force = {0, 0, 4});
  AppliedTorque turn(on = bob.center, torque = {0, 0.5, 0});
energy
  dissipation 0.3*slider.v^2/2;
end Mixed;
"""


def written(text: str) -> str:
    return multibody_text(lag.loads(text))


def parts(text: str) -> dict[str, str]:
    """The modifications of each component, by its class and name."""
    found = re.findall(r"^  (?:inner )?Modelica\.Mechanics\.(?:MultiBody\.)?([\w.]+) (\w+)(?:\((.*)\))?;$", text, re.MULTILINE)
    return {f"{kind} {name}": given for kind, name, given in found}


def test_joints_bodies_and_forces() -> None:
    """Springs and dampers by their formulas, everything else by what it states."""
    text = written(MIXED)
    known = parts(text)
    assert known["World world"] == "n = {0.0, 0.0, -1.0}, g = 9.81"
    assert known["Joints.Revolute hinge"] == "n = {0, hinge_axis_2, 0}, useAxisFlange = true, phi(start = 0.3, fixed = true), " \
        "w(start = 0.1, fixed = true)"
    assert known["Joints.Prismatic slider"] == "n = {0, 0, 1}, useAxisFlange = true, s(start = 0.4, fixed = true), " \
        "v(start = 0.0, fixed = true)"
    assert known["Parts.Body bob"] == "m = bob_m, r_CM = {0, 0, 0}, I_11 = 1/10, I_22 = 1/5, I_33 = 3/10, I_21 = 1/100"
    assert known["Forces.Spring spring"] == "c = k, s_unstretched = spring_s_rel0"
    assert known["Forces.SpringDamperParallel both"] == "c = both_k, s_unstretched = both_s_rel0, d = both_c"
    assert known["Forces.LineForceWithMass hard"] == "m = 0"
    assert known["Rotational.Sources.Torque hinge_drive"] == "useSupport = true"
    assert known["Translational.Sources.Force slider_drive"] == "useSupport = true"
    axes = ", ".join(f"4*slider.frame_b.R.T[3, {k}]" for k in (1, 2, 3))
    for line in ("hinge_drive.tau = -hinge.phi*twist_k;", "slider_drive.f = -3*slider.v/10;", f"jet_force.force = {{{axes}}};",
                 "push_force.force = {0, 3*sin(2*time), 0};", "connect(hinge_drive.support, hinge.support);",
                 "hard_force.f = -hard_k*(2*hard.length - 2*hard_s_rel0)/2 - hard_k3*(hard.length - hard_s_rel0)^3;"):
        assert line in text
    assert "turn_torque.torque = {0, 1/2, 0};" in text


def test_attitudes_begin_by_angles() -> None:
    """The spin in the axes of what carries the ball joint: R of 30 degrees about x times {0, 0, 200}."""
    known = parts(multibody_text(lag.load(EXAMPLES / "top.lag")))
    given = known["Joints.Spherical tip"]
    angles, spin = (list(map(float, x.split(", "))) for x in re.findall(r"start = \{(.*?)\}", given))
    assert angles == pytest.approx([0.5235987755982988, 0, 0]) and spin == pytest.approx([0, -100, 173.20508075688775])
    assert "enforceStates = true" in given and "angles_fixed = true, w_rel_a_fixed = true" in given


def test_planar_loops_have_one_planar_hinge() -> None:
    """And as many fixed starts as freedoms."""
    text = multibody_text(lag.load(EXAMPLES / "four_bar.lag"))
    assert text.count("RevolutePlanarLoopConstraint") == 1 and text.count("fixed = true") == 2


def test_loops_in_space_keep_their_joints() -> None:
    """Of the rod between two balls, one turn about itself is free, besides the crank."""
    text = multibody_text(lag.load(EXAMPLES / "spatial_four_bar.lag"))
    joints = "".join(line for line in text.splitlines(keepends=True) if "Joints." in line)
    assert text.count("Joints.Spherical") == 2 and joints.count("(start = ") == 4 and text.count("fixed = true") == 2
    rod = parts(text)["Parts.Body rod"]  # where a tool begins to look for its attitude
    assert "r_0(start = {0.58348497391" in rod and "angles_start = {" in rod and "w_0_start = {1.629714968" in rod
    initial = text.partition("initial equation\n")[2].partition("equation\n")[0]
    assert len(initial.splitlines()) == 2 and "near_gap[" in initial and "near_spin[" in initial


@pytest.mark.parametrize(("name", "said"), [
    ("bricard", "the loop world - p1 - r1"), ("rolling_disc_space", "the equation 'rolling'"),
    ("torsion_rotor", "'shaft.b.phi'"), ("gear_train", "what 'air' states of attitudes")])
def test_what_multibody_has_not_is_refused_by_name(name: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(EXAMPLES / f"{name}.lag"), "--to", "modelica", "--components", "-o", "-"]) == WRONG
    told = capsys.readouterr()
    assert said in told.err and "L0901" in told.err and not told.out


def test_the_command_chooses_by_what_the_file_speaks_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Drive trains are still written as they stand."""
    assert main(["export", str(EXAMPLES / "furuta.lag"), "--to", "modelica", "--components", "-o", str(tmp_path / "f.mo")]) == 0
    assert "MultiBody.Joints.Revolute swinging(" in (tmp_path / "f.mo").read_text(encoding="utf-8")
    train = ("model D\n  Rotational.Inertia a(J = 1);\n  Rotational.Fixed f;\n  Rotational.Spring s(c = 2);\nequation\n"
             "  connect(f.flange, s.flange_a);\n  connect(s.flange_b, a.flange_a);\nend D;\n")
    (tmp_path / "d.lag").write_text(train, encoding="utf-8")
    assert main(["export", str(tmp_path / "d.lag"), "--to", "modelica", "--components", "-o", "-"]) == 0
    assert "Modelica.Mechanics.Rotational.Components.Spring s(c = 2);" in capsys.readouterr().out


def test_what_reads_attitudes_is_refused() -> None:
    with pytest.raises(LagError, match=r"damping.*omega|omega"):
        written("model S\n  World world(gravity = {0, 0, -9.81});\n  Spherical tip(a = world);\n"
                "  Body b(m = 1, I = {1, 1, 1}, center = shift(tip.b, {0, 0, 1}));\nenergy\n"
                "  dissipation 0.1*dot(b.center.omega, b.center.omega)/2;\nend S;\n")


@pytest.mark.parametrize(("equations", "said"), [
    ("f = turn(shift(world, {x, 0}), phi); g = turn(shift(world, {1, 0}), phi);", "the coordinate 'phi' of more than one joint"),
    ("f = turn(shift(world, {x, 0}), phi); g = turn(world, -phi);", "the coordinate 'phi' of more than one joint"),
    ("f = world; g = turn(shift(world, {x, 0}), phi); energy kinetic 1[kg]*dot(g.v, g.v)/2 + 0.4[kg.m]*g.v[2]*g.w;",
     "no rigid body's"),
    ("f = world; g = turn(shift(world, {x, 0}), phi); energy kinetic 0.4[kg.m2/s]*g.w;", "no rigid body's")])
def test_what_would_move_otherwise_is_refused(equations: str, said: str) -> None:
    """One coordinate in two places, and energies that couple a velocity in the world's axes with a spin, or are linear."""
    with pytest.raises(LagError, match=said):
        written("model S\n  World world(gravity = {0, -9.81});\n  coordinate Angle phi(start = 0.5);\n  coordinate Length x;\n"
                "  Frame f, g;\n  Body one(m = 1, I = 0.1, center = f), two(m = 1, I = 0.1, center = g);\n"
                f"equation\n  {equations}\nend S;\n")


def test_a_hinge_against_its_slider_is_a_joint_of_its_own() -> None:
    """Joints.Cylindrical has one axis for both."""
    scene = ("model S\n  World world(gravity = {0, 0, 0});\n  coordinate Angle phi;\n  coordinate Length s;\n"
             "  Body one(m = 1, I = {1, 1, 1}, center = turn(shift(world, {0, 0, s}), phi, {0, 0, AXIS}));\nend S;\n")
    assert "Joints.Cylindrical" in written(scene.replace("AXIS", "2"))
    known = " ".join(f"{name}({given})" for name, given in parts(written(scene.replace("AXIS", "-1"))).items())
    assert "Cylindrical" not in known and "n = {0, 0, -1}, phi(" in known and "n = {0, 0, 1}, s(" in known


def test_energies_of_one_frame_are_one_body() -> None:
    """Whose weight acts once; gravity follows its parameter; nothing is left out."""
    text = written("model S\n  parameter Acceleration g = 5;\n  World world(gravity = {g, -2*g});\n"
                   "  coordinate Angle phi(start = 0.3);\n  Frame f = shift(turn(world, phi), {1, 0});\n"
                   "  output Length height = f.y;\nenergy\n  kinetic 0.5[kg.m2]*f.w^2/2;\n  kinetic 2[kg]*dot(f.v, f.v)/2;\n"
                   "  potential -2[kg]*dot(world.gravity, f.r);\nend S;\n")
    known = parts(text)
    assert text.count("Parts.Body ") == 1 and known["Parts.Body f"] == "m = 2, r_CM = {0, 0, 0}, I_11 = 0, I_22 = 0, I_33 = 1/2"
    assert "WorldForce" not in text and known["World world"] == "n = {g, -2*g, 0}, g = sqrt(5)*abs(g)"
    assert '  output Real height(unit = "m") = f_place.frame_b.r_0[2];' in text and "// " not in text


def test_names_are_of_modelica_and_frames_may_stand_in_packages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "q.lag").write_text(
        "package Q\n  partial model Base\n    World world(gravity = {0, -9.81});\n    Revolute 'bär'(a = world);\n  end Base;\n"
        "  model One\n    extends Base;\n    Body 'a body'(m = 1, I = 1, center = shift('bär'.b, {1, 0}));\n  end One;\nend Q;\n",
        encoding="utf-8")
    command = ["export", str(tmp_path / "q.lag"), "--model", "Q.One", "--to", "modelica", "--components", "-o", "-"]
    assert main(command) == 0
    text = capsys.readouterr().out
    assert text.startswith("model Q_One\n") and text.endswith("end Q_One;\n")
    assert "Joints.Revolute bar(" in text and "Parts.Body a_body(" in text


ANGLES = """import "parts.lag";
model Größe
  parameter Angle begin = 0.4;
  parameter AngularVelocity ω = 2[1/s];
  World world(gravity = {0, 0, -9.81});
  Revolute hinge(a = world, axis = {0, 1, 0}, phi(start = 2*begin), w(start = ω));
  Knob knob(a = hinge.b);
  output Velocity v[3] = knob.ball.center.v;
  output AngularVelocity omega[3] = knob.ball.center.omega;
  output Real turned = knob.ball.center.Q[1];
end Größe;
"""


def test_starts_and_outputs_are_formulas_and_files_are_imported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What no component tells is named; of drive trains the imported classes are written, too."""
    (tmp_path / "parts.lag").write_text(
        "model Knob Frame a; Ball ball(m = 1, r = 0.1, center = shift(a, {0, 0, -0.3})); end Knob;\n"
        "model Wheel Rotational.Inertia J(J = 1[kg.cm2]); end Wheel;\n", encoding="utf-8")
    for name, text in (("a", ANGLES), ("d", 'import "parts.lag";\nmodel D Wheel w; end D;\n')):
        (tmp_path / f"{name}.lag").write_text(text, encoding="utf-8")
        assert main(["export", str(tmp_path / f"{name}.lag"), "--to", "modelica", "--components", "-o", "-"]) == 0
        told = capsys.readouterr().out
        if name == "a":
            at = "knob_ball_center.frame_b"
            assert told.startswith("model Grosse\n  // outputs are not written: turned\n  parameter") and told.count("//") == 1
            assert "phi(start = 2*begin, fixed = true), w(start = omega, fixed = true)" in told
            assert f'v[3](each unit = "m/s") = {{der({at}.r_0[1]), ' in told and f"= {{{at}.R.w[1], {at}.R.w[2], " in told
        else:
            assert told.lstrip().startswith("model Wheel Modelica.Mechanics.Rotational.Components.Inertia J(J = 0.0001)")
            assert "Knob" not in told and "import" not in told and told.endswith("model D Wheel w; end D;\n")


def test_flat_names_are_of_ascii() -> None:
    text = exported_text(lag.loads("model U coordinate Length höhe; coordinate Length hohe; parameter Mass λ = 1; "
                                   "energy kinetic λ*(der(höhe)^2 + 2*der(hohe)^2)/2; end U;"), "modelica")
    code = re.sub('"[^"]*"', "", text)
    assert code.isascii() and "hohe_(start" in code and "hohe(start" in code and "lambda" in code
