/* The state that moves: what every method of stepping reads and writes. */
#ifndef LAG_MOTION_H
#define LAG_MOTION_H

#include <stdint.h>

#include "base/arena.h"

/* Accelerations a[n] and powers power[n_power]; returns 1 when all are finite. v is the slope of q: it may be corrected. */
typedef int (*LagRhs)(void *context, double t, const double *q, double *v, double *a, double *power);

/* Of scenes that keep their energy: the momenta p = dT/dv; v in terms of them; dp/dt. Returns 1 when the result is finite. */
typedef enum { LAG_MOMENTUM, LAG_VELOCITY, LAG_FORCE } LagFlowPart;
typedef int (*LagFlow)(void *context, LagFlowPart part, const double *q, const double *v_or_p, double *result);

typedef struct {
    int n, size; /* size = 2 n + n_power */
    int n_attitudes;
    const int *attitudes;        /* of the model */
    double *attitude_carry;      /* 4 n_attitudes: what rounding took from their references */
    LagRhs rhs;
    LagFlow flow;
    void *context;
    double t, t_old;   /* the last step went from t_old to t; equal: it is no longer known */
    double t_end;      /* to here, rather: t is earlier where the run went back to an event inside it */
    double *y, *carry; /* state (q, v, energy quadratures) and what rounding took from it */
    double *other, *other_carry; /* the state at t_old, or the new one while a step is tried */
    double *slope;               /* dy/dt where a segment begins */
    double *point, *sum;         /* scratch */
    double looseness;            /* by what `energy` is larger than energies that were seen */
    double energy, strength;     /* its size, at any time and by the square of a step, where errors of its quadratures limit
                                  * steps; 0: they do not */
    double work_error, work_step, work_time; /* of the quadratures in the latest attempt, in units; its length, and where it began */
    int work_is_rough;           /* so many shorter attempts did not make that smaller as they should */
    double doubt;                /* errors of its quadratures so far, as steps estimated them that they did not limit */
    int lacks_slopes;            /* dense output of the latest step is a cubic, since accelerations had no values inside it */
    int64_t evaluations, dense_outputs;
} LagMotion;

void lag_motion_layout(LagMotion *motion, LagArena *arena);

/* Slope k of the state (q, v) at t; v is copied, unless it is already in its place: it is the slope of q, but of attitudes. Returns 1
 * when it is finite. */
int lag_motion_slope(LagMotion *motion, double t, const double *q, const double *v, double *k);

/* other = y + step, compensated. */
void lag_motion_add(LagMotion *motion, const double *step);

/* The state just tried becomes the present one. */
void lag_motion_take(LagMotion *motion, double t_new);

/* The state before the latest step becomes the present one again. */
void lag_motion_take_back(LagMotion *motion);

static inline void lag_swap(double **a, double **b)
{
    double *const c = *a;
    *a = *b;
    *b = c;
}

/* Index of the first value that is not finite; the last one if all are. */
int lag_first_not_finite(const double *x, int n);

#endif
