/* A linear scene as x' = A x with x = (q, v, w), in double-doubles. linear_pattern.h says where its numbers lie. */
#ifndef LAG_LINEAR_SYSTEM_H
#define LAG_LINEAR_SYSTEM_H

#include "numbers/dd_vector.h"
#include "model/inputs.h"
#include "model/linear_pattern.h"

typedef struct {
    int rows;
    const int *start, *column;
    LagDD *value;
} LagSparse;

typedef struct {
    const LagModel *model;
    int n, n_w, n_inputs, changes, n_forms, size;
    const int *order;
    LagSparse lower, F, G, form[2];
    LagDD *diagonal; /* of M, then of D in M = L D L' */
    LagDD *inverse;  /* of D */
    LagDD *values, *waves, *work, *right;
    double *rough; /* n: scratch */
    double *p, *d; /* what the numbers belong to */
    int is_built;
} LagLinearSystem;

void lag_linear_system_layout(LagLinearSystem *s, const LagModel *model, LagArena *arena);

/* The numbers at these parameters and modes. *is_new: they changed. Returns 0 when M is not positive definite or not finite. */
int lag_linear_system_build(LagLinearSystem *s, const double *p, const double *d, int *is_new);

/* w at the time t of the present segment; u[n_inputs] is scratch. */
void lag_linear_system_loads(LagLinearSystem *s, const LagInputs *inputs, double t, const double *d, double *u, LagDDs w);

/* dx = A x */
void lag_linear_system_slope(LagLinearSystem *s, LagDDs x, LagDDs dx);

/* The same in doubles. */
void lag_linear_system_rough_slope(const LagLinearSystem *s, const double *x, double *dx);

#endif
