/* Rest: what is held and moved by nothing but rounding stays where it is. */
#ifndef LAG_REST_H
#define LAG_REST_H

#include "base/status.h"

struct LagRun;

/* Forces like the root of a rate stop it in finite time, and no step is short enough beside their slope there: rates that are less than
 * errors allowed, and are moved by nothing else, become 0. Returns whether there are some. */
int lag_rest_stop(struct LagRun *run);

/* Where forces that hold leave nothing that moves, and nothing depends on time: all rates become 0. Returns whether the scene rests. */
int lag_rest_begins(struct LagRun *run);

/* Time passes, up to the next event. */
LagStatus lag_rest_step(struct LagRun *run);

/* A segment begins with accelerations in motion.slope: which coordinates rest, into sliding.still. */
void lag_rest_note(struct LagRun *run);

/* Of accelerations at rates v: rounding of those that rest is none. */
void lag_rest_calm(const struct LagRun *run, const double *v, double *a);

#endif
