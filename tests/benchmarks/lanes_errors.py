"""Errors and times of runs in lanes beside those of the same runs made one after another, over scenes.

    python tests/benchmarks/lanes_errors.py [--runs N] [--tolerance T] [--stop T] [SCENE ...]

Of each scene (the examples, without being told otherwise) that lanes serve: runs from starts of its first coordinate that
differ a little. The error of a run is the largest of its coordinates at the end, relative to the coordinate over all runs,
against runs made alone at a tolerance a thousand times smaller. Times are processor times, the shorter of two.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import lagrangia as lag
from lagrangia.run.batch import Lanes
from lagrangia.run.request import Request
from lagrangia.study.sweep.journal import Ledger
from lagrangia.study.sweep.measures import read_measures
from lagrangia.study.sweep.plan import Design
from lagrangia.study.sweep.threads import run_on_threads

FOLDER = Path(__file__).resolve().parents[2] / "models" / "examples"


def ends(model: lag.Model, starts: np.ndarray, tolerance: float, stop: float, in_lanes: bool) -> tuple[np.ndarray, Lanes, float]:
    """Coordinates at the end, (runs, n); what went in lanes; seconds."""
    names = model.coordinate_names
    request = Request(stop=stop, tolerance=tolerance, initial={names[0]: starts})
    suited, job = model.prepared_for(read_measures(", ".join(f"final({name})" for name in names)), request, Design())
    job = replace(job, sweep=replace(job.sweep, in_lanes=in_lanes))
    engine = suited.engine_for("auto")
    assert engine is not None
    seconds = np.inf
    for _ in range(2):
        ledger, begin = Ledger(job), time.process_time()
        run_on_threads(job, engine, ledger, 1)
        seconds = min(seconds, time.process_time() - begin)
    return ledger.results, ledger.lanes, seconds


def compared(model: lag.Model, runs: int, tolerance: float, stop: float) -> str:
    """A line of what was found."""
    first = model.simulate(at=[0.0])[model.coordinate_names[0]][0]
    starts = first + np.linspace(0, 0.05, runs) * (1 + abs(first))
    found, lanes, seconds = ends(model, starts, tolerance, stop, True)
    if not lanes.room:
        return "no lanes"
    alone, _, longer = ends(model, starts, tolerance, stop, False)
    exact = ends(model, starts, 1e-3 * tolerance, stop, False)[0]
    size = np.maximum(np.nanmax(np.abs(exact), axis=0), 1e-12)
    error, other = (np.nanmax(np.abs(x - exact) / size, axis=1) for x in (found, alone))
    return (f"{longer / seconds:4.1f} times faster, errors {np.nanmedian(error):.1e} beside {np.nanmedian(other):.1e}, at most "
            f"{np.nanmax(error):.1e} beside {np.nanmax(other):.1e}; {lanes.runs} in lanes, {lanes.alone} made again")


def main() -> None:
    """Prints a line a scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", type=Path, default=sorted(FOLDER.glob("*.lag")))
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--tolerance", type=float, default=1e-8)
    parser.add_argument("--stop", type=float, default=2.0)
    options = parser.parse_args()
    for path in options.scenes:
        try:
            line = compared(lag.load(path), options.runs, options.tolerance, options.stop)
        except (lag.LagError, AssertionError) as problem:
            line = f"not: {str(problem).splitlines()[0]}"
        print(f"{path.stem:24} {line}", flush=True)


if __name__ == "__main__":
    main()
