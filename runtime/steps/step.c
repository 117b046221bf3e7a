#include "steps/step.h"

#include <math.h>

#include "state/account.h"
#include "state/attitudes.h"
#include "numbers/extremes.h"
#include "events/rest.h"
#include "steps/branch.h"
#include "steps/delays.h"
#include "steps/looks.h"
#include "steps/roots.h"
#include "steps/segment.h"
#include "steps/turns.h"

static const double MOST_STEPS = 1e10; /* hours, of the smallest scenes */
enum { LOOK_FOR_PROGRESS = 1 << 17 };
enum { GLANCE = 16 }; /* strides from one look at the energies to the next */

/* The state reached. */
static void note_state(LagRun *run)
{
    if (lag_step_is_every(run, 1)) {
        lag_scale_note(&run->scale, run->motion.y);
        if (run->model->n_multipliers > 0)
            lag_account_rise(run);
    }
    if (lag_step_is_every(run, GLANCE))
        lag_account_glance(run);
}

void lag_step_record(LagRun *run, double h)
{
    LagStatistics *s = &run->statistics;
    s->smallest_step = s->steps == 0 ? h : lag_min(h, s->smallest_step);
    s->largest_step = lag_max(h, s->largest_step);
    ++s->steps;
    ++s->steps_by[run->methods.solver];
    run->segment_over = run->motion.t == run->segment_end;
    if (run->model->n_switches == 0) /* else the end may lie beyond an event */
        note_state(run);
    lag_step_set_units(run, h);
    if (lag_roots_are_close(run, h)) /* there forces turn round within the step, and smaller parts of it matter */
        lag_scale_know_rates(&run->scale, 0);
}

/* Now and then: whether the rest would take more steps, each like the latest ones, than anybody waits for. */
static LagStatus look_for_progress(LagRun *run)
{
    const double t = run->motion.t, stop = run->settings.t_stop, end = isfinite(stop) ? stop : run->wanted;
    const double steps = (end - t) / (t - run->paced) * LOOK_FOR_PROGRESS;
    run->paced = t;
    return run->settings.max_steps == 0 && steps > MOST_STEPS ? lag_step_no_progress(run, run->statistics.worst, steps) : LAG_OK;
}

/* A segment, or a step in one. */
static LagStatus enter(LagRun *run)
{
    if (run->segment_over)
        return lag_segment_next(run);
    if (run->model->n_attitudes > 0)
        lag_attitudes_move(run);
    return lag_rest_stop(run) ? lag_segment_evaluate(run) : LAG_OK;
}

/* With the segments of events that come at once by what the one before holds. */
static LagStatus begin(LagRun *run)
{
    LagStatus status = enter(run);
    while (status == LAG_OK && run->impacts.comes_next)
        status = lag_segment_next(run);
    return status;
}

LagStatus lag_step(LagRun *run)
{
    if (!lag_turn(run))
        return lag_fail(run, LAG_NOT_FINITE, -1, 0, 0);
    lag_switches_resolve(run);
    if (run->model->n_delays > 0)
        lag_history_cut(&run->history, run->motion.t);
    LagStatus status = begin(run);
    if (status != LAG_OK)
        return status;
    if (run->settings.max_steps > 0 && run->statistics.steps >= run->settings.max_steps)
        return lag_fail(run, LAG_TOO_MANY_STEPS, -1, 0, 0);
    if (lag_rest_begins(run))
        return lag_rest_step(run);
    if (!lag_turn_creep(run))
        return lag_fail(run, LAG_NOT_FINITE, -1, 0, 0);
    status = run->methods.table->step(run);
    if (status == LAG_OK)
        status = lag_roots_watch(run);
    if (status == LAG_OK)
        status = lag_looks_watch(run);
    if (status == LAG_OK && run->model->n_delays > 0)
        status = lag_delays_note(run);
    if (status == LAG_OK && run->model->n_multipliers > 0)
        lag_branch_watch(run);
    if (status == LAG_OK) {
        if (run->orbit.is_open)
            lag_orbit_follow(run);
        run->choice.watch(run);
        if (run->model->n_switches > 0) {
            lag_switches_watch(run);
            lag_account_weigh(run);
            note_state(run);
        }
        if (run->statistics.steps > 0 && run->statistics.steps % LOOK_FOR_PROGRESS == 0) /* the first one may be taken back */
            return look_for_progress(run);
    }
    return status;
}
