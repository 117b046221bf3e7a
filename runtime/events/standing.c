#include "events/standing.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "events/sliding.h"
#include "events/switches.h"
#include "numbers/extremes.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double OF_SINE = 1e-12; /* of pi times a number that is whole */
static const double MOMENT = 1e-3, SOME_TIME = 1e-6; /* of a step; s, where no step tells of one */

double lag_standing_value(const LagModel *model, int i)
{
    const int level = i < lag_when(model, 0) ? model->at_level[i] : LAG_LEVEL_EITHER;
    return level == LAG_LEVEL_EITHER || level == LAG_LEVEL_WHOLE ? 0.5 : 0.5 * level;
}

/* What is held has no rate but rounding. */
static int is_still(const LagRun *run, int i, double rate)
{
    return fabs(rate) <= (run->sliding.count > 0 ? run->switches.unknown[i] : 0);
}

static int is_candidate(const LagRun *run, int i)
{
    const LagSwitches *s = &run->switches;
    const int level = run->model->at_level[i];
    const double known = level == LAG_LEVEL_WHOLE ? lag_max(OF_SINE, s->unknown[i]) : s->unknown[i];
    return level != LAG_LEVEL_EITHER && !s->slides[i] && !s->is_idle[i] && fabs(s->g[i]) <= known;
}

/* The rates of all conditions a moment later, into switches.rate_inside. */
static void look_ahead(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    const int n = m->n;
    const double moment = lag_min(run->step > 0 ? MOMENT * run->step : SOME_TIME, MOMENT * (run->segment_end - m->t));
    double *a = s->slope + n;
    lag_motion_slope(&run->motion, m->t + moment, m->y, m->y + n, s->slope);
    for (int i = 0; i < n; ++i) {
        a[i] = fabs(a[i]) <= run->scale.noise[i] ? 0 : a[i];
        s->state[i] = m->y[i] + moment * (m->y[n + i] + moment * a[i] / 2);
        s->state[n + i] = m->y[n + i] + moment * a[i];
    }
    lag_conditions_by(run, m->t + moment, s->state, s->state + n, a, s->g_inside, s->rate_inside);
}

int lag_standing_find(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const int first = lag_when(run->model, 0);
    int some = 0, changes = 0;
    memset(s->stands, 0, (size_t)run->model->n_switches * sizeof *s->stands);
    for (int i = 0; i < first && !s->is_live; ++i)
        some |= s->stands[i] = is_candidate(run, i) && is_still(run, i, s->rate[i]);
    if (some)
        look_ahead(run);
    for (int i = 0; i < first && some; ++i) {
        if (!s->stands[i])
            continue;
        s->stands[i] = is_still(run, i, s->rate_inside[i]);
        const double held = s->stands[i] ? lag_standing_value(run->model, i) : s->rate_inside[i] > 0;
        changes |= held != s->held[i];
        s->held[i] = held;
        if (s->stands[i])
            s->unknown[i] = lag_max(fabs(s->g[i]), s->unknown[i]);
    }
    if (changes)
        lag_switches_recall(run);
    return changes;
}

int lag_standing_lasts(const LagRun *run, int i)
{
    const LagSwitches *s = &run->switches;
    return s->stands[i] && is_candidate(run, i) && is_still(run, i, s->rate[i]);
}
