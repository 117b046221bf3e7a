"""Pictures of runs: numbers of spectra, sections and small motion, what stands beside, and what is refused."""

import shlex
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import WRONG, main
from lagrangia.run.scene import Column
from lagrangia.view.curves import draw
from lagrangia.view.sections import find_section
from lagrangia.view.spectra import find_spectrum

OSCILLATOR = """model Two "costs $5 and _more_ $"
  parameter Mass m = 2; parameter Stiffness k = 800, weak = 288;
  Block a(m = m, base = world, s(start = 0.03)), b(m = m, base = world, along = {0, 1}, s(start = 0.02));
  World world(gravity = {0, 0});
  Spring one(k = k, stretch = a.s), two(k = weak, stretch = b.s);
  annotation(experiment(StopTime = 10, Interval = 0.01));
end Two;
"""
DRIVEN = """model Driven
  parameter Mass m = 2; parameter Real w(unit = "rad/s") = 5;
  Block a(m = m, base = world, s(start = 0.1)); Spring one(k = 200, stretch = a.s); Damper d(c = 3, rate = der(a.s));
  AppliedForce f(at = a.center, force = {4*sin(w*time), 0});
  output Force pull = 200*a.s;
end Driven;
"""
REFUSED = {
    "--plot-quantities a.z": "L0701", "--plot-quantities a.s:": "L0706", "--plot-quantities a.s:b.s:a.s": "L0706",
    "--plot-quantities a.center.r:a.s": "vectors", "--spectrum nothing": "L0701", "--section a.q": "L0701",
    "--section a.s=3[kg]": "wanted", "--section a.s=": "a value is missing",
    "--section a.s --spectrum b.s": "one quantity against",
    "--section a.s --plot-quantities b.s": "one quantity against", "--overlay none.csv": "cannot be read",
    "--overlay other.csv": "nothing that the picture shows", "--overlay heavy.csv": "in kg", "--beside ,": "names nothing",
    "--beside a.q=3": "a.q", "--spectrum a.s --at 0,1,2,3,4,5,6,7,9": "equal distances",
    "--spectrum a.s --interval 5": "8 rows at least",
}


@pytest.fixture
def two(scene) -> lag.Model:
    return scene(OSCILLATOR)


def test_a_spectrum_has_its_peak_at_the_natural_frequency(two: lag.Model) -> None:
    """f = sqrt(k/m)/2 pi; the height is the amplitude, and no less than 0.85 of it between two frequencies."""
    run = two.simulate(tolerance=1e-10)
    for name, frequency, size in (("a.s", np.sqrt(400) / 2 / np.pi, 0.03), ("b.s", 12 / 2 / np.pi, 0.02)):
        found = find_spectrum(name, run.time, run[name])
        peak = int(np.argmax(found.amplitude))
        assert abs(found.frequencies[peak] - frequency) <= 0.5 * found.resolution
        assert 0.84 * size < found.amplitude[peak] <= size * 1.001


def test_a_vibration_on_a_frequency_of_the_spectrum_has_its_amplitude() -> None:
    """At the ends of the axis as well: a mean is taken away, what alternates from row to row is at half the rate."""
    t = np.arange(200) * 0.05
    found = find_spectrum("x", t, 7 + 3 * np.cos(2 * np.pi * 2 * t) + 0.5 * np.cos(np.pi * np.arange(200)))
    assert found.amplitude[20] == pytest.approx(3, rel=1e-12)
    assert found.frequencies[20] == pytest.approx(2)
    assert found.amplitude[-1] == pytest.approx(0.5, rel=1e-12)
    assert found.amplitude[0] < 1e-12


def test_a_section_finds_states_between_rows(two: lag.Model) -> None:
    """b rises through 10 mm where cos(12 t) = 1/2 and sin(12 t) < 0; a is then 0.03 cos(20 t)."""
    run = two.simulate(tolerance=1e-12)
    found = find_section(run.time, run["b.s"], 0.01, [run["a.s"], run["der(a.s)"]])
    expected = (2 * np.pi * np.arange(1, 20) - np.pi / 3) / 12
    expected = expected[expected < 10]
    assert not found.coarse
    np.testing.assert_allclose(found.times, expected, atol=2e-8)
    np.testing.assert_allclose(found.values[0], 0.03 * np.cos(20 * expected), atol=1e-7)
    np.testing.assert_allclose(found.values[1], -0.6 * np.sin(20 * expected), atol=2e-6)


def test_a_section_leaves_out_what_rows_do_not_tell() -> None:
    """At a jump."""
    t = np.linspace(0, 1, 21)
    found = find_section(t, t - 0.52, 0.0, [np.where(t < 0.51, 1.0, -1.0)])
    assert found.coarse == 1
    assert not len(found.times)


def test_small_motion_beside_a_linear_scene_is_the_run_itself(scene) -> None:
    """Driven and damped, outputs too."""
    run = scene(DRIVEN).simulate(stop=4, interval=0.02, tolerance=1e-10)
    figure = run.plot("a.s", "pull", "a.s:a.s'", linear=True)
    for axis in figure.axes:
        whole, small = axis.lines
        np.testing.assert_allclose(small.get_ydata(), whole.get_ydata(), atol=2e-4 * np.abs(whole.get_ydata()).max())
        assert small.get_linestyle() == "--"
    assert [axis.get_ylabel() for axis in figure.axes] == ["a.s [m]", "pull [N]", "der(a.s) [m/s]"]


def test_small_motion_of_a_pendulum_keeps_its_small_period(scene) -> None:
    model = scene("model P Revolute h(a = world, phi(start = 80[deg])); PointMass b(m = 1, center = shift(h.b, {0, -1})); end P;")
    figure = model.simulate(stop=3, interval=0.01).plot(linear=True)
    whole, small = figure.axes[0].lines
    np.testing.assert_allclose(small.get_ydata(), 80 * np.cos(np.sqrt(9.81) * small.get_xdata()), atol=1e-6)
    assert np.abs(whole.get_ydata() - small.get_ydata()).max() > 10


def test_runs_and_measurements_stand_beside(two: lag.Model, tmp_path: Path) -> None:
    (tmp_path / "measured.csv").write_text("time,a.s [mm],unknown\n0,30,1\n1,12,1\n2,-20,1\n")
    run, other = two.simulate(), two.simulate(parameters={"k": 200})
    figure = run.plot("a.s", overlay=[other, tmp_path / "measured.csv"], path=tmp_path / "x.svg")
    first, second, third = figure.axes[0].lines
    np.testing.assert_array_equal(second.get_ydata(), other["a.s"])
    np.testing.assert_allclose(third.get_ydata(), [0.03, 0.012, -0.02])
    assert (third.get_marker(), first.get_marker()) == ("o", "None")
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == ["this run", "run 2", "measured.csv"]


@pytest.mark.parametrize("ending", ["svg", "png", "pdf"])
def test_names_are_taken_literally(two: lag.Model, ending: str, tmp_path: Path) -> None:
    """A dollar begins no formula, nor does an underscore hide a name from the legend; numbers on a log axis stay numbers."""
    path = tmp_path / f"x.{ending}"
    two.simulate(stop=1).plot("a.s", "b.s", spectrum="a.s", path=path)
    starts = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}
    assert path.read_bytes().startswith(starts[ending])
    if ending == "svg":
        xml.parse(path)
        text = path.read_text()
        assert "costs $5 and _more_ $" in text
        assert "mathdefault" not in text.replace("<!-- $\\mathdefault", "")
    figure = draw("t", np.arange(3.0), [(Column("_$x$_1", "m", "", ""), np.arange(3.0)), (Column("y", "m", "", ""), np.ones(3))])
    assert [text.get_text().strip("\u200b") for text in figure.axes[0].get_legend().get_texts()] == ["_$x$_1", "y"]


def test_panels_over_time_share_their_axis(two: lag.Model) -> None:
    figure = two.simulate(stop=1).plot("a.s", "der(a.s)", "a.s:b.s", spectrum="b.s")
    time, rate, plane, spectrum = figure.axes
    assert time.get_shared_x_axes().joined(time, rate)
    assert not any(time.get_shared_x_axes().joined(time, other) for other in (plane, spectrum))
    assert [axis.get_xlabel() for axis in figure.axes] == ["", "time [s]", "a.s [m]", "frequency [Hz]"]


@pytest.mark.parametrize("options", REFUSED)
def test_wrong_options_are_told(options: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("c.lag").write_text(OSCILLATOR)
    Path("other.csv").write_text("time,force\n0,1\n1,2\n")
    Path("heavy.csv").write_text("time,a.s [kg]\n0,1\n1,2\n")
    assert main(["simulate", "c.lag", "--plot", "x.svg", *shlex.split(options)]) == WRONG
    told = capfd.readouterr().err
    assert told.startswith("error[L07")
    assert REFUSED[options] in told
    assert not Path("x.svg").exists()


def test_a_run_beside_is_drawn_from_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("c.lag").write_text(OSCILLATOR)
    assert main(shlex.split("simulate c.lag --plot x.svg --beside 'k=2[kN/m],a.s=10[mm]' --linear --quiet")) == 0
    assert "k=2[kN/m],a.s=10[mm]" in Path("x.svg").read_text()
    assert main(shlex.split("simulate c.lag --plot y.svg --section b.s=1[mm] --quiet")) == 0
    assert "where b.s rises through 0.001 m" in Path("y.svg").read_text()


def test_resonances_of_a_response_are_where_it_has_its_peaks(scene) -> None:
    """omega sqrt(1 - 2 zeta^2) of one mass; none where damping leaves no peak."""
    model = scene(DRIVEN)
    zeta = 3 / (2 * np.sqrt(2 * 200))
    response = model.response(outputs=["a.s"])
    (peak,) = response.resonances[0, 0]
    assert peak == pytest.approx(10 / 2 / np.pi * np.sqrt(1 - 2 * zeta**2), rel=1e-3)
    assert [text.get_text() for text in response.plot().axes[0].texts] == [f"{peak:.4g} Hz"]
    with pytest.raises(LagError):
        model.simulate(stop=1).plot("nothing")


def test_events_are_marked_where_time_runs(scene) -> None:
    """At impacts, in panels over time alone; none where nothing happens, and no bar of too many."""
    ball = lag.load(data_folder("models") / "examples" / "bouncing_ball.lag").simulate(stop=1)
    height = 1.3 - 0.8
    assert ball.events[0] == pytest.approx(np.sqrt(2 * height / 9.81), abs=1e-9)
    over_time, plane = ball.plot("y.s", "x.s:y.s").axes
    (marks,) = over_time.collections
    assert np.allclose([segment[0][0] for segment in marks.get_segments()], ball.events) and not plane.collections
    quiet = scene(OSCILLATOR).simulate(stop=1)
    assert quiet.events.size == 0 and not quiet.plot().axes[0].collections
    many = scene('model M input Force u; Block b(m = 1, base = world); AppliedForce f(at = b.center, force = {u, 0}); end M;')
    times = np.linspace(0, 1, 602)
    run = many.simulate(stop=1, inputs=(times, {"u": times % 0.01}))
    with pytest.warns(UserWarning, match="events are not marked"):
        assert not run.plot().axes[0].collections


def test_energies_are_quantities_of_runs_and_curves() -> None:
    """As sweeps measure them."""
    model = lag.loads("model A Block b(m = 2, base = world, along = {1, 0}, s(start = 0.1)); Spring s(k = 8, stretch = b.s);"
                      " annotation(experiment(StopTime = 1)); end A;")
    run = model.simulate(at=[0.0, 0.25, 0.5])
    assert np.abs(np.array(run["energy.kinetic"]) - 0.04 * np.sin(2 * run.time) ** 2).max() < 1e-9
    assert np.abs(np.array(run["energy.total"]) - 0.04).max() < 1e-9
    assert run.plot("energy.kinetic", "energy.potential") is not None
    assert "energy.kinetic" in run.animate(quantities=["energy.kinetic"])


@pytest.mark.parametrize("asked", ["--plot-quantities tip.S.s[1]", "--plot-quantities tip.S[1]:tip.S.s[2]",
                                   "--spectrum tip.S.s[1]", "--section tip.S.s[1]"])
def test_small_turns_are_no_picture(asked: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They are counted from where each step began: the picture had been empty."""
    file = tmp_path / "top.lag"
    file.write_text("model Top World world(gravity = {0, 0, -9.81}); Spherical tip(a = world, w(start = {0, 0.3, 1})); "
                    "Body b(m = 1, I = {0.1, 0.1, 0.2}, center = shift(tip.b, {0, 0, 0.3})); end Top;")
    plot = tmp_path / "top.svg"
    assert main(["simulate", str(file), "--plot", str(plot), *asked.split()]) == WRONG
    assert "counted from where each step began" in capsys.readouterr().err and not plot.exists()
