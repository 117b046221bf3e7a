"""The benchmarks run; their figures are for people, not for tests."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent / "benchmarks"


COMMANDS = ["work_precision.py --repeats 1", "chain_size.py --largest 5", "closed_loops.py --repeats 1 --largest 2"]


@pytest.mark.parametrize("command", COMMANDS)
def test_benchmark_runs(command: str) -> None:
    script, *options = command.split()
    done = subprocess.run([sys.executable, str(FOLDER / script), *options], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) >= 3
