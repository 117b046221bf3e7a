/* Whether a singular position of a constrained mechanism is near. */
#ifndef LAG_SINGULAR_H
#define LAG_SINGULAR_H

#include "state/state.h"

void lag_singular_layout(LagRun *run, LagArena *arena);

/* How much more accelerations change across the constraints than along the motion, over displacements of the same size, a
 * thousandth of a step of length h: near 1 in general, hundreds and more near singular positions. */
double lag_singularity(LagRun *run, double h);

/* Whether a singular position lies within the next step of about h, or not far behind it: what rates across the constraints do to
 * accelerations becomes something else on the way. Costs five evaluations. */
int lag_singular_is_ahead(LagRun *run, double h);

#endif
