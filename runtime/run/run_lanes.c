#include "run/run_lanes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "methods/taylor.h"
#include "methods/wide_explicit.h"
#include "methods/wide_roots.h"
#include "methods/wide_taylor.h"
#include "numbers/extremes.h"
#include "run/advance.h"
#include "state/account.h"
#include "state/ends.h"
#include "state/state.h"
#include "steps/segment.h"

/* Steps that a run makes before it goes into a lane, at most: they set in motion what rests. Steps that are no good in a row,
 * after which shorter ones do not help. */
enum { MOST_FIRST = 3, PATIENCE = 4 };
/* Steps to the first glance at energies, which costs as much as one and a half steps in a lane, and from one to the next at most; from
 * one look at stability, which costs as much as 20, to the next, and the same while it seems to rule; looks in a row after which it
 * does. */
enum { GLANCE = 16, MOST_GLANCE = 64, LOOK = 256, CLOSE_LOOK = 16, LOOKS = 4 };
enum { LOOK_FOR_PROGRESS = 1 << 17 };
static const double MOST_STEPS = 1e10; /* as in step.c */
static const double MOST_TOLERANCE = 2e-4; /* of Verner's pair, as in choice.c */
static const double CAREFUL = 16; /* by which iterated collocation errs less than Runge-Kutta pairs at the same tolerance */

struct LagRunLanes {
    LagBatch *batch;
    void *block;
    const LagWideMethod *method;
    LagWideSteps *steps;
    LagWideTaylor taylor;
    LagWideExplicit explicit;
    LagWideRoots roots;
    int starts_again; /* runs start as lag_run_start_again does, where it serves */
    int may_turn;  /* others go on where stability rules */
    int are_shared; /* inputs */
    int is_guarded; /* each step is looked at */
    int opened;    /* lanes whose follower and run are there */
    LagFollower follower[LAG_ABREAST];
    int64_t job[LAG_ABREAST]; /* the run in each lane; -1: none */
    int busy;                 /* how many there are */
    double due[LAG_ABREAST];  /* when something is to be looked at */
    double glance[LAG_ABREAST]; /* after so many steps, too */
    int64_t look[LAG_ABREAST];
    int64_t next, runs;  /* of the present call: the run to be started next, and how many there are */
    uint8_t *done;       /* of each run */
    int64_t counts[LAG_LANES_COUNTS];
};

static LagRun *run_in(const LagRunLanes *s, int lane) { return s->follower[lane].run; }

/* -------- whether lanes serve */

static int is_asked(const LagSettings *settings)
{
    const int32_t solver = settings->solver;
    return (solver == LAG_SOLVER_AUTO || solver == LAG_SOLVER_STEPWISE || solver == LAG_SOLVER_TAYLOR) && settings->max_steps == 0;
}

/* What swings back the way it came is read from steps that are kept, which takes no time. */
static int fits(const LagModel *model, const LagSettings *settings)
{
    if (settings->solver == LAG_SOLVER_TAYLOR)
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
    if (model->n_attitudes > 0)
        return 0;
    for (int i = 0; i < sweep->n_reductions; ++i) {
        const LagReduction *what = &sweep->reductions[i];
        if (what->kind != LAG_REDUCE_AT && (what->column > 2 * model->n || what->rate > 2 * model->n))
            return 0;
    }
    return 1;
}

/* -------- birth and death */

/* By series where equations are short, in space where series serve a run alone; else by a Runge-Kutta pair: where somebody looks inside steps, by that which has dense output. */
static int choose(LagRunLanes *s, const LagModel *model, const LagSettings *settings)
{
    const LagBatch *batch = s->batch;
    s->steps = &s->taylor.lanes;
    s->method = &lag_wide_taylor;
    const int32_t alone = lag_run_solver(model, settings, NULL);
    const int is_long = model->n_attitudes > 0 && alone != LAG_SOLVER_TAYLOR && lag_wide_explicit_serves(model);
    if (!is_long && lag_wide_taylor_serves(model))
        return 1;
    s->steps = &s->explicit.lanes;
    const int is_looked_into = batch->n_at < batch->sweep.n_reductions || s->is_guarded;
    s->method = is_looked_into || settings->tolerance > MOST_TOLERANCE ? &lag_wide_dop853 : &lag_wide_verner9;
    s->explicit.caution = alone == LAG_SOLVER_PIRK ? CAREFUL : 1;
    return settings->solver != LAG_SOLVER_TAYLOR && lag_wide_explicit_serves(model);
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
    if (settings->solver == LAG_SOLVER_TAYLOR)
        lag_taylor_plan_for_eight(&run->methods.taylor, batch->model, run->scale.tolerance);
    if (!lag_follow_new(f, batch->model, run, &batch->sweep, batch->at, batch->n_at))
        return 0;
    f->window.is_plain = is_plain(batch->model, &batch->sweep);
    f->is_led = f->window.is_led = 1;
    return 1;
}

static int open(LagRunLanes *s, const LagSettings *settings)
{
    LagArena arena = {NULL, 0};
    while (s->opened < LAG_ABREAST)
        if (!open_lane(s, settings))
            return 0;
    const LagRun *like = run_in(s, 0);
    s->method->layout(s->steps, like, &arena);
    lag_wide_roots_layout(&s->roots, like->model, &arena);
    s->block = calloc(arena.used + LAG_CACHE_LINE, sizeof(double));
    if (!s->block)
        return 0;
    arena.base = lag_at_cache_line(s->block);
    arena.used = 0;
    s->method->layout(s->steps, like, &arena);
    lag_wide_roots_layout(&s->roots, like->model, &arena);
    s->steps->solver = s->method->solver;
    return 1;
}

LagRunLanes *lag_lanes_new(LagBatch *batch)
{
    const LagModel *model = batch->model;
    LagSettings settings = batch->alone.run->settings;
    const int is_wanted = batch->sweep.in_lanes && is_asked(&settings) && takes_one_run(&batch->sweep);
    if (!is_wanted || !fits(model, &settings) || !lag_wide_roots_serve(model))
        return NULL;
    LagRunLanes *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->batch = batch;
    s->is_guarded = lag_guards_watch_motion(model);
    const int is_served = choose(s, model, &settings);
    s->may_turn = lag_methods_turn(&settings) && lag_methods_alternate(model, s->method->solver);
    s->starts_again = lag_run_starts_again(model);
    settings.solver = s->method->solver;
    if (s->method == &lag_wide_taylor && settings.first_step == 0)
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
        LagInputs *to = &run_in(s, lane)->inputs;
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
        lag_run_free(run_in(s, lane));
        lag_follow_free(&s->follower[lane]);
    }
    free(s->block);
    free(s);
}

const int64_t *lag_lanes_counts(const LagRunLanes *s) { return s->counts; }

/* -------- a run comes and goes */

/* Returns 0 when it was stopped. */
static int make_alone(LagRunLanes *s, int64_t i)
{
    ++s->counts[LAG_LANES_ALONE];
    s->done[i] = (uint8_t)lag_batch_alone(s->batch, i);
    return s->done[i];
}

static void leave(LagRunLanes *s, int lane)
{
    s->busy -= s->job[lane] >= 0;
    s->job[lane] = -1;
    s->steps->moves[lane] = 0;
}

/* The run in the lane is over. What is not well is made again, and told as it then is. */
static int end_run(LagRunLanes *s, int lane, LagStatus status)
{
    const int64_t i = s->job[lane];
    LagFollower *f = &s->follower[lane];
    leave(s, lane);
    if (status == LAG_OK)
        status = lag_follow_end(f);
    if (status != LAG_OK)
        return make_alone(s, i);
    lag_batch_conclude(s->batch, f, i, status);
    if (s->batch->outcomes[i].kind != LAG_RUN_DONE)
        return make_alone(s, i);
    ++s->counts[LAG_LANES_RUNS];
    s->done[i] = 1;
    return 1;
}

static void set_due(LagRunLanes *s, int lane)
{
    const LagFollower *f = &s->follower[lane];
    if (s->method->ends_at_rows)
        s->steps->stop[lane] = lag_min(f->next, lag_min(f->run->segment_end, f->run->settings.t_stop));
    s->due[lane] = f->n_pending > 0 || s->is_guarded ? -INFINITY : lag_min(f->next, s->steps->stop[lane]);
}

/* Other inputs are in force from the present time of the lane on, or other modes. */
static LagStatus enter_segment(LagRunLanes *s, int lane)
{
    LagFollower *f = &s->follower[lane];
    LagRun *run = f->run;
    LagStatus status = LAG_OK;
    if (run->model->n_modes > 0)
        status = lag_segment_next(run);
    else if (run->inputs.rows > 1)
        lag_segment_enter(run);
    run->segment_over = 0;
    if (status != LAG_OK)
        return status;
    s->method->enter(s->steps, lane, run);
    lag_wide_roots_enter(&s->roots, lane, run);
    return f->n_pending > 0 ? lag_follow_enter(f, run->motion.t) : LAG_OK;
}

/* The run that was put into the lane goes on there. */
static int settle_in(LagRunLanes *s, int lane)
{
    LagRun *run = run_in(s, lane);
    const int is_over = run->segment_over || lag_run_time(run) >= s->steps->stop[lane];
    lag_wide_roots_enter(&s->roots, lane, run);
    const LagStatus status = is_over ? enter_segment(s, lane) : LAG_OK;
    s->glance[lane] = (double)(run->statistics.steps + GLANCE);
    s->look[lane] = LOOK;
    set_due(s, lane);
    return status == LAG_OK ? 1 : end_run(s, lane, status);
}

/* The first steps of a run, until a lane can take it, or it is over: then there is nothing in the lane. */
static int begin_run(LagRunLanes *s, int lane, int64_t i)
{
    LagFollower *f = &s->follower[lane];
    LagRun *run = f->run;
    LagStatus status = lag_batch_begin(s->batch, f, i);
    if (s->batch->outcomes[i].kind == LAG_RUN_PARAMETER) {
        lag_batch_conclude(s->batch, f, i, status);
        s->done[i] = 1;
        return 1;
    }
    s->job[lane] = i;
    ++s->busy;
    status = status == LAG_OK ? lag_follow_begin(f) : status;
    f->starts_again = s->starts_again && status == LAG_OK;
    for (int k = 0; status == LAG_OK; ++k) {
        if (lag_run_time(run) >= s->batch->sweep.t_stop)
            return end_run(s, lane, status);
        if (run->guards.broken)
            break;
        if (s->method->load(s->steps, lane, run))
            return settle_in(s, lane);
        if (k == MOST_FIRST)
            break;
        const int is_watched = f->n_pending > 0;
        f->starts_again = 0;
        status = is_watched ? lag_follow_step(f) : lag_advance_step(run);
        if (status == LAG_OK && !is_watched)
            status = lag_follow_visit(f, lag_run_time(run));
    }
    leave(s, lane);
    return make_alone(s, i);
}

/* -------- in between */

/* Whether what choice.c would pass on to implicit steps, nobody waits for, or asks for stricter steps, as all lanes have one tolerance, is
 * better made alone. */
static int is_unfit(LagRunLanes *s, int lane)
{
    LagRun *run = run_in(s, lane);
    const int64_t steps = run->statistics.steps;
    if (run->scale.tolerance < run->scale.asked)
        return 1;
    if (steps < s->look[lane])
        return 0;
    const double t = run->motion.t, done = t - s->batch->sweep.t_start;
    s->follower[lane].starts_again = 0;
    const int looks = s->may_turn ? lag_stiffness_look(run, s->steps->length[lane]) : 0;
    s->look[lane] = steps + (looks > 0 ? CLOSE_LOOK : LOOK);
    return looks >= LOOKS
        || (steps > LOOK_FOR_PROGRESS && (s->batch->sweep.t_stop - t) / done * (double)steps > MOST_STEPS);
}

/* After how many steps the next glance comes: twice as many as there were, where these are few, and for the next look at stability. */
static double next_glance(const LagRunLanes *s, int lane)
{
    const double steps = s->steps->steps[lane];
    return lag_min(lag_min(2 * steps, steps + MOST_GLANCE), (double)s->look[lane]);
}

/* The end of the step as a row: that of coordinates and rates alone where nothing else is asked for, without energies but now and then
 * where these are not. */
static LagStatus end_row(LagRunLanes *s, int lane, int glances)
{
    LagFollower *f = &s->follower[lane];
    LagRun *run = f->run;
    f->window.end_time = run->motion.t;
    if (!f->window.is_plain && (glances || f->window.has_energies))
        return lag_run_row(run, f->window.end);
    if (!f->window.is_plain)
        return lag_advance_motion_row(run, run->motion.t, f->window.end);
    f->window.end[0] = run->motion.t;
    memcpy(f->window.end + 1, run->motion.y, 2 * (size_t)s->steps->n * sizeof *run->motion.y);
    return LAG_OK;
}

static LagStatus watch(LagRunLanes *s, int lane, LagShown shown, int glances)
{
    LagFollower *f = &s->follower[lane];
    LagStatus status = end_row(s, lane, glances);
    if (status != LAG_OK)
        return status;
    const int open = lag_follow_glance(f);
    if (open && shown < LAG_SHOWN_DENSE)
        s->method->show(s->steps, lane, f->run, LAG_SHOWN_DENSE);
    f->starts_again &= !open;
    return lag_follow_watch(f, open);
}

/* After a step in the lane. Returns 0 when the batch was stopped. */
static int attend(LagRunLanes *s, int lane)
{
    LagFollower *f = &s->follower[lane];
    const double t = s->steps->t[lane];
    const int glances = s->steps->steps[lane] >= s->glance[lane], is_over = t >= s->batch->sweep.t_stop;
    const int has_event = !is_over && t >= s->steps->stop[lane];
    const int is_dense = s->is_guarded || t > f->next || (has_event && s->batch->model->n_modes > 0);
    const LagShown shown = is_dense ? LAG_SHOWN_DENSE : glances || is_over ? LAG_SHOWN_STEP : LAG_SHOWN_STATE;
    LagStatus status = LAG_OK;
    s->method->show(s->steps, lane, f->run, shown);
    f->starts_again &= shown < LAG_SHOWN_DENSE;
    if (s->is_guarded)
        lag_guards_watch(f->run);
    if (f->run->guards.broken)
        return end_run(s, lane, LAG_PAUSED);
    if (glances) {
        lag_account_glance(f->run);
        if (lag_follow_is_over(f) || is_unfit(s, lane))
            return end_run(s, lane, LAG_PAUSED);
        s->glance[lane] = next_glance(s, lane);
    }
    if (t >= f->next)
        status = lag_follow_visit(f, t);
    if (status == LAG_OK && f->n_pending > 0)
        status = watch(s, lane, shown, glances);
    if (status != LAG_OK || is_over)
        return end_run(s, lane, status);
    if (has_event && (status = enter_segment(s, lane)) != LAG_OK)
        return end_run(s, lane, status);
    set_due(s, lane);
    return 1;
}

/* -------- all of them */

/* Returns 0 when it was stopped. */
static int fill(LagRunLanes *s)
{
    for (int lane = s->busy == LAG_ABREAST ? LAG_ABREAST : 0; lane < LAG_ABREAST; ++lane)
        while (s->job[lane] < 0 && s->next < s->runs)
            if (*s->batch->stop || !begin_run(s, lane, s->next++))
                return 0;
    return 1;
}

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
    s->counts[LAG_LANES_ROOM] += LAG_ABREAST;
    s->counts[LAG_LANES_STEPS] += s->busy;
    for (int lane = is_quiet(s) ? LAG_ABREAST : 0; lane < LAG_ABREAST; ++lane) {
        if (s->job[lane] < 0)
            continue;
        int goes_on = 1;
        if (steps->taken[lane] > 0 && s->roots.suspect[lane] > 0) {
            goes_on = end_run(s, lane, LAG_PAUSED);
        } else if (steps->taken[lane] > 0) {
            if (steps->t[lane] >= s->due[lane] || steps->steps[lane] >= s->glance[lane])
                goes_on = attend(s, lane);
        } else if (steps->in_vain[lane] > PATIENCE) {
            goes_on = end_run(s, lane, LAG_PAUSED);
        }
        if (!goes_on)
            return 0;
    }
    return 1;
}

int64_t lag_lanes_advance(LagRunLanes *s, int64_t runs)
{
    int64_t first = 0;
    s->next = 0;
    s->runs = runs;
    share_inputs(s, !s->batch->held);
    s->done = calloc((size_t)runs + 1, sizeof *s->done);
    if (!s->done)
        return 0;
    while (fill(s) && s->busy > 0 && !*s->batch->stop && step(s)) {
    }
    for (int lane = 0; lane < LAG_ABREAST; ++lane)
        leave(s, lane);
    while (first < runs && s->done[first])
        ++first;
    free(s->done);
    return first;
}
