"""Random runs: statistics with standard errors, an end once these are small, Sobol' indices, pictures."""

import itertools
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.stats

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.command.cli import main
from lagrangia.native.build import find_compiler
from lagrangia.study.sweep.journal import Journal
from lagrangia.study.sweep.statistics import mean, quantile, statistics_of
from lagrangia.study.sweep.until import looks

remove = Journal.remove
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
# T. Ishigami, T. Homma (1990): sin x + 7 sin^2 y + 0.1 z^4 sin x, of three angles that are uniform.
ISHIGAMI = """model Ishigami
  parameter Real x = 0, y = 0, z = 0;
  Block block(m = 1, base = world, s(start = 1)); Spring spring(k = 1, stretch = block.s);
  output Real f = sin(x) + 7*sin(y)^2 + 0.1*z^4*sin(x);
  annotation(experiment(StopTime = 0.1));
end Ishigami;
"""
OSCILLATOR = """model Oscillator
  parameter Stiffness k = 8;
  Block block(m = 2, base = world, s(start = 0.5)); Spring spring(k = k, stretch = block.s);
  annotation(experiment(StopTime = 1));
end Oscillator;
"""
Scene = Callable[[str], lag.Model]
UNIFORM = dict.fromkeys("xyz", f"uniform({-math.pi!r}, {math.pi!r})")


def test_indices_of_a_function_whose_indices_are_known(scene: Scene) -> None:
    found = scene(ISHIGAMI).simulate_many(parameters=UNIFORM, outputs="f", samples=1024, sampling="saltelli", seed=3)
    assert found.runs == 5 * 1024
    a, b = 7.0, 0.1
    parts = [0.5 * (1 + b * math.pi**4 / 5) ** 2, a**2 / 8, 0.0]
    together = b**2 * math.pi**8 * 8 / 225
    whole = sum(parts) + together
    indices = found.sensitivity()["final(f)"]
    for index, part, more in zip(indices.values(), parts, (together, 0.0, together), strict=True):
        for estimate, value in ((index.first, part / whole), (index.total, (part + more) / whole)):
            assert abs(estimate.value - value) < max(0.005, 4 * estimate.error)
            assert estimate.error < 0.06


def test_statistics_have_the_errors_that_repetitions_show() -> None:
    """2 000 repetitions of 400 exponential numbers; SciPy's estimates, and its quantile errors by Maritz and Jarrett."""
    drawn = np.random.Generator(np.random.PCG64(1)).exponential(size=(2000, 400))
    found = [statistics_of(x, (0.1, 0.9)) for x in drawn]
    one = found[0]
    assert one.mean.value == pytest.approx(drawn[0].mean(), rel=1e-14)
    assert one.mean.error == pytest.approx(scipy.stats.sem(drawn[0]), rel=1e-12)
    assert one.deviation.value == pytest.approx(drawn[0].std(ddof=1), rel=1e-14)
    for what in (lambda s: s.mean, lambda s: s.deviation, lambda s: s.quantiles[0.1], lambda s: s.quantiles[0.9]):
        scatter = np.std([what(s).value for s in found])
        assert np.mean([what(s).error for s in found]) == pytest.approx(scatter, rel=0.08)
    assert one.quantiles[0.9].error == pytest.approx(float(scipy.stats.mstats.mjci(drawn[0], [0.9])[0]), rel=0.3)


def test_too_few_numbers_have_no_error() -> None:
    few = statistics_of(np.array([1.0, math.nan, 3.0]))
    assert (few.count, few.missing, few.mean.value, few.least, few.most) == (2, 1, 2.0, 1.0, 3.0)
    assert quantile(np.arange(5.0), 0.95).error == mean(np.array([1.0])).error == math.inf
    assert math.isnan(statistics_of(np.array([math.nan])).mean.value)
    with pytest.raises(LagError, match="between 0 and 1"):
        statistics_of(np.arange(3.0), (95,))


def test_it_ends_after_the_same_runs_however_it_is_computed(scene: Scene, tmp_path: Path) -> None:
    asked = {"parameters": {"k": "normal(8, 0.5)"}, "samples": 100_000, "outputs": "max(block.s, from=0.5), block.s"}
    model = scene(OSCILLATOR)
    whole = model.simulate_many(**(asked | {"samples": 3000}))
    one, two = (model.simulate_many(**asked, until="se(mean(block.s)) < 1[mm]", jobs=jobs) for jobs in (1, 2))
    kept = model.simulate_many(**asked, until="se(mean(final(block.s))) < 1e-3", path=tmp_path / "x.csv")
    assert one.runs == two.runs == kept.runs < 3000
    assert one.ok.all() and not (tmp_path / "x.csv.part").exists()
    for found in (two, kept):
        assert np.array_equal(found["block.s"], one["block.s"])
    assert np.array_equal(whole["block.s"][: one.runs], one["block.s"])
    assert len((tmp_path / "x.csv").read_text().splitlines()) == 1 + one.runs
    before = max(n for n in looks(100_000) if n < one.runs)
    assert scipy.stats.sem(one["block.s"]) < 1e-3 < scipy.stats.sem(one["block.s"][:before])


@pytest.mark.parametrize("until", ["se(mean(block.s)) < 2[mm]", "se(quantile(max(block.s, from=0.5), 0.9)) < 2[mm]"])
def test_it_ends_after_the_same_runs_wherever_it_was_killed(until: str, scene: Scene, tmp_path: Path,
                                                            monkeypatch: pytest.MonkeyPatch) -> None:
    """A journal as a kill leaves it, cut anywhere, within an entry too: the same command makes the same table, byte by byte."""
    path, journals = tmp_path / "x.csv", []
    monkeypatch.setattr(Journal, "remove", lambda self: (journals.append(self.path.read_bytes()), remove(self)))
    asked = {"parameters": {"k": "normal(8, 0.5)"}, "samples": 10_000, "until": until, "path": path,
             "outputs": "max(block.s, from=0.5), block.s"}
    model = scene(OSCILLATOR)
    whole = model.simulate_many(**asked, jobs=1)
    table, journal = path.read_bytes(), journals[0]
    assert 200 < whole.runs < 10_000
    for jobs, kept in enumerate((0.01, 0.3, 0.7, 0.999, 1.0), 1):
        path.unlink()
        path.with_name("x.csv.part").write_bytes(journal[: int(kept * len(journal))])
        assert model.simulate_many(**asked, jobs=1 + jobs % 3).runs == whole.runs
        assert path.read_bytes() == table


@pytest.mark.parametrize("until", ["se(quantile(max(block.s, from=0.5), 0.9)) < 2[mm]", "se(deviation(block.s)) < 0.001"])
def test_other_ends(until: str, scene: Scene) -> None:
    found = scene(OSCILLATOR).simulate_many(parameters={"k": "normal(8, 0.5)"}, samples=100_000, until=until,
                                            outputs="max(block.s, from=0.5), block.s")
    assert 100 < found.runs < 10_000


@pytest.mark.parametrize(("until", "more", "told"), [
    ("mean(block.s) < 1", {}, "no condition on a standard error"),
    ("se(mean(block.v)) < 1", {}, "is not measured"),
    ("se(mean(block.s)) < 0", {}, "must be positive"),
    ("se(mean(block.s)) < 1[kg]", {}, "kg"),
    ("se(quantile(block.s)) < 1", {}, "the share of runs"),
    ("se(quantile(block.s, 90)) < 1", {}, "between 0 and 1"),
    ("se(mean(block.s)) < 1", {"sampling": "lhs"}, "random runs"),
    ("se(mean(block.s)) < 1", {"initial": {"block.s": [1, 2]}}, "random runs"),
    ("se(mean(block.s)) < 1", {"keep": True}, "not supported yet"),
    (None, {"sampling": "saltelli"}, "power of 2"),
    (None, {"sampling": "saltelli", "samples": 8}, "all of the variance"),
])
def test_wrong_conditions_are_told(until: str | None, more: dict[str, object], told: str, scene: Scene) -> None:
    with pytest.raises(LagError, match=told):
        scene(OSCILLATOR).simulate_many(**({"parameters": {"k": "normal(8, 0.5)"}, "samples": 1000, "outputs": "block.s",
                                            "until": until} | more))


def test_indices_need_their_own_runs_and_a_variance(scene: Scene) -> None:
    model = scene(OSCILLATOR)
    with pytest.raises(LagError, match="runs of their own"):
        model.simulate_many(parameters={"k": "normal(8, 0.5)"}, samples=8).sensitivity()
    same = model.simulate_many(parameters={"k": "normal(8, 0.5)"}, initial={"der(block.s)": "uniform(0, 1)"}, samples=8,
                               sampling="saltelli", outputs="initial(block.s)")
    with pytest.raises(LagError, match="no variance"):
        same.sensitivity()


@pytest.mark.parametrize(("given", "panels"), [
    ({"parameters": UNIFORM, "samples": 50}, 4 + 2),  # a column a value, the histogram; parallel coordinates and their bar
    ({"parameters": UNIFORM, "samples": 16, "sampling": "saltelli"}, 5 + 2),
    ({"parameters": {"x": "linspace(0, 1, 5)"}}, 1), ({}, 1)])
def test_pictures_have_a_panel_for_each_pair(given: dict[str, object], panels: int, scene: Scene, tmp_path: Path) -> None:
    figure = scene(ISHIGAMI).simulate_many(**given, outputs="f").plot(tmp_path / "x.svg")
    assert len(figure.axes) == panels
    assert (tmp_path / "x.svg").read_text().count("<svg") == 1
    counts = [axes for axes in figure.axes if axes.get_xlabel() in ("runs", "run")]  # ticks stood at 2.5 of them
    assert bool(counts) == ("x" not in given.get("parameters", {}) or "samples" in given)
    assert all(tick == round(tick) for axes in counts for tick in axes.get_xticks())


def test_sobol_indices_are_bars(scene: Scene) -> None:
    sweep = scene(ISHIGAMI).simulate_many(parameters=UNIFORM, samples=64, sampling="saltelli", outputs="f")
    axes = next(axes for axes in sweep.plot().axes if axes.get_xlabel() == "Sobol' indices")
    (found,) = sweep.sensitivity().values()
    assert [label.get_text() for label in axes.get_yticklabels()] == [*found]
    assert [bar.get_width() for bar in axes.patches] == [getattr(index, which).value for which in ("first", "total")
                                                         for index in found.values()]
    failing = scene(ISHIGAMI).simulate_many(parameters=UNIFORM, samples=4, sampling="saltelli", outputs="f", max_steps=1,
                                            solver="erk").plot()
    assert all([text.get_text() for text in axes.texts] == ["no run has a value"] for axes in failing.axes[:5])


def test_of_very_many_runs_some_are_dots(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """All of a million took 320 MB; the ends of what is found are among those that are drawn."""
    monkeypatch.setattr("lagrangia.study.sweep.pictures._MOST_DOTS", 20)
    sweep = scene(ISHIGAMI).simulate_many(parameters=UNIFORM, samples=100, outputs="f")
    figure = sweep.plot()
    dots = figure.axes[0].collections[0].get_offsets()
    assert 20 <= len(dots) <= 24 and dots[:, 1].min() == sweep["f"].min() and dots[:, 1].max() == sweep["f"].max()
    assert "100 runs (dots of 20)" in figure.get_suptitle()


def test_numbers_of_very_many_runs_stand_apart(scene: Scene, tmp_path: Path) -> None:
    """Those below a histogram of a million ran into each other."""
    sweep = scene(ISHIGAMI).simulate_many(parameters=UNIFORM, samples=20, outputs="f")
    axes = next(axes for axes in sweep.plot(tmp_path / "x.svg").axes if axes.get_xlabel() == "runs")
    axes.set_xlim(0, 160_000)
    axes.figure.canvas.draw()
    boxes = [label.get_window_extent() for label in axes.get_xticklabels() if 0 <= label.get_position()[0] <= 160_000]
    assert len(boxes) > 2 and all(one.x1 < other.x0 for one, other in itertools.pairwise(boxes))


def test_the_command_tells_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.lag").write_text(OSCILLATOR)
    command = ["sweep", "scene.lag", "-p", "k=normal(8,0.5)", "--outputs", "block.s"]
    assert main([*command, "--samples", "9999", "--until", "se(mean(block.s)) < 1[cm]", "--plot", "x.png"]) == 0
    told = capsys.readouterr().out
    assert "ended after 100 runs" in told and "mean -0" in told.replace("mean 0", "mean -0") and "95 % below" in told
    assert Path("x.png").stat().st_size > 1000
    assert main([*command, "--samples", "101", "--until", "se(mean(block.s)) < 1e-9", "-o", "y.csv"]) == 0
    assert "not reached in 101 runs" in capsys.readouterr().out
    never = [*command[:4], "--outputs", "first_time(block.s > 99)", "--samples", "100", "-o", "w.csv"]
    assert main([*never, "--until", "se(mean(first_time(block.s > 99))) < 1"]) == 0
    assert "< 1; too few runs have a value" in capsys.readouterr().out
    shared = [*command, "--initial", "der(block.s)=normal(0,1e-9)", "--samples", "64", "--sampling", "saltelli", "-o", "z.csv"]
    assert main(shared) == 0
    assert "Sobol' indices: k 1.0" in capsys.readouterr().out
    assert main([*command, "--plot", "x.doc"]) == 2
    assert main([*command, "--samples", "9", "--plot", "scene.lag"]) == 2


def test_no_results_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.lag").write_text(OSCILLATOR)
    command = ["sweep", "scene.lag", "-p", "k=normal(8,0.5)", "--outputs", "max(block.s)", "--plot", "x.svg"]
    assert main([*command, "--samples", "1", "-o", "one.csv"]) == 0
    told = capsys.readouterr().out
    assert "mean 0.5" in told and "nan" not in told  # 'deviation nan' of one run
    assert main([*command, "--samples", "3", "--max-steps", "1", "--solver", "erk", "-o", "none.csv"]) == 1
    told = capsys.readouterr().out
    assert "max(block.s): none" in told and "nan" not in told and "accounts" not in told


def test_a_picture_of_nothing_says_so(scene: Scene) -> None:
    figure = scene(ISHIGAMI).simulate_many(parameters=UNIFORM, samples=3, outputs="f", max_steps=1, solver="erk").plot()
    assert len(figure.axes) == 3 + 1 + 1
    assert "3 runs, 3 without results" in figure.get_suptitle()
    assert all(axes.texts[0].get_text() == "no run has a value" and not len(axes.get_xticks()) for axes in figure.axes)


@pytest.mark.parametrize("size", [1e-30, 3.6, 1e20])
def test_a_picture_of_values_that_differ_by_rounding_has_axes(scene: Scene, size: float) -> None:
    """Bars of 1e-17 cannot be told apart: numpy refused to make them."""
    text = f"""model Same "ends where it began, but for rounding"
      Block block(m = 1, base = world, s(start = {size}));
      output Real last = {size}*(1 + 3e-16*sin(1e3*block.m/1[kg]));
    end Same;"""
    figure = scene(text).simulate_many(parameters={"block.m": "uniform(1, 2)"}, samples=50, outputs="last", stop=0.1).plot()
    assert all(np.diff(panel.get_ylim()) == pytest.approx(0.1 * size) for panel in figure.axes)
