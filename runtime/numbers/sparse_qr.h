/* QR factors of matrices that are mostly 0, as those of the equations of a long row of loops. */
#ifndef LAG_SPARSE_QR_H
#define LAG_SPARSE_QR_H

#include "base/arena.h"

/* As made for matrices up to rows x cols. */
typedef struct {
    double *a; /* rows x cols, column-major: reflectors, R above them */
    double *left2; /* cols: what is left of a column, squared */
    double *diagonal, *length2; /* cols: of R; of reflectors, squared */
    int *pivot, *pivot_row; /* cols: column and row of a step's diagonal; columns without a step come last */
    int *column_step, *row_step; /* cols, rows: the step that took them; not less than cols: none has */
    int *entries, *n_entries, *n_above; /* cols x rows, cols, cols: the rows where a column may not be 0, first those of R */
    int *columns, *n_columns; /* rows x cols, rows: the columns without a step that may not be 0 in a row */
    int *changed, *column_mark, *row_mark; /* cols, cols, rows: scratch */
    int rows, cols, rank;
} LagSparseQr;

void lag_sparse_qr_layout(LagSparseQr *qr, size_t rows, size_t cols, LagArena *arena);

/* Factors qr->a, rows x cols. Columns that are shorter than `tolerance` times the first pivot count as dependent. */
void lag_sparse_qr(LagSparseQr *qr, int rows, int cols, double tolerance);

/* Moves x[rows] to the nearest place with A' x = b, in the sense of weighted least squares where columns of A are dependent: by
 * `dependent`, made for cols x cols; y and z [cols] are scratch. */
void lag_sparse_qr_nearest(const LagSparseQr *qr, const double *b, const double *weight, LagSparseQr *dependent, double *y,
                           double *z, double *x);

#endif
