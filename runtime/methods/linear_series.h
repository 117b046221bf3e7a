/* exp(A h) x by its Taylor series, term by term: no matrix but A itself. For steps of all lengths of large sparse systems, and
 * for what is left beside the rungs of a ladder.
 *
 * In steps of |A h| <= 2.5, and until terms are below 1e-21 of what they are added to; those below 1e-4 are plain doubles. Powers are integrated by Gauss's
 * quadrature over the series: with ten nodes to 5e-17 of the largest power.
 */
#ifndef LAG_LINEAR_SERIES_H
#define LAG_LINEAR_SERIES_H

#include "methods/linear_system.h"

enum { LAG_SERIES_NODES = 10 };

/* Powers at a time and state (q, v). */
typedef void (*LagPowers)(void *context, double t, const double *q, double *v, double *power);

typedef struct {
    size_t size, n;
    int n_power;
    double rate;   /* of the fastest of the motions, roughly */
    double entries; /* numbers in A */
    LagDDs from, term, next, sum;
    double *node; /* LAG_SERIES_NODES states (q, v) */
    LagPowers powers;
    void *context;
} LagSeries;

void lag_series_layout(LagSeries *series, const LagLinearSystem *system, int n_power, LagArena *arena);

/* New numbers in the system. `norm`: of A; 0: not known. */
void lag_series_reset(LagSeries *series, LagLinearSystem *system, double norm);

/* y = exp(A h) x, and the integrals of the powers from the time t on are added. Returns 0 when it is not finite. */
int lag_series_move(LagSeries *series, LagLinearSystem *system, double t, LagDD h, LagDDs x, LagDDs y, LagDD *integrals);

/* Multiplications of numbers that a step of length h costs. */
double lag_series_cost(const LagSeries *series, double h);

#endif
