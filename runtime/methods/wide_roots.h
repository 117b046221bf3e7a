/* What stands under square roots in the forces (roots.h), of eight motions at once: whether their latest steps may have come near to
 * where it is 0.
 */
#ifndef LAG_WIDE_ROOTS_H
#define LAG_WIDE_ROOTS_H

#include "methods/wide_steps.h"

typedef struct {
    const LagModel *model;
    double *g, *rate, *g_old, *rate_old; /* n_roots: at present, and where the latest steps began */
    double *u, *d, *c;                   /* of each motion; in d the references of attitudes are those of its steps */
    double *work;
    LagRun *run[LAG_ABREAST];
    double suspect[LAG_ABREAST]; /* 1: the latest step may have come near */
} LagWideRoots;

/* Whether there are instructions to look by, or nothing to look at. */
int lag_wide_roots_serve(const LagModel *model);

void lag_wide_roots_layout(LagWideRoots *roots, const LagModel *model, LagArena *arena);

/* The motion in the lane is that of the run, and is where that is. */
void lag_wide_roots_enter(LagWideRoots *roots, int lane, LagRun *run);

/* The same of all motions that are there, some of which have begun. */
void lag_wide_roots_begin(LagWideRoots *roots, const LagWideSteps *steps);

/* After a step in each lane. */
void lag_wide_roots_look(LagWideRoots *roots, const LagWideSteps *steps);

#endif
