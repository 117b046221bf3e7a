/* Impulses that reset rates, at the present state. */
#ifndef LAG_IMPULSES_H
#define LAG_IMPULSES_H

#include "impacts.h"

/* Rates of what is reset, and what they are to become, at rates v[n]. */
void lag_impulses_look(LagRun *run, const double *v, double *rate, double *wanted);

/* The ways of the `count` resets in impacts.which: into impacts.way. */
void lag_impulses_find_ways(LagRun *run, int count);

/* The rates of conditions where nothing moves but supports, into switches.rate_inside (conditions into g_inside); along way k as well,
 * into rate_begin; and, after both, how much an impulse of 1 along that way closes the contact of the reset impacts.which[k]. */
void lag_impulses_look_at_rest(LagRun *run);
void lag_impulses_look_along(LagRun *run, int k);
double lag_impulses_closing(const LagRun *run, int k);

/* Impulses of the events in impacts.fires, with friction as the shares in d: the rates after them into impacts.after. Returns how many
 * there are, in impacts.which. */
int lag_impulses_solve(LagRun *run);

/* Resets the rates of the events in impacts.fires, from impacts.rate to impacts.wanted. */
void lag_impulses_reset(LagRun *run);

#endif
