/* Accelerations of what is held are differences of equal forces: rounding is left of them, and makes a motion of its own, which grows
 * with the square of time (a block that sticks on a slope had crept for 0.6 mm after 12 days). A coordinate that has no rate but
 * rounding, and is given none but that, is said to rest.
 */
#include "events/rest.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/standing.h"
#include "state/ends.h"
#include "numbers/extremes.h"
#include "state/state.h"

static const double ROUNDING = 4096 * DBL_EPSILON; /* of the largest rate so far: what stops is not known better */

static double slowest(const LagRun *run, int i) { return ROUNDING * run->scale.largest[run->model->n + i]; }

/* Of acceleration i, what is rounding where something is held, or stands. */
static double noise_of(const LagRun *run, int i) { return run->switches.calms ? run->switches.noise[i] : run->scale.noise[i]; }

/* Whether something is held, and no load changes with time: else steps are no longer than that, and rounding does not grow in them. */
static int is_held(LagRun *run)
{
    if (run->sliding.count == 0 || !run->model->is_steady)
        return 0;
    lag_inputs_slope(&run->inputs, run->u_slope);
    for (int i = 0; i < run->model->n_inputs; ++i)
        if (run->u_slope[i] != 0)
            return 0;
    return 1;
}

/* Whether no coordinate that rests, as `state` says, is accelerated by more than rounding. */
static int is_balanced(LagRun *run, const double *state)
{
    const int n = run->model->n;
    const double *a = run->switches.slope + n;
    if (!lag_motion_slope(&run->motion, run->motion.t, state, state + n, run->switches.slope))
        return 0;
    for (int i = 0; i < n; ++i)
        if (!(fabs(a[i]) <= run->scale.noise[i]))
            return 0;
    return 1;
}

/* The present state without the rates that are less than errors allowed, and end within a way that is less; returns how many these are. */
static int without_ending(LagRun *run, double *state)
{
    const LagMotion *m = &run->motion;
    const int n = m->n;
    const double *a = run->switches.slope + n;
    int count = 0;
    for (int i = 0; i < n && count == 0; ++i)
        count += m->y[n + i] != 0 && fabs(m->y[n + i]) <= lag_scale_unit(&run->scale, n + i, m->y, m->y);
    if (count == 0 || !lag_motion_slope(&run->motion, m->t, m->y, m->y + n, run->switches.slope))
        return 0;
    memcpy(state, m->y, 2 * (size_t)n * sizeof *state);
    count = 0;
    for (int i = 0; i < n; ++i) {
        const double v = m->y[n + i], rate = lag_scale_unit(&run->scale, n + i, m->y, m->y);
        const double way = lag_scale_unit(&run->scale, i, m->y, m->y);
        if (!(fabs(v) <= rate && v * a[i] < 0 && v * v <= fabs(a[i]) * way))
            continue;
        state[n + i] = 0;
        ++count;
    }
    return count;
}

int lag_rest_stop(LagRun *run)
{
    LagMotion *m = &run->motion;
    const int n = m->n, least = run->model->n_multipliers > 0 ? n : 1; /* ties may hold rates together */
    double *state = run->switches.state, *a = run->switches.slope + n;
    if (run->model->n_switches == 0 || run->sliding.count > 0 || !run->started || without_ending(run, state) < least)
        return 0;
    if (!lag_motion_slope(m, m->t, state, state + n, run->switches.slope))
        return 0;
    int count = 0;
    for (int i = 0; i < n; ++i)
        if (m->y[n + i] != state[n + i] && fabs(a[i]) <= run->scale.noise[i])
            ++count;
        else
            state[n + i] = m->y[n + i];
    if (count < least)
        return 0;
    for (int i = 0; i < n; ++i)
        if (m->y[n + i] != state[n + i])
            m->y[n + i] = m->carry[n + i] = 0;
    return 1;
}

int lag_rest_begins(LagRun *run)
{
    LagMotion *m = &run->motion;
    const int n = m->n;
    const size_t size = (size_t)n * sizeof *m->y;
    run->rests = 0;
    if (!is_held(run))
        return 0;
    for (int i = 0; i < n; ++i)
        if (!(fabs(m->y[n + i]) <= slowest(run, i)))
            return 0;
    memcpy(run->sliding.state_here, m->y, size);
    memset(run->sliding.state_here + n, 0, size);
    if (!is_balanced(run, run->sliding.state_here))
        return 0;
    memset(m->y + n, 0, size);
    memset(m->carry + n, 0, size);
    run->rests = 1;
    return 1;
}

LagStatus lag_rest_step(LagRun *run)
{
    LagMotion *m = &run->motion;
    const double end = lag_min(run->segment_end, run->settings.t_stop);
    m->t_old = m->t;
    m->t = m->t_end = isinf(end) ? lag_step_aim(run) : end;
    memcpy(m->other, m->y, (size_t)m->size * sizeof *m->y);
    run->segment_over = m->t == run->segment_end;
    ++run->statistics.steps;
    return LAG_OK;
}

void lag_rest_note(LagRun *run)
{
    LagMotion *m = &run->motion;
    LagSwitches *s = &run->switches;
    const int may_hold = run->model->switches_need_acceleration; /* then it is looked at while something is held */
    s->calms = !may_hold && !s->is_live && lag_standing_some(run);
    const int n = may_hold || s->calms ? m->n : 0, may_rest = s->calms || is_held(run);
    for (int i = 0; i < n; ++i) {
        double *v = &m->y[n + i], *a = &m->slope[n + i];
        int *still = &run->sliding.still[i];
        *still = may_rest && fabs(*v) <= slowest(run, i) && fabs(*a) <= noise_of(run, i);
        if (*still)
            *v = m->carry[n + i] = m->slope[i] = *a = 0;
    }
}

void lag_rest_calm(const LagRun *run, const double *v, double *a)
{
    for (int i = 0; i < run->model->n; ++i)
        if (run->sliding.still[i] && fabs(v[i]) <= slowest(run, i) && fabs(a[i]) <= noise_of(run, i))
            a[i] = 0;
}
