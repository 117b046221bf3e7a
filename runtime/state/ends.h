/* Where steps end, and what their errors are measured by; and when there are none any more. */
#ifndef LAG_ENDS_H
#define LAG_ENDS_H

#include "state/settings.h"

/* Where a step of length h ends: the one place where steps are cut short. Two steps of equal length rather than a long
 * one and a tiny one lead up to a limit. */
double lag_step_end(const LagRun *run, double h);

/* The next row, event or stop: where a step ends that may have any length. */
double lag_step_aim(const LagRun *run);

/* Shorter steps do not move t. */
double lag_step_smallest(double t);

/* Errors are to be measured for steps of length h. */
void lag_step_set_units(LagRun *run, double h);

/* More steps than anybody waits for: component `worst` of (q, v) is to blame, -1: none. */
LagStatus lag_step_no_progress(LagRun *run, int worst, double steps);

/* No step is small enough: component `worst` of (q, v) is to blame. */
LagStatus lag_step_give_up(LagRun *run, int worst);

#endif
