/* How far constraints are open, each in its own measure. */
#ifndef LAG_CLOSURE_H
#define LAG_CLOSURE_H

#include "base/arena.h"
#include "model/model.h"

struct LagRun;

typedef struct {
    double *reach, *pace;   /* n_multipliers: what positions, or rates, make of each constraint when they move by their sizes */
    double *still, *moved;  /* n_multipliers: scratch */
    double *way, *place;    /* n: scratch */
    double *phi;            /* n_holonomic: scratch */
    int left;               /* looks before the measures are found again */
} LagClosureMeasure;

void lag_closure_layout(LagClosureMeasure *measure, const LagModel *model, LagArena *arena);

/* The constraints are others now. */
void lag_closure_forget(LagClosureMeasure *measure);

/* Of a state (q, v) at t with these residuals, Phi and J v + dPhi/dt: the largest, relative to what a constraint makes of positions (or
 * rates) as large as any so far, measured anew now and then and where it seems more than `most`. Rates are known to rounding of
 * positions over a step. INFINITY where there is no value. */
double lag_closure_open(struct LagRun *run, double t, const double *y, const double *phi, const double *rate, double most);

#endif
