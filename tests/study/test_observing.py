"""Quantities that are computed from rows: as the run saw them."""

from collections.abc import Callable

import pytest

import lagrangia as lag


@pytest.mark.parametrize(("start", "rates"), [(0, [0, 0, 0, 2]), (-1, [-3, -2, -1, 0]), (1, [1, 2, 3, 4])])
def test_rates_at_bends_are_those_of_the_side_that_a_run_comes_from(start: float, rates: list[float],
                                                                    scene: Callable[[str], lag.Model]) -> None:
    """The rate of its support jumps at t = 0 and 1 s, which the block's own rate makes up for; at the start from behind."""
    model = scene("""model M World world(gravity = {0, 0}); parameter Real c = 1; Real T = time/1[s];
      Prismatic a(a = world), d(a = a.b); PointMass p(m = 1, center = d.b);
      equation a.s = 1[m]*max(0, T^2 - c*T); end M;""")
    run = model.simulate(start=start, stop=start + 1.5, interval=0.5)
    assert run["a.v"] == pytest.approx(rates, abs=1e-9)
    assert run["p.center.v[1]"] == pytest.approx([rates[0]] * 4, abs=1e-9)  # nothing pushes it along its guide


def test_first_rows_after_the_start_are_seen_from_before(scene: Callable[[str], lag.Model]) -> None:
    """The support sets out at t = 1 s, where the first row lies."""
    model = scene("""model M Frame f = shift(world, {max(0, time/1[s] - 1)*1[m], 0}); Prismatic r(a = f);
      PointMass p(m = 1, center = r.b); output Velocity w = p.center.v[1]; end M;""")
    for at in ([1.0], [1.0, 2.0], [0.0, 1.0, 2.0]):
        run = model.simulate(at=at)
        assert run["p.center.v[1]"] == pytest.approx(run["w"], abs=1e-9), at
