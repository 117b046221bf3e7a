"""Events that reset rates, and those that compare them afterwards, beside closed forms."""

import math
from pathlib import Path

import pytest

import lagrangia

KICKS = """
model Kicks "Everything moves freely until 1 s: a pendulum, a mass on a rope over a pulley, a gear"
  parameter Length L = 0.5;
  parameter AngularVelocity w = 0;
  World world(gravity = {0, 0});
  Revolute hinge(a = world, w(start = w));
  PointMass bob(m = 1, center = shift(hinge.b, {0, -L}));
  Prismatic x(a = world, along = {1, 0}, v(start = w*L));
  PointMass ball(m = 3, center = x.b);
  Prismatic z(a = world, along = {1, 0}, v(start = -w*L));
  PointMass load(m = 0.7, center = z.b);
  Length y = 2*x.s;
equation
  when time > 1 then
    reinit(bob.center.v[1], 2*cos(hinge.phi));
    reinit(der(y), 4);
    reinit(-der(z.s), 3);
  end when;
end Kicks;
"""


@pytest.mark.parametrize(("length", "speed"), [(0.5, 0), (0.3, 0), (2, 0), (1, 0), (0.7, 0.2)])
def test_multiples_of_rates(tmp_path: Path, length: float, speed: float) -> None:
    """What is reset is that rate, not the coordinate's, whether it moves before or is at rest, where all rates are alike."""
    file = tmp_path / "kicks.lag"
    file.write_text(KICKS, encoding="utf-8")
    last = lagrangia.load(file).simulate(stop=1.5, parameters={"L": length, "w": speed})
    assert [last[f"der({name})"][-1] for name in ("hinge.phi", "x.s", "z.s")] == pytest.approx([2/length, 2, -3], rel=1e-12)


RELATIVE = """
model Relative "Two masses at rest get a relative speed; one counter asks whether it is above that, the other whether it has come"
  World world(gravity = {0, 0});
  parameter Velocity w = 0.3;
  parameter Mass M = 3;
  Prismatic x(a = world, along = {1, 0}), y(a = world, along = {1, 0});
  PointMass a(m = 1, center = x.b), b(m = M, center = y.b);
  Integer above(start = 0), reached(start = 0), less(start = 0), beyond(start = 0);
equation
  when time >= 1 then reinit(der(x.s) - der(y.s), w); end when;
  when der(x.s) - der(y.s) > w then above = pre(above) + 1; end when;
  when der(x.s) - der(y.s) >= w then reached = pre(reached) + 1; end when;
  when not der(x.s) - der(y.s) < w then less = pre(less) + 1; end when;
  when der(x.s) - der(y.s) > w*(1 - 1e-12) then beyond = pre(beyond) + 1; end when;
end Relative;
"""


def test_levels_that_resets_meet(tmp_path: Path) -> None:
    """But for rounding of the rates, which is other for each mass and speed: >= is true there, > is not, nor less than that."""
    file = tmp_path / "relative.lag"
    file.write_text(RELATIVE, encoding="utf-8")
    model = lagrangia.load(file)
    for mass, speed in ((3, 0.6), (3, 0.7), (7, 0.9), (0.37, 0.1), (0.37, 0.2), (0.37, 0.9), (3, 0.5)):
        last = model.simulate(stop=1.5, parameters={"M": mass, "w": speed})
        assert [last[name][-1] for name in ("above", "reached", "less", "beyond")] == [0, 1, 1, 1], (mass, speed)


def test_levels_that_resets_meet_and_forces_leave(tmp_path: Path) -> None:
    """Upwards the strict event comes at once, though rounding may have been there before; downwards it does not."""
    file = tmp_path / "driven.lag"
    force = "AppliedForce f(at = x.b, force = {if time > 1 then F else 0, 0});"
    driven = RELATIVE.replace("equation", f"parameter Force F = 1; {force} discrete Time when_above(start = -1);\nequation", 1)
    file.write_text(driven.replace("above = pre(above) + 1;", "above = pre(above) + 1; when_above = time;"), encoding="utf-8")
    model = lagrangia.load(file)
    for mass, speed in ((0.37, 0.9), (0.1, 0.1), (11, 0.3), (11, 0.9)):
        for force, solver in ((1, "auto"), (1, "implicit"), (-1, "erk")):
            last = model.simulate(stop=1.2, solver=solver, parameters={"M": mass, "w": speed, "F": force})
            assert [last[name][-1] for name in ("above", "reached")] == [force > 0, 1], (mass, speed, force)
            assert last["when_above"][-1] == pytest.approx(1 if force > 0 else -1, abs=1e-9)


@pytest.mark.parametrize(("condition", "ends"), [
    ("when der(x.s) - der(y.s) >= w then terminate", True), ("when der(x.s) - der(y.s) > w then terminate", False),
    ("assert(der(x.s) - der(y.s) < w,", True), ("assert(der(x.s) - der(y.s) <= w,", False)])
def test_runs_end_on_levels_that_resets_meet(condition: str, ends: bool, tmp_path: Path) -> None:
    """As events come there: by the condition's own word, not by a tolerance or by rounding."""
    file = tmp_path / "ends.lag"
    said = f'{condition}("there"); end when;' if "when" in condition else f'{condition} "there");'
    stated = [line for line in RELATIVE.split("  when der", 1)[0].splitlines() if "Integer" not in line]
    file.write_text("\n".join(stated) + f"\n  {said}\nend Relative;\n", encoding="utf-8")
    model = lagrangia.load(file)
    for mass, speed in ((3, 0.6), (7, 0.9), (0.37, 0.9), (11, 0.3)):
        try:
            end = model.simulate(stop=1.5, parameters={"M": mass, "w": speed}).time[-1]
        except lagrangia.RunError as error:
            end = 1.0 if "does not hold at t = 1:" in str(error) else math.nan
        assert end == pytest.approx(1 if ends else 1.5), (mass, speed)


TURNED = """
model Turned "A pendulum that is turned back at the bottom, with the speed that it has there: no faster than energy lets it be"
  World world(gravity = {0, -9.81});
  parameter Angle A = 1;
  parameter AngularVelocity fastest = sqrt(2*9.81*(1 - cos(A)));
  Revolute h(a = world, phi(start = A));
  PointMass p(m = 1, center = shift(h.b, {0, -1}));
equation
  when h.phi < 0 then reinit(h.w, -pre(h.w)); end when;
  SAID
end Turned;
"""


@pytest.mark.parametrize("said", [
    'assert(h.w <= fastest, "too fast");', 'when h.w > fastest then terminate("too fast"); end when;'])
def test_rates_that_resets_compute_have_the_errors_of_the_motion(said: str, tmp_path: Path) -> None:
    """They are no better known than what they were computed from: what is beyond by less than a tolerance ends no run."""
    file = tmp_path / "turned.lag"
    file.write_text(TURNED.replace("SAID", said), encoding="utf-8")
    model = lagrangia.load(file)
    for solver, tolerance, angle in (("auto", 1e-8, 1.3), ("auto", 1e-6, 1), ("erk5", 1e-6, 1.3), ("implicit", 1e-6, 0.7)):
        result = model.simulate(stop=5, solver=solver, tolerance=tolerance, parameters={"A": angle})
        assert result.time[-1] == 5, (solver, tolerance, angle)


DISCRETE = """
model Discrete "Speeds are set to discrete ones, one of them a parameter, the other read of the motion; then one is driven"
  World world(gravity = {0, 0});
  parameter Velocity w = 0.3;
  Prismatic x(a = world, along = {1, 0}), y(a = world, along = {1, 0}, v(start = 0.1));
  PointMass a(m = 0.37, center = x.b), b(m = 3, center = y.b);
  AppliedForce f(at = x.b, force = {if time > 1.2 then 1 else 0, 0});
  discrete Velocity told(start = 0), read(start = 0);
equation
  when time >= 0.5 then told = w; read = der(y.s); end when;
  when time >= 1 then reinit(der(x.s), told); end when;
  when time >= 1.1 then reinit(der(y.s), read); end when;
  SAID
end Discrete;
"""


@pytest.mark.parametrize(("said", "end"), [("der(x.s) < w", 1), ("der(x.s) <= w", 1.2)])
def test_speeds_that_are_set_to_discrete_ones(said: str, end: float, tmp_path: Path) -> None:
    """A discrete variable that is only set to parameters is known as they are; one that is set to what moves is not."""
    file = tmp_path / "discrete.lag"
    file.write_text(DISCRETE.replace("SAID", f'when not {said} then terminate("there"); end when;'), encoding="utf-8")
    model = lagrangia.load(file)
    assert [bool(flags & 16) for flags in model.scene.patterns["reset_places"][1::3]] == [True, True, True, False]  # LAG_KNOWN
    assert model.simulate(stop=2).time[-1] == pytest.approx(end, abs=1e-6)


SAMPLED = """
model Sampled "x = g t^2/2 is read each 0.1 s: above 0.5 from 0.4 s on, where it stops; n counts from 0.1 s on"
  Prismatic x(a = world, along = {0, -1});
  PointMass ball(m = 1, center = x.b);
  Real u(start = 0);
  Integer n(start = 0), k(start = 0), later(start = 0), both(start = 0), again(start = 0), odd(start = 0);
  discrete Time third(start = 0);
equation
  when sample(0, 0.1) then u = x.s/1[m]; end when;
  when sample(0.1, 0.1) then n = pre(n) + 1; end when;
  when u > 0.5 then reinit(der(x.s), 0); k = pre(k) + 1; end when;
  when n >= 3 then third = time; end when;
  when n - 2.5 + 1e-9*x.s/1[m] > 0 then later = pre(later) + 1; end when;
  when x.s > 0.01 and n >= 3 then both = pre(both) + 1; end when;
  when k >= 1 then again = pre(again) + 1; end when;
  when mod(n, 2) == 1 then odd = pre(odd) + 1; end when;
end Sampled;
"""


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
def test_events_of_what_is_sampled(tmp_path: Path, solver: str) -> None:
    """They come at the instant, after the sample."""
    file = tmp_path / "sampled.lag"
    file.write_text(SAMPLED, encoding="utf-8")
    last = lagrangia.load(file).simulate(stop=0.95, solver=solver, tolerance=1e-9)
    assert [last[name][-1] for name in ("n", "k", "later", "both", "again", "odd")] == [9, 1, 1, 1, 1, 5]
    assert last["third"][-1] == pytest.approx(0.3) and last["der(x.s)"][-1] == pytest.approx(9.81*0.55)
