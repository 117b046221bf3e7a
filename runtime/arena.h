/* One block of doubles for everything a run needs.
 *
 * A layout function is called twice: with no base it only counts, with one it hands out the places. Each vector starts at
 * a multiple of four and is padded to one, so that loops may run in fours (padding is zero and stays zero).
 */
#ifndef LAG_ARENA_H
#define LAG_ARENA_H

#include <stddef.h>

typedef struct {
    double *base; /* NULL while counting */
    size_t used;
} LagArena;

static inline double *lag_take(LagArena *arena, size_t count)
{
    double *place = arena->base ? arena->base + arena->used : NULL;
    arena->used += (count + 3) / 4 * 4;
    return place;
}

static inline int *lag_take_ints(LagArena *arena, size_t count) { return (int *)lag_take(arena, (count + 1) / 2); }

#endif
