"""Starts on contacts: what is at rest there, and what is not."""

from collections.abc import Callable

import lagrangia as lag

Write = Callable[[str], lag.Model]


def test_a_stiff_neighbour_takes_no_start_velocity(scene: Write) -> None:
    """A spring that has nothing to do with the ball accelerates by 1e7 m/s2: what is slow is not told by that."""
    model = scene("""model Beside
      World world(gravity = {0, -9.81});
      Prismatic y(a = world, along = {0, 1}, v(start = 0.5)), z(a = world, s(start = 0.01));
      PointMass ball(m = 0.1, center = y.b), bob(m = 1e-3, center = z.b);
      Stop floor(e = 0.9, gap = y.s); Spring k(k = 1e6, stretch = z.s);
    end Beside;""")
    for v, tolerance in ((0.5, 1e-3), (5e-4, 1e-6)):
        assert model.simulate(at=[0.0], initial={"y.v": v}, tolerance=tolerance)["y.v"][0] == v
