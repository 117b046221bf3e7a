#include "state/ends.h"

#include <float.h>
#include <math.h>

#include "numbers/extremes.h"
#include "state/state.h"

static const double FIRST_STEP = 1; /* towards no end */

double lag_step_smallest(double t) { return lag_max(4 * DBL_EPSILON * fabs(t), DBL_MIN); }

double lag_step_end(const LagRun *run, double h)
{
    const double t = run->motion.t, end = lag_min(run->segment_end, run->settings.t_stop);
    const int has_row = run->methods.table->ends_at_rows && run->wanted > t;
    const double limit = has_row ? lag_min(run->wanted, end) : end, left = limit - t;
    h = lag_min(h, run->history.shortest); /* what is read late is known then */
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

void lag_step_set_units(LagRun *run, double h)
{
    lag_scale_set_step(&run->scale, h, run->methods.solver == LAG_SOLVER_IMPLICIT && run->sliding.count == 0);
    if (run->sliding.known_error < INFINITY)
        lag_scale_know_rates(&run->scale, run->sliding.known_error);
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
