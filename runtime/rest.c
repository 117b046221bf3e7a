/* Accelerations of what is held are differences of equal forces: rounding is left of them, and makes a motion of its own, which grows
 * with the square of time (a block that sticks on a slope had crept for 0.6 mm after 12 days). A coordinate that has no rate but
 * rounding, and is given none but that, is said to rest.
 */
#include "rest.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "advance.h"
#include "evaluate.h"
#include "extremes.h"
#include "state.h"
#include "step.h"

static const double ROUNDING = 4096 * DBL_EPSILON; /* of the largest rate so far: what stops is not known better */

static double slowest(const LagRun *run, int i) { return ROUNDING * run->scale.largest[run->model->n + i]; }

static int inputs_stay(LagRun *run)
{
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

int lag_rest_begins(LagRun *run)
{
    LagMotion *m = &run->motion;
    const int n = m->n;
    const size_t size = (size_t)n * sizeof *m->y;
    run->rests = 0;
    if (run->sliding.count == 0 || !run->model->is_steady)
        return 0;
    for (int i = 0; i < n; ++i)
        if (!(fabs(m->y[n + i]) <= slowest(run, i)))
            return 0;
    memcpy(run->sliding.state_here, m->y, size);
    memset(run->sliding.state_here + n, 0, size);
    if (!inputs_stay(run) || !is_balanced(run, run->sliding.state_here))
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

void lag_rest_keep(LagRun *run)
{
    LagMotion *m = &run->motion;
    const int n = m->n;
    const double h = fabs(run->step);
    for (int i = 0; i < n && run->sliding.count > 0; ++i) {
        const double slow = slowest(run, i), pace = slow + h * run->scale.noise[i];
        const double moved = fabs(m->other[i] - m->y[i]), before = fabs(m->y[n + i]), after = fabs(m->other[n + i]);
        if (run->scale.noise[i] > 0 && before <= slow && after <= pace && moved <= h * pace) {
            m->other[i] = m->y[i];
            m->other_carry[i] = m->carry[i];
            m->other[n + i] = m->other_carry[n + i] = 0;
        }
    }
}
