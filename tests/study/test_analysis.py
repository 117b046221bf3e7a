"""Equilibria, matrices of small motion, modes and responses against closed forms."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
G = 9.81
Write = Callable[[str], lag.Model]

CHAIN = """
model Chain
  parameter Integer n = 5; parameter Boolean has_wall = false;
  World world(gravity = {0, 0});
  Block b[n](each m = 1, each base = world);
  Spring first(k = 1, stretch = b[1].s);
  Spring s[n-1](each k = 1, stretch = {b[i+1].s - b[i].s for i in 1:n-1});
  Spring last(k = 1, stretch = b[n].s) if has_wall;
end Chain;
"""
PENDULUMS = """
model Pendulums
  parameter Integer n = 2; parameter Angle first = -90[deg];
  World world(gravity = {0, -1});
  Revolute h[n]; PointMass m[n](each m = 1);
equation
  connect(world, h[1].a);
  for i in 1:n loop m[i].center = shift(h[i].b, {1, 0}); end for;
  for i in 2:n loop connect(m[i-1].center, h[i].a); end for;
initial equation
  h[1].phi = first;
  for i in 2:n loop h[i].phi = 0; end for;
end Pendulums;
"""
TWO = """
model Two "fixed - k1, c1 - m1 - kc, cc - m2 - k2 - fixed"
  parameter Mass m1 = 2, m2 = 1; parameter Stiffness k1 = 3, kc = 2, k2 = 1; parameter Damping c1 = 0.3, cc = 0.1;
  World world(gravity = {0, 0});
  Block a(m = m1, base = world), b(m = m2, base = world);
  Spring s1(k = k1, stretch = a.s), sc(k = kc, stretch = b.s - a.s), s2(k = k2, stretch = b.s);
  Damper d1(c = c1, rate = a.v), dc(c = cc, rate = b.v - a.v);
  input Force F = 0;
  AppliedForce push(at = a.center, force = {F, 0});
end Two;
"""


def close(found: object, wanted: object, relative: float = 1e-11) -> None:
    np.testing.assert_allclose(np.asarray(found), np.asarray(wanted), rtol=relative, atol=relative)


# ---------------------------------------------------------------- modes


@pytest.mark.parametrize("n", [1, 2, 5, 40])
def test_a_chain_of_masses_fixed_at_one_end(n: int, scene: Write) -> None:
    path = scene(CHAIN).path
    modes = lag.load(path, n=n).modes()
    j = np.arange(1, n + 1)
    close(modes.omega, 2 * np.sin((2 * j - 1) * np.pi / (2 * (2 * n + 1))), 1e-10)
    shape = np.sin(np.outer(j, (2 * j - 1) * np.pi / (2 * n + 1)))  # mass by mode
    shape /= [column[np.abs(column).argmax()] for column in shape.T]
    close(np.abs(modes.shapes), np.abs(shape), 1e-8)


@pytest.mark.parametrize("n", [3, 10])
def test_a_chain_between_two_walls(n: int, scene: Write) -> None:
    """Published zeros where they are given, 2 sin(j pi/(2(n + 1)))."""
    modes = lag.load(scene(CHAIN).path, n=n, has_wall=True).modes()
    close(modes.omega, 2 * np.sin(np.arange(1, n + 1) * np.pi / (2 * (n + 1))))


LAGUERRE = {2: [2 - np.sqrt(2), 2 + np.sqrt(2)], 3: [0.4157745567834790833, 2.294280360279041720, 6.289945082937479197],
            5: [0.2635603197181409102, 1.413403059106516792, 3.596425771040722081, 7.085810005858837557, 12.64080084427578266]}


@pytest.mark.parametrize("n", [2, 3, 5])
def test_hanging_pendulums_have_laguerres_zeros(n: int, scene: Write) -> None:
    """n equal masses on n equal rods: omega^2 = (g/l) x, L_n(x) = 0; upright they run away at the same rates."""
    model = lag.load(scene(PENDULUMS).path, n=n)
    close(model.modes().omega ** 2, LAGUERRE[n])
    upright = model.modes(parameters={"first": np.pi / 2})
    assert [mode.kind for mode in upright] == ["divergence"] * n
    close(sorted(mode.growth**2 for mode in upright), LAGUERRE[n])
    close(sorted(upright.linearization.eigenvalues.real), sorted([*np.sqrt(LAGUERRE[n]), *-np.sqrt(LAGUERRE[n])]), 1e-9)


def test_two_masses_with_dampers(scene: Write) -> None:
    model = scene(TWO)
    linear = model.linearize()
    close(linear.M, [[2, 0], [0, 1]])
    close(linear.K, [[5, -2], [-2, 3]])
    close(linear.C, [[0.4, -0.1], [-0.1, 0.1]])
    close(linear.F[0], [[1], [0]])
    assert linear.states == ("a.s", "b.s", "der(a.s)", "der(b.s)") and linear.inputs == ("F",)
    modes = model.modes(parameters={"c1": 0.0, "cc": 0.0})
    close(modes.omega, [1.146237034110088782, 2.046006026783525182])
    assert not modes.has_damping
    close(modes.frequencies, modes.omega / (2 * np.pi))
    normal = model.modes(mass_normalised=True)
    close(normal.shapes.T @ linear.M @ normal.shapes, np.eye(2))
    close(normal.shapes.T @ linear.K @ normal.shapes, np.diag(normal.omega**2))
    polynomial = np.polyadd(np.polymul([2, 0.4, 5], [1, 0.1, 3]), -np.polymul([0.1, 2], [0.1, 2]))
    roots = np.roots(polynomial)
    close(sorted(d.omega for d in model.modes().damped), sorted(np.abs(roots[roots.imag > 0])))
    close(sorted(d.damping_ratio for d in model.modes().damped), sorted((-roots.real / np.abs(roots))[roots.imag > 0]))


BUS = """
model Bus
  parameter Mass m1 = 2500, m2 = 320; parameter Stiffness k1 = 80000, k2 = 500000; parameter Damping b1 = 350, b2 = 15020;
  World world(gravity = {0, 0});
  Block road(m = 1, base = world, along = {0, 1});
  Motion profile(of = road.s, to = 0.1*sin(1*time));
  Block body(m = m1, base = world, along = {0, 1}), axle(m = m2, base = world, along = {0, 1});
  SpringDamper suspension(k = k1, c = b1, stretch = body.s - axle.s), tyre(k = k2, c = b2, stretch = axle.s - road.s);
end Bus;
"""


def test_a_bus_on_its_suspension(scene: Write) -> None:
    """Published eigenvalues; the response to the road in closed form, the tyre's damper feeling the road's rate."""
    model = scene(BUS)
    wanted = [-23.9757817859989313 + 35.1869235307216066j, -0.109843214001068713 + 5.25044540428717293j]
    close(sorted(d.eigenvalue.real for d in model.modes().damped), sorted(x.real for x in wanted))
    close(sorted(d.eigenvalue.imag for d in model.modes().damped), sorted(x.imag for x in wanted))
    response = model.response(["road.s"], ["body.s", "axle.s"], span=(0.05, 50), points=60)
    s = 2j * np.pi * response.frequencies
    upper, lower = 80000 + 350 * s, 500000 + 15020 * s
    for k, x in enumerate(s):
        Z = np.array([[2500 * x**2 + upper[k], -upper[k]], [-upper[k], 320 * x**2 + upper[k] + lower[k]]])
        close(response.values[k, :, 0], np.linalg.solve(Z, [0, lower[k]]), 1e-9)
    assert model.linearize(excitations=["road.s"]).inputs == ("road.s", "der(road.s)")


def test_a_vibration_absorber_stills_its_machine() -> None:
    model = lag.load(EXAMPLES / "vibration_absorber.lag")
    response = model.response(outputs=["machine.s", "absorber.s"], frequencies=[0.5, 2.0, 18 / (2 * np.pi), 5.0])
    s = 2j * np.pi * response.frequencies
    Z = 10 * s**2 + 30 * s + 4000 + 324 - 324**2 / (s**2 + 324 + 1e-300)
    wanted = np.where(np.abs(s**2 + 324) < 1e-9, 0, 1 / Z)
    np.testing.assert_allclose(response.of("machine.s"), wanted, atol=1e-14)
    assert abs(response.of("machine.s")[2]) < 1e-12 * abs(response.of("absorber.s")[2])
    assert response.inputs == ("shaking.force[1]",)


def test_modes_of_the_double_pendulum_in_closed_form() -> None:
    """Two bars: M and K of small angles against the hinge before, K = diag of weights below."""
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    p = dict(zip(model.parameter_names, model.parameter_values(), strict=True))
    m1, m2, l1, l2 = p["upper.m"], p["lower.m"], p["upper.L"], p["lower.L"]
    M = np.array([[m1 * l1**2 / 3 + m2 * l1**2, m2 * l1 * l2 / 2], [m2 * l1 * l2 / 2, m2 * l2**2 / 3]])  # absolute angles
    K = np.diag([(m1 / 2 + m2) * G * l1, m2 * G * l2 / 2])
    close(model.modes().omega ** 2, np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real))
    point = model.modes().linearization.point
    close([point["shoulder.phi"], point["elbow.phi"]], [-np.pi / 2, 0])


def test_rigid_body_motion_is_told(scene: Write) -> None:
    model = scene("""model Free World world(gravity = {0, 0}); Block a(m = 2, base = world), b(m = 3, base = world);
                     Spring s(k = 5, stretch = b.s - a.s); end Free;""")
    modes = model.modes()
    assert [mode.kind for mode in modes] == ["rigid body", "oscillation"]
    close(modes.omega, [0, np.sqrt(5 * (1 / 2 + 1 / 3))])
    close(list(modes[0].shape.values()), [1, 1])
    floating = scene("model Free World world(gravity = {0, 0}); Bar bar(m = 1, L = 1); end Free;")
    assert [mode.kind for mode in floating.modes()] == ["rigid body"] * 3
    (rest,) = floating.equilibrium()
    assert (rest.stability, rest.n_neutral) == ("neutral", 3)


# ---------------------------------------------------------------- constraints


THIRD = "Revolute h5(a = shift(world, {1, 0})), h6(a = third.b, b = middle); Bar third(m = 0, L = 1, a = h5.b);" \
    "Frame middle = shift(coupler.a, {1, 0});"


@pytest.mark.parametrize("third", ["", THIRD])
def test_a_parallelogram_swings_as_a_pendulum(third: str, scene: Write) -> None:
    """omega^2 = g (m + M)/(L (2 m/3 + M)): cranks m, coupler M; a third crank repeats a constraint."""
    model = scene(f"""model P Revolute h1(a = world, phi(start = -80[deg])), h2(a = left.b, phi(start = 80[deg])),
        h3(a = shift(world, {{2, 0}}), phi(start = -80[deg])), h4(a = right.b, b = coupler.b);
        Bar left(m = 2, L = 1, a = h1.b), coupler(m = 3, L = 2, a = h2.b), right(m = 2, L = 1, a = h3.b); {third} end P;""")
    close(model.modes().omega, [np.sqrt(G * (2 + 3) / (2 * 2 / 3 + 3))], 1e-9)
    first = model.equilibrium()[0]
    close(first.position["h1.phi"], -np.pi / 2, 1e-8)
    assert first.stability == "stable"
    held = [name for name in ("h1", "h3", "h5") if f"{name}.reaction[2]" in first.reactions]
    close(abs(sum(first.reactions[f"{name}.reaction[2]"] for name in held)), 7 * G, 1e-8)


def test_stiffness_of_curved_constraints(scene: Write) -> None:
    """A point on a massless rod, as a distance kept: all its stiffness is the multiplier's."""
    model = scene("""model P PointMass p(m = 2, center(x(start = 0.1), y(start = -0.6)));
                     Link rod(L = 0.7, a = world, b = p.center); end P;""")
    linear = model.linearize()
    close(linear.eigenvalues.imag[linear.eigenvalues.imag > 0], [np.sqrt(G / 0.7)], 1e-9)
    assert linear.states == ("p.center.x", "der(p.center.x)")
    assert {item.stability for item in model.equilibrium()} == {"stable", "unstable"}
    close([abs(item.position["p.center.y"]) for item in model.equilibrium()], [0.7, 0.7])


def test_a_rolling_wheel_in_a_trough(scene: Write) -> None:
    """omega^2 = 2 g/(3 (R - r)): a disc that rolls without slip."""
    model = scene("""model T RollingInTrough t(r = 0.1, R = 0.7, base = world, alpha(start = 0.3));
                     Disc d(m = 2, r = 0.1, center = t.center); end T;""")
    close(model.modes().omega, [np.sqrt(2 * G / (3 * 0.6))], 1e-9)


# ---------------------------------------------------------------- supports that move


PIVOTS = {
    "Motion": "Prismatic slide(a = world);"
              "Motion drive(of = slide.s, to = 0.2*sin(1*time)); Revolute h(a = slide.b, phi(start = -1));",
    "frame": "Frame road = shift(world, {0.2*sin(1*time), 0}); Revolute h(a = road, phi(start = -1));",
    "variable": "Length x = 0.2*sin(1*time); Frame road = shift(world, {x, 0}); Revolute h(a = road, phi(start = -1));",
}


@pytest.mark.parametrize(("way", "name"), [("Motion", "slide.s"), ("Motion", "drive"), ("frame", "road.x"), ("variable", "x")])
def test_a_pendulum_on_a_moving_pivot(way: str, name: str, scene: Write) -> None:
    """L phi'' + g phi = -x'' sin(...): phi/x = omega^2/(g - L omega^2), by the pivot's inertia alone."""
    model = scene(f"model P {PIVOTS[way]} PointMass m(m = 3, center = shift(h.b, {{0.5, 0}})); end P;")
    response = model.response([name], ["h.phi", "m.center.x"], frequencies=[0.2, 0.6, 3.0])
    w2 = (2 * np.pi * response.frequencies) ** 2
    close(response.values[:, 0, 0], w2 / (G - 0.5 * w2), 1e-10)
    close(response.values[:, 1, 0], 1 + 0.5 * w2 / (G - 0.5 * w2), 1e-10)
    assert np.abs(np.angle(response.values[0, 0, 0])) < 1e-12


def test_a_prescribed_shaft_carries_its_gear_along(scene: Write) -> None:
    """A gear of ratio 2 behind a driven shaft: all dependent coordinates follow what is prescribed."""
    model = scene("""model G World world(gravity = {0, 0}); Revolute s[3](each a = world);
        Disc d[3](each m = 1, each r = 0.1); Gear mesh(r_a = 0.1, r_b = 0.2, a = s[1].b, b = s[2].b, carrier = world);
        Motion motor(of = s[1].phi, to = sin(1*time)); TorsionSpring t(k = 3, a = s[2].b, b = s[3].b);
        equation for i in 1:3 loop connect(s[i].b, d[i].center); end for; end G;""")
    response = model.response(["s[1].phi"], ["s[2].phi", "s[3].phi"], frequencies=[0.3, 5.0])
    w2 = (2 * np.pi * response.frequencies) ** 2
    close(response.values[:, 0, 0], [-0.5, -0.5])
    close(response.values[:, 1, 0], -0.5 * 3 / (3 - 0.005 * w2), 1e-10)


def test_a_pendulum_in_a_turning_frame(scene: Write) -> None:
    """Steady turning goes on: omega^2 = Omega^2 R/L about the outward position."""
    model = scene("""model T World world(gravity = {0, 0}); Frame arm = shift(turn(world, 3*time), {0.8, 0});
                     Revolute h(a = arm, phi(start = 0.3)); PointMass m(m = 1, center = shift(h.b, {0.2, 0})); end T;""")
    close(model.modes().omega, [3 * np.sqrt(0.8 / 0.2)], 1e-9)
    found = {round(abs(item.position["h.phi"]), 6): item.stability for item in model.equilibrium()}
    assert found == {0.0: "stable", 3.141593: "unstable"}


def test_bearing_forces_answer_to_loads(scene: Write) -> None:
    """A hanging mass pushed sideways: R_x = m x'' - P."""
    model = scene("""model P Revolute h(a = world, phi(start = -90[deg])); PointMass m(m = 2, center = shift(h.b, {0.5, 0}));
                     AppliedForce P(at = m.center, force = {2*sin(3*time), 0}); end P;""")
    response = model.response(["P.force[1]"], ["h.reaction[1]", "h.phi"], frequencies=[0.1, 0.5, 4.0])
    w2 = (2 * np.pi * response.frequencies) ** 2
    x = 1 / (2 * G / 0.5 - 2 * w2)
    close(response.of("h.phi"), x / 0.5, 1e-10)
    close(response.of("h.reaction[1]"), -2 * w2 * x - 1, 1e-10)


# ---------------------------------------------------------------- equilibria


def test_a_shallow_truss_snaps_through(scene: Write) -> None:
    """Two springs to a guided point: stable on both sides, unstable flat; V of the flat one is k (sqrt(a^2+h^2) - a)^2."""
    model = scene("""model Truss World world(gravity = {0, 0}); Block p(m = 1, base = world, along = {0, 1}, s(start = 0.15));
        Spring left(k = 100, s_rel0 = sqrt(1.04), a = shift(world, {-1, 0}), b = p.center),
               right(k = 100, s_rel0 = sqrt(1.04), a = shift(world, {1, 0}), b = p.center); end Truss;""")
    found = model.equilibrium()
    assert found.is_reached
    close(found[0].position["p.s"], 0.2)
    assert sorted((round(item.position["p.s"], 9), item.stability) for item in found) == \
        [(-0.2, "stable"), (0.0, "unstable"), (0.2, "stable")]
    flat = next(item for item in found if item.stability == "unstable")
    close([flat.potential, flat.growth], [100 * (np.sqrt(1.04) - 1) ** 2, np.sqrt(200 * (np.sqrt(1.04) - 1))], 1e-9)


def test_a_wound_torsion_spring_is_another_place(scene: Write) -> None:
    """m g L sin(phi) = k phi: places a turn apart are not the same."""
    model = scene("""model W Revolute h(a = world, phi(start = 0.1)); PointMass m(m = 1, center = shift(h.b, {0, 1}));
                     TorsionSpring t(k = 0.9, a = world, b = h.b); end W;""")
    places = sorted(item.position["h.phi"] for item in model.equilibrium(starts=80))
    for phi in places:
        assert abs(0.9 * phi - G * np.sin(phi)) < 1e-9
    grid = np.linspace(-4, 4, 100_001)
    wanted = int((np.diff(np.sign(0.9 * grid - G * np.sin(grid))) != 0).sum())
    inside = [phi for phi in places if abs(phi) < 4]
    assert len(inside) >= min(3, wanted) and len(set(np.round(places, 6))) == len(places)


def test_time_and_inputs_of_an_equilibrium(scene: Write) -> None:
    """Loads act as they are at the time that is asked for, and inputs as they are given."""
    model = scene(TWO.replace("force = {F, 0}", "force = {F + 6*time, 0}"))
    K = np.array([[5, -2], [-2, 3]])
    (rest,) = model.equilibrium(time=0.5, inputs={"F": 2.0})
    close([rest.position["a.s"], rest.position["b.s"]], np.linalg.solve(K, [5, 0]))
    assert rest.stability == "asymptotically stable"


def test_nothing_to_rest_on(scene: Write) -> None:
    falling = scene("model Falling PointMass p(m = 1); end Falling;")
    assert len(falling.equilibrium()) == 0
    with pytest.raises(lag.RunError, match="no equilibrium was found"):
        falling.modes()


def test_the_start_where_it_is_no_equilibrium(scene: Write) -> None:
    """A is the exact Jacobian of the motion at a moving state."""
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    initial = {"shoulder.phi": 0.4, "elbow.phi": -0.7, "der(shoulder.phi)": 1.5, "der(elbow.phi)": -2.0}
    linear = model.linearize(about="start", initial=initial)
    q, v = [0.4, -0.7], [1.5, -2.0]
    functions, p = model.functions(), model.parameter_values()
    close(linear.A[2:], functions["jacobian"](0, q, v, [], p).full(), 1e-9)
    close(linear.drift[2:], functions["rhs"](0, q, v, [], p).full().ravel(), 1e-9)
    assert not linear.is_equilibrium


@pytest.mark.parametrize("name", ["suspended_bar", "disc_and_block", "cart_pole", "spring_pendulum", "four_bar", "scissor_lift",
                                  "parallelogram"])
def test_an_equilibrium_stays_where_it_is(name: str) -> None:
    """Simulated from the positions found, at rest and with loads as they are, nothing accelerates."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    for item in model.equilibrium(starts=6):
        if item.stability == "singular":
            continue
        q = [item.position[n] for n in model.coordinate_names]
        a = model.functions()["rhs"](0, q, np.zeros(len(q)), [], model.parameter_values()).full()
        assert np.abs(a).max() < 1e-6


def test_the_linear_form_of_the_suspended_bar() -> None:
    """M = diag(m, I), K = [[k1 + k2, L(k2 - k1)/2], [., L^2 (k1 + k2)/4]], load {P, P(a - L/2)}."""
    linear = lag.load(EXAMPLES / "suspended_bar.lag").linearize(parameters={"c1": 30.0, "c2": 50.0, "L": 1.5})
    close(linear.M, np.diag([10, 10 * 1.5**2 / 12]))
    close(linear.K, [[2500, 0.75 * 500], [0.75 * 500, 1.5**2 * 2500 / 4]])
    close(linear.C, [[80, 0.75 * 20], [0.75 * 20, 1.5**2 * 80 / 4]])
    close(linear.F[0].ravel(), [1, linear.F[0][1, 0]])


# ---------------------------------------------------------------- what a walk through the commands has brought up


def test_a_mass_in_a_turning_frame(scene: Write) -> None:
    """omega^4 - (k_x + k_y + 2 Omega^2) omega^2 + (k_x - Omega^2)(k_y - Omega^2) = 0: not those of M and K alone."""
    model = scene("""model Gyro World world(gravity = {0, 0}); Frame table = turn(world, 2*time);
        Prismatic px(a = table, along = {1, 0}), py(a = px.b, along = {0, 1}); PointMass m(m = 1, center = py.b);
        Spring sx(k = 9, stretch = px.s), sy(k = 16, stretch = py.s); end Gyro;""")
    modes = model.modes()
    close(sorted(d.omega**2 for d in modes.damped), np.sort(np.roots([1, -(9 + 16 + 2 * 4), (9 - 4) * (16 - 4)])), 1e-10)
    close(modes.omega**2, [5, 12])
    assert modes.is_gyroscopic and not modes.has_damping and "across the motion" in modes.notes[0]


def test_a_column_of_two_bars_buckles(scene: Write) -> None:
    """K = 4 k - 2 P L in the foot's angle, M = m (1/3 + 1/3) L^2: it buckles at P = 2 k/L."""
    model = scene("""model Buckle parameter Force P = 8; World world(gravity = {0, 0});
        Revolute foot(a = world, phi(start = 90[deg])), knee(a = lower.b, phi(start = 0));
        Bar lower(m = 1, L = 1, a = foot.b), upper(m = 1, L = 1, a = knee.b); TorsionSpring t(k = 3, a = lower.b, b = knee.b);
        PointOnLine guide(line = turn(world, 90[deg]), point = upper.b);
        AppliedForce load(at = upper.b, force = {0, -P}); end Buckle;""")
    for P in (5.9, 6.1, 8.0):
        (mode,) = model.modes(parameters={"P": P})
        close(mode.omega2, (4 * 3 - 2 * P) / (2 / 3), 1e-8)
        assert model.equilibrium(parameters={"P": P}, starts=1)[0].stability == ("stable" if P < 6 else "unstable")


def test_a_skate_across_a_slope_is_a_family() -> None:
    """Anywhere on the slope, the blade to either side: two families, not as many places as starts."""
    found = lag.load(EXAMPLES / "skate.lag").equilibrium()
    assert sorted(round(item.position["skate.center.phi"], 6) for item in found) == [-1.570796, 1.570796]


def test_loops_are_drawn_closed() -> None:
    """A shape is a straight line in the coordinates; the deflected mechanism stays one."""
    model = lag.load(EXAMPLES / "four_bar.lag")
    modes = model.modes()
    mechanism = modes.mechanism
    assert mechanism is not None
    q = np.array([modes.linearization.point[name] for name in modes.coordinates])
    places = mechanism.places(q + 0.3 * modes.shapes[:, 0])
    assert len({tuple(np.round(places[k, :2], 9)) for pair in mechanism.bodies for k in pair}) == 4 + 3  # hinges and centres


def test_what_is_opposed_lags_by_half_a_turn() -> None:
    """Above its only resonance an undamped mass moves against the force: -180 degrees, not 180."""
    response = lag.load(EXAMPLES / "crank_press.lag").response(frequencies=[1.0, 20.0])
    k = response.outputs.index("table.s")
    close(response.phase[:, k, 0], [0, -180])
    assert "O.phi" not in response.outputs and not any(name.startswith("der(") for name in response.outputs)
    assert response.units[response.outputs.index("pin.phi")] == response.units[-1] == "rad"


@pytest.mark.parametrize(("ground", "place", "moved"), [
    ("shift(world, {0.01*sin(3*time), 0})", "ground.x", "x"),
    ("turn(world, 0.01*sin(3*time))", "ground.phi", "phi"),
])
def test_a_support_carries_its_acceleration_to_what_stands_on_it(ground: str, place: str, moved: str, scene: Write) -> None:
    """Accelerations of frames are -omega^2 times their places, of those on the ground itself as of those on a spring."""
    model = scene(f"""model M
      World world(gravity = {{0, 0}});
      Frame ground = {ground};
      Block b(m = 1, base = ground, s(start = 0));
      Spring c(k = 100, stretch = b.s);
      Revolute h(a = b.center); Bar rod(m = 1, L = 1, a = h.b); TorsionSpring t(k = 40, twist = h.phi);
      output Real place = rod.b.{moved}; output Real jerk = der(der(rod.b.{moved}));
      output Real own = ground.{moved}; output Real felt = der(der(ground.{moved}));
    end M;""")
    frequencies = np.array([0.2, 1.0, 3.0])
    found = model.response([place], ["place", "jerk", "own", "felt"], frequencies=frequencies)
    carried, jerk, own, felt = (found.of(name) for name in ("place", "jerk", "own", "felt"))
    omega = 2 * np.pi * frequencies
    np.testing.assert_allclose(own, 1, atol=1e-12)
    np.testing.assert_allclose(felt, -omega**2, rtol=1e-9)
    np.testing.assert_allclose(jerk, -omega**2 * carried, rtol=1e-9, atol=1e-9)


RING = """model Ring World world(gravity = {0, 0}); PointMass p(m = 1, center(x(start = 0), y(start = 0)));
  Spring s(k = 4, s_rel0 = 0.5, a = world, b = p.center); end Ring;"""


def test_nothing_rests_on_a_cusp_of_the_potential(scene: Write) -> None:
    """A spring of no length has stiffness without bounds; round about it there is one family of positions of rest."""
    model = scene(RING)
    found = model.equilibrium()
    assert len(found) == 1
    assert np.hypot(found[0].position["p.center.x"], found[0].position["p.center.y"]) == pytest.approx(0.5, abs=1e-9)


def test_an_integral_of_a_controller_is_not_supported_yet(scene: Write) -> None:
    model = scene("""model Pid World world(gravity = {0, 0}); Block b(m = 1, base = world); coordinate Length z;
      SpringDamper k(k = 4, c = 3, stretch = b.s); AppliedForce f(at = b.center, force = {-3[N/m]*z, 0});
      equation der(z) = b.s*1[1/s]; end Pid;""")
    for ask in (model.equilibrium, model.modes, model.linearize):
        with pytest.raises(lag.LagError, match="not supported yet: equilibria and small motion where a constraint ties rates"):
            ask()


def test_a_column_under_its_critical_load_rests(scene: Write) -> None:
    model = scene("""model Column parameter TorsionStiffness k = 98.1;
      Revolute h(a = turn(world, 90[deg])); PointMass p(m = 10, center = shift(h.b, {1, 0}));
      TorsionSpring s(k = k, a = turn(world, 90[deg]), b = h.b); end Column;""")
    assert model.equilibrium()[0].position["h.phi"] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e8])
def test_equilibria_of_any_size(size: float, scene: Write) -> None:
    model = scene("""model Offset parameter Length s = 1;
      Revolute a(a = world, phi(start = 1)), b(a = x.b), c(a = g.b, b = y.b); Prismatic g(a = world, along = {1, 0});
      Bar x(m = 1, L = s, a = a.b), y(m = 1, L = 3*s, a = b.b); end Offset;""")
    found = model.equilibrium(parameters={"s": size})
    assert sorted(round(np.degrees(each.position["a.phi"])) % 360 for each in found) == [90, 90, 270, 270]


def test_where_a_distance_vanishes_is_no_equilibrium(scene: Write) -> None:
    """On a peg the rope's stiffness has no bounds, beside which any force would pass for nothing: unequal masses find no rest."""
    rope = """model M
      Rope r(n = 1, L = 2, a = p.center, b = q.center, pulley = {shift(world, {0, 1})});
      PointMass p(m = 1, center(x(start = -0.1), y(start = 0.2))), q(m = 1.5, center(x(start = 0.3), y(start = -0.1)));"""
    assert len(scene(rope + " end M;").equilibrium()) == 0
    (held,) = scene(rope + " Spring s(k = 100, s_rel0 = 0.3, a = shift(world, {0, -1}), b = p.center); end M;").equilibrium()
    assert held.residual < 1e-9 and held.is_stable
    assert held.position["q.center.y"] == pytest.approx(-held.position["p.center.y"])  # the peg is 1 m up, the rope 2 m long


def test_a_coordinate_without_mass_is_told_everywhere(scene: Write) -> None:
    """Where no mass of 0 says so before."""
    model = scene("""model Light parameter Real share = 1; coordinate Length x(start = 1), y; energy
      kinetic share*2[kg]*der(x)^2/2 + 1[kg]*der(y)^2; potential 2[N/m]*(x - y)^2; end Light;""")
    for ask in (model.modes, model.linearize):
        with pytest.raises(lag.RunError, match="the mass matrix is singular"):
            ask(about="start", parameters={"share": 0.0})
