/* Conditions in forces of which what they compare is equal, and stays so: nothing tells a side, and forces are what they say of that. */
#ifndef LAG_STANDING_H
#define LAG_STANDING_H

#include "model/model.h"
#include "state/settings.h"

enum { LAG_WHOLE = 3 }; /* in at_level of the model: of whole numbers, which are what they are */

/* What switch i holds where what it compares is equal: 0.5 where no force jumps with it. */
double lag_standing_value(const LagModel *model, int i);

/* What slides has been chosen: those into switches.stands; what they hold, as what goes away from there a moment later. Returns whether
 * some hold anything else than before. */
int lag_standing_find(LagRun *run);

/* Whether switch i still stands, where conditions are switches.g and their rates switches.rate. */
int lag_standing_lasts(const LagRun *run, int i);

#endif
