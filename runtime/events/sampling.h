/* Values that are held between instants, as those of sampled controllers: at an instant each before the events of its rank. */
#ifndef LAG_SAMPLING_H
#define LAG_SAMPLING_H

#include "base/arena.h"
#include "state/state.h"

void lag_sampling_layout(LagRun *run, LagArena *arena);

/* Values before any instant, into the modes. LAG_BAD_INTERVAL where instants do not follow each other. */
LagStatus lag_sampling_begin(LagRun *run);

/* The same values once more: what was taken at the start is taken anew. */
void lag_sampling_put_back(LagRun *run);

/* At t: whose instant it is that has not been. Whether there are some. */
int lag_sampling_meet(LagRun *run, double t);

/* New values of that rank, of those whose instant was met, by the modes and discrete variables as they are. Whether some were taken. */
int lag_sampling_take(LagRun *run, double t, const double *y, int rank);

int lag_sampling_last_rank(const LagModel *model);

/* Modes of a new segment go on with the values that are held. */
void lag_sampling_keep(LagRun *run);

/* Of a held value its mode, its sampler, and how many events come before it at an instant, in a row. */
static inline int lag_held_mode(const LagModel *model, int k) { return model->held[3 * k]; }
static inline int lag_held_sampler(const LagModel *model, int k) { return model->held[3 * k + 1]; }
static inline int lag_held_rank(const LagModel *model, int k) { return model->held[3 * k + 2]; }

#endif
