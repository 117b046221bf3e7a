"""Native code, tapes, and the change from one to the other in a run."""

import time
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.model import Model
from lagrangia.run import engines, rules

CHAIN = Path(__file__).parents[2] / "models" / "examples" / "chain.lag"


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """With the run time in it, but no scene."""
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


def test_a_small_scene_is_compiled_at_once() -> None:
    assert how(chain(n=2)) == "native"


def test_a_large_scene_starts_on_its_tape() -> None:
    model = chain(n=300)
    assert how(model) == "tape"
    assert "pays from" in engines.describe(model.scene)


def test_a_run_changes_over_when_it_pays(empty_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rules, "_AT_ONCE", -1.0)
    monkeypatch.setattr(engines, "_LOOK", 0.0)
    monkeypatch.setattr(engines, "_START", 0.0)
    monkeypatch.setattr(engines, "_COMPILE", 0.0)
    model = chain()
    assert how(model) == "tape"
    run = wanted = model.simulate(stop=0.3, tolerance=1e-10)
    limit = time.monotonic() + 60  # the compiler needs its time, on a busy machine more than 400 runs take
    while how(model) == "tape" and time.monotonic() < limit:
        run = model.simulate(stop=0.3, tolerance=1e-10)
    assert how(model) == "tape, then native"
    after = model.simulate(stop=0.3, tolerance=1e-10)
    for found in (run, after):
        assert np.array_equal(found["hinge[12].phi"], wanted["hinge[12].phi"])
        assert np.array_equal(found.energy.total, wanted.energy.total)
    assert how(chain()) == "native", "the library is in the cache"


def test_a_short_run_compiles_nothing(empty_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rules, "_AT_ONCE", -1.0)
    model = chain()
    model.simulate(stop=0.01)
    assert how(model) == "tape"
    assert not list(empty_cache.glob("scene-*")) and not list(empty_cache.glob(".scene-*"))


def test_what_a_change_costs_is_counted_over_all_runs() -> None:
    """Many short runs make compiling pay as one long one does."""
    scene = chain(n=300).scene
    upgrade = engines.Upgrade(scene, None)  # type: ignore[arg-type]
    model = None
    for _ in range(3):
        for elapsed in (0.1, 0.15):
            assert not upgrade.look(model, elapsed, 0.5)  # type: ignore[arg-type]
    assert upgrade.spent == pytest.approx(2 * 0.15)


def test_a_build_that_is_given_up_leaves_nothing(empty_cache: Path) -> None:
    from lagrangia.native.build import find_compiler, start_build

    compiler = find_compiler()
    assert compiler is not None
    build = start_build("slow", "int lag_x;" + "".join(f"double f{k}(double x) {{ return x*{k}; }}\n" for k in range(20_000)),
                        compiler=compiler)
    build.cancel()
    assert not [path for path in empty_cache.iterdir() if "slow" in path.name]
