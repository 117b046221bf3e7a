/* The model's functions at a time and state, with the inputs and modes of the present segment. */
#ifndef LAG_EVALUATE_H
#define LAG_EVALUATE_H

#include "state/state.h"

/* The function that gives the accelerations of nearly all states. */
const LagFunction *lag_usual_rhs(const LagModel *model);

/* A LagFlow. */
int lag_flow(void *run, LagFlowPart part, const double *q, const double *v_or_p, double *result);

/* Inputs at t and their rates, into the run. */
void lag_inputs_and_rates(LagRun *run, double t);

/* Conditions of switches g and their rates by the accelerations a (n), but for those of events that ask for forces. */
void lag_conditions_of_motion(LagRun *run, double t, const double *q, const double *v, const double *a, double *g, double *rate);

void lag_energies(LagRun *run, double t, const double *y, double *energies);

/* Whether all of x[n] are numbers: 0 * x is 0 for finite x and NaN for others, and one sum tells. */
static inline int lag_all_finite(const double *x, int n)
{
    double probe = 0;
    for (int i = 0; i < n; ++i)
        probe += 0 * x[i];
    return probe == 0;
}

#endif
