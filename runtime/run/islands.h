/* Groups of coordinates that do not interact, each moved by a run of its own: with its own method, steps and events. */
#ifndef LAG_ISLANDS_H
#define LAG_ISLANDS_H

#include "choice/parts.h"

extern const LagMethod lag_islands_method;

/* The runs of a model's islands. Returns 0 when there is no memory. */
int lag_islands_open(LagIslands *islands, const LagModel *model, const LagSettings *settings);
void lag_islands_close(LagIslands *islands);

#endif
