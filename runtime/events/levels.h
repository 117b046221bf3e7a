/* Events on what is held: while friction or a contact holds a rate it is what it is held at, and its place is where it was; neither is what
 * rounding makes of it. */
#ifndef LAG_LEVELS_H
#define LAG_LEVELS_H

#include "events/impacts.h"

/* In on_level of the model: beside what it is there, nothing but rates is compared; nothing but places is; several things are that may be
 * held (edges.h), by their parts or as it is there. */
enum { LAG_RATES_ALONE = 2, LAG_PLACES_ALONE = -2, LAG_SEVERAL_BY_PARTS = -3, LAG_SEVERAL = 4 };

static inline int lag_compares_several(const LagModel *model, int k)
{
    return model->on_level[k] >= LAG_SEVERAL || model->on_level[k] == LAG_SEVERAL_BY_PARTS;
}

/* What slides has been chosen: into impacts.is_level, which events that are no contacts compare nothing but what is held; what they hold
 * from then on, until something else slides, is as their conditions say of that, where these compare rates, and what it was, where they
 * compare places. Those that come by it: into switches.turned, and the segment is over. */
void lag_levels_enter(LagRun *run);

/* Whether the event with condition i, which compares places, several things, or is true beyond its level alone, is on it where friction
 * stops, turns round or lets go what it compares: it comes a moment later, if that goes on. */
int lag_levels_wait(LagRun *run, int i);

/* Whether the condition g of event k is true amid a run as what it compares, rates alone, is on its very level, or waits there: it is not
 * held so before it comes. */
int lag_levels_meet(LagRun *run, int k, double g);

#endif
