/* Where conditions of time alone may come and go within a step: exp(-(t/w)^2) > 0.5 is true for 1.7 w. What stands inside of the functions
 * that make them tells where (compiler: narrow_places.py): g is 0 there, or turns round. */
#ifndef LAG_HIDING_H
#define LAG_HIDING_H

#include "state/state.h"

enum { LAG_HIDDEN = 64 };

/* Such places in the latest step, as shares of it, in order: at most LAG_HIDDEN. */
int lag_hiding_places(LagRun *run, double *places);

#endif
