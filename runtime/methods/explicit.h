/* Explicit Runge-Kutta methods for q'' = a(t, q, q'), one step at a time. */
#ifndef LAG_EXPLICIT_H
#define LAG_EXPLICIT_H

#include "state/method.h"
#include "model/model.h"

enum { LAG_MOST_SLOPES = 17, LAG_HERMITE_ROWS = 3, LAG_MOST_COEFFICIENTS = 7 };
enum { LAG_RECORD_HEAD = 4, LAG_RECORD_ROWS = 15 }; /* of a step that is kept */

/* The nonzero entries of one row. */
typedef struct {
    int count;
    int column[14];
    double weight[14];
} LagTableauRow;

typedef struct {
    int stages;       /* slopes at the beginning and inside; slope number `stages` is that at the end */
    int all_stages;   /* with those that only serve the dense output */
    int dense_rows;   /* of the interpolation polynomial beyond its cubic */
    const double *node;
    const LagTableauRow *stage, *error, *coarse_error, *dense; /* coarse_error may be NULL */
    int error_at_end; /* `error` uses the slope at the end */
    double caution;   /* multiplies the error, so that a tolerance means about the same error by each method */
} LagTableau;

typedef struct {
    const LagTableau *tableau;
    double *k[LAG_MOST_SLOPES];
    double *dense[LAG_MOST_COEFFICIENTS];
    double *unit;            /* 2 n: of long states */
    int first_slope_is_last; /* the slope at the end of the step before is slope 0 of the next one */
    int dense_ready;
    int has_other_stages;    /* those of a shorter step, which looked into the latest one */
} LagExplicit;

extern const LagTableau lag_verner9_tableau, lag_dop853_tableau, lag_tsit5_tableau;

extern const LagMethod lag_verner9; /* Verner 9(8) */
extern const LagMethod lag_dop853; /* Dormand-Prince 8(5,3) */
extern const LagMethod lag_tsit5;  /* Tsitouras 5(4) */

#endif
