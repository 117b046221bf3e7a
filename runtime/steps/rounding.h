/* How well rounding lets the accelerations be known, at tight tolerances. */
#ifndef LAG_ROUNDING_H
#define LAG_ROUNDING_H

#include "state/settings.h"

/* Before a step: looks now and then. */
void lag_rounding_watch(LagRun *run);

/* Before an implicit step, which rounding of accelerations does not shorten otherwise: looks now and then for what only that moves. */
void lag_rounding_watch_idle(LagRun *run);

/* scale->noise, scale->idle: by how much accelerations change when the state is moved by rounding. */
void lag_rounding_look(LagRun *run);

#endif
