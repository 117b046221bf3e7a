/* How well rounding lets the accelerations be known, at tight tolerances. */
#ifndef LAG_ROUNDING_H
#define LAG_ROUNDING_H

#include "state/settings.h"

/* Before a step: looks now and then. */
void lag_rounding_watch(LagRun *run);

/* scale->noise: by how much accelerations change when the state is moved by rounding. */
void lag_rounding_look(LagRun *run);

#endif
