"""What every phase makes of three scenes, as --dump prints it: tests/golden/SCENE/PHASE.txt; `pytest --update` writes them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import lagrangia as lag
from conftest import Compare
from lagrangia.compile.dumps import dump
from lagrangia.compile.pipeline import PHASES

HERE = Path(__file__).resolve().parents[1]
EXAMPLES = HERE.parent / "models" / "examples"
GOLDEN = HERE / "golden"
SCENES = {"suspended_bar": {}, "disc_and_block": {}, "chain": {"n": 3}}


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> tuple[str, lag.Model]:
    return request.param, lag.load(EXAMPLES / f"{request.param}.lag", **SCENES[request.param])


@pytest.mark.parametrize("phase", PHASES)
def test_each_phase_is_as_it_was(scene: tuple[str, lag.Model], phase: str, compare: Compare) -> None:
    name, model = scene
    compare(dump(model.compilation, phase) + "\n", GOLDEN / name / f"{phase}.txt")


def test_no_golden_file_is_left_over() -> None:
    found = {path.relative_to(GOLDEN) for path in GOLDEN.rglob("*.txt") if "equations" not in path.parts}  # of tests/paper
    assert found == {Path(s, f"{p}.txt") for s in SCENES for p in PHASES}


def printed(scene: str, phase: str, seed: str, folder: Path) -> bytes:
    """The dump of a process of its own, with an empty cache."""
    command = [sys.executable, "-m", "lagrangia.command.cli", "simulate", str(EXAMPLES / f"{scene}.lag"), "--dump", phase]
    environment = os.environ | {"PYTHONHASHSEED": seed, "LAGRANGIA_CACHE": str(folder / seed)}
    return subprocess.run(command, env=environment, capture_output=True, check=True).stdout


@pytest.mark.parametrize("scene", ["quarter_car", "chain"])
def test_equal_input_gives_byte_identical_c(scene: str, tmp_path: Path) -> None:
    first, second = (printed(scene, "c", seed, tmp_path) for seed in ("1", "2"))
    assert len(first) > 1000
    assert first == second
