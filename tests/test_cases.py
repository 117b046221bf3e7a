"""Known problems whose solutions are known to some 20 digits: tests/cases/NAME.yaml, with its scene NAME.lag.

The error of a run is the largest difference from the reference, over all reference times and columns, each column measured
in its amplitude, the largest magnitude it takes during the run.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import inf
from pathlib import Path

import numpy as np
import pytest
import yaml

import lagrangia as lag

FOLDER = Path(__file__).parent / "cases"
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)


@dataclass(frozen=True)
class Case:
    """What is asked of one model of one scene."""

    file: str
    model: str
    constant: float  # error <= constant * tolerance: three times what was measured, so that a lost digit is seen
    finest: float = 1e-9  # the error at tolerance 1e-12 is below this
    until: float = inf  # reference times beyond this are left out
    coarsest: float = 1e-4  # tolerances looser than this are left out of the comparison of errors
    why: str = ""  # the reason for another finest, until or coarsest
    slow: bool = False

    def __str__(self) -> str:
        return f"{self.file}-{self.model}" + ("" if self.until == inf else f"-{self.until:g}s")


CASES = [
    Case("pendulum_elliptic_suite", "Swinging", constant=1),
]


@cache
def scene(case: Case) -> lag.Model:
    return lag.load(FOLDER / f"{case.file}.lag", model=case.model)


def columns(case: Case) -> dict[str, np.ndarray]:
    """The reference: name -> values, with the times as `t`."""
    rows = yaml.safe_load((FOLDER / f"{case.file}.yaml").read_text(encoding="utf-8"))["runs"][case.model]
    rows = [row for row in rows if float(row["t"]) <= case.until]
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@cache
def amplitudes(case: Case) -> dict[str, float]:
    stop = columns(case)["t"][-1]
    run = scene(case).simulate(stop=stop, interval=stop / 1000, tolerance=1e-6)
    return {name: np.abs(run[name]).max() for name in columns(case) if name != "t"}


def error(case: Case, tolerance: float) -> float:
    reference = columns(case)
    run = scene(case).simulate(at=reference["t"], tolerance=tolerance)
    return max(np.abs(run[name] - reference[name]).max() / size for name, size in amplitudes(case).items())


every_case = pytest.mark.parametrize(
    "case", [pytest.param(case, id=str(case), marks=pytest.mark.slow if case.slow else ()) for case in CASES]
)


@every_case
def test_the_finest_tolerance_gives_nine_digits(case: Case) -> None:
    assert error(case, 1e-12) < case.finest


@every_case
def test_the_error_falls_in_step_with_the_tolerance(case: Case) -> None:
    tolerances = [tolerance for tolerance in TOLERANCES if tolerance <= case.coarsest]
    errors = [error(case, tolerance) for tolerance in tolerances]
    assert all(e <= case.constant * tolerance for e, tolerance in zip(errors, tolerances, strict=True)), errors
    assert all(finer < coarser / 10 for coarser, finer in pairwise(errors)), errors


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.yaml")), ids=lambda file: file.stem)
def test_every_reference_is_used(file: Path) -> None:
    runs = yaml.safe_load(file.read_text(encoding="utf-8"))["runs"]
    assert set(runs) == {case.model for case in CASES if case.file == file.stem}


def test_every_exception_has_its_reason() -> None:
    rule = Case("", "", constant=1)
    assert all(case.why for case in CASES if (case.finest, case.until, case.coarsest) != (rule.finest, rule.until, rule.coarsest))
