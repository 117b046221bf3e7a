/* One accepted step of a run. */
#ifndef LAG_STEP_H
#define LAG_STEP_H

#include "state.h"

LagStatus lag_step(LagRun *run);

#endif
