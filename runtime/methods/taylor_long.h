/* Taylor steps of a long state: what taylor.c does for each coordinate, here for LAG_LANES of them at a time. The coefficients of
 * an order lie side by side; accelerations are not kept, they are the first coefficients of the rates.
 */
#ifndef LAG_TAYLOR_LONG_H
#define LAG_TAYLOR_LONG_H

#include "state/state.h"

/* step[2 n]: what a step of length h adds to the state; slope[2 n + 2 LAG_LANES]: first the slope of the rates at its end. */
void lag_long_displacement(const LagModel *model, const double *jets, int order, double h, double *step, double *slope);

/* Raises *last and *before to the largest of the last coefficients and of those before, in units. */
void lag_long_weigh(LagRun *run, const double *end, double *last, double *before);

/* How far the accelerations at the end of the step just tried are from its slope there, in units of rates. */
double lag_long_gap(LagRun *run);

#endif
