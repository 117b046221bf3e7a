/* Accelerations and what needs them, where switches and what slides may have a share in them. */
#ifndef LAG_ACCELERATIONS_H
#define LAG_ACCELERATIONS_H

#include "state/evaluate.h"

/* A LagRhs. */
int lag_accelerations(void *run, double t, const double *q, double *v, double *a, double *power);

/* Of eight states at once (wide.h); out: accelerations, powers behind them, and scratch as long as the third output of the function;
 * work: eight times its own. Returns 0 where this cannot be, or not all are finite. */
int lag_accelerations_abreast(LagRun *run, const double *t, const double *q, const double *v, const double *u, double *const *out,
                              double *work);

/* The parts of the matrix of implicit steps at a state. Returns 0 when they are not finite. */
int lag_jacobian(LagRun *run, double t, const double *y, LagImplicitMatrix *matrix);

/* At an event, after the modes have changed: momentum stays as it is but for the impulses of what holds the scene, so that rates
 * jump where supports do. Returns whether they did. */
int lag_kick(LagRun *run, double t, double *y);

/* Those asked for, of the state y. */
void lag_outputs(LagRun *run, double t, const double *y, double *outputs);

/* Guards and what they compare, of the state y: `found` (n_guards + n_seen). */
void lag_guards_at(LagRun *run, double t, const double *y, double *found);

/* Outputs, with the accelerations and multipliers of the state `beside`. */
void lag_outputs_beside(LagRun *run, double t, const double *beside, const double *y, double *outputs);

#endif
