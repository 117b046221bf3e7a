/* Contacts: events whose resets turn back what approaches, or stop it (impacts.h). */
#ifndef LAG_CONTACTS_H
#define LAG_CONTACTS_H

#include "events/impacts.h"

/* At the present state: into sliding.error, what one tolerance of it makes of the conditions of contacts; those found
 * last where nothing has changed. Returns whether conditions were found for it: switches.g and rate, of lag_conditions_of_events. */
int lag_contacts_find_errors(LagRun *run);

/* How many numbers say where that was: the time, the state, its units, and all modes, switches and shares. */
int lag_contacts_key(const LagModel *model);

/* How far condition i may be on without being taken for it. */
double lag_contacts_margin(const LagRun *run, int i);

/* Whether something rests at contact k, or it is closed but for `near`; g: all conditions. */
int lag_contacts_are_closed(const LagRun *run, int k, const double *g, double near);

/* Whether the condition i of an event is true, so that it cannot come: contacts that are open stay so, or would be passed. */
int lag_contacts_is_inside(LagRun *run, int i, double g);

/* 1 + the first event whose contact is passed, or whose condition holds and would change something; 0: none. */
int lag_contacts_find_passed(LagRun *run);

/* Whether what leaves contact k so fast, and is drawn back so, cannot be told from what rests. */
int lag_contacts_stay(const LagRun *run, int k, double speed, double returns);

/* What is left of the speed at which contact k is found late, at the place where it closed. */
double lag_contacts_lateness(const LagRun *run, int k);

/* Moves positions of contacts that have drifted, or were found late, along the ways of their impulses: none is left, on the shortest way
 * in the metric of masses. */
void lag_contacts_put_back(LagRun *run);

/* Contacts that are closed and neither approach nor leave: into switches.turned, of what rests at them. Returns whether there are
 * some. */
int lag_contacts_find_rest(LagRun *run);

/* How long the next step may be, so that a short bounce is seen: impacts.seen. */
void lag_contacts_foresee(LagRun *run);

#endif
