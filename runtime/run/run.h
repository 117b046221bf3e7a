/* A run: one motion of one model. Runs share nothing; each may live in a thread of its own.
 *
 * Order of calls: new, set_parameters, set_inputs, start, then advance as often as wanted. A run can be started again.
 *
 * A row of results is t, q[n], v[n], y[n_outputs], T, V, H, dissipated, work. A row at the time of an event shows the modes
 * and inputs in force before it; a row at the start those in force after it.
 */
#ifndef LAG_RUN_H
#define LAG_RUN_H

#include "model/model.h"
#include "state/settings.h"

/* All memory is allocated here, but for input tables. NULL: out of memory. The model must outlive the run. */
LAG_API LagRun *lag_run_new(const LagModel *model, const LagSettings *settings);
LAG_API void lag_run_free(LagRun *run);

/* LAG_SOLVER_...: the one that a run with these settings begins with, all parameters from their bindings, and why; decision may be
 * NULL. */
LAG_API int32_t lag_run_solver(const LagModel *model, const LagSettings *settings, LagDecision *decision);

/* given[n_parameters] where mask is not 0; the others from their bindings. NULL, NULL: all from their bindings. */
LAG_API LagStatus lag_run_set_parameters(LagRun *run, const double *given, const double *mask);
LAG_API const double *lag_run_parameters(const LagRun *run);

/* The first parameter that is not finite or not from least to most (n_parameters each); n_parameters more than the first of
 * LagModel.requirements that is not met; -1: all are possible. */
LAG_API int lag_run_wrong_parameter(const LagRun *run, const double *least, const double *most);

/* The same without the requirements, of parameters that none of them asks for. */
LAG_API int lag_run_parameter_beyond(const LagRun *run, const double *least, const double *most);

/* The first of LagModel.requirements that is only told and not met, or -1. */
LAG_API int lag_run_told_parameter(const LagRun *run);

/* Table of inputs, linear between rows, held outside: times[rows], values[rows * n_inputs]; copied. */
LAG_API LagStatus lag_run_set_inputs(LagRun *run, const double *times, const double *values, int rows);

/* Start values of the model's n_lost coordinates and of their rates, NaN where not given, for the starts to come; NULL: none. */
LAG_API void lag_run_set_lost(LagRun *run, const double *given);

/* Start values, NaN or NULL where not given; those given are not moved to satisfy initial equations. Those of an attitude are four
 * times the modified Rodrigues vector of how it is turned (state/attitudes.c, against no turn), all three or none of them. */
LAG_API LagStatus lag_run_start(LagRun *run, const double *q_given, const double *v_given);

/* The same of a run that was started before, with the same inputs and settings: its states since were made elsewhere, as in lanes
 * (run_lanes.h), and nothing was asked of it but rows at their ends. Of models in which nothing happens and no start is asked for. */
int lag_run_starts_again(const LagModel *model);
LagStatus lag_run_start_again(LagRun *run, const double *q_given, const double *v_given);

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

/* From now on the times of events go into times[most], as many as it holds; the caller keeps it. */
LAG_API void lag_run_log_events(LagRun *run, double *times, int most);

/* How many it holds. */
LAG_API int lag_run_logged(const LagRun *run);

/* About the last call that did not answer LAG_OK or LAG_PAUSED. */
LAG_API const LagFailure *lag_run_failure(const LagRun *run);

#endif
