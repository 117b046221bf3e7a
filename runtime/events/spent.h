/* What holds gives no more than it has: within a step of an importer, which finds out where it lets go once the step is over. */
#ifndef LAG_SPENT_H
#define LAG_SPENT_H

#include "state/state.h"

/* Before accelerations are found with all that slides; and after it, when all of it slides again. */
void lag_spent_begin(LagRun *run);
void lag_spent_end(LagRun *run);

/* Those of whose latest shares more is asked than there is give what there is, and hold nothing any more. Returns whether there are
 * some: accelerations are to be found anew. */
int lag_spent_reach(LagRun *run);

#endif
