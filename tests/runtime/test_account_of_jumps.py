"""The energy account where time or inputs let energies jump: what jumps is work, whichever side of the event rows stand on."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag

WAYS = {
    "a support that jumps": "Prismatic t(a = world); Motion m(of = t.s, to = {}); Spring s(k = 10, stretch = b.s - t.s);",
    "a spring drawn by jumps": "Spring s(k = 10, stretch = b.s - ({}));",
    "an anchor that jumps": "Spring s(k = 10, a = shift(world, {{({}) - 5, 0}}), b = b.center);",
}
# Of u = 1.25 t: times in s, and by how much the place of rest jumps there, in m.
LAWS = {"0.1*floor(u)": {0.8: 0.1, 1.6: 0.1}, "0.1*ceil(u)": {0.0: 0.1, 0.8: 0.1, 1.6: 0.1},
        "if u > 1 and u < 2 then 0.1 else 0": {0.8: 0.1, 1.6: -0.1},
        "0.1*floor((time/1[s])^2)": {2**0.5: 0.1, 1.0: 0.1, 3**0.5: 0.1}}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("law", LAWS)
def test_what_jumps_in_time_is_work(law: str, way: str, scene: Callable[[str], lag.Model]) -> None:
    """All but conditions of prescribed motion had right rows and ended with 'the energy account does not close': energies at an
    event were those of one side, before it and after it."""
    model = scene(f"model J input Real u = 0; Block b(m = 1, base = world); {WAYS[way].format(law)} end J;")
    inputs, rate = ([0, 2.0], {"u": [0, 2.5]}), 10**0.5
    for solver in ("erk", "implicit"):
        for rows in ({"interval": 0.1}, {"at": [0, 0.8, 1, 1.4, 1.6, 2]}):
            run = model.simulate(stop=2.0, tolerance=1e-9, inputs=inputs, solver=solver, **rows)
            after = run["time"][:, None] - np.array([*LAWS[law]])
            steps = np.array([*LAWS[law].values()]) * (1 - np.cos(rate * np.maximum(after, 0)))
            if way != "an anchor that jumps":
                assert np.abs(run["b.s"] - steps.sum(axis=1)).max() < 1e-7
            assert not run.statistics.energy_is_open
            assert run.statistics.energy_residual < 1e-6 * run.statistics.energy_stored


def test_what_places_decide_as_well_is_no_work(scene: Callable[[str], lag.Model]) -> None:
    """A step of energy that comes towards what runs against it takes an impulse that is missing."""
    law = "if b.s > 0.5 - 0.1*time/1[s] then 5 else 0"
    model = scene(f"""model S Block b(m = 1, base = world, v(start = 1)); Energy e = {law}; energy potential e;
                      Spring s(k = 1 + ({law}), stretch = b.s); end S;""")
    with pytest.warns(lag.RunWarning, match="energy account"):
        assert model.simulate(stop=1.0, tolerance=1e-9, solver="erk").statistics.energy_is_open


# As u = 1.25 t passes 1: from 0 to 1 at 0.8 s.
STEPS = ("floor(u)", "if u > 1 then 1 else 0", "u - mod(u, 1)", "floor(floor(u) + 0.5)", "floor((1.25*time/1[s])^2 + 1e-9)")


@pytest.mark.parametrize("law", STEPS)
def test_inertias_that_jump_keep_the_momentum(law: str, scene: Callable[[str], lag.Model]) -> None:
    """1 kg becomes 3 kg, at a time that is known otherwise or is not: all came out of it with their rate or another one."""
    start = "input Real u = 0; Block b(m = 1, base = world, v(start = 1)); Spring s(k = 10, stretch = b.s); "
    model = scene(f"model J {start} energy kinetic 1[kg]*({law})*b.v^2; end J;")
    place, rate = np.sin(10**0.5 * 0.8) / 10**0.5, np.cos(10**0.5 * 0.8) / 3
    slow, late = (10 / 3)**0.5, 0.1
    wanted = rate * np.cos(slow * late) - place * slow * np.sin(slow * late)
    for solver in ("erk", "implicit"):
        run = model.simulate(stop=0.9, at=[0, 0.8, 0.9], tolerance=1e-10, inputs=([0, 2.0], {"u": [0, 2.5]}), solver=solver)
        assert run["b.v"][-1] == pytest.approx(wanted, abs=1e-8)
        assert not run.statistics.energy_is_open


@pytest.mark.parametrize("ends", [(0, 1, 1.5), (0, 1, 1), (0, 1, 0), (1.5, 1, 0), (3.5, 1, 3.5)])
def test_inertias_keep_the_momentum_where_inputs_turn_on_whole_numbers(ends: tuple[float, ...], scene: Callable[[str], lag.Model]
                                                                       ) -> None:
    """An input that comes to 1 at a point of its table, and goes on or back."""
    model = scene("model J input Real u = 0; Block b(m = 1, base = world, v(start = 1)); "
                  "energy kinetic 1[kg]*floor(u)*b.v^2; end J;")
    run = model.simulate(stop=2, at=[0, 0.7, 0.9, 2], tolerance=1e-9, inputs=([0, 0.8, 2], {"u": [*ends]}))
    mass = 1 + 2 * np.floor(np.interp(run["time"], [0, 0.8, 2], ends))
    assert run["b.v"] * mass == pytest.approx(mass[0], abs=1e-9)
    assert not run.statistics.energy_is_open


def test_inertias_of_what_is_held_keep_the_momentum_along_it(scene: Callable[[str], lag.Model]) -> None:
    """Two blocks that an equation holds together: 3 kg become 4 kg, without any force."""
    model = scene("""model J input Real u = 0; Block a(m = 1, base = world, v(start = 1)); Block b(m = 2, base = world);
                     energy kinetic 0.5[kg]*floor(u)*b.v^2;
                     equation a.s + 0.2[m]*sin(a.s/1[m]) = b.s + 0.2[m]*sin(b.s/1[m]); end J;""")
    run = model.simulate(stop=1, at=[0, 1], tolerance=1e-10, inputs=([0, 2.0], {"u": [0, 2.5]}))
    assert run["a.v"][-1] == pytest.approx(0.75 * run["a.v"][0], abs=1e-8)
    assert not run.statistics.energy_is_open


def test_potentials_that_jump_and_act_on_nothing_are_work(scene: Callable[[str], lag.Model]) -> None:
    """No force tells of the jump of 0.3 J."""
    model = scene("""model J input Real u = 0; Block b(m = 1, base = world); Spring s(k = 10, stretch = b.s - 0.3);
                     Energy e = 3[J]*(0.1*floor(u)); energy potential e; end J;""")
    run = model.simulate(stop=2, interval=0.5, tolerance=1e-9, inputs=([0, 2.0], {"u": [0, 2.5]}))
    assert not run.statistics.energy_is_open
