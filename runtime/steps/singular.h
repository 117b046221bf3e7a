/* Whether a singular position of a constrained mechanism is near. */
#ifndef LAG_SINGULAR_H
#define LAG_SINGULAR_H

#include "state/state.h"

void lag_singular_layout(LagRun *run, LagArena *arena);

/* How much more accelerations change across the constraints than along the motion, over displacements of the same size, a
 * thousandth of a step of length h: near 1 in general, hundreds and more near singular positions. */
double lag_singularity(LagRun *run, double h);

#endif
