"""What rolls and skates in space: closed forms of a disc in a circle and of a ball on a turntable, and Whipple's bicycle."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.model import Model

FOLDER, EXAMPLES = Path(__file__).with_name("spatial"), Path(__file__).parents[2] / "models" / "examples"
g = 9.81
# Of rolling_disc_steady_circle and sphere_on_turntable in quadruple precision: attitudes after 10 s, and after 5 s.
DISC = [0.35063827182777242067, 0.14350941671949622134, 0.47896246962870689875, 0.79186665691240793498]
BALL = {0.0: [0.52356053829679822943, -0.43672867772344512268, 0.37038520877311539972, -0.63084643290930464098],
        5.0: [0.62971854812263529231, -0.41528115470346729883, -0.40289894218576497426, 0.51833247542872203537]}


@cache
def scene(name: str, *outputs: str) -> Model:
    own = FOLDER / f"{name}.lag"
    return Model(own if own.exists() else EXAMPLES / f"{name}.lag", outputs=outputs)


def vector(run: lag.Trajectory, name: str, size: int = 3) -> np.ndarray:
    return np.array([run[f"{name}[{k}]"] for k in range(1, size + 1)]).T


def upright(quaternion: np.ndarray) -> np.ndarray:
    return quaternion * np.sign(quaternion[0])


@pytest.mark.parametrize("solver", ["pirk", "erk", "implicit"])
def test_a_disc_rolls_in_a_circle(solver: str) -> None:
    """(C + m r^2) w3 phi' sin theta - A phi'^2 sin theta cos theta + m g r cos theta = 0: it leans steadily, without a hint."""
    m, r, theta, turning = 2, 0.25, np.pi / 3, 1.5
    A, C, s, c = m * r**2 / 4, m * r**2 / 2, np.sin(theta), np.cos(theta)
    w3 = (A * turning**2 * s * c - m * g * r * c) / ((C + m * r**2) * turning * s)
    initial = {"der(disc.center.S)[2]": turning * s, "der(disc.center.S)[3]": w3}
    run = scene("rolling_disc_space").simulate(initial=initial, at=[0, 0.5, 1, 5, 10], tolerance=1e-13, solver=solver)
    t, R = run.time, r * w3 / turning
    known = {"disc.center.x": -R * np.sin(turning * t), "disc.center.y": -R * (1 - np.cos(turning * t)),
             "disc.center.z": np.full(5, r * s), "der(disc.center.S)[3]": np.full(5, w3),
             "contact[1]": (r * c - R) * np.sin(turning * t), "contact[2]": -R - (r * c - R) * np.cos(turning * t)}
    for name, values in known.items():
        assert run[name] == pytest.approx(values, rel=1e-12, abs=1e-12 if solver == "pirk" else 1e-11), name
    assert upright(vector(run, "disc.center.S", 4)[-1]) == pytest.approx(DISC, abs=2e-12 if solver == "pirk" else 1e-10)
    assert run.statistics.constraint_residual < 1e-13


@pytest.mark.parametrize("tilt", [0.0, 5.0])
def test_a_ball_on_a_turntable(tilt: float) -> None:
    """v' = 2/7 Omega z x v + 5/7 g_t: a circle at two sevenths of the table's rate."""
    values = {"tilt": np.radians(tilt)}
    run = scene("turntable", "ball.center.w").simulate(parameters=values, at=[0, 0.5, 1, 2, 5], tolerance=1e-13)
    t, rate, down = run.time, 6 / 7, 5 / 7 * g * np.sin(np.radians(tilt))
    drift = 1j * down / rate
    u = (0.2j - drift) * np.exp(1j * rate * t) + drift
    z = 0.3 + (0.2j - drift) * (np.exp(1j * rate * t) - 1) / (1j * rate) + drift * t
    assert run["ball.center.x"] == pytest.approx(z.real, abs=1e-12) and run["ball.center.y"] == pytest.approx(z.imag, abs=5e-12)
    assert run["der(ball.center.x)"] == pytest.approx(u.real, abs=1e-12)
    w = vector(run, "ball.center.w")
    assert w[:, 0] == pytest.approx((3 * z.real - u.imag) / 0.1, abs=1e-10) and w[:, 2] == pytest.approx(np.ones(5), abs=1e-12)
    assert upright(vector(run, "ball.center.S", 4)[-1]) == pytest.approx(BALL[tilt], abs=1e-12 if tilt == 0 else 1e-10)
    energy = run.energy
    assert np.abs(energy.work).max() > 0.02 and np.abs(energy.residual).max() < 1e-12 * np.abs(energy.total).max()


SKATE = """
model Sledge "A skate on a slope, whose centre of mass is ahead of its blade"
  World world(gravity = {gravity});
  {path} path(a = {base}, phi(start = 0));
  Body sledge(m = 70, I = {I}, center = shift(path.b, {{0.3, 0{up}}}));
  Skate blade(base = {base}, edge = path.b);
end Sledge;
"""
PLANE = SKATE.format(gravity="{1, 0}", path="Planar", I="2", up="", base="world")
LEVEL = SKATE.format(gravity="{1, 0, -9.81}", path="PlanarJoint", I="{1, 5, 2}", up=", 0.8", base="world")
TILTED = SKATE.format(gravity="{1, -9.81*sin(0.4), -9.81*cos(0.4)}", path="PlanarJoint", I="{1, 5, 2}", up=", 0.8",
                      base="turn(world, 0.4, {1, 0, 0})")


def test_a_skate_is_the_same_in_every_plane() -> None:
    """Gravity across the plane, which is tilted about the line of fall, does nothing."""
    tilted = TILTED.replace("-9.81*sin(0.4), -9.81*cos(0.4)", "9.81*sin(0.4), -9.81*cos(0.4)")
    runs = [lag.loads(text).simulate(initial={"der(path.phi)": 2.0}, at=[0, 1, 2], tolerance=1e-13)
            for text in (PLANE, LEVEL, tilted)]
    for run in runs:
        for name in ("path.x", "path.y", "path.phi", "der(path.phi)"):
            assert run[name] == pytest.approx(runs[0][name], abs=1e-11)
    aside = -np.sin(runs[0]["path.phi"]) * runs[0]["der(path.x)"] + np.cos(runs[0]["path.phi"]) * runs[0]["der(path.y)"]
    assert aside == pytest.approx(np.zeros(3), abs=1e-13) and runs[0]["path.y"][-1] > 0.05


# ---------------------------------------------------------------- the bicycle

# J.P. Meijaard, J.M. Papadopoulos, A. Ruina, A.L. Schwab: Linearized dynamics equations for the balance and steer of a bicycle: a
# benchmark and review. Proc. R. Soc. A 463 (2007): M q'' + v C1 q' + (g K0 + v^2 K2) q = f of lean and steer.
M = [[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]]
C1 = [[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]]
K0 = [[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]]
K2 = [[0, 76.59734589573222], [0, 2.65431523794604]]
WEAVE, CAPSIZE = 4.29238253634111, 6.02426201538837  # m/s


def test_the_matrices_of_the_bicycle() -> None:
    found = {}
    for v in (2.0, 5.0):
        linear = scene("bicycle").linearize(about="start", parameters={"v": v}, initial={"lean.w": 0.0})
        assert "is steady" in linear.notes[-1]
        rates = [linear.free_rates.index(f"der({name})") for name in ("lean.phi", "steer.phi")]
        places = [linear.coordinates.index(name) for name in ("lean.phi", "steer.phi")]
        assert linear.M[np.ix_(rates, rates)] == pytest.approx(np.array(M), abs=1e-12)
        assert linear.C[np.ix_(rates, rates)] == pytest.approx(v * np.array(C1), abs=1e-12)
        found[v] = linear.K[np.ix_(rates, places)]
        assert found[v] == pytest.approx(g * np.array(K0) + v**2 * np.array(K2), abs=1e-11)
    assert (found[5.0] - found[2.0]) / 21 == pytest.approx(np.array(K2), abs=1e-12)


def test_what_time_pushes_is_not_steady() -> None:
    """Though the load is 0 at the start, and the linear motion without it stays as it is."""
    text = (EXAMPLES / "bicycle.lag").read_text(encoding="utf-8")
    pushed = text.replace("drawing", "energy\n  work 5[N.m]*sin(3[1/s]*time) on lean.phi;\ndrawing")
    linear = lag.loads(pushed).linearize(about="start", initial={"lean.w": 0.0})
    assert "is not steady" in linear.notes[-1]


def test_from_which_speed_to_which_it_holds_itself_upright() -> None:
    """The weave becomes stable at one speed, the capsize unstable at another."""
    def largest(v: float) -> float:
        damped = scene("bicycle").modes(about="start", parameters={"v": v}, initial={"lean.w": 0.0}).damped
        return max(mode.eigenvalue.real for mode in damped if mode.eigenvalue)

    assert largest(WEAVE) == pytest.approx(0, abs=1e-10)
    for speed, side in ((WEAVE, -1), (CAPSIZE, 1)):
        assert largest(speed + side * 1e-3) > 1e-5 and largest(speed - side * 1e-3) < -1e-5
    stiffness = g * np.array(K0) + CAPSIZE**2 * np.array(K2)
    assert np.linalg.det(stiffness) == pytest.approx(0, abs=1e-9)  # and K is as above at all speeds


def test_a_disc_that_lies_flat_is_refused(scene: Callable[[str], lag.Model]) -> None:
    text = """model M World world(gravity = {0, 0, -9.81}); Disc disc(m = 2, r = 0.1, center(z(start = 0.1)));
      RollingDisc rolling(base = world, r = 0.1, center = disc.center); end M;"""
    with pytest.raises(lag.Error, match="the disc lies flat"):
        scene(text).simulate(at=[0.1])
