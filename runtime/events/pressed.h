/* Friction that presses with the force N of a contact that slides as well is mu N (2 s - 1), a product of two shares, with no share s where
 * N passes 0. Accelerations are linear in both forces: it is these that are changed. */
#ifndef LAG_PRESSED_H
#define LAG_PRESSED_H

#include "state/settings.h"

/* Changes the shares share[count] of the first of sliding.which by `times` sliding.change, as dg/dt depends on them at
 * sliding.factored. */
void lag_pressed_add(const LagRun *run, int count, double times, double *share);

/* Whether what presses the friction at place k would pull, so that no share of it is right. */
int lag_pressed_is_pulled(const LagRun *run, int count, int k);

/* How large sliding.change is at place k, by the unit of its share; or of the force that it is a share of. */
double lag_pressed_change(const LagRun *run, int count, int k);

#endif
