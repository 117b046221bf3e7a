/* The length of a first step, at the start and after every event. */
#ifndef LAG_FIRST_STEP_H
#define LAG_FIRST_STEP_H

#include "motion.h"
#include "scale.h"

/* Not longer than `longest`, for a method of this order; motion->slope is known. */
double lag_first_step(LagMotion *motion, const LagScale *scale, double longest, int order);

#endif
