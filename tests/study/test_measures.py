"""Measures over windows of time, of levels, of settling and of cycles: against closed solutions and the standard's own table."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
# s = cos(2 t)
BLOCK = """model Oscillator
  Block block(m = 1, base = world, along = {1, 0}, s(start = 1));
  Spring spring(k = 4, stretch = block.s);
  output Real square = if time > 1 and time < 2 then 1 else 0;
  annotation(experiment(StopTime = 20, Tolerance = 1e-11));
end Oscillator;
"""
# A step of force on a damped block: x = 1 - exp(-z w t) (cos(wd t) + z w/wd sin(wd t)), w = 2, z = 0.3
STEP = """model Step
  Block block(m = 1, base = world, along = {1, 0});
  SpringDamper damper(k = 4, c = 1.2, stretch = block.s);
  AppliedForce push(at = block.center, force = {4, 0});
  annotation(experiment(StopTime = 40, Tolerance = 1e-11));
end Step;
"""
# The history of ASTM E1049-85, figure 6.
HISTORY = """model History
  Block block(m = 1, base = world, along = {1, 0}, v(start = 1));
  output Real y = table(block.s/1[m], {0, 1, 2, 3, 4, 5, 6, 7, 8}, {-2, 1, -3, 5, -1, 3, -4, 4, -2});
  annotation(experiment(StopTime = 8, Tolerance = 1e-10));
end History;
"""
Scene = Callable[[str], lag.Model]
END = 20.0


def turning(a: float, b: float) -> list[float]:
    """cos(2 t) at the ends of a window, and where it turns inside."""
    turns = [math.pi / 2 * k for k in range(100) if a < math.pi / 2 * k < b]
    return [math.cos(2 * t) for t in (a, b, *turns)]


def above(level: float, a: float, b: float) -> list[tuple[float, float]]:
    """The times between a and b in which cos(2 t) > level."""
    half = math.acos(level) / 2
    spans = [(max(a, math.pi * k - half), min(b, math.pi * k + half)) for k in range(100)]
    return [span for span in spans if span[0] < span[1]]


@pytest.mark.parametrize(("measure", "expected"), [
    ("max(block.s, from=1, to=3)", max(turning(1, 3))),
    ("min(block.s, from=2, to=4)", min(turning(2, 4))),
    ("max(block.s, from=1[s], to=1200[ms])", max(turning(1, 1.2))),
    ("range(block.s, to=1.25)", np.ptp(turning(0, 1.25))),
    ("time_of_max(block.s, from=2, to=5)", math.pi),
    ("max(abs(block.s), from=1, to=1.2)", -math.cos(2.4)),
    ("mean(block.s, from=0.3, to=2)", (math.sin(4) - math.sin(0.6)) / 2 / 1.7),
    ("integral(block.s, from=0.3, to=2)", (math.sin(4) - math.sin(0.6)) / 2),
    ("integral(block.s)", math.sin(40) / 2),
    ("integral(abs(block.s), to=2)", 1 - math.sin(4) / 2),
    ("rms(block.s, from=1, to=2)", math.sqrt(0.5 + (math.sin(8) - math.sin(4)) / 8)),
    ("first_time(block.s > 0.5, from=2)", math.pi - math.acos(0.5) / 2),
    ("last_time(block.s > 0.5, to=3.5)", 3.5),
    ("last_time(block.s > 0.5, to=5)", math.pi + math.acos(0.5) / 2),
    ("first_time(block.s > 0.5, from=1, to=2)", math.nan),
    ("count(block.s > 0.5)", len(above(0.5, 0, END))),
    ("count(block.s > 0.5, from=0.1, to=3.3)", 2),
    ("count(block.s > 0.5, from=1, to=2)", 0),
    ("count(block.s > 2)", 0),
    ("count(abs(block.s) > 0.5, to=2)", 2),
    ("duration(block.s > 0.5)", sum(b - a for a, b in above(0.5, 0, END))),
    ("duration(block.s > 0.5, from=3, to=11)", sum(b - a for a, b in above(0.5, 3, 11))),
    ("duration(abs(block.s) < 0.5, to=3.141592653589793)", math.pi - 4 * math.acos(0.5) / 2),
    ("duration(square > 0.5)", 1),
    ("duration(square < 0.5, from=1.5)", 18),
    ("count(square > 0.5)", 1),
    ("period(block.s)", math.pi),
    ("period(block.s < 0.3, from=1)", math.pi),
    ("period(block.s, to=4)", math.nan),
    ("damage(block.s, 3, to=6.283185307179586)", 2 * 2**3),
    ("damage(block.s, 3, 2[m])", 6 + 0.5 * ((1 - math.cos(40)) / 2) ** 3),
])
def test_windows_levels_and_cycles(scene: Scene, measure: str, expected: float) -> None:
    found = scene(BLOCK).measure(measure)
    assert found == {measure: pytest.approx(expected, abs=2e-8, nan_ok=True)}


def test_a_step_settles(scene: Scene) -> None:
    w, z = 2.0, 0.3
    wd = w * math.sqrt(1 - z * z)

    def x(t: float) -> float:
        return 1 - math.exp(-z * w * t) * (math.cos(wd * t) + z * w / wd * math.sin(wd * t))

    found = scene(STEP).measure(["settling_time(block.s, 0.02)", "settling_time(block.s, 0.05)", "settling_time(block.s)",
                                 "settling_time(block.s, 0.02, from=1)", "overshoot(block.s)", "settling_time(block.s, 3)"])
    times = np.linspace(0, 40, 400_001)
    values = np.array([x(t) for t in times])

    def settled(band: float) -> float:
        k = int(np.flatnonzero(abs(values - 1) > band)[-1])
        return float(brentq(lambda t: abs(x(t) - 1) - band, times[k], times[k + 1]))

    assert found["settling_time(block.s, 0.02)"] == pytest.approx(settled(0.02), abs=1e-8)
    assert found["settling_time(block.s)"] == found["settling_time(block.s, 0.02)"]
    assert found["settling_time(block.s, 0.05)"] == pytest.approx(settled(0.05), abs=1e-8)
    band = 0.02 * abs(1 - x(1))
    assert found["settling_time(block.s, 0.02, from=1)"] == pytest.approx(settled(band) - 1, abs=1e-7)
    assert found["settling_time(block.s, 3)"] == 0
    assert found["overshoot(block.s)"] == pytest.approx(math.exp(-math.pi * z / math.sqrt(1 - z * z)), abs=1e-9)


def test_the_cycles_of_the_standard(scene: Scene) -> None:
    """ASTM E1049-85 (2011), X1.1: ranges 3, 4, 6, 8, 9 with 0.5, 1.5, 0.5, 1, 0.5 cycles."""
    model = scene(HISTORY)
    cycles = model.rainflow("y")
    counted: dict[float, float] = {}
    for size, _, count in cycles:
        counted[round(size, 6)] = counted.get(round(size, 6), 0) + count
    assert counted == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}
    assert cycles[2].tolist() == pytest.approx([4, 1, 1], abs=1e-6)
    found = model.measure("damage(y, 5), damage(y, 5, 2)")
    expected = sum(count * size**5 for size, count in counted.items())
    assert found["damage(y, 5)"] == pytest.approx(expected, rel=1e-6)
    assert found["damage(y, 5, 2)"] == pytest.approx(expected / 32, rel=1e-6)


def line(f: float, a: float, b: float) -> float:
    """The amplitude of cos(2 t) at f by Hann's window from a to b, in closed form."""
    length, f0, middle = b - a, 1 / math.pi, np.exp(2j * (a + b) / 2)

    def hann(nu: float) -> float:  # its transform about the middle, over its integral
        x = nu * length
        return float(np.sinc(x) / (1 - x * x))

    mean = (middle * hann(f0)).real
    return float(abs(middle * hann(f - f0) + np.conj(middle) * hann(f + f0) - 2 * mean * hann(f)))


@pytest.mark.parametrize(("a", "b"), [(0.0, END), (1.0, 7.3), (0.37, 19.1)])
def test_the_peak_of_a_spectrum(scene: Scene, a: float, b: float) -> None:
    """Between the lines of a transform, of many periods and of two; of a rest there is none."""
    window = f"from={a}, to={b}"
    model = scene(BLOCK.replace("output", "output Real still = 3; output", 1))
    asked = [f"{kind}({name}, {window})" for name in ("block.s", "still") for kind in ("peak_frequency", "peak_amplitude")]
    found = model.measure(asked)
    frequency, amplitude, none, nothing = (found[text] for text in asked)
    best = minimize_scalar(lambda f: -line(f, a, b), bounds=(0.9 / math.pi, 1.1 / math.pi), method="bounded",
                           options={"xatol": 1e-12})
    assert frequency == pytest.approx(best.x, abs=3e-8), "as well as values tell a maximum"
    assert amplitude == pytest.approx(line(frequency, a, b), abs=1e-9)
    assert amplitude == pytest.approx(-best.fun, abs=1e-9)
    assert math.isnan(none) and nothing == 0
    sweep = model.simulate_many(parameters={"spring.k": [4, 16]}, outputs=asked[:2])
    assert (sweep[asked[0]][0], sweep[asked[1]][0]) == (frequency, amplitude)
    assert sweep[asked[0]][1] == pytest.approx(2 * frequency, rel=0.02)
    assert list(sweep.units()) == ["N/m", "Hz", "m"]


def test_many_runs_are_measured_as_one_is(scene: Scene) -> None:
    """Reductions that take a second run leave the others, and the run after, as they were."""
    model = scene(STEP)
    texts = ["max(block.s)", "settling_time(block.s)", "final(block.s)", "damage(block.s, 3)", "duration(block.s > 1)",
             "period(block.s)"]
    c = [0.5, 1.2, 3.0]
    sweep = model.simulate_many(parameters={"damper.c": c}, outputs=texts)
    for k, value in enumerate(c):
        alone = model.measure(texts, parameters={"damper.c": value})
        np.testing.assert_array_equal([sweep[text][k] for text in texts], [alone[text] for text in texts])


@pytest.mark.parametrize(("measure", "said"), [
    ("max(block.s, from=3, to=2)", "the window is empty"), ("max(block.s, from=30)", "must lie between 0 and 20"),
    ("max(block.s, since=3)", "there is no option 'since'"), ("max(block.s, from=1, from=2)", "'from' is given twice"),
    ("final(block.s, from=3)", "of one time"), ("max(block.s, 3)", "'3' has no meaning there"),
    ("count(block.s)", "needs a condition"),
    ("settling_time(block.s, -1)", "a positive number is needed"), ("damage(block.s)", "slope"),
    ("rainflow(block.s)", "is a table"),
    ("settling_time(abs(block.s))", "not supported yet"),
    ("peak_frequency(abs(block.s))", "not supported yet"), ("peak_amplitude(block.s, 3)", "'3' has no meaning there"),
    ("maximum(block.s)", "there is no measure 'maximum'"),
    ("", "no measure is asked"), ("max()", "not the name of a quantity"), ("max(block.s, from=1[m])", "but s is wanted"),
])
def test_what_is_no_measure_is_told(scene: Scene, measure: str, said: str) -> None:
    with pytest.raises(LagError, match=said):
        scene(BLOCK).measure(measure)


def test_names_of_any_signs_are_measured(scene: Callable[[str], lag.Model]) -> None:
    """Quoted names hold what else would be commas, spaces and calls; a sweep measures all outputs by itself."""
    model = scene("""model N parameter Length 'a b' = 1; output Length 'x y' = b.s, 'f(x)' = 2*b.s, 'a, b' = 3*b.s, '<x>' = 4*b.s;
        Block b(m = 1, base = world, s(start = 'a b')); end N;""")
    found = model.simulate_many(parameters={"'a b'": [1, 2]}, stop=0.01)
    names = ("'x y'", "'f(x)'", "'a, b'", "'<x>'")
    assert [found[f"final({name})"].tolist() for name in names] == [[k, 2 * k] for k in (1, 2, 3, 4)]
    found = model.simulate_many(outputs=",".join([*(f"max(abs({name}))" for name in names), "at(0, 'a, b')", "'a, b'"]),
                                stop=0.01)
    assert [float(found[measure.text][0]) for measure in found.job.measures] == [1, 2, 3, 4, 3, 3]
