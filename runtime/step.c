#include "step.h"

#include <float.h>
#include <math.h>

#include "account.h"
#include "extremes.h"
#include "rest.h"
#include "segment.h"

static const double FIRST_STEP = 1; /* towards no end */
static const double MOST_STEPS = 1e10; /* hours, of the smallest scenes */
enum { LOOK_FOR_PROGRESS = 1 << 17 };
enum { GLANCE = 16 }; /* strides from one look at the energies to the next */

double lag_step_smallest(double t) { return lag_max(4 * DBL_EPSILON * fabs(t), DBL_MIN); }

double lag_step_end(const LagRun *run, double h)
{
    const double t = run->motion.t, end = lag_min(run->segment_end, run->settings.t_stop);
    const int has_row = run->methods.table->ends_at_rows && run->wanted > t;
    const double limit = has_row ? lag_min(run->wanted, end) : end, left = limit - t;
    if (run->impacts.seen > t && h > run->impacts.seen - t)
        return lag_min(run->impacts.seen, limit);
    if (run->sliding.stops > t && h > run->sliding.stops - t)
        return lag_min(run->sliding.stops, limit);
    if (h >= left)
        return limit;
    return t + (2 * h > left ? left / 2 : h);
}

double lag_step_aim(const LagRun *run)
{
    const double t = run->motion.t, end = lag_min(run->segment_end, run->settings.t_stop);
    double target = run->wanted > t && run->wanted < end ? run->wanted : end;
    if (isinf(target))
        target = t + fmax(FIRST_STEP, fabs(t));
    return run->settings.max_step > 0 ? fmin(target, t + run->settings.max_step) : target;
}

/* The state reached. */
static void note_state(LagRun *run)
{
    if (lag_step_is_every(run, 1))
        lag_scale_note(&run->scale, run->motion.y);
    if (lag_step_is_every(run, GLANCE))
        lag_account_glance(run);
}

void lag_step_set_units(LagRun *run, double h)
{
    lag_scale_set_step(&run->scale, h, run->methods.solver == LAG_SOLVER_IMPLICIT && run->sliding.count == 0);
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
}

LagStatus lag_step_give_up(LagRun *run, int worst)
{
    const int n = run->model->n;
    run->careful = 0;
    return lag_fail(run, LAG_STEP_TOO_SMALL, worst < n ? worst : worst - n, worst >= n, 0);
}

LagStatus lag_step_no_progress(LagRun *run, int worst, double steps)
{
    const int n = run->model->n;
    return lag_fail(run, LAG_NO_PROGRESS, worst < n ? worst : worst - n, worst >= n, steps);
}

/* Now and then: whether the rest would take more steps, each like the latest ones, than anybody waits for. */
static LagStatus look_for_progress(LagRun *run)
{
    const double t = run->motion.t, stop = run->settings.t_stop, end = isfinite(stop) ? stop : run->wanted;
    const double steps = (end - t) / (t - run->paced) * LOOK_FOR_PROGRESS;
    run->paced = t;
    return run->settings.max_steps == 0 && steps > MOST_STEPS ? lag_step_no_progress(run, run->statistics.worst, steps) : LAG_OK;
}

LagStatus lag_step(LagRun *run)
{
    if (!lag_stiffness_turn(run))
        return lag_fail(run, LAG_NOT_FINITE, -1, 0, 0);
    lag_switches_resolve(run);
    if (run->segment_over) {
        const LagStatus status = lag_segment_next(run);
        if (status != LAG_OK)
            return status;
    }
    if (run->settings.max_steps > 0 && run->statistics.steps >= run->settings.max_steps)
        return lag_fail(run, LAG_TOO_MANY_STEPS, -1, 0, 0);
    if (lag_rest_begins(run))
        return lag_rest_step(run);
    LagStatus status = run->methods.table->step(run);
    if (status == LAG_OK)
        status = lag_roots_watch(run);
    if (status == LAG_OK) {
        if (run->orbit.is_open)
            lag_orbit_follow(run);
        lag_stiffness_watch(run);
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
