/* Attitudes in steps of iterated collocation: their positions are integrals of N(s) w, not of the rates w (state/attitudes.c). The
 * detours, N(s) w - w, lie behind accelerations and powers, three rows an attitude: positions follow from the rates of a sweep and the
 * detours of the one before, which are small where the rates are not, so that sweeps come nearer as those of other coordinates do.
 */
#ifndef LAG_PIRK_ATTITUDES_H
#define LAG_PIRK_ATTITUDES_H

#include "model/attitude_places.h"
#include "numbers/wide.h"
#include "state/motion.h"

/* So many rows. */
static inline int lag_pirk_detours(const LagMotion *motion) { return 3 * motion->n_attitudes; }

/* The coordinate that row k of them is of. */
static inline int lag_pirk_detour_of(const LagMotion *motion, int k) { return lag_attitude_place(motion->attitudes, k / 3) + k % 3; }

/* Those of eight states with the positions q and rates v, into rows of this stride. */
void lag_pirk_find_detours(const LagMotion *motion, const double *q, const double *v, double *detours, int stride);

#endif
