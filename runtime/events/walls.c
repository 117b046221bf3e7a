#include "events/walls.h"

#include <math.h>

#include "numbers/extremes.h"
#include "model/schedule.h"

static const double LEAST = 1e-14; /* m, or rad: rounding of what a gap is made of, where its parts are some 50 m or less */
static const double GONE = 64;     /* times what may be carried along: no drift */

/* How far the place of contact k may jump and carry along what rests there. Where all is at 0 nothing has a size, and the least jump,
 * by rounding of what the gap is made of, would be larger. */
static double carries(const LagRun *run, int k)
{
    const int i = lag_gap(run->model, k);
    return lag_max(lag_max(run->switches.unknown[i], run->sliding.error[i]), LEAST);
}

int lag_walls_have_moved(LagRun *run, int k, double gap)
{
    const int is_place = run->impacts.has_contact[k] == LAG_CONTACT;
    const int is_moved = is_place && fabs(gap - run->impacts.gap_before[k]) > carries(run, k);
    if (is_moved)
        run->switches.slides[lag_contact(run->model, k)] = 0;
    return is_moved;
}

void lag_walls_let_go(LagRun *run, int k)
{
    LagSwitches *s = &run->switches;
    const double gap = s->g[lag_gap(run->model, k)];
    int *slides = &s->slides[lag_contact(run->model, k)];
    if (!*slides || run->impacts.has_contact[k] != LAG_CONTACT || fabs(gap) <= GONE * carries(run, k))
        return;
    *slides = 0;
    if (gap > 0)
        s->turned[lag_when(run->model, k)] = LAG_JUMPS;
}
