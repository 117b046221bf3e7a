/* Where in the latest step a condition of a switch changes. */
#ifndef LAG_CROSSING_H
#define LAG_CROSSING_H

#include "state/state.h"

#define LAG_NOWHERE 2.0

/* What is looked at in each step, here and of motions in lanes: see crossing.c. */
#define LAG_CROSSING_SHALLOW 0.05
#define LAG_CROSSING_EARLY 0.38
#define LAG_CROSSING_LATE 0.73
#define LAG_CROSSING_ROUGH 0.02

/* The first place, as a share of the step, from which on one has changed; LAG_NOWHERE: there is none. switches.g_begin and .rate_begin
 * are known, and .g and .rate become those of the end where there is none. */
double lag_crossing_find(LagRun *run);

double lag_crossing_time(const LagRun *run, double share);

#endif
