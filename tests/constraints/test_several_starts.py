"""Starts that fit an initial equation in two ways: which was taken is told, unless who wrote it chose."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
BLOCK = "Block b(m = 1, base = world{});"
HINGE = "Revolute h(a = world{}); Bar p(m = 1, L = 1, a = h.b);"
CRANK = """Revolute h(a = world{}); Bar p(m = 1, L = 0.5, a = h.b); Revolute g(a = p.b); Bar q(m = 1, L = 1, a = g.b);
  Prismatic s(a = world); Revolute e(a = s.b, b = q.b); Body slider(m = 1, I = 1, center = s.b);"""
TOLD = [  # what is stated, what was taken, what else there is, how it is chosen
    (BLOCK.format(""), "der(b.s)^2 = 4;", "der(b.s) = -2 m/s", "der(b.s) = 2 m/s", "b.v(start = 2)"),
    (BLOCK.format(""), "b.m*b.v^2/2 = 5e5;", "der(b.s) = -1000 m/s", "der(b.s) = 1000 m/s", "b.v(start = 1000)"),
    (BLOCK.format(", s(start = 3)"), "b.v^2 + 2*b.s = 10;", "der(b.s) = -2 m/s", "der(b.s) = 2 m/s", "b.v(start = 2)"),
    (HINGE.format(""), "p.b.y = 0.5;", "h.phi = 30 deg", "h.phi = 150 deg", "h.phi(start = 150[deg])"),
    (HINGE.format(""), "tan(h.phi) = 1;", "h.phi = 45 deg", "h.phi = -135 deg", "h.phi(start = -135[deg])"),
    (CRANK.format(""), "s.s = 1.2;", "h.phi = 54.9 deg, g.phi = -79.05 deg", "h.phi = -54.9 deg", "h.phi(start = -54.9[deg])"),
    (CRANK.format(""), "h.phi = 1;", "g.phi = -82.18 deg, s.s = 1.177 m", "g.phi = 147.6 deg, s.s = -0.637 m",
     "g.phi(start = 147.6[deg])"),
]
SETTLED = [
    (BLOCK.format(", v(start = -1)"), "der(b.s)^2 = 4;"),
    (BLOCK.format(""), "3*der(b.s) = 4 - der(b.s);"),
    (BLOCK.format(""), "(b.v - 1)^3 = 0; (b.s - 2)^4 = 0;"),
    (HINGE.format(", phi(start = 3)"), "p.b.y = 0.5;"),
    (HINGE.format(""), "sin(h.phi) = 1; h.w = 3;"),
    (CRANK.format(", phi(start = 0.2)"), "s.s = 1.2;"),
    (CRANK.format(", phi(start = 0.2)"), "s.v = 1;"),
]


@pytest.mark.parametrize(("parts", "stated", "taken", "other", "chosen"), TOLD)
def test_another_start_is_told(parts: str, stated: str, taken: str, other: str, chosen: str, scene: Write) -> None:
    model = scene(f"model M {parts} initial equation {stated} end M;")
    (warning,) = model.warnings
    assert warning.startswith(f"warning[L0609]: 2 starts fit this: taken {taken}")
    assert f"there is {other}" in warning and f"{chosen}\n" in warning + "\n"
    name, _, value = taken.partition(",")[0].rpartition(" = ")
    begins = model.simulate(stop=1e-9, interval=1e-9)[name][0]
    assert float(value.split()[0]) == pytest.approx(begins * (57.29577951 if "deg" in value else 1), rel=1e-3)
    assert scene(f'model M {parts} initial equation {stated} annotation(allow = "L0609"); end M;').warnings == []


def test_places_that_equations_of_rates_move_are_told(scene: Write) -> None:
    parts = "Block b(m = 1, base = world, s(start = 0.1)), c(m = 1, base = world{});"
    energy = "b.v^2 + c.v^2 + 1e3*b.s = 200;"
    (warning,) = scene(f"model M {parts.format('')} initial equation {energy} end M;").warnings
    assert warning.startswith("warning[L0609]: this moves starts that are stated: b.s at 0.2 m")
    assert "state a start for der(b.s) or der(c.s)" in warning
    model = scene(f"model M {parts.format(', v(start = 1)')} initial equation {energy} end M;")
    assert model.simulate(stop=0.01)["b.s"][0] == 0.1 and "this moves" not in "".join(model.warnings)


def test_places_are_told_as_runs_find_them(scene: Write) -> None:
    """Unequal masses move unequally far: measured without them, the places told are others (0.4447 and 0.5118 m)."""
    model = scene("model M World world(gravity = {0, 0}); Block a(m = 1, base = world, s(start = 0.3)), "
                  "b(m = 2, base = world, s(start = 0.5)); initial equation "
                  "a.v^2 + 2*b.v^2 + 100[1/s2]*a.s^2 + 50[1/s2]*(b.s - a.s)^2 = 20[m2/s2]; end M;")
    begins = model.simulate(stop=0.01)
    assert f"a.s at {begins['a.s'][0]:.4g} m, b.s at {begins['b.s'][0]:.4g} m" in model.warnings[0]


@pytest.mark.parametrize(("parts", "stated"), SETTLED)
def test_nothing_is_told_where_one_fits_or_a_start_chose(parts: str, stated: str, scene: Write) -> None:
    assert scene(f"model M {parts} initial equation {stated} end M;").warnings == []


def test_sums_with_free_parameters_are_told_or_taken_apart(scene: Write) -> None:
    """x^2 + p vanishes in parts where p is 0 alone, as declared, and is met to half the digits; p*x^2 does whatever p is."""
    begins = "model M parameter Real p = {}; Block b(m = 1, base = world); initial equation {} end M;"
    model = scene(begins.format(0, "(b.s/1[m] - 1)^2 + p = 0;"))
    assert len(model.warnings) == 1 and "L0609]: with the parameters as declared this only just holds" in model.warnings[0]
    model = scene(begins.format(2, "p*sqrt(b.s/1[m] - 3) = 0; ((b.v/1[m/s] - 1)^2 + b.s*0/1[m])/p = 0;"))
    assert not any("L0609" in told for told in model.warnings)
    for p in (2.0, -3.0):
        run = model.simulate(parameters={"p": p}, stop=1e-9, interval=1e-9)
        assert [float(run[name][0]) for name in ("b.s", "der(b.s)")] == pytest.approx([3, 1], abs=1e-12)


@pytest.mark.parametrize("stated", [
    "(a.s - 1)^2 + 3*(b.s - 2)^2 = 0; (a.v - 1)^2 + b.v^2/2 = 0;", "sqrt(a.s - 1[m]) = 0; sqrt(b.s - 2[m])*2 = 0; a.v = 1;",
    "abs(a.s - 1) + abs(b.s - 2) = 0; sqrt(a.v - 1[m/s]) + sqrt(b.v) = 0;",
])
def test_what_vanishes_in_parts_begins_exactly_there(stated: str, scene: Write) -> None:
    """A sum of squares was solved to half the digits, and a root was said to have no finite value."""
    run = scene(f"model M Block a(m = 1, base = world), b(m = 2, base = world); initial equation {stated} end M;").simulate(
        stop=1e-9, interval=1e-9)
    assert [float(run[name][0]) for name in ("a.s", "b.s", "der(a.s)", "der(b.s)")] == pytest.approx([1, 2, 1, 0], abs=1e-12)


def test_a_sum_whose_parameter_is_given_later_is_solved_anew(scene: Write) -> None:
    model = scene("model M parameter Real c = 0; Block a(m = 1, base = world, s(start = 1)); initial equation a.s^2 = c*1[m2]; "
                  "end M;")
    assert model.simulate(stop=1e-9, interval=1e-9, parameters={"c": 4})["a.s"][0] == pytest.approx(2)
