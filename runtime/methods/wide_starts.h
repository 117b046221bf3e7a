/* Series (wide_taylor.h) of motions that begin, of all at once that do: what a first step needs to know follows from the accelerations
 * that begin the series. */
#ifndef LAG_WIDE_STARTS_H
#define LAG_WIDE_STARTS_H

#include "methods/wide_taylor.h"

/* What motions that differ in their states alone have in common at their start, as that in the lane has it. */
void lag_wide_starts_learn(LagWideTaylor *taylor, int lane);

/* Inputs are held in the lane from the present time on, until `stop`: what `enter` does where nothing else happens. */
void lag_wide_starts_hold(LagWideTaylor *taylor, int lane, const double *u, double stop);

/* LagWideMethod.place and .settle. */
void lag_wide_starts_place(void *taylor, int lane, const double *y);
void lag_wide_starts_settle(void *taylor);

#endif
