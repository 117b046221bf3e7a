/* Runs in lanes: eight runs of a batch go on together, each at its own time and with its own steps, and a lane whose run has ended takes
 * the next one.
 *
 * Steps are those of series (wide_taylor.h), or of Runge-Kutta pairs (wide_explicit.h), of what choice.c would leave to such
 * methods, or of the pair that is asked for, and as good: a run whose steps turn out to be bound by stability, that steps do not get on
 * with, that a guard ends, or whose energy account does not close, is made again alone, as it would be without lanes. A pair that is
 * chosen is another one where somebody looks inside steps, as guards do: digits within the tolerance are others then.
 *
 * Where there are events (wide_conditions.h), steps are those of series. A step in which a condition may have changed is looked at by the
 * run itself; where one has, the run leaves the lane, goes on alone, and comes back when nothing is held and nothing has just begun.
 *
 * Whether and how a run goes in a lane depends on nothing but itself, and so do its digits.
 */
#ifndef LAG_RUN_LANES_H
#define LAG_RUN_LANES_H

#include "run/batch_state.h"

/* NULL: there is no memory, or lanes do not serve what the batch does. */
LagRunLanes *lag_lanes_new(LagBatch *batch);
void lag_lanes_free(LagRunLanes *lanes);

/* As lag_batch_advance. */
int64_t lag_lanes_advance(LagRunLanes *lanes, int64_t runs);

/* LAG_LANES_COUNTS numbers. */
const int64_t *lag_lanes_counts(const LagRunLanes *lanes);

#endif
