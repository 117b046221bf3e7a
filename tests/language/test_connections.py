"""Connectors: what meets has one position, whatever gives it, in whatever order it is written."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import expm

import lagrangia as lag

Scene = Callable[[str], lag.Model]

PARTS = """connector Shaft
  Angle phi;
end Shaft;
model Wheel
  parameter Inertia J = 1; Shaft a, b;
  coordinate Angle phi;
equation
  a.phi = phi; b.phi = phi;
energy
  kinetic J*der(phi)^2/2;
end Wheel;
model OpenWheel "As the Modelica Standard Library writes it: phi is no coordinate of its own"
  parameter Inertia J = 1; Shaft a, b;
  Angle phi;
equation
  phi = a.phi; phi = b.phi;
energy
  kinetic J*der(phi)^2/2;
end OpenWheel;
model Twisted
  parameter TorsionStiffness c = 1; Shaft a, b;
energy
  potential c*(b.phi - a.phi)^2/2;
end Twisted;
model Geared
  parameter Real ratio = 3; Shaft a, b;
equation
  a.phi = ratio*b.phi;
end Geared;
model Held
  Shaft a;
equation
  a.phi = 0;
end Held;
"""


def swing(stiffness: np.ndarray, start: np.ndarray, time: float) -> np.ndarray:
    """Places after a time, of unit inertias that start at rest."""
    n = len(start)
    system = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, np.zeros((n, n))]])
    return (expm(system * time) @ np.concatenate([start, np.zeros(n)]))[:n]


@pytest.mark.parametrize("joins", [
    "connect(h.a, s.a); connect(s.b, t.a); connect(t.b, w.a); connect(w.b, r.a); connect(r.b, x.a);",
    "connect(x.a, r.b); connect(r.a, w.b); connect(w.a, t.b); connect(t.a, s.b); connect(s.a, h.a);",
    "connect(t.a, s.b); connect(r.a, t.b); connect(r.a, w.b); connect(x.b, r.b); connect(s.a, h.a); connect(w.a, t.b);",
])
@pytest.mark.parametrize("wheel", ["Wheel", "OpenWheel"])
def test_shafts_in_a_row(wheel: str, joins: str, scene: Scene) -> None:
    start = "w(phi(start = 0.1))" if wheel == "Wheel" else "w"
    given = "initial equation w.phi = 0.1;"
    model = scene(f"{PARTS}model Row Held h; Twisted s(c = 10), t(c = 10), r(c = 5); {wheel} {start}, x; "
                  f"equation {joins} {given} end Row;")
    run = model.simulate(at=[1.0], tolerance=1e-12)
    right = swing(np.array([[5 + 5, -5], [-5, 5.0]]), np.array([0.1, 0]), 1.0)
    assert len(model.coordinate_names) == 2  # the place between two springs has no mass: it follows
    assert [run["w.phi"][0], run["x.phi"][0]] == pytest.approx(right, abs=1e-13)


@pytest.mark.parametrize("bound", ["s[3](b = w.a)", "s[3](b = {w[1].a, w[2].a, w[3].a})"])
def test_given_in_modifications(bound: str, scene: Scene) -> None:
    """Arrays of connectors are dealt out like other values."""
    run = scene(f"""{PARTS}model M Wheel w[3]; Twisted {bound}; Held h(a = s[1].a);
      equation for i in 2:3 loop connect(w[i-1].b, s[i].a); end for;
      initial equation w[1].phi = 1; end M;""").simulate(at=[2.0], tolerance=1e-12)
    right = swing(np.array([[2, -1, 0], [-1, 2, -1], [0, -1, 1.0]]), np.array([1.0, 0, 0]), 2.0)
    assert [run[f"w[{i}].phi"][0] for i in (1, 2, 3)] == pytest.approx(right, abs=1e-12)


def test_gears_beside_each_other_repeat_one_equation(scene: Scene) -> None:
    """Both ends of both gears meet: what the second says follows from the first."""
    run = scene(f"""{PARTS}model M Wheel w(phi(start = 0.3)), x(J = 2); Geared g, h; Twisted s(c = 2); Held f(a = s.a);
      equation connect(w.b, g.a); connect(g.b, x.a); connect(h.b, g.b); connect(g.a, h.a); connect(s.b, x.b);
      end M;""").simulate(at=[1.5], tolerance=1e-12)
    assert run["w.phi"][0] == pytest.approx(0.3 * np.cos(np.sqrt(2 / (9 + 2)) * 1.5), abs=1e-13)


def test_gears_in_a_ring_without_wheels(scene: Scene) -> None:
    """What each end depends on comes back to it: 9 phi = phi, so nothing turns, and the spring holds the wheel."""
    run = scene(f"""{PARTS}model M Geared g, h; Twisted s(c = 4); Wheel w(phi(start = 0.2));
      equation connect(g.a, h.b); connect(h.a, g.b); connect(s.a, g.a); connect(s.b, w.a); end M;""").simulate(at=[1.0])
    assert run["w.phi"][0] == pytest.approx(0.2 * np.cos(2.0), abs=1e-12)


def test_two_wheels_that_meet_are_one(scene: Scene) -> None:
    model = scene(f"{PARTS}model M Wheel w, x(phi(start = 0.2), J = 3); Twisted s(b = x.b); Held h(a = s.a); "
                  "equation connect(w.b, x.a); end M;")
    assert model.simulate(at=[1.0], tolerance=1e-12)["w.phi"][0] == pytest.approx(0.2 * np.cos(0.5), abs=1e-13)


def test_a_signal_in_a_connector_must_be_given(scene: Scene) -> None:
    """What nothing gives and is no position is no coordinate either."""
    with pytest.raises(lag.Error, match="L0211"):
        scene("connector Bus Real x; end Bus; model M Bus a, b; Block k(m = 1, base = world); "
              "AppliedForce f(at = k.center, force = {a.x*1[N], 0}); equation connect(a, b); end M;")


def test_elements_of_a_variable_are_given_one_by_one(scene: Callable[[str], lag.Model]) -> None:
    found = scene("""model M parameter Integer n = 2; Block b[n](each m = 1, each base = world, s(start = {0.1, 0.2}));
      Force f[n]; Real A[2,2]; output Real corner = A[2,1];
      equation for i in 1:n loop f[i] = -4[N/m]*b[i].s; for j in 1:2 loop A[i,j] = 10*i + j; end for; end for;
      energy for i in 1:n loop work f[i] on b[i].s; end for; end M;""").simulate(at=[0.0, 1.0], tolerance=1e-10)
    assert [found["b[1].s"][1], found["b[2].s"][1]] == pytest.approx([0.1 * math.cos(2), 0.2 * math.cos(2)], abs=1e-9)
    assert found["corner"][1] == 21
