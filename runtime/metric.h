/* The mass metric of start values: how far two states are apart, as the kinetic energy of the way between them. */
#ifndef LAG_METRIC_H
#define LAG_METRIC_H

#include "arena.h"
#include "model.h"

typedef struct {
    const LagModel *model;
    double *factor; /* n x n: the rows of L below the diagonal, of the values that may move */
    double *unit;   /* n: what a value is divided by */
    double *column; /* n */
    double *rates;  /* n */
    int *order;     /* n: the values that may move, those nobody guessed first */
    int count, n_free;
} LagMetric;

/* Takes nothing where the model has no `momentum`: every value is then measured by its unit alone. */
void lag_metric_layout(LagMetric *metric, LagArena *arena);

/* The metric at q of the values j with unit[j] > 0; `by_mass` 0: each by its unit. */
void lag_metric_set(LagMetric *metric, const double *q, const double *p, const int *fixed, const double *unit, int by_mass,
                    double *work);

/* With the distance |z|, dx = B z: a gradient g becomes B' g, z becomes dx, dx becomes z; all (n), where the values that may
 * not move are left 0. */
void lag_metric_of_gradient(const LagMetric *metric, const double *g, double *z);
void lag_metric_to_step(const LagMetric *metric, const double *z, double *dx);
void lag_metric_from_step(const LagMetric *metric, const double *dx, double *z);

#endif
