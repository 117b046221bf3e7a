/* Taylor series of the motion: steps as long as the series converges well, and rows inside them for nothing. */
#ifndef LAG_TAYLOR_H
#define LAG_TAYLOR_H

#include <float.h>

#include "numbers/jets.h"
#include "state/method.h"
#include "model/model.h"

typedef struct {
    int order;
    double tolerance;         /* that the order and the next two belong to; 0: none yet */
    double last, before_last; /* what the last two coefficients may be worth in a step, in units of error */
    double *jets;     /* n_jets * LAG_JET_STRIDE: those of the step that begins at the present state */
    double *old_jets; /* those of the latest step */
    double *numbers, *work, *scratch; /* of series without code of their own */
    double *unit, *share; /* of a long state: units of error; scratch, in which the slope at the end of a step waits for its check */
    int begun;        /* orders of `jets` that are known */
    int top, old_top; /* the highest order of `jets`, and of `old_jets`, that is not 0: of motion that is a polynomial, a low one; 0: not
                       * asked for yet */
    int is_fresh;     /* there was no step since the state or the equations changed */
} LagTaylor;

/* See taylor.c. */
#define LAG_TAYLOR_REST 0.004
#define LAG_TAYLOR_WRONG 0.5
#define LAG_TAYLOR_SHRINK 0.5
#define LAG_TAYLOR_GROW 100
#define LAG_TAYLOR_REMAINS 0.25
#define LAG_TAYLOR_NOISE 1e-10
#define LAG_TAYLOR_ROUNDING (16 * DBL_EPSILON) /* share of the largest acceleration of a kind */

extern const double lag_inverse[LAG_JET_ORDER]; /* 1/1, 1/2, ... */

extern const LagMethod lag_taylor;

/* The order, from now on, is that which is cheapest where eight motions go on at once (wide_taylor.h). `tolerance`: that of the run's
 * scale. */
void lag_taylor_plan_for_eight(LagTaylor *taylor, const LagModel *model, double tolerance);

/* What a step of Dormand-Prince 8(5,3) is expected to cost, and what series are over the time of one; in tenths of a nanosecond. */
double lag_taylor_erk_cost(const LagModel *model);
double lag_taylor_cost(const LagModel *model, double tolerance);

/* What the rest of a series may be worth. */
double lag_taylor_eps(double tolerance);

/* Tenths of a nanosecond that series are expected to take per radius of convergence. */
double lag_taylor_pace(const LagModel *model, double tolerance);

#endif
