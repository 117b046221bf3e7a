/* Conditions in forces of which what they compare is equal, and stays so: nothing tells a side, and forces are what they say of that. */
#ifndef LAG_STANDING_H
#define LAG_STANDING_H

#include "model/model.h"
#include "state/settings.h"

/* In at_level of the model, what a switch holds where what it compares is and stays equal: either, as nothing jumps with it; 0, a half
 * or 1, twice that; or a half of whole numbers, which are what they are. held_switches.py has the same. */
enum { LAG_LEVEL_EITHER = -1, LAG_LEVEL_ZERO = 0, LAG_LEVEL_HALF = 1, LAG_LEVEL_ONE = 2, LAG_LEVEL_WHOLE = 3 };

/* What switch i holds where what it compares is equal: 0.5 where no force jumps with it. */
double lag_standing_value(const LagModel *model, int i);

/* What switch i holds where its condition is g, and nothing else is known. */
double lag_standing_alone(const LagModel *model, int i, double g);

/* What slides has been chosen: those into switches.stands; what they hold, as what goes away from there a moment later. Returns whether
 * some hold anything else than before. */
int lag_standing_find(LagRun *run);

/* Rates that stand are at rest, though nothing holds them. */
void lag_standing_rest(LagRun *run);

/* A step was taken, which may have made coordinates larger, and with them what rounding makes of conditions that stand while something
 * slides: into switches.unknown. */
void lag_standing_know(LagRun *run);

/* Whether something stands. */
int lag_standing_some(const LagRun *run);

/* Whether something does while something slides, which may hold it to its level. */
int lag_standing_is_held(const LagRun *run);

/* Whether switch i still stands, where conditions are switches.g and their rates switches.rate. */
int lag_standing_lasts(const LagRun *run, int i);

#endif
