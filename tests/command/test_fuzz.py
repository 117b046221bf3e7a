"""Random models and command lines: never a traceback, a bug, a hang, an error without a place, or rows that are no numbers.

Each command runs in a fork of one process of its own (fuzz_commands.py). LAGRANGIA_FUZZ=N asks for N more, with other seeds.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[1] / "helpers" / "fuzz_commands.py"
SCENE = "model M Revolute c1(a = world, phi(start = 1)); Bar bar(m = 1, L = 1, a = c1.b); " \
        "input Torque u(start = 0); AppliedTorque d(on = c1.b, torque = u); end M;"
# What was once a fault: scene, command, exit code, and what is said now.
KEPT = [
    (SCENE, "check fifo.lag", 2, "'fifo.lag' cannot be read: it is a pipe, not a file"),
    (SCENE, "check loop.lag", 2, "'loop.lag' cannot be read: Too many levels of symbolic links"),
    (SCENE, "check /dev/zero", 2, "'/dev/zero' cannot be read: it is a device, not a file"),
    (SCENE, "fmu check fifo.lag", 2, "it is a pipe, not a file"),
    (SCENE, "fmu check /dev/zero", 2, "it is a device, not a file"),
    (SCENE, "simulate scene.lag -u fifo.csv", 2, "needs a line of names"),
    (SCENE, "sweep scene.lag --runs fifo.csv", 2, "needs a line of names"),
    (SCENE, "sweep scene.lag --runs /dev/zero", 2, "it is a device, not a file"),
    ('import "loop.lag"; ' + SCENE, "check scene.lag", 2, "there is no file 'loop.lag'"),
    (SCENE, "simulate scene.lag --stop 0.1 --plot loop.svg", 2,
     "'loop.svg' cannot be written: Too many levels of symbolic links"),
]


def fuzz(*arguments: str) -> str:
    process = subprocess.run([sys.executable, PROGRAM, *arguments], capture_output=True, text=True, timeout=3_000, check=False)
    assert process.returncode == 0, process.stderr
    return process.stdout


pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="each command runs in a fork")


def test_what_was_once_a_fault_and_a_few_more() -> None:
    told, *rest = fuzz("kept", json.dumps([[text, command.split()] for text, command, _, _ in KEPT]), "1", "6").splitlines()
    for (_, command, code, said), (found_code, found_said, found) in zip(KEPT, json.loads(told), strict=True):
        assert not found, (command, found)
        assert code == found_code and said in found_said, (command, found_code, found_said)
    assert rest[-1].endswith(" 0 faults of 0 kinds"), "\n".join(rest)


@pytest.mark.parametrize(("first", "count"), [
    (0, 8), pytest.param(8, 10 + int(os.environ.get("LAGRANGIA_FUZZ", "0")), marks=pytest.mark.slow)])
def test_models_that_are_right_run(first: int, count: int) -> None:
    """Nearly all: what chance ties together may contradict itself."""
    told = fuzz("valid", str(first), str(count)).splitlines()
    assert told[-1].endswith(" 0 faults of 0 kinds"), "\n".join(told)
    assert int(told[-1].partition(" ")[0]) >= 0.75 * count, told


@pytest.mark.slow
@pytest.mark.parametrize("seed", [10056, 30190, 30219])
def test_models_that_once_took_too_long_or_ended_in_a_bug(seed: int) -> None:
    """Long sums on paper, and lengths of too many terms."""
    told = fuzz("valid", str(seed), "1").splitlines()
    assert told[-1].endswith(" 0 faults of 0 kinds"), "\n".join(told)


@pytest.mark.slow
def test_no_command_does_what_none_may() -> None:
    told = fuzz("100000", str(90 + int(os.environ.get("LAGRANGIA_FUZZ", "0")))).splitlines()
    assert told[-1].endswith(" 0 faults of 0 kinds"), "\n".join(told)
