/* The matrix of implicit steps, mu S0 + S1 + S2/mu for several numbers mu, factored: see the model's function `jacobian`.
 *
 * For the accelerations a = f(t, q, v), and J_q, J_v their derivatives (along the constraints, where there are some),
 *
 *     (mu - J_v - J_q/mu) x = r    <=>    (mu S0 + S1 + S2/mu) (x, l) = S0 (r, 0),
 *
 * so the linear algebra of a step has the size of the coordinates, and M is never inverted.
 */
#ifndef LAG_IMPLICIT_MATRIX_H
#define LAG_IMPLICIT_MATRIX_H

#include "numbers/dense_lu.h"
#include "model/model.h"
#include "numbers/sparse_lu.h"

enum { LAG_MOST_SHIFTS = 4 };

typedef struct {
    int n, size, entries; /* coordinates, with multipliers */
    int is_sparse;
    const int *start, *row, *order, *colour;
    double *part[3];    /* S0, S1, S2 */
    double *re, *im;    /* entries of one matrix */
    double *right_re, *right_im;
    double *along, *still; /* n: a direction, and none */
    LagDenseLu dense[LAG_MOST_SHIFTS]; /* the first one is real */
    LagSparseLu sparse[LAG_MOST_SHIFTS];
} LagImplicitMatrix;

/* Of the model's matrix, for a real mu and up to `pairs` complex ones. */
void lag_implicit_matrix_layout(LagImplicitMatrix *matrix, const LagModel *model, int pairs, LagArena *arena);

/* The parts at a state; `in` are the arguments of the model's function `jacobian`. */
void lag_implicit_matrix_evaluate(LagImplicitMatrix *matrix, const LagModel *model, const double *const *in, double *work);

/* Factor number `which`: 0 is real, the others are complex. */
void lag_implicit_matrix_factor(LagImplicitMatrix *matrix, int which, double mu_re, double mu_im);

/* x[n] with (mu - J_v - J_q/mu) x = r + J_q s; s, and im when `which` is 0, may be NULL. x may be r. */
void lag_implicit_matrix_solve(LagImplicitMatrix *matrix, int which, const double *re, const double *im, const double *s,
                               double *x_re, double *x_im);

#endif
