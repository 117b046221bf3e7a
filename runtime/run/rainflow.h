/* Cycles of a quantity by the rainflow method of ASTM E1049-85 (2011), section 5.4.4, while it goes on.
 *
 * A closed cycle counts 1, what is open at the end 1/2. Turning points that later ones may close are kept: few where the
 * quantity swings evenly, all of them while it dies away.
 */
#ifndef LAG_RAINFLOW_H
#define LAG_RAINFLOW_H

#include <stddef.h>

typedef struct {
    double range, mean, count;
} LagCycle;

typedef struct {
    double *turns; /* the last one may yet move on */
    size_t n_turns, room;
    LagCycle *cycles; /* NULL: only their damage is wanted */
    size_t n_cycles, room_cycles;
    double damage;        /* the sum of count (range / size)^slope */
    double slope, size;
    int keeps_cycles, has_failed; /* failed: out of memory */
} LagRainflow;

/* Starts anew; memory of before serves again. */
void lag_rainflow_start(LagRainflow *flow, double slope, double size, int keeps_cycles);
void lag_rainflow_free(LagRainflow *flow);

/* The next value of the quantity, in the order of time; between two calls it rises or falls throughout. */
void lag_rainflow_add(LagRainflow *flow, double y);

/* Half cycles of what is open. */
void lag_rainflow_end(LagRainflow *flow);

#endif
