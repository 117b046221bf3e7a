/* Rest: what is held and moved by nothing but rounding stays where it is. */
#ifndef LAG_REST_H
#define LAG_REST_H

#include "status.h"

struct LagRun;

/* Where forces that hold leave nothing that moves, and nothing depends on time: all rates become 0. Returns whether the scene rests. */
int lag_rest_begins(struct LagRun *run);

/* Time passes, up to the next event. */
LagStatus lag_rest_step(struct LagRun *run);

/* After a step was tried: coordinates that rested before it, and that it moved by no more than rounding of their accelerations, rest. */
void lag_rest_keep(struct LagRun *run);

#endif
