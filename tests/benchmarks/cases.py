"""The scenes of the benchmark suite, each with the time it runs for."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import lagrangia as lag
from lagrangia.bench.problem import Problem, build_problem
from lagrangia.run.request import Request

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES, CASES = ROOT / "models" / "examples", ROOT / "tests" / "cases"


@dataclass(frozen=True)
class Case:
    name: str
    file: Path
    stop: float  # s
    model: str | None = None
    structural: Mapping[str, int] = field(default_factory=dict)

    def problem(self, stop: float | None = None) -> Problem:
        return build_problem(lag.load(self.file, model=self.model, **self.structural), Request(stop=stop or self.stop))


def _chain(n: int, stop: float) -> Case:
    return Case(f"chain {n}", EXAMPLES / "chain.lag", stop, structural={"n": n})


SUITE = (
    Case("linear 2", CASES / "linear_2dof_vibration.lag", 20.0, "Damped"),
    Case("linear 200", Path(__file__).parent / "scenes" / "row.lag", 50.0),
    Case("pendulum", EXAMPLES / "pendulum.lag", 10.0),
    Case("double pendulum", EXAMPLES / "double_pendulum.lag", 5.0),
    _chain(5, 2.0),
    _chain(20, 2.0),
    _chain(100, 1.0),
    Case("spring pendulum", EXAMPLES / "spring_pendulum.lag", 10.0),
    Case("stiff spring pendulum", CASES / "stiff_spring_pendulum.lag", 1.0),
    Case("Fermi-Pasta-Ulam", CASES / "gni_fermi_pasta_ulam.lag", 10.0),
    Case("quarter car", EXAMPLES / "quarter_car.lag", 3.0),
    Case("Andrews", EXAMPLES / "andrews_squeezer.lag", 0.03),
    Case("four-bar", EXAMPLES / "four_bar.lag", 2.0),
    Case("ten four-bars", EXAMPLES / "n_four_bars.lag", 0.6, structural={"n": 10}),  # at 0.72 s they lie flat: only we pass
    Case("slider crank", EXAMPLES / "slider_crank.lag", 2.0),
)
