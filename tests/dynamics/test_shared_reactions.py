"""Reactions that constraints leave open, by least squares, against closed forms."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main

g = 9.81
Write = Callable[[str], lag.Model]
DOOR = """model Door
  parameter Mass m = 20;
  World world(gravity = {0, 0, -9.81});
  Revolute lower(a = world, phi(start = 0.3));
  Body door(m = m, I = {1, 1, 1.5}, center = shift(lower.b, {0.4, 0, 0.75}));
  Revolute upper(a = shift(world, {0, 0, 1.5}), b = shift(lower.b, {0, 0, 1.5}));
  output Force lift = upper.reaction[3], push = sqrt(upper.reaction[1]^2 + upper.reaction[2]^2);
end Door;
"""


@pytest.mark.parametrize("length", [1.0, 0.2])
def test_a_door_hangs_on_both_hinges(scene: Write, length: float) -> None:
    """Each hinge bears half the weight; horizontal forces F and torques M = 2 F l^2/h are in balance: F h + 2 M = m g b/2."""
    model = scene(DOOR).sharing_reactions(length)
    run = model.simulate(stop=0.1, interval=0.1)
    F = 20 * g * 0.4 / (1.5 + 4 * length**2 / 1.5)
    np.testing.assert_allclose(run["lift"], 10 * g, rtol=1e-12)
    np.testing.assert_allclose(run["push"], F, rtol=1e-12)
    sweep = model.simulate_many(parameters={"m": [1.0, 20.0]}, outputs="final(push)", stop=0.1)
    np.testing.assert_allclose(sweep["final(push)"], [F / 20, F], rtol=1e-12)
    (rest,) = model.equilibrium(starts=1).found
    assert rest.reactions["lower.reaction[3]"] == pytest.approx(10 * g, rel=1e-12)


def test_a_table_on_four_legs(scene: Write) -> None:
    """The force of a leg is linear in its place: F = m g (1/4 + x0 x/sum(x^2) + y0 y/sum(y^2)), places from the legs' middle."""
    run = scene("""model Table
      World world(gravity = {0, 0, -9.81});
      Body top(m = 10, I = {1, 1, 1});
      Frame l1 = shift(top.center, {-0.6, -0.25, -0.7}), l2 = shift(top.center, {0.4, -0.25, -0.7});
      Frame l3 = shift(top.center, {-0.6, 0.35, -0.7}), l4 = shift(top.center, {0.4, 0.35, -0.7});
      output Force F[4] = {constraint_force(l1.z), constraint_force(l2.z), constraint_force(l3.z), constraint_force(l4.z)};
    equation
      l1.z = 0; l2.z = 0; l3.z = 0; l4.z = 0; l1.x = 0; l1.y = 0; l2.y = 0;
    end Table;""").sharing_reactions().simulate(stop=0.1, interval=0.1)
    x, y = np.array([-0.5, 0.5, -0.5, 0.5]), np.array([-0.3, -0.3, 0.3, 0.3])
    np.testing.assert_allclose(run["F"][-1], 10 * g * (0.25 + 0.1 * x - 0.05 * y / 0.36), rtol=1e-11)


def test_a_beam_on_three_supports_in_the_plane(scene: Write) -> None:
    """A pin and two rollers, each of a slide and a hinge that carry the same: w = 1, 2, 2. Least w F^2 with the balances of force
    and torque makes F = (a + b x)/w."""
    run = scene("""model Beam
      Revolute pin(a = world);
      Bar beam(m = 10, L = 2, a = pin.b);
      PointMass load(m = 5, center = shift(beam.a, {1.5, 0}));
      Prismatic r1(a = shift(world, {1, 0})), r2(a = shift(world, {2, 0}));
      Revolute k1(a = r1.b, b = shift(beam.a, {1, 0})), k2(a = r2.b, b = beam.b);
      output Force F[3] = {pin.reaction[2], k1.reaction[2], k2.reaction[2]};
    end Beam;""").sharing_reactions().simulate(stop=0.1, interval=0.1)
    x, w = np.array([0.0, 1.0, 2.0]), np.array([1.0, 2.0, 2.0])
    a, b = np.linalg.solve([[sum(1 / w), sum(x / w)], [sum(x / w), sum(x * x / w)]], [15 * g, 17.5 * g])
    np.testing.assert_allclose(run["F"][-1], (a + b * x) / w, rtol=1e-12)


def test_it_does_not_matter_where_a_loop_is_cut(scene: Write) -> None:
    """A flat four-bar of spatial hinges that turns out of its plane: three equations are redundant."""
    joints = ["A(a = crank.b)", "B(a = coupler.b, b = rocker.b)"]
    told, cuts = [], []
    for order in (joints, joints[::-1]):
        model = scene(f"""model M
          World world(gravity = {{0, -9.81, 3}});
          Revolute O(a = world, phi(start = 40[deg], fixed = true)), C(a = shift(world, {{1, 0}}), phi(start = 75[deg]));
          Revolute {", ".join(order)};
          Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
          output Force F[3] = B.reaction;
          output Torque M[3] = B.reaction_torque;
        end M;""")
        cuts.append([cut.a for cut in model.compilation.graph.closures])
        runs = [m.simulate(stop=0.2, interval=0.1, tolerance=1e-12) for m in (model, model.sharing_reactions())]
        told.append([np.hstack([run["F"], run["M"]]) for run in runs])
    assert cuts[0] != cuts[1]
    np.testing.assert_allclose(told[0][1], told[1][1], atol=1e-7)
    assert np.abs(told[0][0] - told[1][0]).max() > 1
    assert np.abs(told[0][1] - told[0][0]).max() > 1


def test_what_is_asked_in_vain_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "door.lag").write_text(DOOR)
    (tmp_path / "pin.lag").write_text("model Pin Revolute pin(a = world); Bar bar(m = 1, L = 1, a = pin.b); end Pin;")
    assert main(["simulate", "door.lag", "--stop", "0.1", "--least-squares", "20[cm]"]) == 0
    assert "those of least squares, torques over 0.2 m: the loop" in capsys.readouterr().out
    for asked, said in ((["door.lag", "--least-squares", "0"], "more than 0"),
                        (["door.lag", "--least-squares", "3[kg]"], "but m is"),
                        (["pin.lag", "--least-squares", "1"], "no reactions are asked for"),
                        (["pin.lag", "--reactions", "--least-squares", "1"], "leave no reaction open")):
        assert main(["simulate", *asked]) == 2
        assert said in capsys.readouterr().err
    with pytest.raises(lag.LagError, match="more than 0"):
        lag.load("door.lag").sharing_reactions(-1)
