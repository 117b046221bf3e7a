/* A run that another one drives. */
#ifndef LAG_ADVANCE_H
#define LAG_ADVANCE_H

#include "state.h"

/* The row at t, which may lie inside the latest step. LAG_PAUSED: run->deadline has passed. */
LagStatus lag_advance_to(LagRun *run, double t, double *row);

/* The state (q, v, energy quadratures) at t, inside or at the end of the latest step; not yet on the constraints. */
void lag_state_inside(LagRun *run, double t, double *y);

/* The state at t inside the latest step, brought back to the constraints, becomes the present one. */
void lag_go_back(LagRun *run, double t);

#endif
