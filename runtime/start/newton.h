/* Equations g(q, v) = 0 of start values, solved from a guess by the shortest corrections. */
#ifndef LAG_NEWTON_H
#define LAG_NEWTON_H

#include "base/arena.h"
#include "numbers/qr.h"
#include "numbers/sparse_qr.h"
#include "start/metric.h"
#include "model/model.h"
#include "model/slice.h"

typedef struct {
    const LagModel *model;
    const double *u; /* inputs at the start */
    const int *first, *values; /* n_initial + 1: equation i may speak of values[first[i]] .. values[first[i + 1] - 1], ascending */
    double *g, *jacobian; /* n_initial, of what equations may speak of */
    double *transposed;   /* 2 n x n_initial, or fewer of both: scaled */
    double *length;       /* n_initial: size of an equation's scaled gradient */
    double *general;      /* the Jacobian at a general position near the guess */
    double *general_length, *weight; /* n_initial: sizes of its rows, scaled and in the metrics */
    double *longest;      /* n_initial: a scaled gradient that is longer is that of an equation without a value */
    double *right, *diagonal, *share; /* n_initial */
    double *scale;        /* 2 n: natural size of a value, 0: it may not move */
    double *step, *trial, *z, *gradient; /* 2 n */
    int *places;          /* 2 n: where a measured gradient may not be 0 */
    double trusted; /* positions that are no angles may go so far at once */
    double part;    /* of the correction, that was not cut off */
    int *pivot;
    int *active;    /* n_initial: whether an equation is looked at */
    int *rows;      /* these equations when the metrics were taken */
    int n_rows;
    LagSlicer slicer;
    int is_read; /* whether the slicer is that of the model */
    LagSlice residuals, slopes; /* of these equations; nothing where `initial` has no slices */
    LagLeastSquares scratch;
    LagSparseQr sparse, dependent; /* of many equations: `transposed` and scratch.a are theirs */
    int n_matrix_rows; /* of `transposed` */
    int is_sparse; /* whether `transposed` was factored with account of its zeros */
    LagMetric positions, rates;
} LagNewton;

void lag_newton_layout(LagNewton *newton, const LagModel *model, LagArena *arena);

int lag_newton_evaluate(LagNewton *newton, const double *p, const double *x, double *work);

/* Takes what was evaluated last for general: where a gradient vanishes it is measured by that. All else comes after it. */
void lag_newton_survey(LagNewton *newton, const double *reach);

/* `transposed` of so many rows, without entries; puts an entry where there is none. */
void lag_newton_begin_matrix(LagNewton *newton, int rows, int most_columns);
void lag_newton_put(LagNewton *newton, int i, int column, double value);

/* Factors the first `count` columns of `transposed`. Returns its rank: what is shorter than `tolerance` times the longest counts as dependent. */
int lag_newton_factor(LagNewton *newton, int count, double tolerance);

/* The metrics of the values with scale > 0, LAG_METRIC_..., for corrections from x on, of the equations that are looked at now. */
void lag_newton_measure(LagNewton *newton, const double *p, const int *fixed, const double *x, int way, double *work);

/* Moves x = (q, v) until all equations hold. Returns -1, or the equation that is satisfied worst; g is that of x. */
int lag_newton_solve(LagNewton *newton, const double *p, int most_iterations, int most_pushes, double *x, double *work);

/* Fills `step` with the way from x, g evaluated there, to the place nearest to the guess where the linearised equations hold.
 * Returns its length, the longest of its parts in natural sizes. */
double lag_newton_lean(LagNewton *newton, const double *guess, const double *x);

/* Squared distance in the metrics. */
double lag_newton_distance2(LagNewton *newton, const double *a, const double *b);

#endif
