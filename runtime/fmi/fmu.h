/* What the exporter says about a model: generated as `const LagFmu lag_fmu` beside `lag_model`.
 *
 * A value reference is a number counted through these groups, in this order. In FMI 3 that of an array is its first element's.
 */
#ifndef LAG_FMU_H
#define LAG_FMU_H

#include "model/model.h"

enum {
    LAG_GROUP_TIME,
    LAG_GROUP_STATE,     /* n_states: positions, a quaternion for the three of an attitude, and rates: states.c */
    LAG_GROUP_SLOPE,     /* n_states: their derivatives */
    LAG_GROUP_OUTPUT,    /* n_outputs, but for the quaternions of attitudes, which are the first of them */
    LAG_GROUP_ENERGY,    /* LAG_ENERGIES */
    LAG_GROUP_INPUT,
    LAG_GROUP_PARAMETER,
    LAG_GROUP_INDICATOR, /* n_switches: above 0 as long as steps may hold them */
    LAG_GROUP_KEPT_REAL, /* discrete variables: states that events alone change */
    LAG_GROUP_REAL,      /* constants */
    LAG_GROUP_INTEGER,
    LAG_GROUP_BOOLEAN,
    LAG_GROUP_STRING,
    LAG_GROUP_KEPT_INTEGER,
    LAG_GROUP_KEPT_BOOLEAN,
    LAG_GROUPS
};

enum {
    LAG_ENERGY_KINETIC,
    LAG_ENERGY_POTENTIAL,
    LAG_ENERGY_TOTAL,
    LAG_ENERGY_DISSIPATED,
    LAG_ENERGY_WORK,
    LAG_ENERGY_RESIDUAL,
    LAG_ENERGIES
};

typedef struct {
    const LagModel *model;
    const char *token;                    /* FMI 2: guid; FMI 3: instantiationToken */
    double start, tolerance;              /* of the default experiment */
    double stabilisation;                 /* rate in 1/s at which constraints and unit quaternions are approached in Model Exchange: exchange.c */
    int n_reals, n_integers, n_booleans, n_strings, n_kept_reals, n_kept_integers, n_kept_booleans;
    const double *reals, *integers, *booleans;
    const char *const *strings;
    const char *const *names;             /* by value reference */
    const char *const *guards;            /* n_guards: what is said where they break */
    const char *const *requirements;      /* what is said where each of LagModel.requirements is not met */
    const double *state_start;            /* n_states: as declared */
    const int *state_settable;            /* n_states */
    const double *nominal;                /* n_states */
    const double *input_start;
    const double *parameter_start;
    const double *minimum, *maximum;      /* n_parameters */
    const int *parameter_settable;        /* n_parameters: 0 where it follows from others */
    int has_knowns;                       /* whether the last six lists here are there */
    const int *kept;                      /* n_kept_reals, n_kept_integers, n_kept_booleans: the states that they are */
    const int *extents;                   /* FMI 3: how many numbers a value reference stands for; 0 within an array */
    /* By value reference, and one more: where what a number depends on begins in the next two, which tell scalars by their references,
     * rising, and how (fmi3DependencyKind); while the simulation runs, and at its start. */
    const int *known_first, *knowns, *known_kinds, *start_first, *starts, *start_kinds;
    /* q here as states have it. Derivatives of the slopes x', of y, and of the rates R of what may be held, which are 0 while it is. */
    LagFunction forward; /* t, q, v, u, d, w, p, dt, dq, dv, du, dd, dw, dp -> dx', dy, dR   along a direction */
    LagFunction adjoint; /* t, q, v, u, d, p, wx, wy, wR -> wt, wq, wv, wu, wd, wp   gradients of wx.x' + wy.y + wR.R */
} LagFmu;

extern const LagFmu lag_fmu;

#endif
