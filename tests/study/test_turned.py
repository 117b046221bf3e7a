"""Rest and small motion with attitudes, beside closed forms: in small turns, three for each, never in quaternions."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main

BALL = """
model Ball
  World world(gravity = {0, 0, -9.81});
  Spherical tip(a = world, S(start = angles("zxz", 0, 160[deg], 0)), w(start = {0, 0, SPIN}));
  Body bar(m = 0.5, I = {0.008, 0.006, 0.001}, center = shift(tip.b, {0, 0, 0.3}));
  input Force push = 0;
  energy work push on bar.center.r[1];
  output Length x = bar.center.x;
end Ball;
"""
SLEEPING = """
model Sleeping
  World world(gravity = {0, 0, -9.81});
  Spherical tip(a = world, w(start = {0, 0, 150}));
  Body top(m = 0.5, I = {0.0008, 0.0008, 0.001}, center = shift(tip.b, {0, 0, 0.1}));
end Sleeping;
"""
# On a circle, in axes that go round with it: gravity's gradient holds the longest axis upright.
SATELLITE = """
model Satellite
  parameter AngularVelocity n = 0.3;
  World world(gravity = {0, 0, 0});
  Frame orbit;
  Spherical joint(a = orbit, S(start = axis_angle({1, 2, 3}, 0.2)));
  Body body(m = 1, I = {3, 4, 1.5}, center = joint.b);
  Real up[3] = to_frame(body.center, to_world(orbit, {0, 0, 1}));
  energy potential 1.5*n^2*(3*up[1]^2 + 4*up[2]^2 + 1.5*up[3]^2)*1[kg.m2];
equation
  orbit = turn(world, n*time, {0, 1, 0});
end Satellite;
"""


def model(folder: Path, text: str) -> lag.Model:
    path = folder / "scene.lag"
    path.write_text(text.replace("SPIN", "0"))
    return lag.load(path)


def test_a_bar_on_a_ball_joint_swings_about_two_axes_and_turns_about_the_third(tmp_path: Path) -> None:
    ball = model(tmp_path, BALL)
    found = ball.equilibrium()
    assert [round(item.potential, 9) for item in found] == [-1.4715, 1.4715]  # two families, all about the vertical
    assert [item.stability for item in found] == ["neutral", "unstable"] and [item.n_neutral for item in found] == [1, 1]
    q = [found[0].position[f"tip.S[{k}]"] for k in range(1, 5)]
    assert q[0] ** 2 + q[3] ** 2 == pytest.approx(0, abs=1e-12)  # turned by 180 degrees about a level axis
    assert found[0].reactions["tip.reaction[3]"] == pytest.approx(4.905) if "tip.reaction[3]" in found[0].reactions else True
    stiffness, inertia = 0.5 * 9.81 * 0.3, np.array([0.008, 0.006]) + 0.5 * 0.3**2
    modes = ball.modes()
    assert modes.omega == pytest.approx([0, *sorted(np.sqrt(stiffness / inertia))], abs=1e-9)
    linear = ball.linearize()
    assert linear.coordinates == ("tip.S.s[1]", "tip.S.s[2]", "tip.S.s[3]") and linear.A.shape == (6, 6)
    # a level force on the hanging bar: x = push l^2/(J (w0^2 - w^2)) about the axis that is then level
    response = ball.response(frequencies=[0.3], outputs=["x"])
    size = np.abs(response.of("x")[0])
    possible = 0.09 / (stiffness - inertia * (2 * np.pi * 0.3) ** 2)
    assert min(possible) <= size <= max(possible) * (1 + 1e-12)


def test_the_start_may_be_rest_and_need_not_be(tmp_path: Path) -> None:
    """Upside down the same stiffness drives it away; aslant the weight is a load."""
    ball = model(tmp_path, BALL)
    upright = ball.linearize(about="start", initial={"tip.S": [1, 0, 0, 0]})
    assert upright.load == pytest.approx(0, abs=1e-12)
    assert sorted(upright.eigenvalues.real)[-1] == pytest.approx(np.sqrt(1.4715 / 0.051), rel=1e-9)
    aslant = ball.linearize(about="start", initial={"tip.S": "axis_angle({1, 0, 0}, 90[deg])"})
    assert not aslant.is_equilibrium and aslant.load[0] == pytest.approx(1.4715) and aslant.K[0, 0] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("spin", [150.0, 40.0, 25.0])
def test_a_sleeping_top_has_its_two_frequencies(tmp_path: Path, spin: float) -> None:
    """A Omega^2 - C w Omega + m g l = 0 in the world, Omega - w as seen from the top; below 2 sqrt(A m g l)/C it falls."""
    found = model(tmp_path, SLEEPING).linearize(about="start", initial={"tip.w[3]": spin})
    A, C, mgl = 0.0008 + 0.5 * 0.01, 0.001, 0.5 * 9.81 * 0.1
    seen = np.roots([A, -C * spin, mgl]) - spin
    wanted = np.array([0, 0, *(1j * seen), *(-1j * seen.conj())])
    for s in wanted:
        assert np.abs(found.eigenvalues - s).min() < 1e-6 * spin
    falls = spin < 2 * np.sqrt(A * mgl) / C
    assert (found.eigenvalues.real.max() > 1e-3) == falls
    assert any("steady" in note and "not steady" not in note for note in found.notes)


def test_a_free_body_that_spins_about_its_middle_axis_leaves_it(tmp_path: Path) -> None:
    """s^2 = w^2 (J2 - J1)(J3 - J2)/(J1 J3)."""
    text = """model Racket
      World world(gravity = {0, 0, 0});
      Body b(m = 1, I = {1, 2, 3}, center(r(start = {0, 0, 0}), omega(start = {0, 2, 0})));
    end Racket;"""
    racket = model(tmp_path, text)
    growth = racket.linearize(about="start").eigenvalues.real.max()
    assert growth == pytest.approx(2 * np.sqrt(1 * 1 / (1 * 3)), rel=1e-9)
    spun = racket.modes(about="start", initial={"b.center.S": [1, 1, 0, 0], "der(b.center.S)[2]": 0, "der(b.center.S)[3]": 2})
    assert max(mode.eigenvalue.real for mode in spun.damped) == pytest.approx(0, abs=1e-6)
    assert any(abs(mode.eigenvalue - 2j * np.sqrt(2 * 1 / (1 * 2))) < 1e-9 for mode in spun.damped)


def test_gravitys_gradient_holds_a_satellite(tmp_path: Path) -> None:
    """Pitch: 3 n^2 (Jx - Jz)/Jy; roll and yaw: D.B. DeBra, R.H. Delp, J. Astronautical Sciences 8 (1961)."""
    n, x, y, z = 0.3, 3.0, 4.0, 1.5
    linear = model(tmp_path, SATELLITE).linearize()
    a, c = (y - z) / x, (y - x) / z
    pitch = 3 * n**2 * (x - z) / y
    others = np.roots([1, (1 + 3 * a + a * c) * n**2, 4 * a * c * n**4])
    wanted = np.sort(np.sqrt([pitch, *(-others.real)]))
    assert np.sort(linear.eigenvalues.imag)[3:] == pytest.approx(wanted, rel=1e-9)
    assert linear.eigenvalues.real == pytest.approx(0, abs=1e-9) and linear.is_equilibrium


def test_commands_tell_it_and_what_is_not_there_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.lag"
    file.write_text(BALL.replace("SPIN", "0"))
    for command, told in (("equilibrium", "tip.S[2]"), ("linearize", "tip.S.s[1]"), ("modes", "0.838"), ("response", "x"),
                          ("explain", "depends on push")):
        assert main([command, str(file)]) == 0
        assert told in capsys.readouterr().out
    assert main(["simulate", str(file), "--from", "equilibrium", "--stop", "1", "-o", "-"]) == 0
    rows = [line.split(",") for line in capsys.readouterr().out.splitlines()]
    place = rows[0].index("tip.S[2]")
    assert abs(float(rows[1][place]) - float(rows[-1][place])) < 1e-12
    assert main(["simulate", str(file), "--from", "steady tip.w[3]=2", "--stop", "0.1", "-o", "-"]) == 0
    assert "starts in steady motion: der(tip.S)[3] = 2, tip.S[1] = " in capsys.readouterr().err


def test_the_tip_bears_what_the_motion_asks_for_and_the_account_closes(tmp_path: Path) -> None:
    """The reaction is m (a - g), a by differences of the places of the centre."""
    path = tmp_path / "top.lag"
    path.write_text(SLEEPING.replace("tip(a = world,", 'tip(a = world, S(start = axis_angle({1, 0, 0}, 0.5)),'))
    times, h = np.linspace(0, 0.02, 41), 0.0005
    run = lag.Model(path, outputs=("tip.reaction", "top.center.r")).simulate(at=times, tolerance=1e-13)
    r = np.array([run[f"top.center.r[{k}]"] for k in (1, 2, 3)])
    weights = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]) / h**2
    a = np.array([np.convolve(x, weights, "valid") for x in r])
    wanted = 0.5 * (a + np.array([[0], [0], [9.81]]))
    np.testing.assert_allclose([run[f"tip.reaction[{k}]"][4:-4] for k in (1, 2, 3)], wanted, atol=1e-7)
    assert np.abs(run.energy.residual).max() < 1e-12 * run["energy.kinetic"][0]
