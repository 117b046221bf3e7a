/* A correction onto the constraints: how large it is, and adding it. Components first .. first + n - 1 of the state: its positions, or
 * its rates.
 */
#ifndef LAG_CORRECTION_H
#define LAG_CORRECTION_H

#include "state/settings.h"

/* The largest component, each compared with its coordinate; infinity when they are not finite. */
double lag_correction_size(const LagRun *run, int first);

/* Whether none of its components first .. first + count - 1 is above a unit of error. */
int lag_correction_is_fine(const LagRun *run, int first, int count);

/* Whether a correction of positions is rounding beside their natural sizes. */
int lag_correction_is_rounding(const LagRun *run);

/* Adds it to the projection's state as the integrator adds its steps, compensated. */
void lag_correction_apply(LagRun *run, int first);

#endif
