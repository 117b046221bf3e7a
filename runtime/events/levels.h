/* Events on rates that are held: while friction or a contact holds a rate it is what it is held at, and not what rounding makes of it. */
#ifndef LAG_LEVELS_H
#define LAG_LEVELS_H

#include "events/impacts.h"

/* In on_level of the model, beside what it is there: nothing but rates is compared. */
enum { LAG_RATES_ALONE = 2 };

/* What slides has been chosen: into impacts.is_level, which events that are no contacts compare nothing but what is held; what they hold
 * from then on, until something else slides, is as their conditions say of that. Those that come by it: into switches.turned, and the
 * segment is over. */
void lag_levels_enter(LagRun *run);

/* Whether the event with condition i, which is true beyond its level alone, is on it where friction stops or turns round what it
 * compares: it comes a moment later, if that goes on. */
int lag_levels_wait(const LagRun *run, int i);

#endif
