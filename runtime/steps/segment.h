/* A segment: the time between two events. Modes are constant in it, inputs linear, accelerations smooth. */
#ifndef LAG_SEGMENT_H
#define LAG_SEGMENT_H

#include "state/state.h"

/* Chooses modes and inputs for the segment that begins at the present time. */
void lag_segment_enter(LagRun *run);

/* Evaluates the accelerations at its beginning and chooses a first step. */
LagStatus lag_segment_evaluate(LagRun *run);

/* The latter at the start of a run, behind the events that what is sampled there brings about. */
LagStatus lag_segment_begin(LagRun *run);

/* Both, at an event; keeps the energy account over it. */
LagStatus lag_segment_next(LagRun *run);

#endif
