"""Known problems whose solutions are known to some 20 digits: tests/cases/NAME.yaml, with its scene NAME.lag.

The error of a run is the largest difference from the reference, over all reference times and columns, each column measured
in its amplitude, the largest magnitude it takes during the run.
"""

from dataclasses import dataclass
from functools import cache
from math import inf
from pathlib import Path

import numpy as np
import pytest
import yaml

import lagrangia as lag

FOLDER = Path(__file__).parents[1] / "cases"
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


@dataclass(frozen=True)
class Case:
    """What is asked of one model of one scene: error = constant * tolerance, and nine digits at the finest tolerance.

    The constant was measured. It holds what the motion itself magnifies: close encounters, instability, periods gone by.
    """

    file: str
    model: str
    constant: float
    until: float = inf  # later reference times are left out
    tolerances: tuple[float, ...] = TOLERANCES  # the errors at these are compared
    finest: float = 1e-9  # the error at tolerance 1e-12 is below this
    gain: float = 25  # two steps of the tolerance divide the error by more than this
    why: str = ""  # the reason for any of the four above
    slow: bool = False

    def __str__(self) -> str:
        return f"{self.file}-{self.model}" + ("" if self.until == inf else f"-{self.until:g}s")


EXACT = 1e-13  # linear scenes, by exponentials at all tolerances
STABILITY = "stability keeps the steps short: finer tolerances change little until they rule"
CASES = [
    Case("cart_pole_barto_sutton", "CartPole", constant=0.1),
    Case("cart_pole_barto_sutton", "PushedCartPole", constant=0.008),
    Case("coupled_pendulums_spring", "CoupledPendulums", constant=0.2),
    Case("double_pendulum_chaotic", "DoublePendulum", constant=0.5, until=10, why="then chaos takes over: the next is to 20 s"),
    Case("double_pendulum_chaotic", "DoublePendulum", constant=7e3, until=20, tolerances=TOLERANCES[1:], finest=1e-7,
         why="errors grow tenfold every 2.2 s, and that of rounding is as large as the motion soon after 30 s"),
    Case("gni_fermi_pasta_ulam", "FermiPastaUlam", constant=3, until=50, why="then errors grow fast: the next is all of it"),
    Case("gni_fermi_pasta_ulam", "FermiPastaUlam", constant=500, tolerances=TOLERANCES[1:-1], finest=1e-7,
         why="errors grow a millionfold in 200 s: the loosest tolerance loses the motion, the finest is ruled by rounding"),
    Case("ifto_a01_simple_pendulum", "SimplePendulum", constant=15, until=100, why="42 periods: the next is all 845"),
    Case("ifto_a01_simple_pendulum", "SimplePendulum", constant=2e3, tolerances=TOLERANCES[1:], why="1e-4 loses the phase"),
    Case("kepler_orbits", "Orbit", constant=80),
    Case("kepler_orbits", "CometOrbit", constant=500),
    Case("linear_2dof_vibration", "Beat", constant=0.07),
    Case("linear_2dof_vibration", "Undamped", constant=0.17),
    Case("linear_2dof_vibration", "Damped", constant=0.014),
    Case("linear_chain_1000", "Mode1", constant=2e-3, tolerances=TOLERANCES[:3], slow=True, why=STABILITY),
    Case("linear_chain_1000", "Mode10", constant=6e-3, tolerances=TOLERANCES[:3], gain=20, slow=True, why=STABILITY),
    Case("linear_chain_1000", "Mode500", constant=1.5, slow=True),
    Case("msl_double_pendulum", "DoublePendulum", constant=0.2),
    Case("msl_pendulum_spring_damper", "PendulumWithSpringDamper", constant=0.02),
    Case("pendulum_elliptic_suite", "Swinging", constant=0.003),
    Case("pendulum_elliptic_suite", "NearlyInverted", constant=35),
    Case("pendulum_elliptic_suite", "Rotating", constant=2.5),
    Case("planarmechanics_crane_crab", "CraneCrab", constant=0.02),
    Case("planarmechanics_double_pendulum", "DoublePendulum", constant=1),
    Case("quarter_car_bus_ctms", "RoadStep", constant=0.03),
    Case("quarter_car_bus_ctms", "Actuated", constant=0.02),
    Case("stiff_spring_pendulum", "StiffSpringPendulum", constant=0.5),
    Case("testset_pleiades", "Pleiades", constant=0.8),
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


@cache
def error(case: Case, tolerance: float) -> float:
    reference = columns(case)
    run = scene(case).simulate(at=reference["t"], tolerance=tolerance)
    return max(np.abs(run[name] - reference[name]).max() / size for name, size in amplitudes(case).items())


def for_every(cases: list[Case]) -> pytest.MarkDecorator:
    marked = [pytest.param(case, id=str(case), marks=pytest.mark.slow if case.slow else ()) for case in cases]
    return pytest.mark.parametrize("case", marked)


@for_every(CASES)
def test_the_finest_tolerance_gives_nine_digits(case: Case) -> None:
    assert error(case, 1e-12) < case.finest


@for_every(CASES)
def test_the_error_falls_in_step_with_the_tolerance(case: Case) -> None:
    """Their ratio is the constant on average; single ones may be off by luck, but every two steps of the tolerance pay."""
    errors = np.array([error(case, tolerance) for tolerance in case.tolerances])
    ratios = errors / np.array(case.tolerances)
    average = ratios.prod() ** (1 / len(ratios))
    assert average < 3 * case.constant, f"a digit is lost: {ratios}"
    assert ratios.max() < 30 * case.constant, f"a digit is lost at one tolerance: {ratios}"
    is_exact = errors.max() < EXACT
    pays = (errors[2:] < errors[:-2] / case.gain) | (errors[2:] < 2 * EXACT)  # rounding does not fall
    assert is_exact or pays.all(), f"a finer tolerance does not pay: {errors}"


@pytest.mark.parametrize("file", sorted({case.file for case in CASES}))
def test_every_reference_is_used(file: str) -> None:
    runs = yaml.safe_load((FOLDER / f"{file}.yaml").read_text(encoding="utf-8"))["runs"]
    assert set(runs) == {case.model for case in CASES if case.file == file}


def test_every_exception_has_its_reason() -> None:
    assert all(case.why for case in CASES if (case.until, case.tolerances, case.finest, case.gain) != (inf, TOLERANCES, 1e-9, 25))
