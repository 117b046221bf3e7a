/* Radau IIA methods of order 5, 9 and 13 for q'' = a(t, q, q'), one step at a time: stiff scenes. */
#ifndef LAG_RADAU_H
#define LAG_RADAU_H

#include "methods/radau_border.h"
#include "methods/collocation.h"
#include "model/implicit_matrix.h"
#include "state/method.h"

typedef struct {
    const LagRadauTableau *tableau; /* of the next step */
    int since_change;               /* steps since it was chosen */
    LagImplicitMatrix matrix;
    LagBorder border;               /* of what slides */
    int jacobian_is_known, jacobian_is_fresh; /* at some state; at the present one */
    double factored;                          /* step that the factors are for; 0: none */
    const LagRadauTableau *factored_tableau;

    LagCollocation trial, last; /* the step being tried, and the one before */
    int has_last, had_last; /* the latter: before the latest step */
    double *slope;              /* size: dy/dt at the present state */
    double *place;              /* stages x n: positions minus those at the beginning */
    double *force;              /* stages x n: accelerations */
    double *change;             /* stages x n: of the rates, by an iteration */
    double *w_re, *w_im;        /* n */
    double *weight;             /* 2 n: 1 / unit of error; 0: does not count */
    double *error, *filtered;   /* 2 n */

    double doubt;       /* error of the energy quadratures in the step being tried */
    double missed;      /* the largest of them, in units of what they count by; 0: they do not */
    double contraction; /* of the latest iterations, per iteration */
    double patience;    /* error left, as a multiple of the latest change */
    int iterations;
    int64_t evaluations; /* of stages so far */
    double accepted_step, accepted_error; /* of the step before; 0: none */
} LagRadau;

extern const LagMethod lag_radau;

/* -------- the equations of a step (radau_newton.c) */

typedef enum { LAG_STAGES_CONVERGED, LAG_STAGES_SLOW, LAG_STAGES_DIVERGED, LAG_STAGES_NOT_FINITE, LAG_NO_JACOBIAN } LagConvergence;

/* Error of component i that counts as 1 in the step being tried, to y_new: not less than rounding of the time moves it. Motions
 * that set in from rest are not resolved against noise. */
double lag_radau_unit(const LagRadau *s, const LagMotion *motion, const LagScale *scale, int i, const double *y_new);

/* Iterations allowed with so many stages. */
int lag_radau_most_iterations(const LagRadauTableau *tableau);

/* Jacobian and factors for a step of length h, as far as they are not there. Returns 0 when derivatives are not finite. */
int lag_radau_prepare(LagRadau *s, struct LagRun *run, double h);

/* Solves for the stages of a step of length h. SLOW: *shorter is the factor by which a step should be shorter. */
LagConvergence lag_radau_solve(LagRadau *s, struct LagRun *run, double h, double *shorter, int *worst);

/* The new state into motion->other, from the stages; 0 when the powers are not finite. */
int lag_radau_finish(LagRadau *s, struct LagRun *run, double h);

/* Whether the error of a quadrature, `missed`, is more than the stages' own errors make of it: of stiff forces they tell few digits. */
int lag_radau_knows_powers(LagRadau *s, struct LagRun *run, double h);

/* The error of the embedded method in units; with `again` filtered once more, for first and rejected steps. */
double lag_radau_error(LagRadau *s, struct LagRun *run, double h, int again, int *worst);

/* Whether the stages are those of a motion. Where forces come again with each turn the equations of a long step have many solutions,
 * with all stages at like angles, whose accelerations do not change and whose error is none: a pendulum that whirls ever faster. */
int lag_radau_is_solution(LagRadau *s, struct LagRun *run, double h);

#endif
