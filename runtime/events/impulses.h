/* Impulses that reset rates, at the present state. */
#ifndef LAG_IMPULSES_H
#define LAG_IMPULSES_H

#include "events/impacts.h"

/* Rates of what is reset, and what they are to become, at rates v[n]. */
void lag_impulses_look(LagRun *run, const double *v, double *rate, double *wanted);

/* Rates (n) where nothing moves but along a way, NULL: none; and what discrete variables are. Into impacts.state. */
const double *lag_impulses_rates(LagRun *run, const double *way);

/* The ways of the `count` resets in impacts.which: into impacts.way. */
void lag_impulses_find_ways(LagRun *run, int count);

/* That of one, into way[n]. */
void lag_impulses_find_way(LagRun *run, int reset, double *way);

/* Whether an impulse of this reset is to push alone, as that of a contact; what is passed already takes any. */
int lag_impulses_push(const LagRun *run, int reset);

/* Conditions where nothing moves but supports, into switches.g_inside; along way k as well, into g_begin; and, after both, how much an
 * impulse of 1 along that way closes the contact of the reset impacts.which[k]. */
void lag_impulses_look_at_rest(LagRun *run);
void lag_impulses_look_along(LagRun *run, int k);
double lag_impulses_closing(const LagRun *run, int k);

/* After rest: looks along way k, and returns how much an impulse of 1 opens its contact. */
double lag_impulses_opening(LagRun *run, int k);

/* Resets the rates of the events in impacts.fires, from impacts.rate to impacts.wanted; `presses`: see contact_friction.h. Returns 0 where there are
 * no impulses that do. */
int lag_impulses_reset(LagRun *run, int presses);

#endif
