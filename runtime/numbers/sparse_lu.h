/* Elimination of sparse complex matrices with partial pivoting, column by column.
 *
 * The order of the columns is given; the memory is the most that any choice of pivots can need. Once factored, a matrix with
 * other values is factored again on the same pattern, as long as its pivots stay good. Dependent columns: see dense_lu.h.
 */
#ifndef LAG_SPARSE_LU_H
#define LAG_SPARSE_LU_H

#include "base/arena.h"

typedef struct {
    int size;
    int is_known;      /* the pattern of the factors is that of an earlier matrix */
    int *l_start, *l_row, *u_start, *u_column; /* pivots of U's column k: those of columns u_column, in an order that works */
    int *pivot;        /* size: row of the pivot of column k; -1: none */
    int *column;       /* size: column whose pivot a row holds; -1: none so far */
    int *stack, *next, *seen; /* size: search */
    double *l_re, *l_im, *u_re, *u_im;
    double *d_re, *d_im; /* size: 1/pivot */
    double *x_re, *x_im; /* size: the column at work */
    double *scale;       /* size: 1 / largest entry of the row */
} LagSparseLu;

/* A matrix with the entries of column order[k] in places start[order[k]] .. start[order[k] + 1] - 1 of row, re, im. */
typedef struct {
    const int *start, *row, *order;
    const double *re, *im;
} LagSparseMatrix;

void lag_sparse_lu_layout(LagSparseLu *lu, int size, int n_lower, int n_upper, LagArena *arena);
void lag_sparse_lu_factor(LagSparseLu *lu, const LagSparseMatrix *matrix);

/* x = A^-1 x; `order` as it was when factored. */
void lag_sparse_lu_solve(LagSparseLu *lu, const int *order, double *re, double *im);

#endif
