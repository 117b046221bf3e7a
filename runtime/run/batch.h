/* Many runs of one model, with nobody between them: parameters and start values in, a few numbers of each motion out.
 *
 * A batch drives one run again and again; the result of a run does not depend on those before it. Batches share nothing, so
 * that each may live in a thread of its own. A run that fails is an outcome, and the next one goes on.
 */
#ifndef LAG_BATCH_H
#define LAG_BATCH_H

#include "run/follow.h"

typedef struct LagBatch LagBatch;

enum { LAG_RUN_DONE, LAG_RUN_FAILED, LAG_RUN_PARAMETER, LAG_RUN_OVERTIME, LAG_RUN_OPEN };

enum { LAG_GUARD_BITS = 31 };

typedef struct {
    int32_t kind;       /* LAG_RUN_...; of a wrong parameter, failure holds its index (lag_run_wrong_parameter) and its
                         * value; of an energy account that is open, the time from which on it is,
                         * and by how much of its size: results are there all the same */
    int32_t warned;     /* bits of the guards that warned; the last one stands for all beyond */
    LagFailure failure;
    int64_t steps;
    double energy;      /* residual of the energy account, relative to the largest energy */
    int64_t methods;    /* bits of LAG_SOLVER_...: what took the steps */
} LagOutcome;

/* Copies the sweep. NULL: out of memory. The run must outlive the batch and serves nobody else; it has its inputs already. */
LAG_API LagBatch *lag_batch_new(const LagModel *model, LagRun *run, const LagSweep *sweep);
LAG_API void lag_batch_free(LagBatch *batch);

/* values[runs * n_varied] -> results[runs * n_reductions], outcomes[runs], and rows[runs * n_rows * width] where there are any.
 * held[runs * (n_rows - 1) * n_inputs]: inputs from each row to the next, which no step goes across; NULL: they are as they are.
 * Results that a motion does not have are NaN, and rows that it does not reach.
 * Answers how many runs were done: fewer only when *stop was set to something else than 0 meanwhile. */
LAG_API int64_t lag_batch_advance(LagBatch *batch, int64_t runs, const double *values, const double *held, double *results,
                                  LagOutcome *outcomes, double *rows, const volatile int32_t *stop);

/* Of runs in lanes (run_lanes.h), since the batch was made: those that ended there, those that were made alone after all, steps of all,
 * what there was room for, and how often runs left a lane for an event. Zeros where lanes do not serve. */
enum { LAG_LANES_RUNS, LAG_LANES_ALONE, LAG_LANES_STEPS, LAG_LANES_ROOM, LAG_LANES_LEFT, LAG_LANES_COUNTS };
LAG_API void lag_batch_lanes(const LagBatch *batch, int64_t *counts);

/* The rainflow cycles of the latest run for a reduction that keeps them; they last until the next run. */
LAG_API const LagCycle *lag_batch_cycles(const LagBatch *batch, int reduction, int64_t *count);

#endif
