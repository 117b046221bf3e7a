/* What holds where contacts and friction cannot be chosen one by one, since each depends on the others: as one problem
 * (complementarity.h), which is linear in forces, where shares of friction that presses with the force of a contact are multiplied. */
#ifndef LAG_JAMS_H
#define LAG_JAMS_H

#include "state/settings.h"

/* The shares of the first `count` of sliding.which at a state: into sliding.share; impacts.problem has their states. Returns 0 where there
 * are none. */
int lag_jams_solve(LagRun *run, double t, const double *y, int count);

/* Whether there are forces that candidate k could have, by the latest solution. */
int lag_jams_may_act(const LagRun *run, int k);

#endif
