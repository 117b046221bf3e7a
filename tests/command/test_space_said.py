"""Scenes in space: what is asked of attitudes and inertias in a way that says nothing is told, and what is right runs."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main

HEAD = "model T\n  World world(gravity = {0, 0, -9.81});\n"
BODY = "Body b(m = 1, I = {1, 2, 2.5}, center(omega(start = {1, 0.1, 2})));"
WRONG = {
    "Spherical s(a = world, S(start = {0.1, 0, 0})); Body b(m = 1, I = {1, 1, 1}, center = s.b);": "'s.S' begins at an attitude",
    "Spherical s(a = world, S(start = 0.3)); Body b(m = 1, I = {1, 1, 1}, center = s.b);": "'s.S' begins at an attitude",
    "Body b(m = 1, I = {1, 1, 1}, center(w(start = {0, 0, 1}), omega(start = {1, 0, 0})));": "the angular velocity is said twice",
    "Body b(m = 1, I = {1, 1, 1}, center(R(start = identity(3))));": "a frame does not begin by its R",
    "Revolute h(a = world, axis = {1, 0, 0}); Body b(m = 1, I = {1, 1, -1}, center = h.b);": "is negative about z",
    f"{BODY} energy work {{1, 2, 3}} on b.center.R;": "a force works on a position of the same size",
}


def written(folder: Path, body: str) -> Path:
    file = folder / "t.lag"
    file.write_text(f"{HEAD}  {body}\nend T;\n")
    return file


@pytest.mark.parametrize("body", WRONG)
def test_what_is_wrong_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str], body: str) -> None:
    assert main(["check", str(written(tmp_path, body))]) == 2
    assert WRONG[body] in capsys.readouterr().err


def test_parts_of_attitudes_are_no_quantities(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Their numbers are against attitudes that move along."""
    file = str(written(tmp_path, BODY))
    assert main(["simulate", file, "--initial", "b.center.S.s[1]=0.3", "-o", str(tmp_path / "x.csv")]) == 2
    assert "which begins as a whole" in capsys.readouterr().err
    model = lag.load(file)
    with pytest.raises(lag.LagError, match="says nothing without the attitude"):
        model.simulate_many(parameters={"b.m": [1, 2]}, outputs=["max(b.center.S.s[1])"], stop=1)
    assert np.isnan(model.rollout(times=[0, 1])["b.center.S.s[1]"]).all()
    kept = model.simulate_many(parameters={"b.m": [1, 2]}, outputs=["max(b.center.x)"], stop=1, interval=0.5, keep=True)
    columns = [column.name for column in lag.load(file).simulate(stop=1).columns]
    part = columns.index("b.center.S.s[1]")
    alone = model.simulate(stop=1)
    assert np.isnan(alone["b.center.S.s[1]"]).all() and np.isfinite(alone["b.center.S[1]"]).all()
    assert np.isnan(kept.trajectories[:, :, part]).all()
    assert np.isfinite(kept.trajectories[:, :, columns.index("b.center.z")]).all()


def test_inertias_of_a_run_are_looked_at(tmp_path: Path) -> None:
    matrix = "{{2, 0.1, 0}, {0.1, 2, 0}, {0, 0, 3}}"
    model = lag.load(written(tmp_path, f"Revolute h(a = world, axis = {{1, 0, 0}}); Body b(m = 1, I = {matrix}, center = h.b);"))
    model.simulate(stop=0.1, parameters={"b.I[1,2]": 0.2, "b.I[2,1]": 0.2})
    for given, told in (({"b.I[1,2]": 0.3}, "is not symmetric"), ({"b.I[1,2]": 3, "b.I[2,1]": 3}, "is negative about an axis")):
        with pytest.raises(lag.LagError, match=told):
            model.simulate(stop=0.1, parameters=given)


@pytest.mark.parametrize("body", [
    "Revolute h(a = world, w(start = 1)); Body b(m = 1, I = 0.1, center = h.b); output Real M = h.reaction_torque[3];",
    "Revolute h(a = world, axis = {1, 0, 0}); Body b0(m = 1, I = {1, 1, 1}, center = h.b); Block b(m = 1, base = h.b);",
    "parameter Inertia J[3] = {1, 2, 9}; Revolute h(a = world); Body b(m = 1, I = J[1], center = h.b); output Real x = sum(J);",
    'Revolute h(a = world); Body b(m = 1, I = 0.1, center = h.b); equation assert(b.center.omega_z < 3, "x");',
    "Body b(m = 1, I = {1, 1, 1}); initial equation b.center.omega[3] = 0.5;",
])
def test_what_is_right_runs_without_a_word(tmp_path: Path, capsys: pytest.CaptureFixture[str], body: str) -> None:
    assert main(["simulate", str(written(tmp_path, body)), "--stop", "0.1", "-o", str(tmp_path / "x.csv")]) == 0
    assert capsys.readouterr().err == ""


def test_a_pin_is_pressed_across_its_axis_alone(tmp_path: Path) -> None:
    """A vertical hinge carries the weight along its axis: w' = -mu r m l w^2/(I + m l^2)."""
    file = written(tmp_path, "RoughRevolute h(a = world, w(start = 3), mu = 0.2, radius = 0.02); "
                             "Body b(m = 1, I = {0.1, 0.1, 0.1}, center = shift(h.b, {1, 0, 0}));")
    run = lag.load(file).simulate(stop=2, tolerance=1e-12)
    rates = np.asarray(run["der(h.phi)"])
    time = np.asarray(run.time)
    # the pin feels the centripetal force and what turns the body: F = m l (w^2, w')
    k = 0.2 * 0.02 / 1.1
    factor = k / np.sqrt(1 - k * k)
    assert np.abs(1 / rates - 1 / 3 - factor * time).max() < 1e-10


def test_hinges_on_points_turn_bodies_in_space(tmp_path: Path) -> None:
    """The point would have to turn, and has no inertia: it is told, not left out."""
    file = written(tmp_path, "PointMass a(m = 1); Revolute h(a = a.center, axis = {1, 0, 0}, w(start = 1)); "
                             "Box c(m = 1, size = {0.1, 0.2, 0.3}, center = shift(h.b, {0, 0, -0.5}));")
    with pytest.raises(lag.LagError, match=r"the attitude 'a.center.S' moves no mass about its x axis"):
        lag.load(file)


DOOR = ("Revolute low(a = world, phi(start = 0.5)); Body b(m = 20, I = {1, 1.5, 0.9}, center = shift(low.b, {0.4, 0.03, 1})); "
        "Revolute high(a = shift(world, {0, 0, 2}), b = shift(low.b, {0, 0, 2}));")


@pytest.mark.parametrize("asked", [["--reactions"], ["--outputs", "high.reaction"], []])
def test_reactions_that_loops_share_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str], asked: list[str]) -> None:
    """One of two hinges of a door could carry what the other does: the run says that its figures are one way of it."""
    assert main(["simulate", str(written(tmp_path, DOOR)), "--stop", "0.1", "-o", str(tmp_path / "x.csv"), *asked]) == 0
    told = "the reactions are one way of several: the loop world - high - low - world repeats in part what others already impose"
    assert (told in capsys.readouterr().out) == bool(asked)


@pytest.mark.parametrize("command", [["equilibrium"], ["simulate", "--stop", "0.01"]])
@pytest.mark.parametrize("output", ["", "output Force F = mid.b.reaction[2];"])
def test_reactions_that_loops_of_the_plane_share_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str], output: str
) -> None:
    """A beam on three parallel cranks: which of its equations repeats others is seen in numbers alone. Equilibria have reactions
    of their own, runs as far as outputs are made of them."""
    file = tmp_path / "cranks.lag"
    file.write_text(f"""model Cranks
  Revolute h[3](a = {{shift(world, {{i, 0}}) for i in 0:2}}, each phi(start = -80[deg]));
  Bar crank[3](each m = 1, each L = 0.5, a = h.b);
  Revolute tip(a = crank[1].b); Bar beam(m = 3, L = 2, a = tip.b);
  Revolute mid(a = crank[2].b, b = shift(beam.a, {{1, 0}})), far(a = crank[3].b, b = beam.b);
  {output} end Cranks;""")
    (first, *options), to = command, ["-o", str(tmp_path / "x.csv")] if command[0] == "simulate" else []
    assert main([first, str(file), *options, *to]) == 0
    is_told = "the reactions are one way of several: the loop world - h[3]" in capsys.readouterr().out
    assert is_told == (first == "equilibrium" or bool(output))


def test_a_hinge_beside_a_clamp_is_checked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No coordinate is left at all."""
    file = written(tmp_path, "Revolute l(a = world); Bar b(m = 1, L = 1, a = l.b); Weld r(a = shift(world, {1, 0}), b = b.b);")
    assert main(["check", str(file)]) == 0
    assert "0 degrees of freedom, so it stands still: statics" in capsys.readouterr().out


def test_a_run_that_fails_at_a_flat_start_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "flat.lag"
    file.write_text("""model T
  World world(gravity = {0, 0});
  Revolute p1(a = world, phi(start = 0, fixed = true), w(start = 2, fixed = true));
  Bar b1(m = 1, L = 1, a = p1.b);
  Revolute p2(a = b1.b);
  Bar b2(m = 1, L = 2, a = p2.b);
  Revolute p3(a = shift(world, {2, 0}));
  Bar b3(m = 1, L = 1, a = p3.b);
  Revolute p4(a = b3.b, b = b2.b);
end T;
""")
    assert main(["simulate", str(file), "--stop", "0.1", "-o", str(tmp_path / "x.csv")]) == 1
    assert "the start is a singular position, where 2 ways of moving meet" in capsys.readouterr().err
