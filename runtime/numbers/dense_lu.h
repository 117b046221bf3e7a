/* Elimination of small full matrices, real and complex, with partial pivoting.
 *
 * Rows are compared relative to their largest entry, since they have units of their own. A column that depends on those
 * before it (constraints that repeat each other) gets no pivot: its unknown is 0, and one equation, which then repeats the
 * others, is left out.
 */
#ifndef LAG_DENSE_LU_H
#define LAG_DENSE_LU_H

#include "base/arena.h"


/* Pivots smaller than this, compared with the largest entry of their column, are rounding. */
#define LAG_DEPENDENT 1e-13

typedef struct {
    int size;
    double dependent; /* LAG_DEPENDENT, or what is set after layout */
    double early;     /* the first pivot that is this share of the best one is taken; 1, or what is set after layout */
    int apart;        /* the first so many columns have pivots in the first so many rows alone; 0, or what is set before factoring */
    double *re, *im; /* size x size, column-major: the matrix, then its factors; im is NULL when it is real */
    double *scale;   /* size: 1 / largest entry of the row */
    int *pivot;      /* size: row that changed places with the pivot's; -1: the column has no pivot */
} LagDenseLu;

void lag_dense_lu_layout(LagDenseLu *lu, int size, int is_complex, LagArena *arena);

/* Factors the matrix in place. */
void lag_dense_lu_factor(LagDenseLu *lu);

/* x = A^-1 x; im is NULL when the matrix is real. */
void lag_dense_lu_solve(const LagDenseLu *lu, double *re, double *im);

#endif
