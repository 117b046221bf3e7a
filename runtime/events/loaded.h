/* Events whose conditions ask for forces: reactions of joints, multipliers, and what holds at contacts. Forces follow from all that is held,
 * and jump where something else is: such conditions stay what they are while that is chosen, and come by it. What an impulse does is no
 * force.
 */
#ifndef LAG_LOADED_H
#define LAG_LOADED_H

#include "base/arena.h"
#include "model/model.h"
#include "state/settings.h"

typedef struct {
    int *is_loaded;   /* n_whens */
    double *a, *power, *multipliers;
    double *g;        /* n_loaded */
    double *all, *rates, *held; /* n_switches: conditions, their rates, and shares */
    double *state, *slope;      /* size */
} LagLoaded;

void lag_loaded_layout(LagLoaded *loaded, const LagModel *model, int size, LagArena *arena);

/* A run starts. */
void lag_loaded_reset(LagRun *run);

/* Into g: conditions of such events at a state, with shares as they are. */
void lag_loaded_put(LagRun *run, double t, const double *q, const double *v, double *g);

/* Their rates where conditions are g and switches.slope is the slope of the state: what they have been a moment of `span` before. */
void lag_loaded_rates(LagRun *run, double t, const double *y, double span, const double *g, double *rate);

/* All that is held has been chosen: such events are true or false from then on as they say; those that come by it: into
 * switches.turned, and the segment is over. */
void lag_loaded_enter(LagRun *run);

#endif
