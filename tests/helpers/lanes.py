"""Batches of runs advanced in lanes, or one by one."""

from dataclasses import replace

import numpy as np

import lagrangia as lag
from lagrangia.run.batch import Batch, Lanes
from lagrangia.study.sweep.plan import Job

# Of a scene of two coordinates with an output: runs of 2 s in lanes, with rows and measures, and once more with their ends alone.
DRIVER = """
#include "run/batch.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
extern const LagModel lag_model;
enum { RUNS = 21 };
int main(void)
{
    const LagSettings settings = {.t_stop = 2, .tolerance = 1e-8};
    const LagReduction reductions[] = {{.kind = LAG_REDUCE_AT, .column = 1, .rate = -1, .value = 2},
        {.kind = LAG_REDUCE_MAX, .column = 2, .rate = 4, .from = -INFINITY, .to = INFINITY},
        {.kind = LAG_REDUCE_MEAN, .column = 5, .rate = -1, .from = -INFINITY, .to = INFINITY}};
    const int varied[] = {lag_model.n_parameters + 1};
    const size_t n = (size_t)lag_model.n_parameters;
    double *zeros = calloc(n, sizeof *zeros), *least = malloc(n * sizeof *least), *most = malloc(n * sizeof *most);
    double start[4] = {NAN, NAN, NAN, NAN};
    for (int i = 0; i < lag_model.n_parameters; ++i) { least[i] = -INFINITY; most[i] = INFINITY; }
    const double times[] = {0, 1, 2};
    const LagSweep sweep = {.t_stop = 2, .window = 0.1, .n_reductions = 3, .reductions = reductions, .n_varied = 1,
        .varied = varied, .given = zeros, .mask = zeros, .start = start, .least = least, .most = most, .in_lanes = 1,
        .n_rows = 3, .row_times = times};
    LagRun *run = lag_run_new(&lag_model, &settings);
    LagBatch *batch = lag_batch_new(&lag_model, run, &sweep);
    double values[RUNS], results[RUNS * 3], *rows = calloc((size_t)(RUNS * 3 * lag_run_row_width(&lag_model)), sizeof *rows);
    LagOutcome outcomes[RUNS];
    int64_t counts[LAG_LANES_COUNTS];
    volatile int32_t stop = 0;
    for (int i = 0; i < RUNS; ++i) values[i] = 0.1 + 0.05 * i;
    int failed = lag_batch_advance(batch, RUNS, values, NULL, results, outcomes, rows, &stop) != RUNS;
    for (int i = 0; i < 3 * RUNS; ++i) failed |= !isfinite(results[i]);
    for (int i = 0; i < RUNS; ++i) failed |= outcomes[i].kind != LAG_RUN_DONE;
    stop = 1;
    failed |= lag_batch_advance(batch, RUNS, values, NULL, results, outcomes, rows, &stop) != 0;
    lag_batch_lanes(batch, counts);
    failed |= counts[LAG_LANES_RUNS] != RUNS;
    lag_batch_free(batch);
    LagSweep bare = sweep; /* their ends alone */
    bare.n_reductions = 1; bare.n_rows = 0; stop = 0;
    batch = lag_batch_new(&lag_model, run, &bare);
    double ends[RUNS];
    failed |= lag_batch_advance(batch, RUNS, values, NULL, ends, outcomes, NULL, &stop) != RUNS;
    for (int i = 0; i < RUNS; ++i) failed |= outcomes[i].kind != LAG_RUN_DONE || !(fabs(ends[i] - results[3 * i]) < 1e-9);
    lag_batch_free(batch); lag_run_free(run); free(zeros); free(least); free(most); free(rows);
    return failed;
}
"""


def advanced(model: lag.Model, job: Job, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, Lanes]:
    engine = model.engine_for("auto")
    assert engine is not None
    with Batch(engine.runtime, engine.model, job.sweep) as batch:
        results, outcomes, _ = batch.advance(values)
        return results, outcomes, batch.lanes


def one_by_one(job: Job) -> Job:
    return replace(job, sweep=replace(job.sweep, in_lanes=False))
