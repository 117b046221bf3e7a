"""A spring in a row with a damper (Maxwell element) against its closed form, and where a place between two such is refused."""

import numpy as np
import pytest

import lagrangia as lag

K, C, M = 100.0, 20.0, 1.0
FREE = f"""model Free World world(gravity = {{0, 0}});
  Block b(m = {M}, base = world, s(start = 1));
  MaxwellSpring e(k = {K}, c = {C}, stretch = b.s); end Free;"""


def test_its_force_dies_out_as_it_should() -> None:
    """f'' + k/c f' + k/m f = 0 from f = k, f' = -k^2/c; what is lost is all of the spring's energy."""
    run = lag.loads(FREE).simulate(at=np.linspace(0, 2, 401), tolerance=1e-10)
    a = K / C / 2
    w, t = np.sqrt(K / M - a**2), run.time
    right = K * np.exp(-a * t) * (np.cos(w * t) - a / w * np.sin(w * t))
    assert np.array(run["e.f"]) == pytest.approx(right, abs=1e-7)
    assert abs(run.energy.residual).max() < 1e-8
    assert np.trapezoid(run["e.loss"], run.time) + run["e.stored"][-1] + run.energy.kinetic[-1] == pytest.approx(K/2, rel=1e-3)


@pytest.mark.parametrize("c", [0.0, -1.0])
def test_a_damper_that_passes_no_force_is_refused(c: float) -> None:
    with pytest.raises(lag.LagError, match=r"'e\.c' is .* less than its minimum"):
        lag.loads(FREE).simulate(parameters={"e.c": c})
    with pytest.raises(lag.LagError, match=r"'e\.c' is .* less than its minimum"):
        lag.loads(FREE.replace(f"c = {C}", f"c = {c}")).simulate()


def test_it_acts_along_the_line_of_its_ends() -> None:
    """A point that is thrown across: its moment of momentum stays, as it does under central forces alone."""
    scene = """model Thrown World world(gravity = {0, 0});  PointMass p(m = 2);
      MaxwellSpring e(a = world, b = p.center, k = 100, c = 5, s_rel0 = 1);
      output Real L = p.center.x*p.center.v[2] - p.center.y*p.center.v[1];
    initial equation p.center.x = 1.5; p.center.y = 0; der(p.center.y) = 1; end Thrown;"""
    run = lag.loads(scene).simulate(stop=2, tolerance=1e-10)
    assert np.array(run["L"]) == pytest.approx(1.5, abs=1e-7)


@pytest.mark.parametrize(("first", "second", "told"), [
    ("Spring", "Damper", r"MaxwellSpring\(k = "), ("Spring", "Spring", r"PointMass node\(m = 0"),
    ("Damper", "Damper", "with a mass")])
def test_what_is_proposed_between_two_is_no_more_than_what_runs(first: str, second: str, told: str) -> None:
    value = {"Spring": "k = 100", "Damper": "c = 5"}
    scene = f"""model M World world; PointMass p(m = 2);
      {first} s1(a = world, {value[first]});  {second} s2(a = s1.b, b = p.center, {value[second]}); end M;"""
    with pytest.raises(lag.LagError, match=told):
        assert lag.loads(scene).scene


def test_a_plane_place_between_spring_and_damper_says_what_to_write() -> None:
    scene = """model M World world; PointMass p(m = 2), node(m = 0);
      Spring s1(a = world, k = 100, b = node.center);  Damper s2(a = node.center, b = p.center, c = 5); end M;"""
    with pytest.raises(lag.LagError, match="MaxwellSpring"):
        assert lag.loads(scene).scene
