/* A run that another one drives. */
#ifndef LAG_ADVANCE_H
#define LAG_ADVANCE_H

#include "state/state.h"

/* The row at t, which may lie inside the latest step. LAG_PAUSED: run->deadline has passed. */
LagStatus lag_advance_to(LagRun *run, double t, double *row);

#endif
