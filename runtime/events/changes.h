/* Which conditions have changed at the present state. */
#ifndef LAG_CHANGES_H
#define LAG_CHANGES_H

#include "state/settings.h"

/* Notes in switches.turned which have changed there, or change there: segments begin with that. `after`: n_switches conditions just behind
 * the place that was found; NULL: none was. Returns the first; -1: none. */
int lag_changes_note(LagRun *run, const double *after);

/* Whether an event is among those that are noted. */
int lag_changes_come(const LagRun *run);

#endif
