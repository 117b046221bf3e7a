/* What a run is asked for, and what it tells of itself. */
#ifndef LAG_SETTINGS_H
#define LAG_SETTINGS_H

#include "base/status.h"
#include "state/facts.h"

typedef struct LagRun LagRun;

/* Ways to step. AUTO stands for the one the model names, or the cheapest one of TRANSITION, PIRK, ERK9, ERK, ERK5, ADAMS and TAYLOR;
 * STEPWISE for the latter four, whose steps are as short as the motion is quick. Both go over to implicit steps where those are cheaper, and back.
 * TRANSITION is LINEAR in doubles, ORBIT reads steps that were kept: outside they are called by what they stand for. */
enum {
    LAG_SOLVER_AUTO,
    LAG_SOLVER_ERK,
    LAG_SOLVER_LINEAR,
    LAG_SOLVER_IMPLICIT,
    LAG_SOLVER_ISLANDS,
    LAG_SOLVER_CONSERVATIVE,
    LAG_SOLVER_TAYLOR,
    LAG_SOLVER_ERK5,
    LAG_SOLVER_ADAMS,
    LAG_SOLVER_STEPWISE,
    LAG_SOLVER_TRANSITION,
    LAG_SOLVER_ORBIT,
    LAG_SOLVER_ERK9,
    LAG_SOLVER_PIRK,
    LAG_SOLVERS /* how many numbers there are */
};

/* Smaller tolerances are raised to this one. */
#define LAG_SMALLEST_TOLERANCE 1e-14

typedef struct {
    double t_start, t_stop; /* t_stop may be infinity */
    double tolerance;       /* of the result, in motions that are not chaotic: see scale.c */
    double max_step;        /* 0: no limit */
    double first_step;      /* 0: found automatically */
    int64_t max_steps;      /* 0: no limit */
    int32_t solver;         /* LAG_SOLVER_...; automatic: the one the model names */
} LagSettings;

typedef struct {
    int64_t steps, rejected, rhs_evaluations, dense_outputs, events;
    int64_t projections; /* Newton corrections of positions and of velocities */
    int64_t implicit_steps, jacobians, factorisations; /* of the implicit method */
    double smallest_step, largest_step; /* of the accepted steps */
    double energy_residual; /* largest |H - H(0) + dissipated - work| seen */
    double energy_scale;    /* largest of |T|, |V|, |H|, |dissipated|, |work| in rows */
    double energy_stored;   /* largest of |T|, |V|, |H| in rows, in steps now and then, and foreseen where they are 0 */
    double energy_risen;    /* largest H - H(0) seen */
    double energy_given;    /* largest work - dissipated seen: what H could rise by */
    double energy_open;     /* time of the first row from which on the account misses by more than the tolerance explains */
    double energy_rounding; /* largest miss that is explained by rounding, not by the tolerance */
    double unsure_time;     /* of the first row of which an output is not known: rounding decides it */
    double jam_time;        /* of the first impulse without a collision: friction pressed further what slid, and no force held it */
    double constraint_residual;      /* largest |Phi| in rows */
    double constraint_rate_residual; /* largest |J v + dPhi/dt| in rows */
    int32_t worst;          /* component that last limited the step: q is 0 .. n-1, v is n .. 2n-1 */
    int32_t tolerance_raised;
    int32_t tolerance_missed; /* steps near singular positions that were taken with a larger error */
    int32_t solver;           /* LAG_SOLVER_...: in use now */
    int32_t switches;         /* from one solver to another */
    int32_t energy_is_open;   /* whether there is such a row */
    int32_t passed;           /* 1 + the first event whose contact was passed at the start, so that it does not come; 0: none */
    int32_t jammed;           /* 1 + an event it stopped; 0: there was none */
    int32_t unsure;           /* how many there are */
    int32_t unsure_output;    /* the first that is not known in the first one */
    int32_t rule;             /* of lag_rule: the row of the choice that decided last; 0: none yet */
    int32_t chosen;           /* LAG_SOLVER_...: what it took */
    int64_t steps_by[LAG_SOLVERS]; /* of them all, those of each solver */
    LagFacts facts;           /* what that row went by */
} LagStatistics;

#endif
