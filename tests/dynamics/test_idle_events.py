"""Events that compare what never changes are pointed at; those that other parameters or motions bring are not."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
BAR = "model M Revolute h(a = world, phi(start = 0.3)); Bar b(m = 1, L = 1, a = h.b); {} end M;"
ROD = "model M PointMass p(m = 1), q(m = 1); Link l(a = p.center, b = q.center, L = 1); {} initial equation p.center.x = 0; "\
      "p.center.y = 0; q.center.x = 1; q.center.y = 0; end M;"
DRIVEN = ROD.replace("Link l(a = p.center, b = q.center, L = 1); {}", "discrete Integer n(start = 0); {} equation "
                     "distance(p.center, q.center) = {}; when {} then n = pre(n) + 1; end when;")
IDLE = {
    "a stop on one body": BAR.format("Stop stop(gap = distance(b.a, b.b) - 0.5);"),
    "a stop that a rod keeps": ROD.format("Stop stop(gap = distance(p.center, q.center) - 0.5);"),
    "a distance on one body": BAR.format("equation when distance(b.center, b.b) > 3 then reinit(h.w, 0); end when;"),
}
COMING = {
    "in the world": BAR.format("Stop stop(a = b.a, b = b.b, along = {1, 0});"),
    "with another rod": ROD.format("Stop stop(gap = q.center.x - p.center.x + 2);"),
    "with other parameters": BAR.format("parameter Length e = 0; Stop stop(gap = e*cos(h.phi) + 1[m]);"),
    "with a rod that grows": DRIVEN.format("", "1[m] + 0.5[m/s]*time", "distance(p.center, q.center) > 1.2"),
    "with a rod of an input": DRIVEN.format("input Length L(start = 1);", "L", "distance(p.center, q.center) > 1.2"),
    "with a crank that time turns": """model M discrete Integer n(start = 0); Revolute h(a = world);
        Bar b(m = 1, L = 0.5, a = h.b); Prismatic s(a = world, s(start = 2)); Link l(a = b.b, b = s.b, L = 1.5);
        Block k(m = 1, base = s.b); equation h.phi = 2[rad/s]*time; when s.s < 1.7 then n = pre(n) + 1; end when; end M;""",
    "with time": BAR.format("Stop stop(gap = distance(b.a, b.b) - time*1[m/s]);"),
}


def _told(model: lag.Model) -> list[str]:
    return [text for text in model.scene.notes["warnings"] if "L0224" in text]


@pytest.mark.parametrize("case", IDLE)
def test_what_never_changes_is_told(case: str, scene: Write) -> None:
    (told,) = _told(scene(IDLE[case]))
    assert "what it compares never changes" in told and "^^^" in told


@pytest.mark.parametrize("case", COMING)
def test_what_may_change_is_not(case: str, scene: Write) -> None:
    assert _told(scene(COMING[case])) == []
