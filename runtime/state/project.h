/* Back to the constraints: positions with Phi(q, t) = 0, then velocities with J v + dPhi/dt = 0. */
#ifndef LAG_PROJECT_H
#define LAG_PROJECT_H

#include "state/closure.h"
#include "model/model.h"
#include "state/settings.h"

/* Of a projected state. */
typedef struct {
    double energies[3]; /* T, V, H */
    double gap, rate;   /* largest residuals of positions and of rates */
} LagClosure;

typedef struct {
    double *state, *carry;         /* 2 n: the state being corrected, and what rounding took from it */
    double *before, *before_carry; /* n: positions or rates before the latest correction */
    double *correction, *unit;     /* 2 n: the latest, and units of error to compare it with */
    double *phi, *rate;            /* n_holonomic, n_multipliers: residuals */
    LagClosure latest, end;        /* of the state corrected latest, and of the end of the latest step */
    int is_complete;               /* the energies and residuals of the latest are known */
    int is_exact;                  /* what was left of it is rounding */
    double end_time;               /* where the end is as exact as rows are; NaN where it is not */
    LagClosureMeasure measure;     /* of what the residuals mean */
    int waits;                     /* the latest step hardly drifted */
} LagProjection;

void lag_projection_layout(LagProjection *projection, const LagModel *model, LagArena *arena);

/* Each of these does nothing to a model without constraints. */

/* The state just tried, at t. Returns 0; or, where the constraints are farther away than a good step could have gone astray, how
 * far in units of error: infinity where they are out of reach, or the step is an ordinary one. *worst is then the component that
 * moves most, and nothing is changed if that is more than `allowed`. */
double lag_project_step(LagRun *run, double t, double allowed, int *worst);

/* Whether a state (q, v) at t that is being tried is so near the constraints that it tells how large motions are: steps that run away
 * leave them, however small their errors are beside where they landed; steps far through contacts look like any others. */
int lag_project_is_near(LagRun *run, double t, const double *y);

/* Whether a short step to t may go unprojected: the one before hardly drifted, nor has it, and it is not the last. */
int lag_project_waits(LagRun *run, double t);

/* The present state, however far it is from the constraints: at the start, and when parameters or modes have changed. */
void lag_project_present(LagRun *run);

/* Energies at the present time are no longer what they were: parameters, inputs or the state have changed. */
void lag_project_forget(LagRun *run);

/* A state (q, v, ...) at t, inside the latest step. */
void lag_project_inside(LagRun *run, double t, double *y);

/* The same for a row, whose residuals it notes in the statistics. {T, V, H} of the row go to `energies`, without constraints,
 * too. Returns how far its constraints are open, relative to the motion; there is no more to it up to `most`. */
double lag_project_row(LagRun *run, double t, double *y, double *energies, double most);

#endif
