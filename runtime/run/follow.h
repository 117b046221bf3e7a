/* What is taken from one run of many while it goes on: reductions, and rows that are kept. */
#ifndef LAG_FOLLOW_H
#define LAG_FOLLOW_H

#include "run/reduce.h"

typedef struct {
    double t_start, t_stop; /* those of the run */
    double window;          /* the motion is looked at in windows no longer than this: see reduce.h */
    double seconds;         /* wall time that one run may take; 0: no limit */
    int n_reductions;
    const LagReduction *reductions; /* times of LAG_REDUCE_AT lie between t_start and t_stop */
    int n_varied;
    const int *varied;          /* what differs from run to run: parameter k, or n_parameters + k for (q, v)[k] */
    const double *given, *mask; /* n_parameters: those given for all runs */
    const double *start;        /* 2 n: start values given for all runs, NaN where not */
    const double *least, *most; /* n_parameters: what each parameter may be */
    int is_driven; /* something is moved in time, and may bring energy whatever the steps */
    int in_lanes;  /* runs may go in lanes: run_lanes.h */
    int n_rows;    /* whole rows of each run that are kept, at these times, ascending, of the run's; their energies may be NaN */
    const double *row_times;
} LagSweep;

typedef struct {
    const LagModel *model;
    const LagSweep *sweep;
    LagRun *run;
    double *memory;
    LagWindow window;
    const int *at; /* the reductions of kind LAG_REDUCE_AT in the order of their times */
    int n_at, next_at;
    LagReduction *taken; /* what is asked for in the present of two runs */
    LagReduced *reduced;
    int *is_open;  /* those that the windows of the present step are looked at for */
    int n_pending; /* reductions over windows that are not known yet */
    int starts_again;   /* the run: as lag_run_start_again asks */
    int has_parameters; /* those of all runs, where these do not differ */
    int wrong_parameter; /* of the run's: see LagOutcome; -1: none */
    int needs_outputs;  /* somebody asks for more of rows than coordinates, rates and energies */
    double *row, *rows; /* a row; those that are kept */
    const double *held; /* inputs from each row to the next; NULL: as they are */
    int next_row;
    double next; /* the time of the next reduction at a time, or of the next row */
    int is_led; /* steps are made elsewhere, and nothing that rows tell of them is asked for */
    double end; /* of the run: t_stop, or where a guard ends it */
    double deadline;
    const volatile int32_t *stop;
} LagFollower;

/* The sweep, its lists and `at` are kept by the caller. Returns 0 when there is no memory. */
int lag_follow_new(LagFollower *follower, const LagModel *model, LagRun *run, const LagSweep *sweep, const int *at, int n_at);
void lag_follow_free(LagFollower *follower);

/* Nothing is known of the run that comes. */
void lag_follow_start(LagFollower *follower);

/* A second run is wanted: what needs one is started anew by what the first one has found; all else is known. */
int lag_follow_again(LagFollower *follower);

/* The inputs until the next row, if there is one. */
LagStatus lag_follow_hold(LagFollower *follower);

/* The run that was started is where others have brought it, and all rows before this one are there. */
LagStatus lag_follow_resume(LagFollower *follower, int row);

/* The run that was started, to its end: LAG_PAUSED where its time is over. */
LagStatus lag_follow_run(LagFollower *follower);

/* The same in pieces: what there is at the start; a step of the run, while reductions over windows are pending; what is left after
 * the last step. LAG_PAUSED where the run's time is over. */
LagStatus lag_follow_begin(LagFollower *follower);
LagStatus lag_follow_step(LagFollower *follower);
LagStatus lag_follow_end(LagFollower *follower);

/* The present row into `row`, whole where somebody may ask for more than its energies. */
LagStatus lag_follow_row(LagFollower *follower);

/* And of a step: reductions at times and kept rows up to t, all within the latest step or at its end; a glance at the step's ends, of
 * which the later one is in the window's `end`, which says how many reductions ask for a look inside it; and that look. */
LagStatus lag_follow_visit(LagFollower *follower, double t);
int lag_follow_glance(LagFollower *follower);
LagStatus lag_follow_watch(LagFollower *follower, int open);

/* The motion, or quantities alone, start anew at t. */
LagStatus lag_follow_enter(LagFollower *follower, double t);

int lag_follow_is_over(const LagFollower *follower);

/* The results, NaN where the motion has none: of a run that did not end well those that are known. */
void lag_follow_results(LagFollower *follower, LagStatus status, double *results);

#endif
