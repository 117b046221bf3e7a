/* What a batch consists of, and what runs alone and runs in lanes do alike. Private to batch.c and run_lanes.c. */
#ifndef LAG_BATCH_STATE_H
#define LAG_BATCH_STATE_H

#include "run/batch.h"

typedef struct LagRunLanes LagRunLanes;

struct LagBatch {
    const LagModel *model;
    LagSweep sweep; /* its lists are those of the batch */
    double *memory;
    LagReduction *reductions;
    int *varied, *at; /* at: the reductions of kind LAG_REDUCE_AT in the order of their times */
    int n_at;
    int varies_parameters;
    double *mask;
    double *p, *state; /* of the run that is started: parameters and start values given */
    LagFollower alone;
    LagRunLanes *lanes; /* NULL: all runs are made one by one */
    /* of the present call: see lag_batch_advance */
    const double *values, *held;
    double *results, *rows;
    LagOutcome *outcomes;
    const volatile int32_t *stop;
};

/* What is given for a run, into `p`, where parameters vary, and `state`. */
void lag_batch_insert(const LagBatch *batch, int64_t run);

/* Starts run i, with nothing known of it. */
LagStatus lag_batch_begin(LagBatch *batch, LagFollower *follower, int64_t i);

/* The account is closed, and results and outcome are written. */
void lag_batch_conclude(LagBatch *batch, LagFollower *follower, int64_t i, LagStatus status);

/* Run i from its start to its end. Returns 0 when it was stopped. */
int lag_batch_alone(LagBatch *batch, int64_t i);

#endif
