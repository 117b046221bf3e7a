/* The length of a first step, at the start and after every event. */
#ifndef LAG_FIRST_STEP_H
#define LAG_FIRST_STEP_H

#include "state/motion.h"
#include "state/scale.h"

/* How soon the accelerations change, as far as steps up to `longest` tell; motion->slope is known. Kinds that are moved by less than
 * `faint` units of error say nothing. */
double lag_slowness(LagMotion *motion, const LagScale *scale, double longest, double faint);

/* For a method of this order where they change so soon. */
double lag_first_step(const LagScale *scale, double slowness, int order);

#endif
