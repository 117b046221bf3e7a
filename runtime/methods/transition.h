/* Linear scenes of few states, as `auto` runs them: from row to row by their transition matrices, in doubles. */
#ifndef LAG_TRANSITION_H
#define LAG_TRANSITION_H

#include "state/method.h"
#include "state/settings.h"
#include "methods/transition_matrices.h"

typedef struct {
    LagTransitionMatrices matrices;
    int is_fresh;        /* the loads are to be set, A perhaps built anew */
    double until;        /* the time up to which doubles have the digits that are asked for */
    double usual;        /* a length of step that comes again and again, */
    int times;           /* so often, and that is no rung's */
    double lag, lag_old; /* how far the state is behind the time, by rounding of times */
    double *x, *sum, *loads, *loads_old;
} LagTransition;

/* Whether a run with these settings may begin so. */
int lag_transition_fits(const LagModel *model, const LagSettings *settings);

/* Whether doubles have the digits that are asked for, at the run's parameters and up to its end. */
int lag_transition_serves(struct LagRun *run);

extern const LagMethod lag_transition;

#endif
