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
