/* QR factors of matrices that are mostly 0, as those of the equations of a long row of loops. */
#ifndef LAG_SPARSE_QR_H
#define LAG_SPARSE_QR_H

#include "base/arena.h"
#include "numbers/heap.h"

/* As made for matrices up to rows x cols. */
typedef struct {
    double *a; /* rows x cols, column-major: reflectors, R above them */
    LagHeap longest, shortest; /* of the columns without a step: less what is left of each, squared; the number of its rows */
    double *diagonal, *length2; /* cols: of R; of reflectors, squared */
    int *pivot, *pivot_row; /* cols: column and row of a step's diagonal */
    int *column_step, *row_step; /* cols, rows: the step that took them; not less than cols: none has */
    int *entries, *n_entries, *n_above; /* cols x rows, cols, cols: the rows where a column may not be 0, first those of R */
    int *columns, *n_columns; /* rows x cols, rows: the columns without a step that may not be 0 in a row */
    int *changed, *column_mark, *row_mark; /* cols, cols, rows: scratch */
    int rows, cols, rank, room; /* room for columns in a row */
} LagSparseQr;

void lag_sparse_qr_layout(LagSparseQr *qr, size_t rows, size_t cols, LagArena *arena);

/* Begins a matrix of so many rows, and columns at most, without entries. */
void lag_sparse_qr_begin(LagSparseQr *qr, int rows, int cols);

/* Puts an entry where there is none. */
void lag_sparse_qr_add(LagSparseQr *qr, int i, int j, double value);

/* The number of entries that are not 0 in the first columns. */
size_t lag_sparse_qr_entries(const LagSparseQr *qr, int cols);

/* Writes their zeros, too: qr->a is the whole matrix. */
void lag_sparse_qr_fill(LagSparseQr *qr, int cols);

/* Factors the first columns. Those that are shorter than `tolerance` times the first pivot count as dependent. */
void lag_sparse_qr(LagSparseQr *qr, int cols, double tolerance);

/* Moves x[rows] to the nearest place with A' x = b, in the sense of weighted least squares where columns of A are dependent: by
 * `dependent`, made for cols x cols; y and z [cols] are scratch. */
void lag_sparse_qr_nearest(const LagSparseQr *qr, const double *b, const double *weight, LagSparseQr *dependent, double *y,
                           double *z, double *x);

#endif
