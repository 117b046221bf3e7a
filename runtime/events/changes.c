#include "events/changes.h"

#include <float.h>

#include "events/conditions.h"
#include "events/levels.h"
#include "events/sliding.h"
#include "events/standing.h"
#include "numbers/extremes.h"
#include "state/state.h"

static const double END_OF_SHARE = 64 * DBL_EPSILON;

/* Whether an event comes here, where switches.rate tells which way its condition goes; `after`: conditions behind the place that was found,
 * or NULL. What has been put where constraints hold there may be a rounding before it: it came a moment later, as another event. */
static int has_come(LagRun *run, int i, double depth, const double *after)
{
    const LagSwitches *s = &run->switches;
    const double slack = lag_slack(run->model, &run->impacts, i);
    const int is_found = after && lag_depth(s, i, after) < 0 && !run->impacts.has_contact[i - lag_when(run->model, 0)];
    const int goes_on = depth <= (is_found ? s->unknown[i] : -slack) && lag_depth(s, i, s->rate) < 0;
    return (depth < -lag_max(s->unknown[i], slack) || goes_on) && !lag_levels_wait(run, i);
}

int lag_changes_note(LagRun *run, const double *after)
{
    LagSwitches *s = &run->switches;
    int first = -1;
    if (run->model->n_whens > 0)
        lag_conditions_with_rates(run, run->motion.t, run->motion.y, s->g, s->rate);
    else
        lag_conditions(run, run->motion.t, run->motion.y, s->g, s->rate);
    for (int i = 0; i < run->model->n_switches; ++i) {
        const double depth = lag_depth(s, i, s->g);
        const int is_at_end = !s->is_idle[i] && depth <= (s->slides[i] ? END_OF_SHARE : 0) && !lag_standing_lasts(run, i);
        const int changes = lag_is_event(run->model, i) ? has_come(run, i, depth, after) : is_at_end;
        const int has_more = lag_may_have_all(run, i) && *lag_share(run, i) > 0.5;
        s->turned[i] = !changes ? LAG_STAYS : !s->slides[i] ? LAG_CHANGES : has_more ? LAG_TO_1 : LAG_TO_0;
        first = first < 0 && changes ? i : first;
    }
    return first;
}

int lag_changes_come(const LagRun *run)
{
    for (int i = lag_when(run->model, 0); i < run->model->n_switches; ++i)
        if (run->switches.turned[i])
            return 1;
    return 0;
}
