#include "trial.h"

#include <math.h>
#include <string.h>

#include "explicit.h"
#include "state.h"
#include "step.h"

enum { STEPS = 300, REST = 12 };

LagTrial lag_trial(LagRun *run)
{
    LagMotion *m = &run->motion;
    const size_t size = (size_t)m->size * sizeof *m->y;
    const LagStatistics statistics = run->statistics;
    const LagMethod *table = run->methods.table;
    void *self = run->methods.self;
    const double t = m->t, step = run->step;
    LagTrial trial = {INFINITY, 0};
    memcpy(run->inside, m->y, size);
    run->methods.table = &lag_dop853;
    run->methods.self = &run->methods.dop853;
    lag_dop853.restart(&run->methods.dop853, m);
    for (int i = 0; i < STEPS && m->t < run->settings.t_stop; ++i) {
        if (lag_step_adaptive(run) != LAG_OK)
            break;
        if ((i >= REST || i == 0) && m->t < run->settings.t_stop)
            trial.shortest = i == REST ? m->t - m->t_old : fmin(trial.shortest, m->t - m->t_old);
    }
    trial.span = m->t - t;
    if (!isfinite(trial.shortest))
        trial.shortest = trial.span;
    memcpy(m->y, run->inside, size);
    memset(m->carry, 0, size);
    m->t = m->t_old = t;
    run->step = step;
    run->statistics = statistics;
    run->segment_over = 0;
    run->methods.table = table;
    run->methods.self = self;
    return trial;
}
