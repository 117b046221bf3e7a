"""Measures of one run: the same as a sweep takes of each of its runs."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from lagrangia.base.cutting import cut_list
from lagrangia.base.diagnostics import Interrupted, RunError, fail
from lagrangia.run.batch import Batch
from lagrangia.run.request import Request
from lagrangia.run.solvers import name_of
from lagrangia.study.sweep.journal import Ledger
from lagrangia.study.sweep.measures import Measure, quantities, read_measure, read_measures
from lagrangia.study.sweep.plan import Design, Job
from lagrangia.study.sweep.run import Asked, run_job
from lagrangia.study.sweep.table import Sweep

if TYPE_CHECKING:
    import numpy as np


def prepare_measures(model: Asked, texts: str | Sequence[str], request: Request) -> Callable[[], Sweep]:
    """What takes them: a sweep of one run, which raises RunError where that fails, and Interrupted. Raises LagError."""
    measures = read_measures(texts)
    if not measures:
        fail("L0711", "no measure is asked for", None, "say which: max(y), settling_time(y, 0.02), count(y > 1)")
    suited, job = _prepared(model, measures, request)

    def take() -> Sweep:
        sweep = run_job(job, suited, Ledger(job), jobs=1)
        if sweep.interrupted:
            raise Interrupted("the measured run was interrupted")
        _raise_failure(sweep)
        return sweep

    return take


def measure_lines(sweep: Sweep) -> list[str]:
    """Each measure with its value and unit."""
    values = zip(sweep.job.measures, sweep.units(), sweep.ledger.results[0].tolist(), strict=True)
    return [f"  {measure.text} = {f'{value:.10g} {unit}'.rstrip() if math.isfinite(value) else 'none'}"
            for measure, unit, value in values]


def take_cycles(model: Asked, quantity: str, request: Request) -> "np.ndarray":
    """Rainflow cycles (ASTM E1049) of a quantity, or of one over a window, "y, from=2": (cycles, 3) of range, mean and count,
    which is 1 or 1/2, in the order in which they are closed. Raises LagError, RunError where the run fails."""
    import numpy as np

    name, *window = cut_list(quantity)
    suited, job = _prepared(model, [read_measure(f"damage({', '.join([name, '1', *window])})")], request)
    engine = suited.engine_for(name_of(job.sweep.settings.solver))
    if engine is None:
        fail("L0901", "not supported yet: measures without a run time of our own")
    (reduction,) = job.sweep.reductions
    ledger = Ledger(job)
    with Batch(engine.runtime, engine.model, replace(job.sweep, reductions=[replace(reduction, keeps_cycles=True)])) as batch:
        ledger.enter(0, *batch.advance(np.empty((1, 0)))[:2])
        _raise_failure(Sweep(job, ledger, 0.0))
        return batch.cycles(0)


def _prepared(model: Asked, measures: Sequence[Measure], request: Request) -> tuple[Asked, Job]:
    suited, job = model.reporting(quantities(measures)).prepared_for(measures, request, Design())
    if job.runs != 1:
        fail("L0712", "one run is measured: each parameter and each start has one value", None, "simulate_many takes many")
    return suited, job


def _raise_failure(sweep: Sweep) -> None:
    if why := sweep.failures.get(0):
        raise RunError(why)
