/* Motion that sets in from rest, where nothing has a size yet. */
#ifndef LAG_ONSET_H
#define LAG_ONSET_H

#include "state/motion.h"
#include "state/scale.h"

/* Accelerations below this one are none, in any units. */
#define LAG_ONSET_FAINT 1e-100

/* Where a kind of coordinates rests and nothing accelerates it, the loads until `end` tell how well accelerations will be known.
 * m->slope is that of the present state. */
void lag_onset_look(LagMotion *m, LagScale *scale, double end);

/* Where something has just changed: what h, in which accelerations change by about themselves, makes of a kind that hardly moved is
 * its size from now on. */
void lag_onset_expect(LagMotion *m, LagScale *scale, double h);

/* What a step to t_new that was rejected, with an error (relative to the state), tells of the size of motions: its end does where it
 * is wrong by less than `foreseen`. */
void lag_onset_learn(LagMotion *m, LagScale *scale, double t_new, double error, double foreseen);

/* What has just been let go may begin with accelerations that change within `moment`, in which times cannot be told apart, by about
 * themselves: their change in that is rounding. m->slope is that of the present state. */
void lag_onset_blur(LagMotion *m, LagScale *scale, double moment);

#endif
