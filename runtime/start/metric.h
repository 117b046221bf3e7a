/* The mass metric of start values: how far two states are apart, as the kinetic energy of the way between them. */
#ifndef LAG_METRIC_H
#define LAG_METRIC_H

#include "base/arena.h"
#include "model/model.h"

/* Positions at the start; there are as many rates. Called n where start values are solved. */
static inline int lag_start_size(const LagModel *model) { return model->n + model->n_lost; }

/* Whether there are so many start equations that account of zeros may be worth while. */
static inline int lag_is_long_start(const LagModel *model) { return model->n_initial >= 100; }

typedef struct {
    const LagModel *model;
    double *factor; /* of each block the rows of L, as many columns as rows: below the diagonal, of the values that may move */
    double *unit;   /* n: what a value is divided by */
    double *column; /* n */
    double *rates;  /* n */
    int *order;     /* n: the values that may move, those nobody guessed first */
    int *first;     /* n: before it a row of L is 0, of the values in `order` */
    int *start;     /* n + 1: where the members of each block begin */
    int *member;    /* n: places in `order`, ascending in each block */
    int *part;      /* n: where the rows of a block begin */
    int *touched, *mark; /* n: scratch of blocks */
    int offset; /* of positions 0, of rates n: the first of `values` that it measures */
    int count, n_free, n_blocks, asked;
} LagMetric;

/* Takes nothing where the model has no `momentum`: every value is then measured by its unit alone. */
void lag_metric_layout(LagMetric *metric, LagArena *arena);

/* How values are measured: by their mass, or each by its unit, in both those that nobody guessed as moving most easily; or each
 * by its unit and all alike. */
enum { LAG_METRIC_MASS, LAG_METRIC_UNITS, LAG_METRIC_EVEN, LAG_METRIC_WAYS };

/* The metric at q of the values j with unit[j] > 0. */
void lag_metric_set(LagMetric *metric, const double *q, const double *p, const int *fixed, const double *unit, int way,
                    double *work);

/* With the distance |z|, dx = B z: a gradient g (n) becomes B' g, z becomes dx (n), 0 for values that may not move, dx becomes z.
 * z has `count` entries; of a gradient that is 0 but for `values` those that need not be 0 are written alone, and listed in `places`.
 * Returns their number. */
int lag_metric_of_gradient(LagMetric *metric, const double *g, const int *values, int n_values, double *z, int *places);
void lag_metric_to_step(const LagMetric *metric, const double *z, double *dx);
void lag_metric_from_step(const LagMetric *metric, const double *dx, double *z);

#endif
