/* Motion that sets in from rest, where nothing has a size yet. */
#ifndef LAG_ONSET_H
#define LAG_ONSET_H

#include "motion.h"
#include "scale.h"

/* Where a kind of coordinates rests and nothing accelerates it, the loads until `end` tell how well accelerations will be known.
 * m->slope is that of the present state. */
void lag_onset_look(LagMotion *m, LagScale *scale, double end);

/* Takes notice of the motion that the step just tried to t_new has brought about, or that the loads there would. */
void lag_onset_foresee(LagMotion *m, LagScale *scale, double t_new);

#endif
