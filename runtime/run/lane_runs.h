/* Runs that come into lanes, are looked at there, and go. */
#ifndef LAG_LANE_RUNS_H
#define LAG_LANE_RUNS_H

#include "run/lanes_state.h"

/* What is to come into lanes that are free. Returns 0 when it was stopped, as all below do. */
int lag_lanes_fill(LagRunLanes *lanes);

/* Something is due after a good step in the lane. */
int lag_lanes_attend(LagRunLanes *lanes, int lane);

/* An event may have come in a good step in the lane. */
int lag_lanes_look(LagRunLanes *lanes, int lane);

/* The run in the lane is over. What is not well is made again, and told as it then is. */
int lag_lanes_end_run(LagRunLanes *lanes, int lane, LagStatus status);

/* What has ended and is not told yet is told. */
int lag_lanes_conclude(LagRunLanes *lanes);

/* There is nothing in the lane. */
void lag_lanes_leave(LagRunLanes *lanes, int lane);

#endif
