/* Impulses that reset rates, at the present state. */
#ifndef LAG_IMPULSES_H
#define LAG_IMPULSES_H

#include "impacts.h"

/* Rates of what is reset, and what they are to become, at rates v[n]. */
void lag_impulses_look(LagRun *run, const double *v, double *rate, double *wanted);

/* The ways of the `count` resets in impacts.which: into impacts.way. */
void lag_impulses_find_ways(LagRun *run, int count);

/* Resets the rates of the events in impacts.fires, from impacts.rate to impacts.wanted. */
void lag_impulses_reset(LagRun *run);

#endif
