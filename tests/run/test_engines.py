"""Tapes, native code, and the change from one to the other in a run."""

import itertools
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.model import Model
from lagrangia.native.build import find_compiler
from lagrangia.run import engines, prepared, stepped
from lagrangia.run.library import start_runtime
from lagrangia.run.simulate import Experiment, _Looks

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
CHAIN, PENDULUM, ISLANDS = (EXAMPLES / f"{name}.lag" for name in ("chain", "double_pendulum", "free_bar"))
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path))
    return tmp_path


def chain(native: bool | None = None, n: int = 12) -> Model:
    model = lag.load(CHAIN, n=n)
    model.native = native
    return model


def how(model: Model) -> str:
    assert model.engine is not None
    return model.engine.how


def test_tape_and_native_code_give_the_same_digits() -> None:
    runs = [chain(native).simulate(stop=0.3, tolerance=1e-10) for native in (False, True)]
    for name in ("hinge[1].phi", "hinge[12].phi"):
        assert np.array_equal(runs[0][name], runs[1][name])


@pytest.mark.parametrize("n", [2, 300])
def test_every_scene_starts_on_its_tape_and_compiles_nothing_for_a_short_run(n: int, empty_cache: Path) -> None:
    model = chain(n=n)
    model.simulate(stop=1e-3)
    assert how(model) == "tape"
    assert "pays from" in engines.describe(model.scene)
    assert {path.name for path in empty_cache.iterdir()} == {"scenes", ".pruned"}, "not even whether a compiler works is tried"


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiling costs nothing, so that it pays at once."""
    for name in ("_LOOK", "_START", "_COMPILE", "_SERIES", "_SEEK"):
        monkeypatch.setattr(engines, name, 0.0)


@needs_compiler
@pytest.mark.parametrize("solver", ["auto", "taylor"])
def test_a_run_changes_over_when_it_pays(solver: str, empty_cache: Path, eager: None) -> None:
    model, other = (lag.load(PENDULUM) for _ in range(2))

    def run() -> lag.Trajectory:
        return model.simulate(stop=3, tolerance=1e-10, solver=solver)

    assert how(model) == "tape"
    found = wanted = run()
    limit = time.monotonic() + 60  # the compiler needs its time, on a busy machine more than 400 runs take
    while how(model) == "tape" and time.monotonic() < limit:
        found = run()
    assert how(model) == "tape, then native"
    after = run()
    for again in (found, after):
        assert np.array_equal(again.rows, wanted.rows)
    other.simulate(stop=3)
    assert how(other) == "native", "the library is in the cache"


@needs_compiler
def test_islands_change_over_together(empty_cache: Path, eager: None) -> None:
    model = lag.load(ISLANDS)
    assert model.scene.islands
    wanted = model.simulate(stop=1, solver="islands")
    limit = time.monotonic() + 60
    while how(model) == "tape" and time.monotonic() < limit:
        model.simulate(stop=1, solver="islands")
    assert model.engine is not None
    assert model.engine.how == "tape, then native"
    assert len(list(empty_cache.glob("scene-*"))) >= 2
    assert np.array_equal(model.simulate(stop=1, solver="islands").rows, wanted.rows)


def test_what_a_change_costs_is_counted_over_all_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many short runs make compiling pay as one long one does."""
    scene, begun = chain(n=12).scene, []
    monkeypatch.setattr(engines.Upgrade, "_make", lambda self: begun.append(self.spent))
    monkeypatch.setattr(engines.Upgrade, "_seek", lambda self: None)
    upgrade = engines.Upgrade(start_runtime(), [(scene, None)])  # type: ignore[list-item]
    runs = 0
    while not begun and runs < 1000:
        assert not upgrade.look(0.01, 0.0)
        runs += 1
    assert upgrade.spent == pytest.approx(0.01 * runs)
    assert upgrade.compiling < upgrade.spent < upgrade.compiling + 0.02


def test_what_many_runs_ask_for_at_their_start_is_compiled_where_it_is_short() -> None:
    loop, large = (lag.load(EXAMPLES / f"{name}.lag").scene for name in ("four_bar", "hexapod"))
    at_start = {"initial", "momentum", "parameters", "hoist", "start", "requirements"}
    assert at_start & set(loop.tapes) <= set(engines._often(loop))
    assert at_start & set(engines._often(large)) == {"momentum", "start", "requirements"}


def test_a_build_that_is_given_up_leaves_nothing(empty_cache: Path) -> None:
    from lagrangia.native.build import start_build

    compiler = find_compiler()
    assert compiler is not None
    build = start_build("slow", "int lag_x;" + "".join(f"double f{k}(double x) {{ return x*{k}; }}\n" for k in range(20_000)),
                        compiler=compiler)
    build.cancel()
    assert not [path for path in empty_cache.iterdir() if "slow" in path.name]


def test_what_others_have_the_processor_for_is_not_counted_as_a_run() -> None:
    """A run of a millisecond that waited for its turn was compiled."""
    told: list[float] = []
    engine = SimpleNamespace(upgrade=None, how="tape", look=lambda spent, left: told.append(spent))
    looks = _Looks(engine, SimpleNamespace(experiment=Experiment(0.0, 1.0, 1e-8, 0.1), time=0.5))  # type: ignore[arg-type]
    looks.pause()
    time.sleep(0.3)
    looks.look()
    assert told[0] < 0.1


@pytest.mark.parametrize("module", [prepared, stepped])
def test_nor_is_it_of_prepared_runs_and_steps(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a machine where each look at the clock is a second later than the last one."""
    waits, told = itertools.count(), []
    monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: float(next(waits)), thread_time=time.thread_time))
    model = chain()
    rolled = model.start(tolerance=1e-4) if module is stepped else None
    run = model.prepare(stop=0.01, tolerance=1e-4) if rolled is None else None
    assert model.engine is not None
    model.engine.upgrade = SimpleNamespace(look=lambda spent, left: told.append(spent))  # type: ignore[assignment]
    for _ in range(2):
        run() if run is not None else rolled.steps(3, 0.001)
    assert len(told) == 2 and all(0 <= spent < 0.5 for spent in told)
