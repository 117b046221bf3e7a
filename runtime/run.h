/* A run: one motion of one model. Runs share nothing; each may live in a thread of its own.
 *
 * Order of calls: new, set_parameters, set_inputs, start, then advance as often as wanted. A run can be started again.
 *
 * A row of results is t, q[n], v[n], y[n_outputs], T, V, H, dissipated, work. A row at the time of an event shows the modes
 * and inputs in force before it; a row at the start those in force after it.
 */
#ifndef LAG_RUN_H
#define LAG_RUN_H

#include "model.h"
#include "status.h"

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
    double energy_stored;   /* largest of |T|, |V|, |H| in rows, and in steps now and then */
    double energy_risen;    /* largest H - H(0) seen */
    double energy_given;    /* largest work - dissipated seen: what H could rise by */
    double energy_open;     /* time of the first row from which on the account misses by more than the tolerance explains */
    double constraint_residual;      /* largest |Phi| in rows */
    double constraint_rate_residual; /* largest |J v + dPhi/dt| in rows */
    int32_t worst;          /* component that last limited the step: q is 0 .. n-1, v is n .. 2n-1 */
    int32_t tolerance_raised;
    int32_t tolerance_missed; /* steps near singular positions that were taken with a larger error */
    int32_t solver;           /* LAG_SOLVER_...: in use now */
    int32_t switches;         /* from one solver to another */
    int32_t energy_is_open;   /* whether there is such a row */
    int32_t passed;           /* 1 + the first event whose contact was passed at the start, so that it does not come; 0: none */
    int64_t steps_by[LAG_SOLVERS]; /* of them all, those of each solver */
} LagStatistics;

/* All memory is allocated here, but for input tables. NULL: out of memory. The model must outlive the run. */
LAG_API LagRun *lag_run_new(const LagModel *model, const LagSettings *settings);
LAG_API void lag_run_free(LagRun *run);

/* LAG_SOLVER_...: the one that a run with these settings begins with, all parameters from their bindings. */
LAG_API int32_t lag_run_solver(const LagModel *model, const LagSettings *settings);

/* given[n_parameters] where mask is not 0; the others from their bindings. NULL, NULL: all from their bindings. */
LAG_API LagStatus lag_run_set_parameters(LagRun *run, const double *given, const double *mask);
LAG_API const double *lag_run_parameters(const LagRun *run);

/* Table of inputs, linear between rows, held outside: times[rows], values[rows * n_inputs]; copied. */
LAG_API LagStatus lag_run_set_inputs(LagRun *run, const double *times, const double *values, int rows);

/* Start values of the model's n_lost coordinates and of their rates, NaN where not given, for the starts to come; NULL: none. */
LAG_API void lag_run_set_lost(LagRun *run, const double *given);

/* Start values, NaN or NULL where not given; those given are not moved to satisfy initial equations. */
LAG_API LagStatus lag_run_start(LagRun *run, const double *q_given, const double *v_given);

/* No step goes past t_stop. It may be moved on while running, as a co-simulation does. */
LAG_API void lag_run_set_stop(LagRun *run, double t_stop);

/* The present time becomes t, inside the latest step: what happens at t (inputs, parameters) may then be set. */
LAG_API LagStatus lag_run_cut(LagRun *run, double t);

LAG_API int lag_run_row_width(const LagModel *model);

/* One row for each of the ascending times. *done rows are valid whatever is returned. seconds: wall time, 0: no limit. */
LAG_API LagStatus lag_run_advance(LagRun *run, const double *times, int rows, double *results, int *done, double seconds);

/* One row after each accepted step, until the rows are full or t_stop is reached (*done < rows). */
LAG_API LagStatus lag_run_advance_steps(LagRun *run, int rows, double *results, int *done, double seconds);

/* The row of the present time. */
LAG_API LagStatus lag_run_row(LagRun *run, double *row);

LAG_API double lag_run_time(const LagRun *run);
LAG_API const LagStatistics *lag_run_statistics(LagRun *run);

/* About the last call that did not answer LAG_OK or LAG_PAUSED. */
LAG_API const LagFailure *lag_run_failure(const LagRun *run);

#endif
