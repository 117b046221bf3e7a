"""The examples in Python are run as a reader would, and do what they say."""

import subprocess
import sys
from pathlib import Path

import pytest

from lagrangia.native.build import find_compiler

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def said(name: str, folder: Path) -> str:
    done = subprocess.run([sys.executable, str(EXAMPLES / name)], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_pole_is_swung_up_and_caught(tmp_path: Path) -> None:
    words = said("swing_up.py", tmp_path).split()
    assert abs(float(words[3])) < 0.2 and words[4] == "deg", "upright at the end"


def test_the_environment_is_one_to_learn_in(tmp_path: Path) -> None:
    assert said("environment.py", tmp_path).startswith("500 steps upright")
