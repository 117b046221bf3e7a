/* Directions of rates that change what slides while it is held. */
#ifndef LAG_HELD_WAYS_H
#define LAG_HELD_WAYS_H

#include "base/arena.h"
#include "model/model.h"
#include "state/settings.h"

typedef struct {
    int count, rank; /* of what is held; of independent directions */
    int *which;      /* most that slide: the switch of each */
    int *base;       /* most: of each direction, the first that goes along it and none before */
    double *row;     /* most x n: directions, orthogonal to each other, of rates of 1 in SI units */
    double *mix;     /* most x most: what of each direction is in how each changes with rates: rows of those */
    double *left;    /* most: scratch: how far each is from where it is held */
} LagHeldWays;

void lag_held_ways_layout(LagHeldWays *ways, const LagModel *model, LagArena *arena);

/* Those of what slides, where its values g (n_switches) at the present state were found. */
void lag_held_ways_find(LagRun *run, const double *g);

/* Whether they are those of what slides now. */
int lag_held_ways_last(const LagRun *run);

/* Takes off x (n) what makes each of what is held be off by so much as `left` tells. */
void lag_held_ways_put(const LagHeldWays *ways, int n, double *x);

/* How much the value of the one at place j changes along x (n). */
double lag_held_ways_along(const LagHeldWays *ways, int n, int j, const double *x);

/* Takes off x (n) all that changes what is held. */
void lag_held_ways_leave(const LagHeldWays *ways, int n, double *x);

#endif
