/* What lies between the ends of a step and its outermost stages. */
#ifndef LAG_PIRK_EDGES_H
#define LAG_PIRK_EDGES_H

#include "state/motion.h"

struct LagPirk;

/* The error of the step just tried, whose end is motion->other, by what its stages do not see; in units, 0 where it is smooth. */
double lag_pirk_edges(struct LagPirk *pirk, LagMotion *motion, double t_new);

/* The accelerations at the end of the step just tried are those at the beginning of the next one. */
void lag_pirk_keep_end(struct LagPirk *pirk, const LagMotion *motion, double t_new);

#endif
