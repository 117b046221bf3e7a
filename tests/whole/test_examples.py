"""Every model in models/examples runs, closes its energy account and agrees with equations written here by hand."""

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy import cos, sin
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk

import lagrangia as lag
from helpers.reference import Array, integrate, linear_response
from helpers.spatial_examples import REFERENCES as SPATIAL
from whole.test_loop_examples import REFERENCES as LOOPS
from whole.test_space_examples import REFERENCES as SPACE
from whole.test_space_loop_examples import REFERENCES as SPACE_LOOPS

FOLDER = Path(__file__).parents[2] / "models" / "examples"
EXAMPLES = sorted(FOLDER.glob("*.lag"))
ANNOTATION = re.compile(r"annotation\((?:allow = \"\w+\", )?experiment\(StopTime = ([\d.]+), Tolerance = ([\d.e-]+)\)\);")
g = 9.81

Columns = dict[str, Array]


# ---------------------------------------------------------------- the examples, on paper


def suspended_bar(t: Array) -> Columns:
    """Centre at height x, tilt theta, springs at the ends; P acts at the distance a from the left end:

    m x''     + (k1 + k2) x + (L/2)(k2 - k1) sin theta                                   = P + f_x
    I theta'' + (L/2)(k2 - k1) x cos theta + (L^2/4)(k1 + k2) sin theta cos theta        = P (a - L/2) cos theta + f_theta
    f_x     = -(c1 + c2) x' - (c2 - c1)(L/2) cos theta theta'
    f_theta = -(L/2) cos theta (c2 - c1) x' - (L cos theta/2)^2 (c1 + c2) theta'
    """
    m, L, a, k1, k2, c1, c2 = 10, 2, 1.5, 1000, 1500, 20, 20

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (x, theta), (dx, w) = q, v
        P, arm = 50 * sin(3 * t), L / 2 * cos(theta)
        force = P - (k1 + k2) * x - (k2 - k1) * L / 2 * sin(theta) - (c1 + c2) * dx - (c2 - c1) * arm * w
        moment = P * (a - L / 2) * cos(theta) - arm * ((k2 - k1) * x + (k1 + k2) * L / 2 * sin(theta))
        moment -= arm * ((c2 - c1) * dx + arm * (c1 + c2) * w)
        return np.array([force / m, moment / (m * L**2 / 12)])

    (x, theta), (dx, w) = integrate(acceleration, [0, np.radians(5)], [0, 0], t)
    return {"guide.s": x, "y": x, "tilt.phi": theta, "der(guide.s)": dx, "tilt.w": w}


def disc_and_block(t: Array, c1: float = 0, c2: float = 0) -> Columns:
    """Block at s, disc turned by phi; the second spring is stretched by r phi - s:

    m s'' + k1 s + c1 s'       = k2 (r phi - s) + c2 (r phi' - s')
    I phi'' + r (k2 (r phi - s) + c2 (r phi' - s')) = 0.5 sin 2t,      I = md r^2/2
    """
    m, md, r, k1, k2 = 2, 5, 0.2, 100, 50

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (s, phi), (ds, w) = q, v
        tie = k2 * (r * phi - s) + c2 * (r * w - ds)
        return np.array([(tie - k1 * s - c1 * ds) / m, (0.5 * sin(2 * t) - r * tie) / (md * r**2 / 2)])

    (s, phi), (ds, w) = integrate(acceleration, [0, 0], [0, 0], t)
    return {"block.s": s, "axle.phi": phi, "block.v": ds, "axle.w": w}


def disc_and_block_damped(t: Array) -> Columns:
    return disc_and_block(t, c1=2, c2=1)


def pendulum(t: Array) -> Columns:
    """L phi'' = -g sin phi from rest at phi0: sin(phi/2) = k sn(K(k) - sqrt(g/L) t, k) with k = sin(phi0/2)."""
    k = sin(np.pi / 4)
    sn = ellipj(ellipk(k**2) - np.sqrt(g) * t, k**2)[0]
    phi = 2 * np.arcsin(k * sn)
    return {"hinge.phi": phi, "bob.center.x": sin(phi), "bob.center.y": -cos(phi)}


def double_pendulum(t: Array) -> Columns:
    """Angles A, B of the two bars from the horizontal, D = B - A, Ji = mi Li^2/3 about a bar's own hinge:

    (J1 + m2 L1^2) A'' + (m2 L1 L2/2)(B'' cos D - B'^2 sin D) + (m1/2 + m2) g L1 cos A = 0
    J2 B''             + (m2 L1 L2/2)(A'' cos D + A'^2 sin D) + (m2/2)      g L2 cos B = 0
    """
    m1, L1, m2, L2 = 1, 1, 0.5, 0.7

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (A, B), (dA, dB) = q, v
        coupling = m2 * L1 * L2 / 2
        M = [
            [m1 * L1**2 / 3 + m2 * L1**2, coupling * cos(B - A)],
            [coupling * cos(B - A), m2 * L2**2 / 3],
        ]
        load = [
            coupling * dB**2 * sin(B - A) - (m1 / 2 + m2) * g * L1 * cos(A),
            -coupling * dA**2 * sin(B - A) - m2 / 2 * g * L2 * cos(B),
        ]
        return np.linalg.solve(M, load)

    (A, B), (dA, dB) = integrate(acceleration, [0, np.pi / 3], [0, 0], t)
    return {"shoulder.phi": A, "elbow.phi": B - A, "shoulder.w": dA, "elbow.w": dB - dA}


def chain(t: Array) -> Columns:
    """n equal bars at the angles A_i from the horizontal. With a_ij = 1/2 + n - max(i, j) and a_ii = 1/3 + n - i:

    m L^2 sum_j a_ij (A_j'' cos(A_i - A_j) + A_j'^2 sin(A_i - A_j)) + m g L (1/2 + n - i) cos A_i = 0
    """
    n, L = 5, 0.5
    i = np.arange(1, n + 1)
    a = 0.5 + n - np.maximum.outer(i, i) - np.diag(np.full(n, 1 / 6))

    def acceleration(t: float, q: Array, v: Array) -> Array:
        difference = np.subtract.outer(q, q)
        return np.linalg.solve(a * cos(difference), -(a * sin(difference)) @ v**2 - g / L * (0.5 + n - i) * cos(q))

    q, v = integrate(acceleration, np.ones(n), np.zeros(n), t)
    phi, w = np.diff(q, axis=0, prepend=0), np.diff(v, axis=0, prepend=0)
    return {f"hinge[{k}].phi": phi[k - 1] for k in i} | {f"hinge[{k}].w": w[k - 1] for k in i}


def cart_pole(t: Array) -> Columns:
    """Cart at s, pole leaning by phi to the left of upright, l = L/2:

    (M + m) s'' - m l (phi'' cos phi - phi'^2 sin phi) = F = 3 s + 5 s' - 45 phi - 11 phi'
    (4/3) l phi'' - s'' cos phi - g sin phi            = 0
    """
    M, m, l = 1, 0.1, 0.5

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (s, phi), (ds, w) = q, v
        F = 3 * s + 5 * ds - 45 * phi - 11 * w
        matrix = [[M + m, -m * l * cos(phi)], [-cos(phi), 4 / 3 * l]]
        return np.linalg.solve(matrix, [F - m * l * w**2 * sin(phi), g * sin(phi)])

    (s, phi), (ds, w) = integrate(acceleration, [0, np.radians(20)], [0, 0], t)
    return {"cart.s": s, "hinge.phi": phi, "cart.v": ds, "hinge.w": w, "top": 2 * l * cos(phi)}


def spring_pendulum(t: Array) -> Columns:
    """In polar coordinates, theta from the downward vertical, with k/m = 3 g/L:

    r'' = r theta'^2 + g cos theta - (k/m)(r - L),      r theta'' = -2 r' theta' - g sin theta
    """
    L, x, y = 1, 0.1, -1.5

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (r, theta), (dr, w) = q, v
        return np.array([r * w**2 + g * cos(theta) - 3 * g / L * (r - L), (-2 * dr * w - g * sin(theta)) / r])

    (r, theta), _ = integrate(acceleration, [np.hypot(x, y), np.arctan2(x, -y)], [0, 0], t)
    return {"bob.center.x": r * sin(theta), "bob.center.y": -r * cos(theta)}


def quarter_car(t: Array) -> Columns:
    """Wheel at y2 and car at y1 above rest, h(t) the road's height, 1 - cos between 0.5 s and 0.6 s:

    m1 y1'' = -k1 (y1 - y2) - c1 (y1' - y2'),      m2 y2'' = k1 (y1 - y2) + c1 (y1' - y2') - k2 (y2 - h)
    """
    m1, m2, k1, k2, c1 = 300, 40, 20e3, 180e3, 1.5e3

    def acceleration(t: float, q: Array, v: Array) -> Array:
        h = 0.04 * (1 - cos(2 * np.pi * (10 * t - 5))) if 0.5 < t < 0.6 else 0
        suspension = k1 * (q[0] - q[1]) + c1 * (v[0] - v[1])
        return np.array([-suspension / m1, (suspension - k2 * (q[1] - h)) / m2])

    q, v = integrate(acceleration, [0, 0], [0, 0], t, breaks=[0.5, 0.6])
    return {"car.s": q[0], "wheel.s": q[1], "car.v": v[0], "felt": -(k1 * (q[0] - q[1]) + c1 * (v[0] - v[1])) / m1}


def vibration_absorber(t: Array) -> Columns:
    """Machine at s, absorber at s + u, k = m Omega^2; at last s = 0 and u = -(F/k) sin Omega t:

    (M + m) s'' + m u'' + C s' + K s = F sin Omega t,      m s'' + m u'' + k u = 0
    """
    M, m, K, C, Omega, F = 10, 1, 4000, 30, 18, 10
    k = m * Omega**2
    s, u = linear_response([[M + m, m], [m, m]], [[C, 0], [0, 0]], [[K, 0], [0, k]], t, load=[F, 0], Omega=Omega, q0=[0, 0])
    return {"machine.s": s, "absorber.s": u}


def free_bar(t: Array) -> Columns:
    """The centre flies along the parabola of a thrown point, and the bar turns evenly."""
    x, y, phi = 3 * t, 4 * t - g * t**2 / 2, 5 * t
    return {"bar.center.x": x, "bar.center.y": y, "bar.center.phi": phi, "height": y + sin(phi) / 2}


def torsion_rotor(t: Array) -> Columns:
    """Motor (inertia I1, angle A) and rotor (I2, B) on the shaft k, c; T acts on the motor for the time tau since 0.5 s:

    I1 A + I2 B = T tau^2/2
    z = B - A:  J z'' + c z' + k z = -T J/I1,  1/J = 1/I1 + 1/I2, and so with d = c/2J, w^2 = k/J - d^2
    z = -(T J/I1 k) (1 - e^(-d tau) (cos w tau + (d/w) sin w tau))
    """
    I1, I2, k, c, T = 4 * 0.1**2 / 2, 10 * 0.2**2 / 2, 50, 0.1, 2
    J = I1 * I2 / (I1 + I2)
    d = c / J / 2
    w = np.sqrt(k / J - d**2)
    tau = np.maximum(t - 0.5, 0)
    z = -T / I1 * J / k * (1 - np.exp(-d * tau) * (cos(w * tau) + d / w * sin(w * tau)))
    A = (T * tau**2 / 2 - I2 * z) / (I1 + I2)
    return {"bearing[1].phi": A, "bearing[2].phi": A + z, "twist": z}


def stick_slip(t: Array) -> Columns:
    """It slides with slip = s' - belt < 0, from s0 and v0, until s' = belt; then it sticks until k s = F, and so on:

    s'' - fall s' + k s = F - fall belt,    s = s_e + e^(fall t/2) (A cos w t + B sin w t),    w^2 = k - fall^2/4
    """
    k, belt, F, fall = 20, 0.1, 3, 0.5
    middle, w = (F - fall * belt) / k, np.sqrt(k - fall**2 / 4)

    def swing(x: Array, A: float, B: float) -> Array:
        return middle + np.exp(fall / 2 * x) * (A * cos(w * x) + B * sin(w * x))

    def slip(x: float, A: float, B: float) -> float:
        return swing(x, fall / 2 * A + w * B, fall / 2 * B - w * A) - middle - belt

    begin, s0, v0, s = 0.0, 0.0, 0.0, np.empty_like(t)
    while begin <= t[-1]:
        ways = s0 - middle, (v0 - fall / 2 * (s0 - middle)) / w
        until = (0, np.pi / 2 / w) if v0 < belt else (np.pi / w, 2 * np.pi / w)
        caught = brentq(slip, *until, ways, xtol=1e-15)
        place = swing(caught, *ways)
        torn = begin + caught + (F / k - place) / belt
        slides, sticks = (t >= begin) & (t < begin + caught), (t >= begin + caught) & (t < torn)
        s[slides], s[sticks] = swing(t[slides] - begin, *ways), place + belt * (t[sticks] - begin - caught)
        begin, s0, v0 = torn, F / k, belt
    return {"block.s": s}


def bouncing_ball(t: Array) -> Columns:
    """Parabolas between bounces, each with e times the speed: on the table, whose edge it leaves at rest, then on the floor."""
    e, H, x_edge, y, u = 0.7, 0.8, 1.8, 1.3, 0.6
    place, begin = np.empty_like(t), 0.0
    for level, end in ((H, x_edge / u), (0.0, np.inf)):
        fall = np.sqrt(2 * (y - level) / g)
        now = (t >= begin) & (t < end)
        place[now] = y - g * (t[now] - begin) ** 2 / 2
        begin, v = begin + fall, e * g * fall
        while v > 1e-15:
            now = (t >= begin) & (t < end)
            place[now] = level + v * (t[now] - begin) - g * (t[now] - begin) ** 2 / 2
            begin, v = begin + 2 * v / g, e * v
        place[(t >= begin) & (t < end)] = level
        begin, y = end, level
    return {"x.s": u * t, "y.s": place}


def road_at_knots() -> CubicSpline:
    """The height of the road over the time of the car, m by s: the spline through the file's rows, at 10 m/s."""
    x, z = np.loadtxt(FOLDER / "road_profile.csv", delimiter=",", skiprows=1).T
    return CubicSpline(x / 10, z / 1000)


def rough_road(t: Array) -> Columns:
    """As quarter_car, on the spline of the road's rows, at whose knots its third derivative jumps."""
    m1, m2, k1, k2, c1 = 300, 40, 20e3, 180e3, 1.5e3
    road = road_at_knots()

    def acceleration(t: float, q: Array, v: Array) -> Array:
        suspension = k1 * (q[0] - q[1]) + c1 * (v[0] - v[1])
        return np.array([-suspension / m1, (suspension - k2 * (q[1] - road(t))) / m2])

    q, v = integrate(acceleration, [0, 0], [0, 0], t, breaks=[x for x in road.x if 0 < x < t[-1]])
    felt = -(k1 * (q[0] - q[1]) + c1 * (v[0] - v[1])) / m1
    return {"car.s": q[0], "wheel.s": q[1], "felt": felt, "load": k1 * (q[0] - q[1])}


def dc_motor_stick_slip(t: Array) -> Columns:
    """The load rests while the shaft's torque is below what tears it off, and then slips with its speed above 0. Between such
    moments z = (phi1, w1, phi2, w2, i, I, 1) obeys z' = A z with constant A:

    J1 w1' = k_m i - k (phi1 - phi2) - c (w1 - w2),      J2 w2' = k (phi1 - phi2) + c (w1 - w2) - tau,
    L i' = K (e + I) - R i - k_m w1,      I' = e/Ti,      e = w - w1
    """
    J1, J2, k, c, tau, holds = 0.5 * 0.06**2 / 2, 4 * 0.15**2 / 2, 2, 0.02, 0.3, 0.5
    R, L, k_m, K, Ti, w = 1.2, 6e-3, 0.15, 2, 0.1, 0.5
    torque = np.array([k, c, -k, -c, 0, 0, 0])
    A = np.zeros((7, 7))
    A[0, 1] = A[2, 3] = 1
    A[1] = -torque / J1
    A[1, 4] += k_m / J1
    A[3] = torque / J2
    A[3, 6] = -tau / J2
    A[4] = np.array([0, -K - k_m, 0, 0, -R, K, K * w]) / L
    A[5] = np.array([0, -1, 0, 0, 0, 0, w]) / Ti
    rest = A.copy()
    rest[2:4] = 0
    z, begin, is_at_rest, found = np.array([0, 0, 0, 0, 0, 0, 1.0]), 0.0, True, np.empty((len(t), 7))
    while begin <= t[-1]:
        matrix, left = (rest, torque) if is_at_rest else (A, np.eye(7)[3])
        level = holds if is_at_rest else 0.0

        def beyond(x: float, z: Array = z, matrix: Array = matrix, left: Array = left, level: float = level) -> float:
            return float(left @ expm(matrix * x) @ z) - level

        steps = np.arange(1, 200) * 0.02
        last = next(x for x in steps if (beyond(x) > 0) == is_at_rest)
        end = float(brentq(beyond, max(last - 0.02, 1e-6), last, xtol=1e-15))
        now = (t >= begin) & (t < begin + end)
        found[now] = (expm(np.multiply.outer(t[now] - begin, matrix)) @ z)[:, :7]
        z, begin, is_at_rest = expm(matrix * end) @ z, begin + end, not is_at_rest
        z[3] = 0.0
    phi1, w1, phi2, w2, i, _, _ = found.T
    return {"axle.phi": phi1, "axle.w": w1, "bearing.phi": phi2, "load_speed": w2, "motor.i": i, "shaft.twist": phi2 - phi1}


# The motion magnifies all errors, those of SciPy too, as bars do that lie flat again and again: compared until here only.
CHAOTIC_AFTER = {"chain": 2.0, "double_pendulum": 6.0, "n_four_bars": 2.0}

def crane(t: Array) -> Columns:
    """Trolley at x, load at x + L sin phi; F is held from late after an instant on:

    (M + m) x'' + m L (cos phi phi'' - sin phi phi'^2) = F - c x',    L phi'' + cos phi x'' + g sin phi = 0
    """
    M, m, L, way, Ts, late, most, c = 800, 2000, 8, 12, 0.1, 0.02, 4000, 150
    state, F, before = np.zeros(4), 0.0, np.zeros(2)
    rows: list[Array] = []
    forces: list[float] = []

    def acceleration(_t: float, q: Array, v: Array) -> Array:
        (_, phi), (dx, w) = q, v
        A = [[M + m, m * L * cos(phi)], [cos(phi), L]]
        return np.linalg.solve(A, [F - c * dx + m * L * sin(phi) * w**2, -g * sin(phi)])

    for k in range(round(t[-1] / Ts)):
        here = state[:2]
        rates = (here - before) / Ts
        wanted = np.clip(1550 * (way - here[0]) - 3200 * rates[0] + 400 * here[1] - 7500 * rates[1], -most, most)
        before = here
        for begin, end, force in ((k * Ts, k * Ts + late, F), (k * Ts + late, (k + 1) * Ts, wanted)):
            F = force
            inside = t[(begin < t) & (t <= end + 1e-9)] if rows else t[t <= end + 1e-9]
            times = np.unique(np.concatenate([[begin], np.minimum(inside, end), [end]]))
            q, v = integrate(acceleration, state[:2], state[2:], times)
            found = np.vstack([q, v])
            rows += [found[:, np.argmin(np.abs(times - x))] for x in inside]
            forces += [F] * len(inside)
            state = found[:, -1]
    x, phi, dx, w = np.array(rows).T
    found = {"trolley.s": x, "hook.phi": phi, "der(trolley.s)": dx, "hook.w": w}
    return {**found, "F": np.array(forces), "reached": x + L * sin(phi)}


REFERENCES: dict[str, Callable[[Array], Columns]] = {
    "bouncing_ball": bouncing_ball,
    "cart_pole": cart_pole,
    "chain": chain,
    "crane": crane,
    "dc_motor_stick_slip": dc_motor_stick_slip,
    "disc_and_block": disc_and_block,
    "disc_and_block_damped": disc_and_block_damped,
    "double_pendulum": double_pendulum,
    "free_bar": free_bar,
    "pendulum": pendulum,
    "quarter_car": quarter_car,
    "rough_road": rough_road,
    "spring_pendulum": spring_pendulum,
    "stick_slip": stick_slip,
    "suspended_bar": suspended_bar,
    "torsion_rotor": torsion_rotor,
    "vibration_absorber": vibration_absorber,
    **LOOPS,
    **SPATIAL,
    **SPACE,
    **SPACE_LOOPS,
}

# ---------------------------------------------------------------- the tests


@pytest.fixture(scope="module", params=EXAMPLES, ids=lambda path: path.stem)
def example(request: pytest.FixtureRequest) -> Path:
    return request.param


def assert_follows(run: lag.Trajectory, expected: Columns) -> None:
    """Each column agrees to 10^-11 of its amplitude."""
    for name, values in expected.items():
        np.testing.assert_allclose(run[name], values, rtol=0, atol=1e-11 * np.abs(values).max(), err_msg=name)


def test_runs_as_annotated_and_closes_its_energy_account(example: Path) -> None:
    stop, tolerance = map(float, ANNOTATION.search(example.read_text(encoding="utf-8")).groups())
    run = lag.load(example).simulate()
    energy = run.energy
    largest = max(np.abs(part).max() for part in (energy.kinetic, energy.potential, energy.dissipated, energy.work))
    assert run.time[-1] == stop
    assert largest > 0
    assert np.abs(energy.residual).max() < tolerance * largest


def test_follows_the_equations_on_paper(example: Path) -> None:
    assert example.stem in REFERENCES, "a new example needs its equations here"
    model = lag.load(example)
    t = np.linspace(0, CHAOTIC_AFTER.get(example.stem, model.scene.stop), 61)
    assert_follows(model.simulate(at=t, tolerance=1e-13), REFERENCES[example.stem](t))


def test_the_damage_of_the_rough_road() -> None:
    """Cycles of the motion on paper by four points, halves of what is left (Amzallag et al., Int. J. Fatigue 16, 1994)."""
    t = np.linspace(0, 6, 6001)
    load = rough_road(t)["load"]
    turns: list[float] = [load[0]]
    for k in range(1, len(t) - 1):
        if (load[k] - load[k - 1]) * (load[k + 1] - load[k]) < 0:
            a, b, c = load[k - 1 : k + 2]
            turns.append(b - (c - a) ** 2 / (8 * (a - 2 * b + c)))  # of the parabola through three
    turns.append(load[-1])
    ranges: list[tuple[float, float]] = []
    kept: list[float] = []
    for y in turns:
        kept.append(y)
        while len(kept) >= 4 and abs(kept[-2] - kept[-3]) <= min(abs(kept[-1] - kept[-2]), abs(kept[-3] - kept[-4])):
            ranges.append((abs(kept[-2] - kept[-3]), 1.0))
            del kept[-3:-1]
    ranges += [(abs(b - a), 0.5) for a, b in pairwise(kept)]
    expected = sum(count * (size / 1e4) ** 5 for size, count in ranges)
    found = lag.load(FOLDER / "rough_road.lag").measure("damage(load, 5, 10[kN])", tolerance=1e-11)
    assert found["damage(load, 5, 10[kN])"] == pytest.approx(expected, rel=1e-6)


def test_small_motion_of_the_suspended_bar_is_linear() -> None:
    """Mass and stiffness 10^6 times larger make the load 10^6 times smaller, and the tilt too small for its cube to count:

    M = diag(m, I),  K = [[k1 + k2, (L/2)(k2 - k1)], [., (L^2/4)(k1 + k2)]],  f = P (1, a - L/2)
    """
    m, L, a, k1, k2, phi = 10e6, 2, 1.5, 1e3 * 1e6, 1.5e3 * 1e6, 1e-8
    t = np.linspace(0, 10, 61)
    K = [[k1 + k2, L / 2 * (k2 - k1)], [L / 2 * (k2 - k1), L**2 / 4 * (k1 + k2)]]
    P = [50, 50 * (a - L / 2)]
    x, theta = linear_response(np.diag([m, m * L**2 / 12]), np.zeros((2, 2)), K, t, load=P, Omega=3, q0=[0, phi])
    parameters = {"m": m, "k1": k1, "k2": k2, "c1": 0, "c2": 0}
    model = lag.load(FOLDER / "suspended_bar.lag")
    run = model.simulate(at=t, tolerance=1e-12, parameters=parameters, initial={"tilt.phi": phi})
    assert_follows(run, {"guide.s": x, "tilt.phi": theta})


@pytest.mark.parametrize(("name", "c1", "c2"), [("disc_and_block", 0, 0), ("disc_and_block_damped", 2, 1)])
def test_disc_and_block_is_linear(name: str, c1: float, c2: float) -> None:
    """K = [[k1 + k2, -r k2], [-r k2, r^2 k2]] in (s, phi), C likewise, and so q by the matrix exponential."""
    m, I, r = 2, 0.1, 0.2
    t = np.linspace(0, 10, 61)

    def joined(wall: float, tie: float) -> Array:
        return np.array([[wall + tie, -r * tie], [-r * tie, r**2 * tie]])

    s, phi = linear_response(np.diag([m, I]), joined(c1, c2), joined(100, 50), t, load=[0, 0.5], Omega=2, q0=[0, 0])
    assert_follows(lag.load(FOLDER / f"{name}.lag").simulate(at=t, tolerance=1e-12), {"block.s": s, "axle.phi": phi})


def test_the_absorber_stills_its_machine() -> None:
    """What is left of the machine's motion at the end is a thousandth of what the shaking does to it without the absorber."""
    model = lag.load(FOLDER / "vibration_absorber.lag")
    t = np.linspace(39, 40, 101)
    with_absorber = model.simulate(at=t)["machine.s"]
    without = model.simulate(at=t, parameters={"m": 1e-6})["machine.s"]
    assert np.abs(with_absorber).max() < 1e-3 * np.abs(without).max()
