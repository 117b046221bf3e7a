/* States and shares of candidates for sliding: candidates.h. */
#ifndef LAG_SLIDE_STATES_H
#define LAG_SLIDE_STATES_H

#include "events/sliding.h"
#include "state/settings.h"

/* What of dg/dt is rounding in the choice, by its terms. */
#define LAG_STATES_ROUNDING 1e-12

/* States and shares of `count` candidates at a state, where each depends on few others. Returns whether they are right. */
int lag_states_choose(LagRun *run, double t, const double *y, int count);

/* The same where each may depend on all. */
int lag_states_choose_any(LagRun *run, double t, const double *y, int count);

/* Whether the g of candidate k changes. */
int lag_states_goes(const LagSliding *s, int count, int k);

#endif
