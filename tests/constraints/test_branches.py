"""Singular positions: the ways of moving that meet there, each with its modes in closed form, and those where nothing moves."""

from collections.abc import Callable
from itertools import chain

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.run.engines import load_engine
from lagrangia.run.request import Request, check_values, plan
from lagrangia.run.simulate import start_run
from lagrangia.study.modes import Modes

G = 9.81
Write = Callable[[str], lag.Model]
LINE = "PointOnLine slide(line = world, point = rod.b);"
GUIDE = "Prismatic guide(a = world, along = {1, 0}); equation rod.b.r = guide.b.r;"


def rates(modes: Modes) -> dict[str, list[float]]:
    return {way: [m.omega or m.growth for m in modes.modes if m.way == way] for way in modes.ways}


@pytest.mark.parametrize("tie", [LINE, GUIDE])
@pytest.mark.parametrize(("m", "L", "angle"), [(1, 1, 90), (3, 0.02, 90), (1e-3, 40, -90)])
def test_a_crank_as_long_as_its_rod(tie: str, m: float, L: float, angle: float, scene: Write) -> None:
    """Upright or hanging both may turn together, J = 2/3 m L^2, or as mirror images, J = 8/3 m L^2; V'' = -+ m g L."""
    model = scene(f"""model Crank
      Revolute O(a = world, phi(start = {angle}[deg])), pin(a = crank.b, b = rod.a, phi(start = -180[deg]));
      Bar crank(m = {m}, L = {L}, a = O.b), rod(m = {m}, L = {L}); {tie}
    end Crank;""")
    wanted = np.sqrt([3 * G / (2 * L), 3 * G / (8 * L)])
    modes = model.modes()
    assert next(iter(modes.ways)) == "O.phi alone"
    np.testing.assert_allclose(sorted(chain(*rates(modes).values()))[::-1], wanted, rtol=1e-7)
    kinds = {"oscillation"} if angle < 0 else {"divergence"}
    assert {mode.kind for mode in modes.modes} == kinds
    first = model.equilibrium(starts=1)[0]
    assert first.stability == ("stable" if angle < 0 else "unstable") and len(first.ways) == 2
    if angle > 0:
        assert first.growth == pytest.approx(wanted[0], rel=1e-7)
    with pytest.raises(lag.RunError, match="2 ways of moving meet, and matrices are of one: O"):
        model.linearize()


def test_each_crank_of_two_has_its_ways(scene: Write) -> None:
    """Two mechanisms that do not interact: four planes."""
    cranks = "".join(f"""
      Revolute O{k}(a = world, phi(start = 90[deg])), pin{k}(a = crank{k}.b, b = rod{k}.a, phi(start = -180[deg]));
      Bar crank{k}(m = 1, L = {L}, a = O{k}.b), rod{k}(m = 1, L = {L}); PointOnLine slide{k}(line = world, point = rod{k}.b);"""
                     for k, L in ((1, 1), (2, 2)))
    found = sorted(sorted(x) for x in rates(scene(f"model Cranks {cranks} end Cranks;").modes()).values())
    fast, slow = np.sqrt([3 * G / 2, 3 * G / 8])
    wanted = sorted(sorted([a, b / np.sqrt(2)]) for a in (fast, slow) for b in (fast, slow))
    np.testing.assert_allclose(sorted(np.round(found, 6).tolist()), np.round(wanted, 6).tolist(), rtol=1e-5)


@pytest.mark.parametrize("third", ["", "Link third(a = shift(world, {0.5, 0}), b = coupler.center, L = 0.4);"])
def test_a_flat_parallelogram_opens_or_crosses(third: str, scene: Write) -> None:
    """With a spring at one crank: parallel, J = 2/3 m a^2 + m a^2; crossed, the other turns back (L + a)/(L - a) as far.
    A third crank, which repeats the others, allows the first way alone."""
    model = scene(f"""model Flat World world(gravity = {{0, 0}});
      Revolute O(a = world), A(a = crank.b), B(a = coupler.b, b = rocker.b), C(a = shift(world, {{1, 0}}));
      Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 1, L = 1, a = A.b), rocker(m = 1, L = 0.4, a = C.b);
      TorsionSpring s(a = world, b = O.b, k = 2); {third}
    end Flat;""")
    found = sorted(chain(*rates(model.modes()).values()))
    a, L, r = 0.4, 1.0, 1.4 / 0.6
    parallel = a**2 * (2 / 3 + 1)
    crossed = a**2 / 3 * (1 + r**2) + (a * (1 - r) / 2) ** 2 + L**2 / 12 * (a * (1 + r) / L) ** 2
    wanted = [np.sqrt(2 / parallel)] if third else sorted([np.sqrt(2 / parallel), np.sqrt(2 / crossed)])
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


TAUT = """model Taut Revolute h1(a = world, phi(start = 10[deg])), h2(a = b1.b, phi(start = -10[deg]));
  Bar b1(m = 1, L = {a}, a = h1.b), b2(m = 1, L = {b}, a = h2.b); Link l(a = shift(world, {{3, 0}}), b = b2.b, L = 3 - {a} - {b});
end Taut;"""


@pytest.mark.parametrize(("a", "b"), [(1, 1), (0.5, 1.5), (2, 0.3)])
def test_what_is_just_long_enough_does_not_move(a: float, b: float, scene: Write) -> None:
    model = scene(TAUT.format(a=a, b=b))
    notes = model.freedom
    assert (notes["degrees_of_freedom"], notes["is_rigid_at_start"]) == (0, True)
    first = model.equilibrium()[0]
    assert first.stability == "fixed" and max(map(abs, first.position.values())) < 1e-12
    assert len(model.modes()) == 0


def test_constraints_that_depend_everywhere_are_an_ordinary_freedom(scene: Write) -> None:
    """Two bars in line, tied to the length of both: they turn as one, wherever they are. J = (1 + 0.8 + ...) by hand."""
    model = scene("""model Straight Revolute h1(a = world, phi(start = 90[deg])), h2(a = b1.b);
      Bar b1(m = 1, L = 0.8, a = h1.b), b2(m = 1, L = 0.8, a = h2.b); Link tie(a = world, b = b2.b, L = 1.6);
    end Straight;""")
    assert model.freedom["degrees_of_freedom"] == model.freedom["degrees_at_start"] == 1
    modes = model.modes()
    assert modes.ways == ("",) and modes.modes[0].kind == "divergence"
    J = 2 * 1.6**2 / 3  # of one bar of 2 kg
    np.testing.assert_allclose(modes.modes[0].growth, np.sqrt(2 * G * 0.8 / J), rtol=1e-9)


def test_what_warned_before_another_choice_begins_anew_has_warned_once(scene: Write) -> None:
    """A crank as long as its pivots are apart: the account opens late, and the run begins again from its start."""
    made = scene("""model Crank World world(gravity = {0, 0});
      Revolute O(a = world, phi(start = 0.3)); Motion turned(of = O.phi, to = 10*time + 0.3);
      Revolute Q(a = shift(world, {0, -0.5}), phi(start = 1.1));
      Bar crank(m = 1, L = 0.499999, a = O.b), arm(m = 2, L = 1.2, a = Q.b); PointOnLine slot(line = Q.b, point = crank.b);
      equation assert(time < 0.1, "late", AssertionLevel.warning); assert(O.phi < 2, "far", AssertionLevel.warning);
      annotation(experiment(StopTime = 5)); end Crank;""").scene
    engine, told = load_engine(made, native=False), []
    assert engine is not None
    with start_run(made, engine, plan(made, Request(tolerance=1e-3)), check_values(made)) as run:
        for k in range(1, 151):
            run.advance([k / 100])
            told += [which for which, _ in run.warnings()]
    assert sorted(told) == [0, 1]
