#include "run/batch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "run/stepping.h"
#include "state/state.h"

static const double PAUSE = 0.05; /* s between two looks at the caller's wish to stop */
/* Of an account: relative; of tolerances; J that may be rounding. */
static const double DOUBTFUL = 0.1, HOPELESS = 0.5, MUCH = 100, LITTLE = 1e-9;
enum { STEPS_PER_LOOK = 16, MANY_STEPS = 100 };

struct LagBatch {
    const LagModel *model;
    LagRun *run;
    LagSweep sweep;
    LagWindow window;
    double *memory;
    LagReduction *reductions, *taken; /* what is asked for, and what of it in the present of two runs */
    LagReduced *reduced;
    int *varied, *at; /* at: the reductions of kind LAG_REDUCE_AT in the order of their times */
    int n_at, next_at;
    double *row_times, *rows; /* of the present run */
    const double *held; /* inputs of the present run from each row to the next; NULL: as they are */
    int next_row;
    int n_pending; /* reductions over windows that are not known yet */
    int *is_open;  /* those that the windows of the present step are looked at for */
    double *given, *mask, *start, *least, *most;
    double *p, *state, *row; /* of the present run: parameters given, start values given, a row */
    double deadline;
    const volatile int32_t *stop;
};

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
    batch->given = copied(arena, sweep->given, parameters);
    batch->mask = copied(arena, sweep->mask, parameters);
    batch->least = copied(arena, sweep->least, parameters);
    batch->most = copied(arena, sweep->most, parameters);
    batch->start = copied(arena, sweep->start, 2 * n);
    batch->p = lag_take(arena, parameters);
    batch->state = lag_take(arena, 2 * n);
    batch->row = lag_take(arena, (size_t)lag_run_row_width(model));
    batch->row_times = copied(arena, sweep->row_times, (size_t)sweep->n_rows);
    lag_window_layout(&batch->window, model, arena);
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
    batch->taken = malloc((reductions + 1) * sizeof *batch->taken);
    batch->reduced = calloc(reductions + 1, sizeof *batch->reduced);
    batch->varied = copied_indices(sweep->varied, sweep->n_varied);
    batch->at = copied_indices(NULL, sweep->n_reductions);
    batch->is_open = copied_indices(NULL, sweep->n_reductions);
    if (!batch->memory || !batch->reductions || !batch->taken || !batch->reduced || !batch->varied || !batch->at || !batch->is_open)
        return 0;
    arena.base = batch->memory;
    arena.used = 0;
    layout(batch, sweep, &arena);
    memcpy(batch->reductions, sweep->reductions, reductions * sizeof *batch->reductions);
    return 1;
}

LagBatch *lag_batch_new(const LagModel *model, LagRun *run, const LagSweep *sweep)
{
    LagBatch *batch = calloc(1, sizeof *batch);
    if (!batch)
        return NULL;
    batch->model = model;
    batch->run = run;
    batch->sweep = *sweep;
    if (!allocate(batch, sweep)) {
        lag_batch_free(batch);
        return NULL;
    }
    lag_window_init(&batch->window, run);
    order_times(batch);
    return batch;
}

void lag_batch_free(LagBatch *batch)
{
    if (!batch)
        return;
    for (int i = 0; batch->reduced && i < batch->sweep.n_reductions; ++i) {
        lag_rainflow_free(&batch->reduced[i].flow);
        lag_spectrum_free(&batch->reduced[i].spectrum);
    }
    free(batch->memory);
    free(batch->reductions);
    free(batch->taken);
    free(batch->reduced);
    free(batch->varied);
    free(batch->at);
    free(batch->is_open);
    free(batch);
}

/* ---------------------------------------------------------------- one run */

static int is_over(const LagBatch *batch) { return *batch->stop || (batch->deadline < INFINITY && lag_clock() > batch->deadline); }

static void keep_at(LagBatch *batch, const double *row)
{
    const int i = batch->at[batch->next_at++];
    lag_reduce_row(&batch->reductions[i], &batch->reduced[i], row);
}

static double next_at(const LagBatch *batch)
{
    return batch->next_at < batch->n_at ? batch->reductions[batch->at[batch->next_at]].value : INFINITY;
}

static double next_row(const LagBatch *batch)
{
    return batch->next_row < batch->sweep.n_rows ? batch->row_times[batch->next_row] : INFINITY;
}

/* The inputs until the next row, if there is one. */
static LagStatus hold(LagBatch *batch)
{
    const int k = batch->next_row > 0 ? batch->next_row - 1 : 0;
    if (!batch->held || k >= batch->sweep.n_rows - 1)
        return LAG_OK;
    lag_run_set_stop(batch->run, batch->row_times[k + 1]);
    return lag_run_hold(batch->run, batch->held + (size_t)k * (size_t)batch->model->n_inputs);
}

/* Reductions at times up to t, and rows that are kept, which are asked for one by one. */
static LagStatus visit(LagBatch *batch, double t)
{
    const size_t width = (size_t)lag_run_row_width(batch->model);
    for (double when; (when = fmin(next_at(batch), next_row(batch))) <= t && when < INFINITY;) {
        LagStatus status = LAG_PAUSED;
        for (int done = 0; status == LAG_PAUSED;) {
            if (is_over(batch))
                return LAG_PAUSED;
            status = lag_run_advance(batch->run, &when, 1, batch->row, &done, PAUSE);
        }
        if (status != LAG_OK)
            return status;
        while (next_at(batch) == when)
            keep_at(batch, batch->row);
        for (; next_row(batch) == when; ++batch->next_row)
            memcpy(batch->rows + (size_t)batch->next_row * width, batch->row, width * sizeof *batch->row);
        if ((status = hold(batch)) != LAG_OK)
            return status;
    }
    return LAG_OK;
}

/* The end of the window from a, at the latest b: where a quantity begins or ceases to be taken, one ends. */
static double window_end(const LagBatch *batch, double a, double b)
{
    for (int i = 0; i < batch->sweep.n_reductions; ++i) {
        const LagReduction *what = &batch->taken[i];
        if (batch->is_open[i] && a < what->from && what->from < b)
            b = what->from;
        if (batch->is_open[i] && a < what->to && what->to < b)
            b = what->to;
    }
    return b;
}

/* Everything in the windows of the step that started at a; what is known after one of them is not looked at in the next. */
static LagStatus look(LagBatch *batch, double a)
{
    const double b = batch->window.end_time, parts = fmax(1, ceil((b - a) / batch->sweep.window * (1 - 1e-12)));
    LagStatus status = LAG_OK;
    for (double k = 1, t = a; k <= parts && status == LAG_OK;) {
        const double whole = k < parts ? a + (b - a) * (k / parts) : b, end = window_end(batch, t, whole);
        status = lag_window_fill(&batch->window, end);
        for (int i = 0; i < batch->sweep.n_reductions && status == LAG_OK; ++i)
            if (batch->is_open[i])
                status = lag_reduce_window(&batch->taken[i], &batch->reduced[i], &batch->window);
        lag_window_next(&batch->window);
        t = end;
        k += end == whole;
    }
    return status;
}

/* The motion, or the quantities alone, start anew at t. */
static LagStatus enter(LagBatch *batch, double t)
{
    const LagStatus status = lag_window_open(&batch->window, t);
    for (int i = 0; i < batch->sweep.n_reductions; ++i)
        lag_reduce_open(&batch->taken[i], &batch->reduced[i], &batch->window);
    return status;
}

/* The step from a is made: first a glance at its ends, which mostly is enough. */
static LagStatus watch(LagBatch *batch, double a)
{
    const int is_long = batch->window.end_time - a > batch->sweep.window * (1 + 1e-12);
    int open = 0;
    batch->n_pending = 0;
    for (int i = 0; i < batch->sweep.n_reductions; ++i) {
        batch->is_open[i] = lag_reduce_glance(&batch->taken[i], &batch->reduced[i], &batch->window, is_long);
        open += batch->is_open[i];
    }
    LagStatus status = LAG_OK;
    if (open)
        status = look(batch, a);
    else
        lag_window_skip(&batch->window);
    for (int i = 0; i < batch->sweep.n_reductions; ++i) {
        batch->reduced[i].is_known |= batch->taken[i].kind != LAG_REDUCE_AT && batch->window.end_time >= batch->taken[i].to;
        batch->n_pending += batch->taken[i].kind != LAG_REDUCE_AT && !batch->reduced[i].is_known;
    }
    return status;
}

/* The exact solver's steps are as long as they may be, and a row far inside of one costs as much as a step. */
static void limit_step(const LagBatch *batch, double a)
{
    if (lag_run_statistics(batch->run)->solver == LAG_SOLVER_LINEAR)
        lag_run_set_stop(batch->run, fmin(a + batch->sweep.window, batch->sweep.t_stop));
}

static LagStatus follow(LagBatch *batch)
{
    LagRun *run = batch->run;
    LagStatus status = visit(batch, batch->sweep.t_start);
    if (status == LAG_OK && batch->n_pending > 0)
        status = enter(batch, batch->sweep.t_start);
    for (int64_t steps = 1; status == LAG_OK && batch->n_pending > 0 && lag_run_time(run) < batch->sweep.t_stop; ++steps) {
        const double a = lag_run_time(run);
        const int64_t events = lag_run_statistics(run)->events;
        if (steps % STEPS_PER_LOOK == 0 && is_over(batch))
            return LAG_PAUSED;
        limit_step(batch, a);
        status = lag_window_step(&batch->window);
        if (status == LAG_OK && lag_run_statistics(run)->events != events)
            status = enter(batch, a); /* things may have jumped there */
        if (status == LAG_OK)
            status = visit(batch, batch->window.end_time);
        if (status == LAG_OK)
            status = watch(batch, a);
    }
    if (!batch->held)
        lag_run_set_stop(run, batch->sweep.t_stop);
    return status == LAG_OK ? visit(batch, INFINITY) : status;
}

static void insert(LagBatch *batch, const double *values)
{
    const size_t n = (size_t)batch->model->n, parameters = (size_t)batch->model->n_parameters;
    memcpy(batch->p, batch->given, parameters * sizeof *batch->p);
    memcpy(batch->state, batch->start, 2 * n * sizeof *batch->state);
    for (int i = 0; i < batch->sweep.n_varied; ++i) {
        const size_t place = (size_t)batch->varied[i];
        *(place < parameters ? batch->p + place : batch->state + (place - parameters)) = values[i];
        if (place < parameters)
            batch->mask[place] = 1;
    }
}

/* The first parameter that is not finite or out of its limits, or -1. */
static int wrong_parameter(const LagBatch *batch)
{
    const double *p = lag_run_parameters(batch->run);
    for (int i = 0; i < batch->model->n_parameters; ++i)
        if (!isfinite(p[i]) || p[i] < batch->least[i] || p[i] > batch->most[i])
            return i;
    return -1;
}

static void start_reductions(LagBatch *batch)
{
    batch->next_at = batch->next_row = 0;
    batch->row[0] = NAN;
    batch->n_pending = batch->sweep.n_reductions - batch->n_at;
    for (int i = 0; i < batch->sweep.n_reductions; ++i) {
        batch->taken[i] = lag_reduce_first(&batch->reductions[i]);
        lag_reduce_start(&batch->taken[i], &batch->reduced[i]);
    }
}

static double duration_of(const LagBatch *batch, const LagReduction *what)
{
    return fmin(batch->sweep.t_stop, what->to) - fmax(batch->sweep.t_start, what->from);
}

/* What needs a second run is started anew by what the first one has found; all else is known. */
static int start_second(LagBatch *batch)
{
    batch->n_pending = 0;
    for (int i = 0; i < batch->sweep.n_reductions; ++i) {
        const LagReduction *what = &batch->reductions[i];
        batch->reduced[i].is_known = 1;
        if (!lag_reduce_takes_two(what))
            continue;
        batch->taken[i] = lag_reduce_second(what, &batch->reduced[i], duration_of(batch, what));
        lag_reduce_start(&batch->taken[i], &batch->reduced[i]);
        ++batch->n_pending;
    }
    return batch->n_pending > 0;
}

static LagStatus begin(LagBatch *batch, const double *values, LagOutcome *outcome)
{
    insert(batch, values);
    lag_run_set_stop(batch->run, batch->sweep.t_stop);
    lag_run_set_parameters(batch->run, batch->p, batch->mask);
    const int wrong = wrong_parameter(batch);
    if (wrong >= 0) {
        outcome->kind = LAG_RUN_PARAMETER;
        outcome->failure.index = wrong;
        outcome->failure.value = lag_run_parameters(batch->run)[wrong];
        return LAG_NOT_STARTED;
    }
    const LagStatus status = hold(batch);
    return status == LAG_OK ? lag_run_start(batch->run, batch->state, batch->state + batch->model->n) : status;
}

/* Each row judges the energy account: there is one at the end, whatever was asked for. */
static LagStatus close_account(LagBatch *batch)
{
    return batch->row[0] == lag_run_time(batch->run) ? LAG_OK : lag_run_row(batch->run, batch->row);
}

/* Whether H rose by much more than powers ever gave it: however badly they are integrated, they would have shown. */
static int rises_from_nothing(const LagBatch *batch, const LagStatistics *s)
{
    return !batch->sweep.is_driven && s->energy_risen > fmax(DOUBTFUL * s->energy_stored, MUCH * s->energy_given);
}

/* Whether an account does not close at all; in integrals of powers that may be their own error: see run/simulate.py. */
static int is_beyond_doubt(const LagBatch *batch, const LagStatistics *s, double missed)
{
    const int is_told = s->steps > MANY_STEPS || s->energy_residual > LITTLE;
    return is_told && missed > fmax(DOUBTFUL, MUCH * batch->run->settings.tolerance)
        && (batch->model->n_power == 0 || missed > HOPELESS || rises_from_nothing(batch, s));
}

static void conclude(LagBatch *batch, LagStatus status, double *results, LagOutcome *outcome)
{
    const LagStatistics *statistics = lag_run_statistics(batch->run);
    if (outcome->kind == LAG_RUN_DONE && status != LAG_OK) {
        outcome->kind = status == LAG_PAUSED ? LAG_RUN_OVERTIME : LAG_RUN_FAILED;
        if (status == LAG_PAUSED)
            outcome->failure.time = lag_run_time(batch->run);
        else
            outcome->failure = *lag_run_failure(batch->run);
    }
    if (outcome->kind != LAG_RUN_PARAMETER) {
        outcome->steps = statistics->steps;
        const double energy = fmax(statistics->energy_scale, statistics->energy_stored);
        outcome->energy = energy > 0 ? statistics->energy_residual / energy : 0;
    }
    const int is_open = statistics->energy_is_open;
    if (outcome->kind == LAG_RUN_DONE && (is_open || is_beyond_doubt(batch, statistics, outcome->energy))) {
        outcome->kind = LAG_RUN_OPEN;
        outcome->failure.time = is_open ? statistics->energy_open : batch->sweep.t_start;
        outcome->failure.value = outcome->energy;
    }
    for (int i = 0; i < batch->sweep.n_reductions; ++i) {
        const LagReduction *what = &batch->reductions[i];
        results[i] = status == LAG_OK || batch->reduced[i].is_known
            ? lag_reduce_result(what, &batch->taken[i], &batch->reduced[i], fmax(batch->sweep.t_start, what->from),
                                duration_of(batch, what)) : NAN;
    }
}

/* One run, and a second one for what takes two. */
static LagStatus drive(LagBatch *batch, const double *values, LagOutcome *outcome)
{
    start_reductions(batch);
    LagStatus status = begin(batch, values, outcome);
    if (status == LAG_OK)
        status = follow(batch);
    if (status == LAG_OK && start_second(batch)) {
        status = begin(batch, values, outcome);
        if (status == LAG_OK)
            status = follow(batch);
    }
    return status == LAG_OK ? close_account(batch) : status;
}

int64_t lag_batch_advance(LagBatch *batch, int64_t runs, const double *values, const double *held, double *results,
                          LagOutcome *outcomes, double *rows, const volatile int32_t *stop)
{
    const LagOutcome fresh = {0};
    const size_t kept = (size_t)batch->sweep.n_rows * (size_t)lag_run_row_width(batch->model);
    const size_t between = batch->sweep.n_rows > 0 ? (size_t)(batch->sweep.n_rows - 1) * (size_t)batch->model->n_inputs : 0;
    batch->stop = stop;
    for (int64_t i = 0; i < runs; ++i) {
        if (*stop)
            return i;
        LagOutcome *outcome = &outcomes[i];
        *outcome = fresh;
        outcome->failure.index = -1;
        batch->rows = rows + (size_t)i * kept;
        batch->held = held ? held + (size_t)i * between : NULL;
        for (size_t k = 0; k < kept; ++k)
            batch->rows[k] = NAN;
        batch->deadline = batch->sweep.seconds > 0 ? lag_clock() + batch->sweep.seconds : INFINITY;
        const LagStatus status = drive(batch, values + i * batch->sweep.n_varied, outcome);
        if (status == LAG_PAUSED && *stop)
            return i;
        conclude(batch, status, results + i * batch->sweep.n_reductions, outcome);
    }
    return runs;
}

const LagCycle *lag_batch_cycles(const LagBatch *batch, int reduction, int64_t *count)
{
    *count = (int64_t)batch->reduced[reduction].flow.n_cycles;
    return batch->reduced[reduction].flow.cycles;
}
