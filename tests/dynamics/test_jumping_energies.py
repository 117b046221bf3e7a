"""Energies that jump with a position are told of: no force is their slope."""

import re
from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]


@pytest.mark.parametrize(("what", "is_told"), [
    ("GeneralSpring s(stretch = b.s, V = if b.s > 1 then 5 else 0);", True),
    ("GeneralSpring s(stretch = b.s, V = 5*floor(b.s/0.1));", True),
    ("GeneralSpring s(stretch = b.s, V = if b.s > L then 50*b.s^2 else 0);", True),
    ("GeneralSpring s(stretch = b.s, V = if b.s > L then 50*(b.s - L)^2 else 0);", False),
    ("GeneralSpring s(stretch = b.s, V = if time > 1 then 50*b.s^2 else 0);", False),
    ("PointMass p(m = 1); GeneralSpring s(stretch = b.s, V = if distance(p.center, b.center) > L then 3 else 2);", True),
    ("PointMass p(m = 1); energy potential if p.center.x < 0 and p.center.y < 0 then 50[N/m]*p.center.y^2 else 0;", True),
    ("energy kinetic (if b.s > 0.5 then 2 else 1)*b.v^2/2;", True),
    ("energy kinetic (if b.s > 0.5 then 4[kg/m]*b.s - 1 else 1)*b.v^2/2;", False),
    ("energy kinetic (if b.v > 0.5 then 2 else 1)*b.v^2/2;", True),
    ("energy kinetic (if b.v + b.s/1[s] > 0.5 then 2 else 1)*b.v^2/2;", True),
    ("energy kinetic (if b.v > 0 then 2 else 1)*b.v^2/2;", False),
    ("energy kinetic (if time > 1 then 2 else 1)*b.v^2/2;", False),
])
def test_energies_that_jump_are_told(what: str, is_told: bool, scene: Write) -> None:
    told = scene(f"model Jump parameter Length L = 0.3; Block b(m = 1, base = world); {what} end Jump;").warnings
    assert any("L0744" in warning for warning in told) == is_told


@pytest.mark.parametrize("what", ["b.s > 0.5", "b.v > 1.5"])
@pytest.mark.parametrize("solver", ["auto", "erk5", "implicit"])
def test_runs_past_a_jump_name_it(what: str, solver: str, scene: Write) -> None:
    """The sentence spoke of collisions and divisions by zero, and asked for a smaller tolerance."""
    model = scene(f"""model Jump Block b(m = 1, base = world, v(start = 1.2)); AppliedForce f(at = b.center, force = {{1, 0}});
                      energy kinetic (if {what} then 1[kg] else 0)*b.v^2/2; end Jump;""")
    with pytest.warns(lag.RunWarning, match=r"an energy jumps .*, at .*scene.lag:2:\d+, which gives no impulse"):
        model.simulate(stop=1.0, interval=0.1, solver=solver)


@pytest.mark.parametrize("what", ["b.s > 0.5", "b.v > 1.5"])
def test_sweeps_past_a_jump_name_it(what: str, scene: Write) -> None:
    """They asked for a smaller tolerance or another solver."""
    model = scene(f"""model Jump parameter Mass m = 1; Block b(m = m, base = world, v(start = 1.2));
                      AppliedForce f(at = b.center, force = {{1, 0}});
                      energy kinetic (if {what} then 1[kg] else 0)*b.v^2/2; end Jump;""")
    with pytest.warns(lag.RunWarning, match="misses"):
        swept = model.simulate_many(parameters={"m": [1.0, 1.1]}, stop=1.0)
    told = r"an energy jumps .*, at .*scene.lag:3:\d+, which gives no impulse \(L0744\)"
    assert re.search(told, swept.message(0)) and all(re.search(told, text) for text, _ in swept.common_failures())


def test_what_is_told_to_write_instead_keeps_the_energy(scene: Write) -> None:
    """1 kg becomes 2 kg over 1 mm."""
    model = scene("""model Rise Block b(m = 1, base = world, v(start = 3));
                     energy kinetic 1[kg]*min(1, max(0, (b.s - 0.5)/0.001))*b.v^2/2; end Rise;""")
    run = model.simulate(stop=1.0, interval=0.1, tolerance=1e-10)
    assert not model.warnings and run["b.v"][-1] == pytest.approx(3 / 2**0.5, abs=1e-9)
    assert not run.statistics.energy_is_open
