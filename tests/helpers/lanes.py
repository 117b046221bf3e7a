"""Batches of runs advanced in lanes, or one by one."""

from dataclasses import replace

import numpy as np

import lagrangia as lag
from lagrangia.run.batch import Batch, Lanes
from lagrangia.study.sweep.plan import Job


def advanced(model: lag.Model, job: Job, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, Lanes]:
    engine = model.engine_for("auto")
    assert engine is not None
    with Batch(engine.runtime, engine.model, job.sweep) as batch:
        results, outcomes, _ = batch.advance(values)
        return results, outcomes, batch.lanes


def one_by_one(job: Job) -> Job:
    return replace(job, sweep=replace(job.sweep, in_lanes=False))
