/* Values that are held between instants, as those of sampled controllers. */
#ifndef LAG_SAMPLING_H
#define LAG_SAMPLING_H

#include "base/arena.h"
#include "state/state.h"

void lag_sampling_layout(LagRun *run, LagArena *arena);

/* Values before any instant, into the modes. LAG_BAD_INTERVAL where instants do not follow each other. */
LagStatus lag_sampling_begin(LagRun *run);

/* New values at t, where that is an instant that has not been, by the modes in force from there on. Whether some were taken. */
int lag_sampling_take(LagRun *run, double t, const double *y);

/* Modes of a new segment go on with the values that are held. */
void lag_sampling_keep(LagRun *run);

#endif
