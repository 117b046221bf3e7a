#include "run/run_lanes.h"

#include <math.h>
#include <stdlib.h>

#include "methods/taylor.h"
#include "run/lane_runs.h"
#include "state/state.h"

enum { PATIENCE = 4 }; /* steps that are no good in a row, after which shorter ones do not help */
static const double MOST_TOLERANCE = 2e-4; /* of Verner's pair, as in choice.c */
static const double CAREFUL = 16; /* by which iterated collocation errs less than Runge-Kutta pairs at the same tolerance */

/* -------- whether lanes serve */

/* That of the pair which somebody has named, or NULL. */
static const LagWideMethod *named_pair(const LagSettings *settings)
{
    switch (settings->solver) {
    case LAG_SOLVER_ERK: return &lag_wide_dop853;
    case LAG_SOLVER_ERK5: return &lag_wide_tsit5;
    case LAG_SOLVER_ERK9: return &lag_wide_verner9;
    default: return NULL;
    }
}

static int is_asked(const LagSettings *settings)
{
    const int is_free = lag_methods_turn(settings) || settings->solver == LAG_SOLVER_TAYLOR;
    return (is_free || named_pair(settings)) && settings->max_steps == 0;
}

/* What swings back the way it came is read from steps that are kept, which takes no time. Where there are events, lanes make what series
 * would make alone. */
static int fits(const LagModel *model, const LagSettings *settings)
{
    if (model->n_switches > 0)
        return lag_run_solver(model, settings, NULL) == LAG_SOLVER_TAYLOR;
    if (settings->solver == LAG_SOLVER_TAYLOR || named_pair(settings))
        return 1;
    switch (lag_run_solver(model, settings, NULL)) {
    case LAG_SOLVER_PIRK: case LAG_SOLVER_ERK9: case LAG_SOLVER_ERK: case LAG_SOLVER_ERK5: case LAG_SOLVER_ADAMS: case LAG_SOLVER_TAYLOR:
        return !model->is_swing;
    default: return 0;
    }
}

static int takes_one_run(const LagSweep *sweep)
{
    for (int i = 0; i < sweep->n_reductions; ++i)
        if (lag_reduce_takes_two(&sweep->reductions[i]) || sweep->reductions[i].keeps_cycles)
            return 0;
    return 1;
}

static int is_plain(const LagModel *model, const LagSweep *sweep)
{
    if (model->n_attitudes + model->n_multipliers > 0)
        return 0;
    for (int i = 0; i < sweep->n_reductions; ++i) {
        const LagReduction *what = &sweep->reductions[i];
        if (what->kind != LAG_REDUCE_AT && (what->column > 2 * model->n || what->rate > 2 * model->n))
            return 0;
    }
    return 1;
}

/* -------- birth and death */

/* By the pair that is named; else by series where equations are short, in space where series serve a run alone; else by a Runge-Kutta
 * pair: where somebody looks inside steps, by that which has dense output. */
static int choose(LagRunLanes *s, const LagModel *model, const LagSettings *settings)
{
    const LagBatch *batch = s->batch;
    const LagWideMethod *pair = named_pair(settings);
    s->steps = &s->taylor.lanes;
    s->method = &lag_wide_taylor;
    const int32_t alone = lag_run_solver(model, settings, NULL);
    const int is_long = model->n_attitudes > 0 && alone != LAG_SOLVER_TAYLOR && lag_wide_explicit_serves(model);
    if (!pair && !is_long && lag_wide_taylor_serves(model))
        return 1;
    s->steps = &s->explicit.lanes;
    const int is_looked_into = batch->n_at < batch->sweep.n_reductions || s->is_guarded;
    s->method = pair ? pair : is_looked_into || settings->tolerance > MOST_TOLERANCE ? &lag_wide_dop853 : &lag_wide_verner9;
    s->explicit.caution = alone == LAG_SOLVER_PIRK ? CAREFUL : 1;
    return settings->solver != LAG_SOLVER_TAYLOR && (pair || model->n_multipliers == 0) && lag_wide_explicit_serves(model);
}

static int open_lane(LagRunLanes *s, const LagSettings *settings)
{
    const LagBatch *batch = s->batch;
    LagRun *run = lag_run_new(batch->model, settings);
    LagFollower *f = &s->follower[s->opened];
    s->job[s->opened] = -1;
    if (!run)
        return 0;
    ++s->opened;
    if (s->method == &lag_wide_taylor)
        lag_taylor_plan_for_eight(&run->methods.taylor, batch->model, run->scale.tolerance);
    if (!lag_follow_new(f, batch->model, run, &batch->sweep, batch->at, batch->n_at))
        return 0;
    f->window.is_plain = is_plain(batch->model, &batch->sweep);
    f->is_led = f->window.is_led = 1;
    return 1;
}

static void layout(LagRunLanes *s, LagArena *arena)
{
    const LagRun *like = lag_lanes_run(s, 0);
    s->method->layout(s->steps, like, arena);
    lag_wide_roots_layout(&s->roots, like->model, arena);
    lag_wide_conditions_layout(&s->conditions, like->model, arena);
    lag_bare_layout(&s->bare, like->model, like->motion.size, arena);
}

static int open(LagRunLanes *s, const LagSettings *settings)
{
    LagArena arena = {NULL, 0};
    while (s->opened < LAG_ABREAST)
        if (!open_lane(s, settings))
            return 0;
    layout(s, &arena);
    s->block = calloc(arena.used + LAG_CACHE_LINE, sizeof(double));
    if (!s->block)
        return 0;
    arena.base = lag_at_cache_line(s->block);
    arena.used = 0;
    layout(s, &arena);
    s->steps->solver = s->method->solver;
    return 1;
}

LagRunLanes *lag_lanes_new(LagBatch *batch)
{
    const LagModel *model = batch->model;
    LagSettings settings = batch->alone.run->settings;
    const int is_wanted = batch->sweep.in_lanes && is_asked(&settings) && takes_one_run(&batch->sweep);
    const int are_looked_at = lag_wide_roots_serve(model) && lag_wide_conditions_serve(model);
    if (!is_wanted || !are_looked_at || !fits(model, &settings))
        return NULL;
    LagRunLanes *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->batch = batch;
    s->is_guarded = lag_guards_watch_motion(model);
    const int is_served = choose(s, model, &settings);
    s->is_loop = model->n_multipliers > 0;
    s->has_events = model->n_switches > 0;
    s->may_turn = lag_methods_turn(&settings) && lag_methods_alternate(model, s->method->solver);
    s->starts_again = lag_run_starts_again(model);
    s->is_bare = s->method == &lag_wide_taylor && !s->is_guarded && lag_bare_serve(batch);
    s->bare.batch = batch;
    s->bare.taylor = &s->taylor;
    if (!s->has_events) /* else runs go on as they would alone, where they leave their lanes */
        settings.solver = s->method->solver;
    if (s->method == &lag_wide_taylor && settings.first_step == 0 && !s->has_events)
        settings.first_step = INFINITY; /* found where they are loaded */
    if (!is_served || !open(s, &settings)) {
        lag_lanes_free(s);
        return NULL;
    }
    return s;
}

/* The lanes' runs have the table of inputs of the batch's own, or one that they hold themselves. */
static void share_inputs(LagRunLanes *s, int are_shared)
{
    const LagInputs *from = &s->batch->alone.run->inputs;
    for (int lane = 0; lane < s->opened; ++lane) {
        LagInputs *to = &lag_lanes_run(s, lane)->inputs;
        if (s->are_shared || are_shared) {
            if (!s->are_shared)
                lag_inputs_free(to);
            to->times = are_shared ? from->times : NULL;
            to->values = are_shared ? from->values : NULL;
            to->rows = are_shared ? from->rows : 0;
            to->capacity = 0;
            ++to->version;
        }
    }
    s->are_shared = are_shared;
}

void lag_lanes_free(LagRunLanes *s)
{
    if (!s)
        return;
    share_inputs(s, 0);
    for (int lane = 0; lane < s->opened; ++lane) {
        lag_run_free(lag_lanes_run(s, lane));
        lag_follow_free(&s->follower[lane]);
    }
    free(s->block);
    free(s);
}

const int64_t *lag_lanes_counts(const LagRunLanes *s) { return s->counts; }

/* -------- all of them */

/* Whether no motion has to be looked at after this step: all are good, and nothing is due. */
static int is_quiet(const LagRunLanes *s)
{
    const LagWideSteps *steps = s->steps;
    const LagWide zero = LAG_WIDE_OF(0);
    LagWide calls = zero;
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const LagWide moves = lag_wide_read(steps->moves + lane), t = lag_wide_read(steps->t + lane);
        calls += LAG_WIDE_SELECT(lag_wide_read(steps->taken + lane) > zero, zero, moves);
        calls += LAG_WIDE_SELECT(t < lag_wide_read(s->due + lane), zero, moves);
        calls += LAG_WIDE_SELECT(lag_wide_read(steps->steps + lane) < lag_wide_read(s->glance + lane), zero, moves);
        calls += LAG_WIDE_SELECT(lag_wide_read(s->roots.suspect + lane) > zero, moves, zero);
        calls += LAG_WIDE_SELECT(lag_wide_read(s->conditions.suspect + lane) > zero, moves, zero);
    }
    return !lag_wide_is_some(calls);
}

/* A step in all lanes. Returns 0 when it was stopped. */
static int step(LagRunLanes *s)
{
    LagWideSteps *steps = s->steps;
    s->method->step(steps);
    if (s->batch->model->n_roots > 0)
        lag_wide_roots_look(&s->roots, steps);
    if (s->has_events)
        lag_wide_conditions_look(&s->conditions, &s->taylor);
    s->counts[LAG_LANES_ROOM] += LAG_ABREAST;
    s->counts[LAG_LANES_STEPS] += s->busy;
    for (int lane = is_quiet(s) ? LAG_ABREAST : 0; lane < LAG_ABREAST; ++lane) {
        if (s->job[lane] < 0)
            continue;
        int goes_on = 1;
        if (steps->taken[lane] > 0 && s->roots.suspect[lane] > 0) {
            goes_on = lag_lanes_end_run(s, lane, LAG_PAUSED);
        } else if (steps->taken[lane] > 0 && s->conditions.suspect[lane] > 0) {
            goes_on = lag_lanes_look(s, lane);
        } else if (steps->taken[lane] > 0) {
            if (steps->t[lane] >= s->due[lane] || steps->steps[lane] >= s->glance[lane])
                goes_on = lag_lanes_attend(s, lane);
        } else if (steps->in_vain[lane] > PATIENCE) {
            goes_on = lag_lanes_end_run(s, lane, LAG_PAUSED);
        }
        if (!goes_on)
            return 0;
    }
    return 1;
}

/* Whether runs come to the end of a segment before their own: by what they all have alike. */
static int are_cut(const LagRunLanes *s)
{
    return s->batch->model->n_modes > 0 || s->batch->held || s->batch->alone.run->inputs.rows > 2;
}

int64_t lag_lanes_advance(LagRunLanes *s, int64_t runs)
{
    int64_t first = 0;
    s->next = 0;
    s->runs = runs;
    share_inputs(s, !s->batch->held);
    s->taylor.is_cut = are_cut(s);
    s->done = calloc((size_t)runs + 1, sizeof *s->done);
    if (!s->done)
        return 0;
    while (lag_lanes_fill(s) && s->busy > 0 && !*s->batch->stop && step(s)) {
    }
    for (int lane = 0; lane < LAG_ABREAST; ++lane)
        lag_lanes_leave(s, lane);
    lag_lanes_conclude(s);
    while (first < runs && s->done[first])
        ++first;
    free(s->done);
    return first;
}
