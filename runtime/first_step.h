/* The length of a first step, at the start and after every event. */
#ifndef LAG_FIRST_STEP_H
#define LAG_FIRST_STEP_H

#include "dop853.h"

/* Not longer than `longest`; slope 0 of the solver is known. */
double lag_first_step(LagDop853 *solver, const LagScale *scale, double longest);

#endif
