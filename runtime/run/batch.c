#include "run/batch_state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "run/run_lanes.h"
#include "state/state.h"

/* Of an account: relative; of tolerances; J that may be rounding. */
static const double DOUBTFUL = 0.1, HOPELESS = 0.5, MUCH = 100, LITTLE = 1e-9;
enum { MANY_STEPS = 100 };

static double *copied(LagArena *arena, const double *values, size_t count)
{
    double *place = lag_take(arena, count);
    if (place)
        memcpy(place, values, count * sizeof *place);
    return place;
}

static void layout(LagBatch *batch, const LagSweep *sweep, LagArena *arena)
{
    const LagModel *model = batch->model;
    const size_t n = (size_t)model->n, parameters = (size_t)model->n_parameters;
    batch->sweep.given = copied(arena, sweep->given, parameters);
    batch->sweep.mask = batch->mask = copied(arena, sweep->mask, parameters);
    batch->sweep.least = copied(arena, sweep->least, parameters);
    batch->sweep.most = copied(arena, sweep->most, parameters);
    batch->sweep.start = copied(arena, sweep->start, 2 * n);
    batch->sweep.row_times = copied(arena, sweep->row_times, (size_t)sweep->n_rows);
    batch->p = lag_take(arena, parameters);
    batch->state = lag_take(arena, 2 * n);
}

static int time_order(const LagBatch *batch, int a, int b)
{
    return batch->reductions[a].value < batch->reductions[b].value;
}

/* Insertion: there are few, mostly in order already. */
static void order_times(LagBatch *batch)
{
    batch->n_at = 0;
    for (int i = 0; i < batch->sweep.n_reductions; ++i) {
        if (batch->reductions[i].kind != LAG_REDUCE_AT)
            continue;
        int place = batch->n_at++;
        for (; place > 0 && time_order(batch, i, batch->at[place - 1]); --place)
            batch->at[place] = batch->at[place - 1];
        batch->at[place] = i;
    }
}

static int *copied_indices(const int *values, int count)
{
    int *copy = malloc(((size_t)count + 1) * sizeof *copy);
    if (copy && values)
        memcpy(copy, values, (size_t)count * sizeof *copy);
    return copy;
}

static int allocate(LagBatch *batch, const LagSweep *sweep)
{
    const size_t reductions = (size_t)sweep->n_reductions;
    LagArena arena = {NULL, 0};
    layout(batch, sweep, &arena);
    batch->memory = calloc(arena.used + 1, sizeof *batch->memory);
    batch->reductions = malloc((reductions + 1) * sizeof *batch->reductions);
    batch->varied = copied_indices(sweep->varied, sweep->n_varied);
    batch->at = copied_indices(NULL, sweep->n_reductions);
    if (!batch->memory || !batch->reductions || !batch->varied || !batch->at)
        return 0;
    arena.base = batch->memory;
    arena.used = 0;
    layout(batch, sweep, &arena);
    memcpy(batch->reductions, sweep->reductions, reductions * sizeof *batch->reductions);
    batch->sweep.reductions = batch->reductions;
    batch->sweep.varied = batch->varied;
    order_times(batch);
    for (int i = 0; i < sweep->n_varied; ++i)
        batch->varies_parameters |= sweep->varied[i] < batch->model->n_parameters;
    return 1;
}

LagBatch *lag_batch_new(const LagModel *model, LagRun *run, const LagSweep *sweep)
{
    LagBatch *batch = calloc(1, sizeof *batch);
    if (!batch)
        return NULL;
    batch->model = model;
    batch->sweep = *sweep;
    if (!allocate(batch, sweep) || !lag_follow_new(&batch->alone, model, run, &batch->sweep, batch->at, batch->n_at)) {
        lag_batch_free(batch);
        return NULL;
    }
    batch->lanes = lag_lanes_new(batch);
    return batch;
}

void lag_batch_free(LagBatch *batch)
{
    if (!batch)
        return;
    lag_lanes_free(batch->lanes);
    if (batch->alone.sweep)
        lag_follow_free(&batch->alone);
    free(batch->memory);
    free(batch->reductions);
    free(batch->varied);
    free(batch->at);
    free(batch);
}

/* ---------------------------------------------------------------- one run */

void lag_batch_insert(const LagBatch *batch, int64_t run)
{
    const double *values = batch->values + run * batch->sweep.n_varied;
    const size_t n = (size_t)batch->model->n, parameters = (size_t)batch->model->n_parameters;
    if (batch->varies_parameters)
        memcpy(batch->p, batch->sweep.given, parameters * sizeof *batch->p);
    memcpy(batch->state, batch->sweep.start, 2 * n * sizeof *batch->state);
    for (int i = 0; i < batch->sweep.n_varied; ++i) {
        const size_t place = (size_t)batch->varied[i];
        *(place < parameters ? batch->p + place : batch->state + (place - parameters)) = values[i];
        if (place < parameters)
            batch->mask[place] = 1;
    }
}

static LagStatus refuse(const LagBatch *batch, LagFollower *f, int64_t i)
{
    LagOutcome *outcome = &batch->outcomes[i];
    const int wrong = f->wrong_parameter;
    outcome->kind = LAG_RUN_PARAMETER;
    outcome->failure.index = wrong;
    outcome->failure.value = wrong < batch->model->n_parameters ? lag_run_parameters(f->run)[wrong] : 0;
    return LAG_NOT_STARTED;
}

static LagStatus start(LagBatch *batch, LagFollower *f, int64_t i)
{
    LagRun *run = f->run;
    lag_batch_insert(batch, i);
    lag_run_set_stop(run, batch->sweep.t_stop);
    run->started = 0; /* the one before is over */
    if (batch->varies_parameters || !f->has_parameters) {
        lag_run_set_parameters(run, batch->varies_parameters ? batch->p : batch->sweep.given, batch->mask);
        f->wrong_parameter = lag_run_wrong_parameter(run, batch->sweep.least, batch->sweep.most);
    }
    f->has_parameters = 1;
    if (f->wrong_parameter >= 0)
        return refuse(batch, f, i);
    const double *q = batch->state, *v = q + batch->model->n;
    const LagStatus status = lag_follow_hold(f);
    if (status != LAG_OK)
        return status;
    return f->starts_again ? lag_run_start_again(run, q, v) : lag_run_start(run, q, v);
}

static size_t rows_size(const LagBatch *batch, int rows) { return (size_t)rows * (size_t)lag_run_row_width(batch->model); }

LagStatus lag_batch_begin(LagBatch *batch, LagFollower *f, int64_t i)
{
    const LagOutcome fresh = {0};
    const int n_rows = batch->sweep.n_rows;
    const size_t kept = rows_size(batch, n_rows);
    const size_t between = n_rows > 0 ? (size_t)(n_rows - 1) * (size_t)batch->model->n_inputs : 0;
    batch->outcomes[i] = fresh;
    batch->outcomes[i].failure.index = -1;
    f->rows = batch->rows + (size_t)i * kept;
    f->held = batch->held ? batch->held + (size_t)i * between : NULL;
    f->stop = batch->stop;
    f->deadline = batch->sweep.seconds > 0 ? lag_clock() + batch->sweep.seconds : INFINITY;
    f->run->retry.stop = f->stop;
    f->run->retry.limit = f->deadline < INFINITY ? f->deadline : 0;
    lag_follow_start(f);
    return start(batch, f, i);
}

/* Whether H rose by much more than powers ever gave it: however badly they are integrated, they would have shown. */
static int rises_from_nothing(const LagBatch *batch, const LagStatistics *s)
{
    return !batch->sweep.is_driven && s->energy_risen > fmax(DOUBTFUL * s->energy_stored, MUCH * s->energy_given);
}

/* Whether an account does not close at all; in integrals of powers that may be their own error: see run/simulate.py. */
static int is_beyond_doubt(const LagBatch *batch, const LagRun *run, const LagStatistics *s, double missed)
{
    const int is_told = s->steps > MANY_STEPS || s->energy_residual > LITTLE;
    return is_told && missed > fmax(DOUBTFUL, MUCH * run->settings.tolerance)
        && (batch->model->n_power == 0 || missed > HOPELESS || rises_from_nothing(batch, s));
}

/* Each row judges the energy account: there is one at the end, whatever was asked for. */
static LagStatus close_account(LagFollower *f)
{
    return f->row[0] == lag_guards_limit(f->run) ? LAG_OK : lag_follow_row(f);
}

static void tell_failure(const LagRun *run, LagStatus status, LagOutcome *outcome)
{
    outcome->kind = status == LAG_PAUSED ? LAG_RUN_OVERTIME : LAG_RUN_FAILED;
    if (status == LAG_PAUSED)
        outcome->failure.time = lag_run_time(run);
    else
        outcome->failure = *lag_run_failure(run);
}

/* Bits of the guards that have warned. */
static int32_t warned_of(LagRun *run)
{
    double when = 0;
    uint32_t found = 0;
    for (int guard = lag_run_warning(run, &when); guard > 0; guard = lag_run_warning(run, &when))
        found |= 1U << (guard - 1 < LAG_GUARD_BITS - 1 ? guard - 1 : LAG_GUARD_BITS - 1);
    return (int32_t)found;
}

/* Bits of those that took steps. */
static int64_t methods_of(const LagStatistics *s)
{
    int64_t found = 0;
    for (int k = 0; k < LAG_SOLVERS; ++k)
        if (s->steps_by[k] > 0)
            found |= (int64_t)1 << k;
    return found;
}

void lag_batch_conclude(LagBatch *batch, LagFollower *f, int64_t i, LagStatus status)
{
    LagOutcome *outcome = &batch->outcomes[i];
    if (status == LAG_OK)
        status = close_account(f);
    const LagStatistics *statistics = &f->run->statistics;
    for (size_t k = rows_size(batch, f->next_row); k < rows_size(batch, batch->sweep.n_rows); ++k)
        f->rows[k] = NAN;
    outcome->warned = outcome->kind == LAG_RUN_PARAMETER ? 0 : warned_of(f->run); /* of what did not start: of another run */
    if (outcome->kind == LAG_RUN_DONE && status != LAG_OK)
        tell_failure(f->run, status, outcome);
    if (outcome->kind != LAG_RUN_PARAMETER) {
        outcome->steps = statistics->steps;
        outcome->methods = methods_of(statistics);
        const double energy = fmax(statistics->energy_scale, statistics->energy_stored);
        outcome->energy = energy > 0 ? statistics->energy_residual / energy : 0;
    }
    const int is_open = statistics->energy_is_open;
    if (outcome->kind == LAG_RUN_DONE && (is_open || is_beyond_doubt(batch, f->run, statistics, outcome->energy))) {
        outcome->kind = LAG_RUN_OPEN;
        outcome->failure.time = is_open ? statistics->energy_open : batch->sweep.t_start;
        outcome->failure.value = outcome->energy;
    }
    lag_follow_results(f, status, batch->results + i * batch->sweep.n_reductions);
}

/* And a second time for what takes two. */
int lag_batch_alone(LagBatch *batch, int64_t i)
{
    LagFollower *f = &batch->alone;
    LagStatus status = lag_batch_begin(batch, f, i);
    if (status == LAG_OK)
        status = lag_follow_run(f);
    if (status == LAG_OK && lag_follow_again(f)) {
        status = start(batch, f, i);
        if (status == LAG_OK)
            status = lag_follow_run(f);
    }
    if (status == LAG_PAUSED && *batch->stop)
        return 0;
    lag_batch_conclude(batch, f, i, status);
    return 1;
}

int64_t lag_batch_advance(LagBatch *batch, int64_t runs, const double *values, const double *held, double *results,
                          LagOutcome *outcomes, double *rows, const volatile int32_t *stop)
{
    batch->values = values;
    batch->held = held;
    batch->results = results;
    batch->outcomes = outcomes;
    batch->rows = rows;
    batch->stop = stop;
    if (batch->lanes)
        return lag_lanes_advance(batch->lanes, runs);
    for (int64_t i = 0; i < runs; ++i)
        if (*stop || !lag_batch_alone(batch, i))
            return i;
    return runs;
}

void lag_batch_lanes(const LagBatch *batch, int64_t *counts)
{
    for (int k = 0; k < LAG_LANES_COUNTS; ++k)
        counts[k] = batch->lanes ? lag_lanes_counts(batch->lanes)[k] : 0;
}

const LagCycle *lag_batch_cycles(const LagBatch *batch, int reduction, int64_t *count)
{
    *count = (int64_t)batch->alone.reduced[reduction].flow.n_cycles;
    return batch->alone.reduced[reduction].flow.cycles;
}
