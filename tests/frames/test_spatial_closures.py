"""Joints in space that close loops: what is said of their coordinates, rates and forces."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
import yaml

import lagrangia as lag
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.constraints.parameters import default_parameters
from lagrangia.frames.spatial_joints import triad
from lagrangia.model import Model

SPATIAL = Path(__file__).parents[1] / "whole" / "spatial"
LEGS = """
  World world(gravity = {0, 0, -9.81});
  Revolute h1(a = world, axis = {1, 2, 3}, phi(start = 0.2));
  Body b1(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h1.b, {0.3, 0.1, 0}));
  Universal h2(a = shift(h1.b, {0.5, 0.2, 0.1}), phi_a(start = 0.3), phi_b(start = -0.2));
  Body b2(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h2.b, {0.2, -0.1, 0.3}));
  Universal h3(a = shift(h2.b, {0.4, 0.1, -0.2}), axis_b = {0, 0, 1}, phi_a(start = -0.1), phi_b(start = 0.4));
  Body b3(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h3.b, {0.1, 0.2, 0}));
  Revolute h4(a = shift(world, {1, -0.3, 0.2}), axis = {0, 1, 1}, phi(start = 0.1));
  Body b4(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h4.b, {0.2, 0.2, 0.1}));
  Revolute h5(a = shift(h4.b, {0.1, 0.5, 0}), axis = {1, 0, -1}, phi(start = 0.2));
  Body b5(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h5.b, {0.1, -0.1, 0.2}));
"""
CUTS = {
    "hinge": "Revolute cut(a = shift(h3.b, {0.2, 0, 0.1}), axis = {1, 1, 0.5}, b = shift(h5.b, {0.1, 0.3, 0.1}));",
    "slider": "Prismatic cut(a = shift(h3.b, {0.2, 0, 0.1}), along = {1, 1, 0.5}, b = shift(h5.b, {0.1, 0.3, 0.1}));",
    "ball": "Spherical cut(a = shift(h3.b, {0.2, 0, 0.1}), b = shift(h5.b, {0.1, 0.3, 0.1}));",
    "cylinder": "Cylindrical cut(a = shift(h3.b, {0.2, 0, 0.1}), axis = {1, 1, 0.5}, b = shift(h5.b, {0.1, 0.3, 0.1}));",
    "cross": "Universal cut(a = shift(h3.b, {0.2, 0, 0.1}), axis_a = {1, 0.2, 0}, axis_b = {0.3, 1, 0.1}, "
             "b = shift(h5.b, {0.1, 0.3, 0.1}));",
    "weld": "PlanarJoint cut(a = shift(h3.b, {0.2, 0, 0.1}), b = shift(h5.b, {0.1, 0.3, 0.1}));",
}
# Like Universal and Revolute, but cut as welds.
CROSSED = """model Crossed
  parameter Real axis_b[3] = {0, 1, 0} annotation(Evaluate = true); Frame a, b; coordinate Angle phi_a; coordinate Angle phi_b;
equation
  b = turn(shift(turn(a, phi_a, {1, 0, 0}), {0.01, 0, 0}), phi_b, axis_b);
end Crossed;
model Odd
  parameter Real axis[3] annotation(Evaluate = true); Frame a, b; coordinate Angle phi;
equation
  b = turn(a, 1*phi, axis);
end Odd;
"""


@pytest.mark.parametrize("kind", CUTS)
def test_gaps_and_their_rates_agree(kind: str) -> None:
    """Where the loop is closed, the slopes of the rates are those of the gaps; of a motion, gaps stay shut and energy is kept."""
    legs = LEGS if kind in ("ball", "cross", "cylinder") else LEGS.replace("Universal", "Crossed")  # which would be cut before
    if kind in ("slider", "weld"):
        legs = legs.replace("Revolute", "Odd")
    model = lag.loads(f"{CROSSED} model M {legs} {CUTS[kind]} end M;", model="M")
    c = model.compilation
    (cut,) = c.graph.closures
    assert cut.kind == kind
    run = model.simulate(stop=0.4, interval=0.2, tolerance=1e-10)
    assert run.statistics.constraint_residual < 1e-12
    assert run.energy.total == pytest.approx([run.energy.total[0]] * run.time.size, abs=1e-8)
    if kind == "ball":
        return
    p, values = default_parameters(c.kinematics)
    rows = c.motion.constrained.rows
    look = ca.Function("look", [c.motion.q, p], [rows.phi, ca.jacobian(rows.phi, c.motion.q), c.motion.constrained.J])
    q = [run[name][-1] for name in c.kinematics.symbols.positions]
    phi, slopes, J = (x.full() for x in look(q, values))
    assert np.abs(phi).max() < 1e-12 and slopes == pytest.approx(J, abs=1e-11)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (0.6, 0, -0.8), (-0.48, 0.64, 0.6)])
def test_axes_that_are_parameters_may_point_anywhere(axis: tuple[float, ...]) -> None:
    x, algebra = ca.SX.sym("axis", 3), CasadiAlgebra(ca.SX.sym("t"), ca.SX.sym("x"))
    rows = ca.vertcat(*[ca.horzcat(*row) for row in triad(x.elements(), algebra)])
    R = ca.Function("triad", [x], [rows])(ca.DM(axis)).full()
    assert np.abs(R @ R.T - np.eye(3)).max() < 1e-15 and np.linalg.det(R) == pytest.approx(1)
    assert R[2] == pytest.approx(axis)


RSSR = """
model Rssr
  World world(gravity = {0, 0, -9.81});
  Revolute crank(a = world, axis = {0, 0, 1}, phi(start = 0, fixed = true), w(start = 8));
  Body crank_body(m = 1, I = {0.001, 0.02, 0.02}, center = shift(crank.b, {0.15, 0, 0}));
  Revolute rocker(a = shift(world, {0.9, 0.5, 0.2}), axis = {0, 1, 0}, phi(start = -1.6));
  Body rocker_body(m = 1.5, I = {0.001, 0.05, 0.05}, center = shift(rocker.b, {0.3, 0, 0}));
  Spherical ball_a(a = shift(crank.b, {0.3, 0, 0}));
  Body coupler(m = 2, I = {0.002, 0.2, 0.2}, center = shift(ball_a.b, {0.55, 0, 0}));
  Spherical ball_b(a = shift(ball_a.b, {1.1, 0, 0}), b = shift(rocker.b, {0.6, 0, 0}));
  output Acceleration a[3] = der(coupler.center.v);
  output Real spin[3] = ball_b.w - to_frame(ball_b.b, ball_b.b.w - ball_b.a.w);
  output Real turned[3] = to_world(ball_b.b, {1, 2, 3}) - to_world(ball_b.a, {1, 2, 3});
end Rssr;
"""


def test_two_ball_joints_between_crank_and_rocker() -> None:
    """To the digits of the reference; what both ball joints exert accelerates the coupler."""
    known = yaml.safe_load((SPATIAL / "references.yaml").read_text(encoding="utf-8"))["rssr"]
    model = Model(lag.loads(RSSR).path, outputs=("ball_a.reaction", "ball_b.reaction", "ball_b.reaction_torque"))
    assert len(model.compilation.constraints.rows) == 6 and model.compilation.motion.way == "independent coordinates"
    run = model.simulate(at=[0, *known["t"]], tolerance=1e-13)
    assert run["crank.phi"][1:] == pytest.approx(known["theta"], abs=1e-12)
    assert run["rocker.phi"][1:] == pytest.approx(known["phi"], abs=1e-12)
    for k, gravity in enumerate((0, 0, -9.81), 1):
        held = run[f"ball_a.reaction[{k}]"] - run[f"ball_b.reaction[{k}]"]
        assert 2 * run[f"a[{k}]"] == pytest.approx(held + 2 * gravity, abs=1e-9)
        assert run[f"spin[{k}]"] == pytest.approx(np.zeros(run.time.size), abs=1e-11)
        assert run[f"ball_b.reaction_torque[{k}]"] == pytest.approx(np.zeros(run.time.size), abs=1e-9)


LOOP = """
  Revolute j1(a = world, axis = {0, 0, 1}, phi(start = 0.5, fixed = true), w(start = 3, fixed = true));
  Body crank(m = 1, I = {0.01, 0.02, 0.02}, center = shift(j1.b, {0.2, 0, 0}));
  Revolute j2(a = shift(j1.b, {0.4, 0, 0}) J2);
  Body coupler(m = 1, I = {0.01, 0.1, 0.1}, center = shift(j2.b, {0.5, 0, 0}));
  Revolute j3(a = shift(j2.b, {1, 0, 0}) J3);
  Body rocker(m = 1, I = {0.01, 0.05, 0.05}, center = shift(j3.b, {-0.35, 0, 0}));
  Revolute j4(a = shift(world, {0.9, 0, 0}), phi(start = 1.3) J4, b = shift(j3.b, {-0.7, 0, 0}));
  Revolute off(a = world, axis = {1, 0, 0});
  Body other(m = 1, I = {1, 1, 1}, center = shift(off.b, {0, 0, 1}));
"""


def test_what_acts_in_a_cut_hinge_acts() -> None:
    """A spring and a motor in the hinge that is cut; the same motion where another one is cut. Full turns are told."""
    springs = "TorsionSpring s(k = 5, twist = j3.phi); TorsionDamper d(c = 0.2, rate = j3.w); energy work 0.3[N.m] on j3.phi;"
    texts = [LOOP.replace("J2", two).replace("J3", three).replace("J4", "")
             for two, three in (("", ", phi(start = 1.2)"), (", phi(start = -0.2)", ""))]
    one, other = (lag.loads(f"model M {text} {springs} end M;") for text in texts)
    cuts = [{cut.kept for cut in model.compilation.graph.closures} for model in (one, other)]
    assert cuts[0] != cuts[1] and {"j3.phi"} in cuts
    a = one.simulate(stop=2, interval=0.5, tolerance=1e-11)
    initial = {name: a[name][0] for name in ("j2.phi", "j3.phi", "j4.phi")}
    b = other.simulate(stop=2, interval=0.5, tolerance=1e-11, initial=initial)
    for name in ("j1.phi", "j2.phi", "j3.phi", "der(j3.phi)"):
        assert b[name] == pytest.approx(a[name], abs=1e-8), name
    assert a.energy.residual == pytest.approx(np.zeros(a.time.size), abs=1e-8)


def test_a_point_on_a_line_in_space() -> None:
    """Two equations across the line; energy is kept, and the point stays."""
    model = lag.loads("""model M
      World world(gravity = {0, 0, -9.81});
      Universal h(a = world, phi_a(start = 0.4), phi_b(start = 0.3));
      Body b(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h.b, {0, 0, -0.5}));
      Universal k(a = shift(h.b, {0, 0, -1}), phi_a(start = -0.5));
      Body c(m = 1, I = {0.1, 0.2, 0.15}, center = shift(k.b, {0, 0, -0.5}));
      Frame line = turn(shift(world, {0, 0.4, -1.6}), 0.5, {0, 0, 1}), point = shift(k.b, {0, 0, -1});
      PointOnLine on(line = line, point = point);
      output Length place[3] = to_frame(line, point.r - line.r);
    end M;""")
    run = model.simulate(stop=1, interval=0.25, tolerance=1e-10)
    for k in (2, 3):
        assert run[f"place[{k}]"] == pytest.approx(np.zeros(run.time.size), abs=1e-12)
    assert np.ptp(run["place[1]"]) > 0.1
    assert run.energy.total == pytest.approx([run.energy.total[0]] * run.time.size, abs=1e-8)


def test_a_slider_rubs_on_a_guide_in_space() -> None:
    """By what presses it across its way: s = (g.e - mu |g - (g.e) e|) t^2/2."""
    text = """model M
      Frame base = turn(world, -0.5, {0.1, 0.2, 1});
      RoughPrismatic guide(mu = 0.2, a = base, along = {1, 0, 0});
      Body d(m = 2, I = {0.1, 0.1, 0.1}, center = shift(guide.b, {0, 0.1, 0}));
      output Real e[3] = to_world(base, {1, 0, 0});
      output Force pressed = guide.couple "by its ends, which are not reckoned with";
    end M;"""
    run = lag.loads(text).simulate(stop=1, interval=1, tolerance=1e-11)
    assert run["pressed"][0] == 0
    way, gravity = np.array([run[f"e[{k}]"][0] for k in (1, 2, 3)]), np.array([0, -9.81, 0])
    along = gravity @ way
    assert run["guide.s"][-1] == pytest.approx((along - 0.2 * np.linalg.norm(gravity - along * way)) / 2, rel=1e-9)
    with pytest.raises(lag.LagError, match="length"):
        lag.loads(text.replace("mu = 0.2,", "mu = 0.2, length = 0.3,")).simulate(stop=1)


def test_a_loop_begins_and_ends_with_ball_joints() -> None:
    """As where three equations hold its tip."""
    bars = """
      World world(gravity = {0, 0, -9.81});
      Spherical h1(a = world), h2(a = shift(h1.b, {0.3, 0.1, 0}));
      Body b1(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h1.b, {0.3, 0.1, 0.05}));
      Body b2(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h2.b, {0.1, 0, 0}));
      Frame tip = shift(h2.b, {0.2, -0.1, 0});"""
    cut, held = (lag.loads(f"model M {bars} {end} end M;") for end in
                 ("Spherical cut(a = tip, b = shift(world, {0.5, 0, 0}));", "equation tip.r = {0.5, 0, 0};"))
    assert [x.kind for x in cut.compilation.graph.closures] == ["ball"]
    ends = [[run[f"{name}.center.omega[{k}]"][-1] for name in ("b1", "b2") for k in (1, 2, 3)]
            for run in (model.simulate(stop=0.5, tolerance=1e-11) for model in (cut, held))]
    assert ends[0] == pytest.approx(ends[1], abs=1e-8) and np.abs(ends).max() > 1


@pytest.mark.parametrize("kind", ["cross", "cylinder"])
def test_reactions_of_cut_joints_accelerate_a_body(kind: str) -> None:
    """Newton's and Euler's laws of a body between a hinge and the joint that is cut, by differences of what it does."""
    words = """output Force F[3] = cut.b.reaction + h5.b.reaction; output Velocity v[3] = b5.center.v;
      output Real L[3] = to_world(b5.center, {0.1*b5.center.omega[1], 0.2*b5.center.omega[2], 0.15*b5.center.omega[3]});
      output Torque M[3] = cut.b.reaction_torque + h5.b.reaction_torque + cross(cut.b.r - b5.center.r, cut.b.reaction)
        + cross(h5.b.r - b5.center.r, h5.b.reaction);"""
    h = 1e-3
    run = lag.loads(f"model M {LEGS} {CUTS[kind]} {words} end M;").simulate(stop=0.05, interval=h, tolerance=1e-11)
    F, v, L, M = (np.array([run[f"{name}[{k}]"] for k in (1, 2, 3)]) for name in "FvLM")
    for rate, wanted in ((v, F - np.array([[0], [0], [9.81]])), (L, M)):
        assert (rate[:, 2:] - rate[:, :-2]) / (2 * h) == pytest.approx(wanted[:, 1:-1], abs=1e-4)


def test_gears_and_belts_join_angles_of_hinges_in_space() -> None:
    """A bevel pair and a belt to a third shaft: with a torque on the first all turn as one inertia; a belt that slips pulls by
    Euler's and Eytelwein's force."""
    axes = {"p": "{1, 0, 0}", "q": "{0, 1, 0}", "r": "{0, 1, 0}", "s": "{0, 0, 1}"}
    shafts = "".join(f"Revolute {name}(a = shift(world, {{0, 0, {k}}}), axis = {axis}); "
                     f"Body r{name}(m = 1, I = {{{0.1 * (k + 1)}, {0.1 * (k + 1)}, {0.1 * (k + 1)}}}, center = {name}.b); "
                     for k, (name, axis) in enumerate(axes.items()))
    model = lag.loads(f"""model M {shafts}
      Gear pair(r_a = 0.1, r_b = 0.2, phi_a = p.phi, phi_b = q.phi);
      Belt belt(r_a = 0.3, r_b = 0.1, phi_a = q.phi, phi_b = r.phi);
      RoughBelt slack(r_a = 0.1, r_b = 0.1, phi_a = r.phi, phi_b = s.phi, mu = 0.3, angle = 2, tension = 0.5);
      energy work 0.7 on p.phi; end M;""")
    run = model.simulate(stop=1, interval=0.5, tolerance=1e-11)
    pull = 2 * 0.5 * np.tanh(0.3) * 0.1  # on the slack belt's pulleys
    rate = (0.7 - 1.5 * pull) / (0.1 + 0.2 / 4 + 0.3 * 1.5**2)  # r turns by -1.5 of p
    assert run["der(p.phi)"][-1] == pytest.approx(rate, rel=1e-9)
    assert [run[f"der({x}.phi)"][-1] / rate for x in "qr"] == pytest.approx([-0.5, -1.5], rel=1e-12)
    assert run["der(s.phi)"][-1] == pytest.approx(-pull / 0.4, rel=1e-9)
