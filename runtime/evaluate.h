/* The model's functions at a time and state, with the inputs and modes of the present segment. */
#ifndef LAG_EVALUATE_H
#define LAG_EVALUATE_H

#include "state.h"

/* A LagRhs. */
int lag_accelerations(void *run, double t, const double *q, double *v, double *a, double *power);

/* The function that gives the accelerations of nearly all states. */
const LagFunction *lag_usual_rhs(const LagModel *model);

/* Of eight states at once (wide.h); out: accelerations, powers behind them, and scratch as long as the third output of the function;
 * work: eight times its own. Returns 0 where this cannot be, or not all are finite. */
int lag_accelerations_abreast(LagRun *run, const double *t, const double *q, const double *v, const double *u, double *const *out,
                              double *work);

/* The parts of the matrix of implicit steps at a state. Returns 0 when they are not finite. */
int lag_jacobian(LagRun *run, double t, const double *y, LagImplicitMatrix *matrix);
/* A LagFlow. */
int lag_flow(void *run, LagFlowPart part, const double *q, const double *v_or_p, double *result);

/* At an event, after the modes have changed: momentum stays as it is but for the impulses of what holds the scene, so that rates
 * jump where supports do. Returns whether they did. */
int lag_kick(LagRun *run, double t, double *y);

/* Conditions of switches g and their rates by the accelerations a (n). */
void lag_conditions_by(LagRun *run, double t, const double *q, const double *v, const double *a, double *g, double *rate);

void lag_outputs(LagRun *run, double t, const double *y, double *outputs);
void lag_energies(LagRun *run, double t, const double *y, double *energies);

/* Whether all of x[n] are numbers. */
int lag_all_finite(const double *x, int n);

#endif
