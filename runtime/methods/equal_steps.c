#include "methods/equal_steps.h"

#include <math.h>
#include <string.h>

#include "methods/explicit.h"
#include "state/state.h"
#include "steps/step.h"

enum { STEPS = 300, REST = 12, MOST_HALVINGS = 40 };
/* Equal steps that are too many if those of the trial are so much longer: near collisions they are a thousand times. */
static const double MANY = 1e6, UNEVEN = 1e4;
static const double SAME = 1e-9; /* lengths of steps that differ by less are equal */

LagTrial lag_trial(LagRun *run)
{
    LagMotion *m = &run->motion;
    const size_t size = (size_t)m->size * sizeof *m->y;
    const LagStatistics statistics = run->statistics;
    const LagMethod *table = run->methods.table;
    void *self = run->methods.self;
    const double t = m->t, step = run->step;
    LagTrial trial = {INFINITY, 0, 1, 0};
    memcpy(run->inside, m->y, size);
    run->methods.table = &lag_dop853;
    run->methods.self = &run->methods.dop853;
    lag_dop853.restart(&run->methods.dop853, m);
    for (int i = 0; i < STEPS && m->t < run->settings.t_stop; ++i) {
        if (lag_step_adaptive(run) != LAG_OK)
            break;
        trial.bends |= lag_roots_cross(run);
        if ((i >= REST || i == 0) && m->t < run->settings.t_stop)
            trial.shortest = i == REST ? m->t - m->t_old : fmin(trial.shortest, m->t - m->t_old);
    }
    trial.span = m->t - t;
    trial.steps = fmax(1, (double)(run->statistics.steps - statistics.steps));
    if (!isfinite(trial.shortest))
        trial.shortest = trial.span;
    memcpy(m->y, run->inside, size);
    memset(m->carry, 0, size);
    m->t = m->t_old = t;
    run->step = step;
    run->statistics = statistics;
    run->segment_over = 0;
    lag_roots_forget(run);
    run->methods.table = table;
    run->methods.self = self;
    return trial;
}

double lag_equal_length(const LagRun *run, double wish)
{
    const double left = run->settings.t_stop - run->motion.t;
    const double h = run->settings.max_step > 0 ? fmin(wish, run->settings.max_step) : wish;
    return isfinite(left) ? left / ceil(left / h * (1 - SAME)) : h;
}

int lag_equal_never_ends(const LagRun *run, const LagTrial *trial, double h, double *steps)
{
    const double left = run->settings.t_stop - run->motion.t, mean = trial->span / trial->steps;
    *steps = left / h;
    const int is_possible = h >= lag_step_smallest(isfinite(left) ? run->settings.t_stop : run->motion.t);
    return is_possible && run->settings.max_steps == 0 && *steps > MANY && mean > UNEVEN * h;
}

LagStatus lag_equal_step(LagRun *run, double *h, LagTry attempt)
{
    LagMotion *m = &run->motion;
    const double stop = run->settings.t_stop, shortest = lag_step_smallest(isfinite(stop) ? stop : m->t);
    for (int halvings = 0; halvings < MOST_HALVINGS && *h >= shortest; ++halvings) {
        const double t_new = lag_step_end(run, *h * (1 + SAME)), length = t_new - m->t;
        const int is_cut = !(fabs(length - *h) < SAME * *h * 10);
        m->t_old = m->t;
        if (attempt(run, is_cut ? length : *h, is_cut)) {
            lag_motion_take(m, is_cut || t_new == lag_step_end(run, INFINITY) ? t_new : m->t + *h);
            lag_step_record(run, length);
            return LAG_OK;
        }
        ++run->statistics.rejected;
        *h /= 2;
    }
    return lag_step_give_up(run, 0);
}
