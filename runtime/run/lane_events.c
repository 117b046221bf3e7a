#include "run/lane_events.h"

#include <string.h>

#include "events/conditions.h"
#include "numbers/extremes.h"
#include "state/account.h"
#include "state/ends.h"

int lag_lane_events_look(LagRun *run)
{
    LagMotion *m = &run->motion;
    LagSwitches *s = &run->switches;
    const double end = m->t, h = end - m->t_old;
    run->statistics.largest_step = lag_max(h, run->statistics.largest_step);
    run->segment_over = end == run->segment_end;
    memset(m->other_carry, 0, (size_t)m->size * sizeof *m->other_carry);
    lag_step_set_units(run, h);
    lag_conditions_with_rates(run, m->t_old, m->other, s->g, s->rate);
    lag_switches_watch(run);
    lag_account_weigh(run);
    return m->t < end || (run->segment_over && end < run->segment_end);
}
