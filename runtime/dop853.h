/* The Dormand-Prince method 8(5,3) for q'' = a(t, q, q'), one step at a time. */
#ifndef LAG_DOP853_H
#define LAG_DOP853_H

#include <stdint.h>

#include "scale.h"

enum { LAG_DOP853_SLOPES = 16, LAG_DOP853_COEFFICIENTS = 7 };

/* Accelerations a[n] and powers power[n_power]; returns 1 when all are finite. v is the slope of q: it may be corrected. */
typedef int (*LagRhs)(void *context, double t, const double *q, double *v, double *a, double *power);

typedef struct {
    int n, size; /* size = 2 n + n_power */
    LagRhs rhs;
    void *context;
    double t, t_old;   /* the last step went from t_old to t; equal: it is no longer known */
    double *y, *carry; /* state and what rounding took from it */
    double *other, *other_carry; /* the state at t_old, or the new one while a step is tried */
    double *point, *sum;         /* scratch */
    double *k[LAG_DOP853_SLOPES];
    double *dense[LAG_DOP853_COEFFICIENTS];
    int first_slope_is_last; /* slope 12 of the step before is slope 0 of the next one */
    int dense_ready;
    int64_t evaluations, dense_outputs;
} LagDop853;

void lag_dop853_layout(LagDop853 *solver, LagArena *arena);

/* Evaluates slope 0 at the present state, which the caller set or changed. Returns 1 when it is finite. */
int lag_dop853_restart(LagDop853 *solver, double t);

/* Index of the first value that is not finite; the last one if all are. */
int lag_first_not_finite(const double *x, int n);

/* Tries a step to t_new. Returns the error estimate (a step of error <= 1 is good) and the component it is largest in,
 * or infinity when an evaluation is not finite. */
double lag_dop853_try(LagDop853 *solver, double t_new, const LagScale *scale, int *worst);

/* Takes the step just tried. Returns 0, and takes nothing, when the slope at its end is not finite. */
int lag_dop853_accept(LagDop853 *solver, double t_new);

/* State at t in [t_old, t]. */
void lag_dop853_interpolate(LagDop853 *solver, double t, double *y);

#endif
