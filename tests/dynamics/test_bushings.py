"""Springs between attitudes: bushings and springs of ball joints, beside closed forms."""

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import lagrangia as lag


def loaded(folder: Path, body: str) -> lag.Model:
    file = folder / "t.lag"
    file.write_text(f"model T\n  World world(gravity = {{0, 0, 0}});\n{body}\nend T;\n")
    return lag.load(file)


def test_a_bushing_swings_along_and_about_its_axes(tmp_path: Path) -> None:
    found = loaded(tmp_path, """  Frame seat = turn(world, 0.4, {1, 2, 2});
  Body b(m = 2, I = {0.1, 0.2, 0.25}, center(Q(start = axis_angle({1, 2, 2}, 0.3))));
  Bushing s(a = seat, b = b.center, k = {100, 200, 300}, k_turn = {5, 6, 7});""").modes()
    assert np.allclose(np.sort(found.frequencies), np.sqrt([28, 30, 50, 50, 100, 150])/2/np.pi, rtol=1e-7)


def test_a_spring_of_a_ball_joint_draws_back_with_the_sine(tmp_path: Path) -> None:
    run = loaded(tmp_path, """  Spherical j(a = world, S(start = axis_angle({1, 2, 2}, 2.5)));
  Body b(m = 2, I = {0.1, 0.1, 0.1}, center = j.b);
  SphericalSpring s(a = j.a, b = j.b, k = 3);
  output Real trace = j.b.R[1, 1] + j.b.R[2, 2] + j.b.R[3, 3];""").simulate(stop=1, interval=0.5, tolerance=1e-11)
    angle = solve_ivp(lambda t, y: [y[1], -30 * np.sin(y[0])], (0, 1), [2.5, 0], t_eval=[0, 0.5, 1], rtol=1e-12, atol=1e-12).y[0]
    assert np.abs(np.asarray(run["trace"]) - 1 - 2 * np.cos(angle)).max() < 1e-8


def test_a_bushing_between_two_bodies_keeps_their_momenta(tmp_path: Path) -> None:
    run = loaded(tmp_path, """  Body p(m = 1, I = {0.1, 0.2, 0.25}, center(omega(start = {1, 0, 2})));
  Body q(m = 3, I = {0.2, 0.3, 0.4}, center(r(start = {0.1, 0.2, 0}), v(start = {0, 0.5, 1}), Q(start = angles("xyz", 1, 0, 1))));
  Bushing s(a = shift(p.center, {0.1, 0, 0}), b = q.center, k = {100, 50, 30}, k_turn = {5, 6, 7}, c = {1, 2, 3},
    c_turn = {0.1, 0.2, 0.3});
  output Real total[3] = p.center.v + 3*q.center.v;
  output Real spin[3] = to_world(p.center, {0.1*p.center.omega[1], 0.2*p.center.omega[2], 0.25*p.center.omega[3]})
    + to_world(q.center, {0.2*q.center.omega[1], 0.3*q.center.omega[2], 0.4*q.center.omega[3]})
    + cross(p.center.r, p.center.v) + 3*cross(q.center.r, q.center.v);""").simulate(stop=1, interval=0.25, tolerance=1e-11)
    for name in ("total", "spin"):
        kept = np.array([run[f"{name}[{k}]"] for k in (1, 2, 3)])
        assert np.abs(kept - kept[:, :1]).max() < 1e-9
