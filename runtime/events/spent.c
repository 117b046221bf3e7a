/* The equations of an importer's step hold on to what slides until an event. Where an input jumps within the step that may ask for any
 * force: friction gives a share from 0 to 1, and what pushes does not pull. Conditions, by which the importer finds the event, say what
 * is asked for all the same.
 */
#include "events/spent.h"

#include <string.h>

#include "events/candidates.h"
#include "events/cones.h"
#include "events/pressed.h"
#include "events/sliding.h"
#include "numbers/extremes.h"

static const double NO_FORCE = 0.5; /* a share */

/* The share that there is, in the place of one that is asked for: components of friction in the plane are those of one force, and what is
 * pressed by a contact that would pull has none. */
static double limited(const LagRun *run, int k)
{
    const int i = run->sliding.which[k];
    const double share = *lag_share(run, i);
    if (!lag_may_have_all(run, i))
        return lag_max(0, share);
    if (lag_pressed_is_pulled(run, run->sliding.count, k))
        return NO_FORCE;
    return lag_cones_have(run, i) ? lag_cones_limited(run, i) : lag_max(0, lag_min(1, share));
}

void lag_spent_begin(LagRun *run)
{
    LagSliding *s = &run->sliding;
    const size_t count = (size_t)s->count;
    s->all = s->count;
    memcpy(s->which_all, s->which, count * sizeof *s->which);
    memcpy(s->of_all, s->unit, count * sizeof *s->unit);
    memcpy(s->of_all + s->most, s->noise, count * sizeof *s->noise);
}

/* What has a share that is not that which is asked for: components of a slip in the plane do together. */
static void find_spent(LagRun *run)
{
    LagSliding *s = &run->sliding;
    for (int k = 0; k < s->count; ++k)
        s->is_spent[k] = s->share_here[k] != *lag_share(run, s->which[k]);
    for (int k = 0; k < s->count; ++k) {
        const int partner = lag_candidates_place(s, s->count, lag_cones_partner(run, s->which[k]));
        if (s->is_spent[k] && partner >= 0)
            s->is_spent[partner] = 1;
    }
}

int lag_spent_reach(LagRun *run)
{
    LagSliding *s = &run->sliding;
    int left = 0;
    for (int k = 0; k < s->count; ++k)
        s->share_here[k] = limited(run, k);
    find_spent(run);
    for (int k = 0; k < s->count; ++k) {
        *lag_share(run, s->which[k]) = s->share_here[k];
        s->which[left] = s->which[k];
        s->unit[left] = s->unit[k];
        s->noise[left] = s->noise[k];
        left += !s->is_spent[k];
    }
    const int some = left < s->count;
    s->is_lost |= some; /* what is known is that of all of them */
    s->count = left;
    return some;
}

void lag_spent_end(LagRun *run)
{
    LagSliding *s = &run->sliding;
    const size_t count = (size_t)s->all;
    for (int k = 0; k < s->all; ++k)
        s->is_spent[k] = lag_candidates_place(s, s->count, s->which_all[k]) < 0;
    s->count = s->all;
    memcpy(s->which, s->which_all, count * sizeof *s->which);
    memcpy(s->unit, s->of_all, count * sizeof *s->unit);
    memcpy(s->noise, s->of_all + s->most, count * sizeof *s->noise);
}
