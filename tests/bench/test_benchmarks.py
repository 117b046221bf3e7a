"""The benchmarks run, and the peers' models written by hand move as ours do; figures are for people, not for tests."""

import subprocess
import sys
from pathlib import Path

import pytest

from lagrangia.bench.measure import Point, measure
from lagrangia.bench.peers import Solver
from lagrangia.bench.reference import find_reference

FOLDER = Path(__file__).parents[1] / "benchmarks"
EXAMPLES = FOLDER.parents[1] / "models" / "examples"
sys.path.insert(0, str(FOLDER))

import peer_exudyn  # noqa: E402
import peer_mujoco  # noqa: E402
import peer_rumoca  # noqa: E402

from cases import SUITE, Case  # noqa: E402

# Peers that are not installed are skipped, and the benchmark says so.
TINY = ["--tolerances", "1e-4,1e-6", "--repeat", "1", "--share", "0.02"]
COMMANDS = [
    ["chain_size.py", "--largest", "5"],
    ["rhs_size.py", "--largest", "5"],
    ["rhs_size.py", "--rope", "--largest", "10"],
    pytest.param(["hand_written.py"], marks=pytest.mark.slow, id="hand_written.py"),
    pytest.param(["startup.py", "--repeat", "1", "--links", "5"], marks=pytest.mark.slow, id="startup.py --repeat"),
    ["four_bars.py", "--largest", "2"],
    ["space.py", "--repeat", "1", "--only", "arm,bricard", "--longest", "0.01", "--no-native"],
    ["many_runs.py", "--runs", "50", "--repeats", "1"],
    ["stepping.py", "--steps", "200", "--repeats", "1"],
    ["rollouts.py", "--runs", "20", "--repeats", "1"],
    ["ensemble.py", "--runs", "20", "--repeats", "1"],
    ["lanes_errors.py", "--runs", "9", "--stop", "0.2", *(f"{EXAMPLES}/{name}.lag" for name in ("chain", "four_bar"))],
    ["fmu_steps.py", "--engine", "tape", "--repeats", "2"],
    pytest.param(["suite.py", "--scenes", "pendulum,four-bar", "--solvers", "erk,casadi:erk,heyoka,mujoco,exudyn,rumoca", *TINY],
                 marks=pytest.mark.slow, id="suite.py --scenes"),
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: " ".join(command[:2]))
def test_benchmark_runs(command: list[str]) -> None:
    script, *options = command
    done = subprocess.run([sys.executable, str(FOLDER / script), *options], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) >= 2


def test_the_suite_keeps_points_pictures_and_a_summary(tmp_path: Path) -> None:
    command = [str(FOLDER / "suite.py"), "--scenes", "pendulum", "--solvers", "erk,casadi:erk", *TINY, "-o", str(tmp_path)]
    subprocess.run([sys.executable, *command], check=True, capture_output=True)
    assert (tmp_path / "pendulum.csv").read_text().count("erk") == 4
    assert (tmp_path / "pendulum.png").stat().st_size > 10_000
    assert "| pendulum | " in (tmp_path / "summary.md").read_text()


SCENES = [(peer, case) for peer in (peer_mujoco, peer_exudyn) for case in SUITE if case.name in peer.SCENES]
SOLVERS = [*((peer.solver(case.name), case) for peer, case in SCENES if case.name not in ("linear 200", "chain 100")),
           *((peer_rumoca.SOLVER, case) for case in SUITE if case.name in ("pendulum", "double pendulum", "slider crank"))]


@pytest.mark.parametrize(("solver", "case"), SOLVERS, ids=lambda value: value.name)
def test_a_model_written_for_a_peer_moves_as_ours(solver: Solver, case: Case) -> None:
    if solver.version is None:
        pytest.skip(f"{solver.name} is not installed")
    problem = case.problem(case.stop / 20)
    points = [p for p in measure(problem, find_reference(problem), [solver], (1e-8,), 1) if isinstance(p, Point)]
    assert len(points) == 1
    assert points[0].error < 3e-5
