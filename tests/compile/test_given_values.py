"""Values that are given for parameters decide as if declared: what is compiled in, what moves no mass, what is printed."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
TWO = """model M parameter Mass {z};
  Block b(m = 1, base = world, s(start = 0.1)), c(m = {bound}, base = world);
  Spring s(k = 2, stretch = b.s - c.s), t(k = 3, stretch = c.s); end M;"""
PENDULUM = """model M parameter Length L = 1; Revolute h(a = world); PointMass p(m = 1, center = shift(h.b, {0, -L})); end M;"""


def two(scene: Write, z: str = "z = 0", bound: str = "z") -> lag.Model:
    return scene(TWO.format(z=z, bound=bound))


@pytest.mark.parametrize(("z", "bound", "given"), [
    ("z = 0", "z", {}), ("z = 1", "z", {"z": 0}), ("z = 1", "z", {"c.m": 0}), ("z = 1", "2*z", {"z": 0}),
    ("z = 1, y = 2", "y - z", {"z": 2}), ("z = 0", "z", {"b.m": 1})])
def test_a_mass_that_is_0_by_its_parameters_leaves_its_place_to_the_balance_of_forces(
        scene: Write, z: str, bound: str, given: dict[str, float]) -> None:
    found = two(scene, z, bound).simulate(at=[0, 1], tolerance=1e-10, parameters=given)
    s = 0.1 * np.cos(np.sqrt(1.2) * np.array([0, 1]))
    np.testing.assert_allclose(found["b.s"], s, atol=1e-12)
    np.testing.assert_allclose(found["c.s"], 0.4 * s, atol=1e-12)
    assert found.names[:2] == ["time", "b.s"]


@pytest.mark.parametrize("bound", ["z", "0"])
def test_a_mass_declared_0_may_be_given(scene: Write, bound: str) -> None:
    """Its place is a coordinate then, which may be started."""
    model, other = two(scene, "z = 0", bound), lag.loads(TWO.format(z="z = 1", bound="z"))
    given = {"c.m" if bound == "0" else "z": 1.0}
    for initial in ({}, {"c.s": 0.3}):
        found, wanted = (m.simulate(at=[0, 1], initial=initial, parameters=p) for m, p in ((model, given), (other, {})))
        for name in ("b.s", "c.s", "der(c.s)"):
            np.testing.assert_allclose(found[name], wanted[name], rtol=1e-9)
    assert model.modes(parameters=given).frequencies == pytest.approx(other.modes().frequencies, rel=1e-9)
    prepared = model.prepare({"c.s": 0.3}, given, at=[0, 1])
    np.testing.assert_allclose(prepared([0.3], [1.0])[:, 1:5], wanted.rows[:, 1:5], rtol=1e-9)


def test_sweeps_over_masses_that_are_0_in_all_runs_and_in_some(scene: Write) -> None:
    model = two(scene, "z = 1")
    swept = model.simulate_many(parameters={"z": 0.0, "b.m": [1.0, 2.0]}, outputs="final(c.s)", stop=1)
    assert swept["final(c.s)"] == pytest.approx(0.04 * np.cos(np.sqrt(1.2 / np.array([1, 2]))), rel=1e-6)
    mixed = two(scene, "z = 0").simulate_many(parameters={"z": [0.0, 1.0]}, outputs="final(c.s)", stop=1)
    assert "'z', 'c.m' are 0" in mixed.failures[0]
    assert mixed["final(c.s)"][1] == pytest.approx(model.simulate(at=[1])["c.s"][0], rel=1e-6)


def test_an_fmu_lets_no_mass_be_0_that_a_coordinate_needs(scene: Write, tmp_path: Path) -> None:
    for z, given in (("z = 0", {}), ("z = 1", {"z": 0.0})):
        with pytest.raises(lag.LagError, match=r"L0704.*'c.s' moves no mass"):
            two(scene, z).export_fmu(tmp_path, parameters=given)
    assert two(scene, "z = 0", "0").general.scene.n == 2
    final = scene(TWO.format(z="z = 0", bound="z").replace("parameter Mass", "final parameter Mass").replace("c(m", "c(final m"))
    assert final.general.scene.n == 1


GRAVITIES = [((9.81, -9.81), np.pi / 4, "φ'' − 9.81 cos φ + 9.81 sin φ = 0"), ((3.0, 0.0), np.pi / 2, "φ'' − 3 cos φ = 0"),
             ((0.0, 3.0), np.pi, "φ'' − 3 sin φ = 0")]


@pytest.mark.parametrize(("gravity", "angle", "equation"), GRAVITIES)
def test_gravity_of_any_direction_may_be_given(scene: Write, gravity: tuple[float, float], angle: float, equation: str) -> None:
    model, given = scene(PENDULUM), {f"world.gravity[{k}]": g for k, g in enumerate(gravity, 1)}
    rest = next(e for e in model.equilibrium(parameters=given, initial={"h.phi": 0.5}) if e.is_stable)
    assert rest.position["h.phi"] == pytest.approx(angle, abs=1e-9)
    assert equation in model.equations(parameters=given, numbers=True)
    omega = model.modes(parameters=given, initial={"h.phi": angle - 0.1}).frequencies[0] * 2 * np.pi
    assert omega == pytest.approx(np.hypot(*gravity) ** 0.5, rel=1e-9)


def test_equations_speak_of_what_is_given(scene: Write) -> None:
    model = two(scene, "z = 1", "0")
    assert "s_c''" not in model.equations()
    assert "m_c s_c''" in model.equations(parameters={"c.m": 2.0})
    for given, code in (({"z": -1.0}, "L0605"), ({"y": 1.0}, "L0702"), ({"z": float("inf")}, "L0706")):
        with pytest.raises(lag.LagError, match=code):
            model.equations(parameters=given)
    with pytest.raises(lag.LagError, match="L0701"):
        scene("model M final parameter Mass m = 1; Block b(m = m, base = world); end M;").equations(parameters={"m": 2.0})


@pytest.mark.parametrize("start", ["each start = 3", "start = 3", "start = {3, 3}", "start = fill(3, 2)"])
def test_one_start_for_all_elements_of_an_input(scene: Write, start: str) -> None:
    """1.5 t^2 of 1 kg."""
    found = scene(f"""model M input Force F[2]({start}); Block b[2](each m = 1, each base = world);
      AppliedForce f[2](at = b.center, force = {{{{F[1], 0}}, {{F[2], 0}}}}); end M;""").simulate(at=[0, 1])
    assert [found["b[1].s"][-1], found["b[2].s"][-1]] == pytest.approx([1.5, 1.5])
