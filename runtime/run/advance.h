/* A run that another one drives. */
#ifndef LAG_ADVANCE_H
#define LAG_ADVANCE_H

#include "state/state.h"

/* The row at t, which may lie inside the latest step. LAG_PAUSED: run->deadline has passed. */
LagStatus lag_advance_to(LagRun *run, double t, double *row);

/* The same without energies, which are NaN, where nobody asks for them: half of what a row of a small tree costs. */
LagStatus lag_advance_motion_row(LagRun *run, double t, double *row);

/* One step, as lag_retry_step; none where a guard has ended the run. */
LagStatus lag_advance_step(LagRun *run);

#endif
