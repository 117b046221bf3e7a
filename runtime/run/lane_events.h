/* Events of a run in a lane: what the run does itself about the latest step that the lane has made for it. */
#ifndef LAG_LANE_EVENTS_H
#define LAG_LANE_EVENTS_H

#include "state/state.h"

/* Looks at the step, which was shown to the run with all that dense output asks for, as if the run had made it. Returns whether a
 * condition has changed in it: the run is where that was then, and has to go on alone. */
int lag_lane_events_look(LagRun *run);

#endif
