/* Where in the latest step a condition of a switch changes. */
#ifndef LAG_CROSSING_H
#define LAG_CROSSING_H

#include "state/state.h"

#define LAG_NOWHERE 2.0

/* The first place, as a share of the step, from which on one has changed; LAG_NOWHERE: there is none. switches.g_begin and .rate_begin
 * are known, and .g and .rate become those of the end where there is none. */
double lag_crossing_find(LagRun *run);

double lag_crossing_time(const LagRun *run, double share);

#endif
