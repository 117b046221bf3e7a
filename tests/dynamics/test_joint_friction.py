"""Friction that feels reactions: closed forms, and Newton-Euler equations integrated by SciPy."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.base.diagnostics import LagError

Write = Callable[[str], lag.Model]
Vector = np.ndarray
G = 9.81
SOLVERS = ("auto", "erk", "erk9", "adams", "implicit", "pirk", "taylor")


# ---------------------------------------------------------------- one joint

SLOPE = """model Slope
  parameter Angle alpha = 30[deg]; parameter Real mu = 0.3, mu_static = mu; parameter Force P = 0;
  RoughPrismatic guide(a = world, along = {cos(alpha), sin(alpha)}, mu = mu, mu_static = mu_static, v(start = 2));
  PointMass m(m = 2, center = guide.b);
  AppliedForce push(at = m.center, force = P*{sin(alpha), -cos(alpha)});
end Slope;"""


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_block_on_a_slope(scene: Write, solver: str) -> None:
    """Up against mu (m g cos + P), and down again with it; with much more it stays above, exactly."""
    sine, press, model = 0.5, G * np.sqrt(0.75) + 1.5 / 2, scene(SLOPE)
    up, down = G * sine + 0.3 * press, G * sine - 0.3 * press
    top, back = 2 / up, 1 - 2 / up
    run = model.simulate(parameters={"P": 1.5}, at=[1.0], solver=solver, tolerance=1e-10)
    assert run["guide.s"][-1] == pytest.approx(4 / (2 * up) - down * back**2 / 2, abs=1e-9)
    held = model.simulate(parameters={"P": 1.5, "mu_static": 0.6}, at=[1.0, 5.0], solver=solver, tolerance=1e-10)
    assert held["guide.s"] == pytest.approx([2 * top / 2] * 2, abs=1e-9)
    assert held["guide.s"][0] == held["guide.s"][1]
    assert list(held["guide.v"]) == [0.0, 0.0]


def test_a_sledge_that_locks_itself(scene: Write) -> None:
    """Pushed from above at an angle with tan(angle) > 1/mu no force moves it."""
    model = scene("""model Sledge
      parameter Angle angle = 60[deg]; parameter Force P = 100;
      RoughPrismatic guide(a = world, mu = 0.6);
      PointMass m(m = 2, center = guide.b);
      AppliedForce push(at = m.center, force = P*{cos(angle), -sin(angle)});
    end Sledge;""")
    for P in (100.0, 1e7):
        assert model.simulate(parameters={"P": P}, at=[1.0])["guide.s"][-1] == 0.0
    angle = np.radians(58.0)
    a = (1e4 * np.cos(angle) - 0.6 * (2 * G + 1e4 * np.sin(angle))) / 2
    run = model.simulate(parameters={"P": 1e4, "angle": angle}, at=[1.0])
    assert run["guide.s"][-1] == pytest.approx(a / 2, rel=1e-12)


def test_a_pin_that_nothing_presses_yet(scene: Write) -> None:
    """A force that grows from nothing begins to turn it, where the length of its reaction is 0 and has no series."""
    model = scene("""model Bar_
      World world(gravity = {0, 0});
      RoughRevolute hinge(a = world, mu = 0.3, radius = 0.02);
      Bar bar(m = 1, L = 1, a = hinge.b);
      AppliedForce push(at = bar.b, force = {0, 3[N/s]*time});
    end Bar_;""")

    def slope(t: float, y: Vector) -> Vector:
        e, turn = np.array([np.cos(y[0]), np.sin(y[0])]), 0.0
        for _ in range(20):  # the load is that of the acceleration that it lets
            load = np.hypot(*((turn * np.array([-e[1], e[0]]) - y[1] ** 2 * e) / 2 - [0, 3 * t]))
            turn = 3 * (3 * t * e[0] - 0.3 * 0.02 * load)
        return np.array([y[1], turn])

    right = solve_ivp(slope, (0, 1), [0, 0], method="DOP853", rtol=1e-12, atol=1e-14).y[0, -1]
    for solver in SOLVERS:
        assert model.simulate(at=[1.0], solver=solver, tolerance=1e-9)["hinge.phi"][-1] == pytest.approx(right, abs=1e-8)


PENDULUM = """model Pendulum
  RoughRevolute hinge(a = world, mu = 0.2, radius = 0.05, phi(start = 0.5[rad]), w(start = 8));
  Bar bar(m = 1, L = 1, a = hinge.b);
end Pendulum;"""


def pendulum(q: float, w: float, sign: float) -> tuple[float, float]:
    """The angular acceleration of the rod against its bearing, by repetition; and the force in this."""
    torque = 0.0
    while True:
        a = 3 * (torque - G / 2 * np.cos(q))
        x, y = -(np.cos(q) * w**2 + np.sin(q) * a) / 2, (np.cos(q) * a - np.sin(q) * w**2) / 2 + G
        found = -sign * 0.01 * np.hypot(x, y)
        if abs(found - torque) < 1e-15:
            return a, float(np.hypot(x, y))
        torque = found


def stopping_pendulum(end: float) -> tuple[float, Vector]:
    """When and where it is at the end, or when it sticks."""
    t, y, sign = 0.0, np.array([0.5, 8.0]), 1.0
    while t < end:
        def stops(_: float, y: Vector) -> float:
            return float(y[1])
        stops.terminal, stops.direction = True, -sign  # type: ignore[attr-defined]
        found = solve_ivp(lambda _, y, s=sign: [y[1], pendulum(y[0], y[1], s)[0]], (t, end), y, "DOP853", rtol=1e-12, atol=1e-13,
                          max_step=0.02, events=stops)
        t, y = found.t[-1], found.y[:, -1]
        if found.status == 1:
            y[1] = 0.0
            torque = G / 2 * np.cos(y[0])  # that holds it: then the bearing carries the weight
            if abs(torque) <= 0.01 * G:
                return t, y
            sign = -float(np.sign(torque))
    return t, y


def test_a_pendulum_turns_through_and_sticks(scene: Write) -> None:
    model, (_, y) = scene(PENDULUM), stopping_pendulum(12.0)
    for solver in SOLVERS:
        run = model.simulate(at=[12.0], solver=solver, tolerance=1e-11)
        assert run["hinge.phi"][-1] == pytest.approx(y[0], abs=2e-9), solver
        assert run["hinge.w"][-1] == pytest.approx(y[1], abs=2e-9), solver
    t, y = stopping_pendulum(60.0)
    run = model.simulate(at=[t - 1e-3, t + 1e-3, 100.0], tolerance=1e-11)
    assert run["hinge.phi"][1:] == pytest.approx([y[0]] * 2, abs=2e-9)
    assert run["hinge.w"][0] != 0
    assert list(run["hinge.w"][1:]) == [0.0, 0.0]
    assert run["hinge.phi"][1] == run["hinge.phi"][2]


def test_the_heat_of_a_bearing(scene: Write) -> None:
    """What the account takes out is what the energy loses."""
    text = PENDULUM.replace("Bar bar", "output Power heat = 0.01*hinge.load*abs(hinge.w); Bar bar")
    run = scene(text).simulate(stop=3.0, tolerance=1e-11)
    kinetic, height = run["hinge.w"] ** 2 / 6, np.sin(run["hinge.phi"]) / 2
    lost = -np.diff(kinetic + G * height)
    assert lost.sum() > 1
    assert lost == pytest.approx((run["heat"][1:] + run["heat"][:-1]) / 2 * np.diff(run["time"]), abs=2e-3)


# ---------------------------------------------------------------- several

CRANK = """model Crank
  parameter Real mu = 0.2;
  RoughRevolute crank(a = world, mu = mu, radius = 0.03, phi(start = 0.3[rad], fixed = true), w(start = 12, fixed = true));
  Bar arm(m = 1, L = 0.2, a = crank.b);
  RoughRevolute pin(a = arm.b, mu = mu, radius = 0.02);
  Bar rod(m = 1.5, L = 0.5, a = pin.b);
  RoughRevolute wrist(a = rod.b, mu = mu, radius = 0.02);
  RoughPrismatic guide(a = world, b = wrist.b, mu = mu/2);
  PointMass piston(m = 0.8, center = guide.b);
end Crank;"""


def cross(a: Vector, b: Vector) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def crank(q: float, w: float, signs: Vector) -> tuple[float, float]:
    """The angular acceleration of the crank, by Newton's and Euler's equations of its three bodies, and the force of the guide:
    forces of friction by repetition."""
    b = -np.arcsin(0.4 * np.sin(q))
    e, f, n, k = (np.array(x) for x in ((np.cos(q), np.sin(q)), (np.cos(b), np.sin(b)), (-np.sin(q), np.cos(q)),
                                        (-np.sin(b), np.cos(b))))
    slope = -0.4 * e[0] / f[0]
    bent = (0.2 * e[1] * w**2 + 0.5 * f[1] * (slope * w) ** 2) / (0.5 * f[0])  # of the rod's acceleration
    M, known = np.zeros((8, 8)), np.zeros(8)  # of a, forces on arm, rod and piston, force of the guide
    M[0:2, 0], M[0:2, 1:3], M[0:2, 3:5] = 0.1 * n, -np.eye(2), np.eye(2)
    known[0:2] = 0.1 * e * w**2 + [0, -G]
    M[2, 0], M[2, 1:3], M[2, 3:5] = 0.2**2 / 12, [-0.1 * e[1], 0.1 * e[0]], [-0.1 * e[1], 0.1 * e[0]]
    M[3:5, 0], M[3:5, 3:5], M[3:5, 5:7] = 1.5 * (0.2 * n + 0.25 * slope * k), -np.eye(2), np.eye(2)
    known[3:5] = -1.5 * (-0.2 * e * w**2 + 0.25 * (bent * k - f * (slope * w) ** 2)) + [0, -1.5 * G]
    M[5, 0], M[5, 3:5], M[5, 5:7] = 1.5 * 0.25 / 12 * slope, [-0.25 * f[1], 0.25 * f[0]], [-0.25 * f[1], 0.25 * f[0]]
    known[5] = -1.5 * 0.25 / 12 * bent
    M[6:8, 0], M[6:8, 5:7], M[7, 7] = 0.8 * (0.2 * n + 0.5 * slope * k), -np.eye(2), -1.0
    known[6:8] = -0.8 * (-0.2 * e * w**2 + 0.5 * (bent * k - f * (slope * w) ** 2)) + [0, -0.8 * G]
    inverse, rub = np.linalg.inv(M), np.zeros(4)
    while True:
        more = np.array([0, 0, rub[0] - rub[1], 0, 0, rub[1] - rub[2], rub[3], 0])
        x = inverse @ (known + more)
        sizes = np.hypot(x[[1, 3, 5, 7]], [x[2], x[4], x[6], 0]) * [0.006, 0.004, 0.004, 0.1]
        if np.abs(-signs * sizes - rub).max() < 1e-13:
            return float(x[0]), float(x[7])
        rub = -signs * sizes


def rates(y: Vector) -> Vector:
    """Of the crank, of the rod against it, of the guide against the rod, of the piston."""
    q, w = y
    b = -np.arcsin(0.4 * np.sin(q))
    turn = -0.4 * np.cos(q) / np.cos(b) * w
    return np.array([w, turn - w, -turn, -0.2 * np.sin(q) * w - 0.5 * np.sin(b) * turn])


def test_a_slider_crank_that_rubs_everywhere(scene: Write) -> None:
    """Four frictions, each of which changes all reactions, in a closed loop."""
    t, y, end = 0.0, np.array([0.3, 12.0]), 1.0
    while t < end:
        signs = np.sign(rates(y + 1e-9 * np.array([y[1], crank(*y, np.sign(rates(y)))[0]])))
        events = [lambda _, y, k=k: rates(y)[k] for k in range(4)] + [lambda _, y, s=signs: crank(*y, s)[1]]
        for event in events:
            event.terminal = True  # type: ignore[attr-defined]
        known = {"fun": lambda _, y, s=signs: [y[1], crank(*y, s)[0]], "method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
        begin = solve_ivp(t_span=(t, min(t + 1e-6, end)), y0=y, **known)
        found = solve_ivp(t_span=(begin.t[-1], end), y0=begin.y[:, -1], events=events, **known)
        t, y = found.t[-1], found.y[:, -1]
    run = scene(CRANK).simulate(at=[end], tolerance=1e-12)
    assert run["crank.phi"][-1] == pytest.approx(y[0], abs=1e-9)
    assert run["crank.w"][-1] == pytest.approx(y[1], abs=1e-8)


def test_solvers_agree_about_it(scene: Write) -> None:
    model = scene(CRANK)
    runs = [model.simulate(at=[3.0], tolerance=1e-11, solver=solver)["crank.phi"][-1] for solver in ("erk", "adams", "implicit")]
    assert runs == pytest.approx([runs[0]] * 3, abs=2e-8)


def test_all_frictions_hold_together(scene: Write) -> None:
    """A four-bar under its weight, held by the friction of its bearings: nothing moves, and the forces are in balance."""
    model = scene(CRANK.replace("mu = 0.2;", "mu = 2;").replace("w(start = 12, fixed = true)", "w(start = 0)"))
    run = model.simulate(at=[0.0, 1.0, 50.0])
    assert list(run["crank.phi"]) == [0.3] * 3
    assert list(run["crank.w"]) == [0.0] * 3


# ---------------------------------------------------------------- ropes, wheels, gears


def test_a_capstan(scene: Write) -> None:
    """Euler and Eytelwein: one side pulls exp(mu pi) times as much; below that ratio of weights it holds."""
    model = scene("""model Capstan2
      parameter Mass m = 3;
      Prismatic left(a = world, along = {0, -1}), right(a = world, along = {0, -1});
      PointMass A(m = 1, center = left.b), B(m = m, center = right.b);
      output Force mean = rope.tension;
      Capstan rope(mu = 0.2, angle = 180[deg], L = 3, s_a = 1 + left.s, s_b = 2 + right.s);
    end Capstan2;""")
    e = np.exp(0.2 * np.pi)
    run = model.simulate(at=[1.0])
    a = G * (3 - e) / (3 + e)
    assert run["right.s"][-1] == pytest.approx(a / 2, rel=1e-11)
    assert run["mean"][-1] == pytest.approx((3 * (G - a) + G + a) / 2, rel=1e-11)
    assert model.simulate(parameters={"m": 0.999 * e}, at=[5.0])["right.s"][-1] == 0.0


def test_a_wheel_rolls_or_slides(scene: Write) -> None:
    """A disc on a slope rolls where tan(alpha) <= 3 mu, and slides beyond it; thrown without turning it slides, then rolls."""
    model = scene("""model Wheel
      parameter Angle alpha = 30[deg]; parameter Real mu = 0.1;
      RoughWheel wheel(base = turn(world, -alpha), r = 0.3, mu = mu);
      Disc disc(m = 2, r = 0.3, center = wheel.center);
    end Wheel;""")
    sine, cosine = 0.5, np.sqrt(0.75)
    run = model.simulate(at=[1.0])
    assert run["wheel.s"][-1] == pytest.approx(G * (sine - 0.1 * cosine) / 2, rel=1e-11)
    assert run["wheel.phi"][-1] == pytest.approx(-2 * 0.1 * G * cosine / 0.3 / 2, rel=1e-11)
    run = model.simulate(parameters={"mu": 0.2}, at=[1.0])
    assert run["wheel.s"][-1] == pytest.approx(G * sine / 3, rel=1e-11)
    assert run["wheel.phi"][-1] == pytest.approx(-run["wheel.s"][-1] / 0.3, rel=1e-14)
    run = model.simulate(parameters={"alpha": 0.0}, initial={"der(wheel.s)": 3.0}, at=[3.0])
    rolls = 3 / (3 * 0.1 * G)
    assert run["der(wheel.s)"][-1] == pytest.approx(2.0, rel=1e-11)
    assert run["wheel.s"][-1] == pytest.approx(3 * rolls - 0.1 * G * rolls**2 / 2 + 2 * (3 - rolls), rel=1e-10)


def test_the_efficiency_of_a_gear(scene: Write) -> None:
    """Whichever side drives, the other gets eta times its power."""
    text = """model Geared
      parameter Torque t1 = 0.5, t2 = 0;
      Revolute x(a = world), y(a = shift(world, {0.3, 0}));
      Disc A(m = 1, r = 0.1, center = x.b), B(m = 2, r = 0.2, center = y.b);
      RoughGear gear(r_a = 0.1, r_b = 0.2, eta = 0.8, a = A.center, b = B.center, carrier = world);
      AppliedTorque on_a(on = A.center, torque = t1), on_b(on = B.center, torque = t2);
    end Geared;"""
    model = scene(text)
    a, b = 1 * 0.1**2 / 2, 2 * 0.2**2 / 2
    first = 0.5 / (a + b / 4 / 0.8)
    assert model.simulate(at=[1.0])["x.phi"][-1] == pytest.approx(first / 2, rel=1e-11)
    second = 0.5 / (b + 4 * a / 0.8)
    assert model.simulate(parameters={"t1": 0.0, "t2": 0.5}, at=[1.0])["y.phi"][-1] == pytest.approx(second / 2, rel=1e-11)


# ---------------------------------------------------------------- what has no answer

PAINLEVE = """model Painleve
  RoughPrismatic guide(a = world, mu = 2, v(start = 1));
  PointMass light(m = 0.05, center = guide.b);
  Revolute hinge(a = guide.b, phi(start = -60[deg]));
  Bar rod(m = 2, L = 1, a = hinge.b);
end Painleve;"""


def test_painleves_paradox_is_told(scene: Write) -> None:
    """Dragged with its rod ahead, the slider would press itself more than its friction takes: mu |dN/dF| > 1."""
    model = scene(PAINLEVE.replace("v(start = 1)", "v(start = -1)").replace("-60", "60"))
    for text in (PAINLEVE, PAINLEVE.replace("-60", "-120"), PAINLEVE.replace("-60", "60")):
        with pytest.raises(lag.RunError, match="Painleve"):
            scene(text).simulate(at=[1.0])
    with pytest.raises(lag.RunError, match="Painleve"):
        model.simulate(at=[1.0])
    assert scene(PAINLEVE.replace("mu = 2", "mu = 0.5")).simulate(at=[1.0])["guide.v"].size


def test_what_is_not_there_yet_is_told(scene: Write) -> None:
    model = scene(PENDULUM)
    with pytest.raises(LagError, match="L0914"):
        model.equilibrium()
    with pytest.raises(LagError, match="L0914"):
        model.equations()
    bounces, shaken = "equation when hinge.phi < 0 then reinit(hinge.w, -pre(hinge.w)); end when;", (
        "Prismatic x(a = world); Motion m(of = x.s, to = if time < 1 then 1[m/s]*time else 2[m/s]*time - 1[m]);")
    for text in (PENDULUM.replace("end Pendulum", f"{bounces} end Pendulum"),
                 PENDULUM.replace("world", "x.b").replace("end Pendulum", f"{shaken} end Pendulum")):
        with pytest.raises(LagError, match="L0914"):
            assert scene(text).scene
