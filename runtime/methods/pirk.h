/* Parallel iterated Runge-Kutta steps: Gauss collocation whose stages are evaluated all at once. */
#ifndef LAG_PIRK_H
#define LAG_PIRK_H

#include "state/method.h"
#include "model/model.h"
#include "methods/pirk_dense.h"

typedef struct LagPirk {
    double *a, *tried; /* 8 (n + n_power): accelerations and powers at the stages; those before the latest sweep */
    double *known;     /* the same of the polynomial that foresees others: of the latest step, or of one just rejected */
    double begin, length; /* of that one; 0: there is none yet */
    double *q, *v;     /* 8 n: stages */
    double *u;         /* 8 n_inputs */
    double *rest, *work; /* of eight evaluations at once: what nobody reads, and scratch */
    double times[LAG_ABREAST];
    double *end;       /* 8 (n + n_power): what these come to: lag_pirk_end */
    double *slope, slope_time; /* n + n_power: where a segment begins, or at the end of the latest step; when */
    double *reached;   /* 2 n + n_power: slope at the end of the step just tried */
    int has_end;       /* that is known */
    double last;       /* the largest of the last coefficients of its accelerations, in units */
    double *unit, *weight; /* 2 n; n: what an acceleration is worth in a step, in units of error */
    double *one;       /* state and slope of a single stage */
    double contraction, per; /* by which the latest sweeps brought stages nearer, in a step so long; 0: nobody knows */
    int is_told;       /* those of the latest try have told it */
    int foresees;      /* that of the latest try may: its sweeps did not run away */
    double factor;     /* for the next step */
    int was_careful;   /* in the latest step */
    int is_flat;       /* coefficients of the latest accelerations do not fall */
    int is_doubtful;   /* the last of them fall too slowly for the error that is told by the first */
    int limited;       /* steps, of late, that are as long as sweeps bear and not as errors allow */
    LagPirkDense dense;
} LagPirk;

/* Accelerations s->a of the eight states s->times, s->q, s->v. Returns 0 where they are not finite. */
int lag_pirk_evaluate(LagPirk *pirk, LagMotion *motion);

/* The times of eight stages, at these shares of a step of length h from t, and the inputs then. */
void lag_pirk_set_times(LagPirk *pirk, const LagMotion *motion, double t, double h, const double *node);

/* What a step is expected to cost, and what series are over the time of one, which is two or three times as long as one of theirs; in
 * tenths of a nanosecond. */
double lag_pirk_cost(const LagModel *model);
double lag_pirk_series_cost(const LagModel *model, double tolerance);

extern const LagMethod lag_pirk;

#endif
