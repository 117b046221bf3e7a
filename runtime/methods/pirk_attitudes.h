/* Attitudes in steps of iterated collocation: their positions are integrals of ways, not of rates (state/attitudes.c). Ways, less the
 * rates at the beginning, lie behind accelerations and powers, three rows an attitude.
 */
#ifndef LAG_PIRK_ATTITUDES_H
#define LAG_PIRK_ATTITUDES_H

#include "model/attitude_places.h"
#include "numbers/wide.h"
#include "state/motion.h"

/* So many rows. */
static inline int lag_pirk_ways(const LagMotion *motion) { return 3 * motion->n_attitudes; }

/* The coordinate that row k of them is of. */
static inline int lag_pirk_way_of(const LagMotion *motion, int k) { return lag_attitude_place(motion->attitudes, k / 3) + k % 3; }

/* Ways of eight states with the positions q and rates v, from rates at the beginning of y, into rows of this stride. */
void lag_pirk_find_ways(const LagMotion *motion, const double *y, const double *q, const double *v, double *ways, int stride);

#endif
