/* A step by collocation, as the polynomial it stands for: rates through their values at 0 and at the nodes. */
#ifndef LAG_COLLOCATION_H
#define LAG_COLLOCATION_H

#include "state/motion.h"
#include "methods/radau_tableau.h"

typedef struct {
    const LagRadauTableau *tableau;
    double h;
    double *rate;        /* stages x n: rates minus those at the beginning */
    double *power;       /* stages x n_power: powers minus those at the beginning */
    double *slope;       /* size: slope at the beginning */
} LagCollocation;

void lag_collocation_layout(LagCollocation *step, const LagMotion *motion, LagArena *arena);

/* Stage values of the next step, of length h with another tableau perhaps, as this polynomial foresees them: relative to the
 * rates at its own end. */
void lag_collocation_foresee(const LagCollocation *step, int n, const LagRadauTableau *tableau, double h, double *rate);

/* The state at x in [0, 1] of the step that began at y. */
void lag_collocation_at(const LagCollocation *step, const LagMotion *motion, const double *y, double x, double *at);

#endif
