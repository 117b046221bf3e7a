/* One block of doubles for everything a run needs.
 *
 * A layout function is called twice: with no base it only counts, with one it hands out the places. Each vector starts at
 * a multiple of four and is padded to one, so that loops may run in fours (padding is zero and stays zero). A run's block
 * begins at a line of the cache: four numbers that were read from two lines took a chain of 100 links a fifth longer.
 */
#ifndef LAG_ARENA_H
#define LAG_ARENA_H

#include <stddef.h>
#include <stdint.h>

#include "base/registers.h"

enum { LAG_CACHE_LINE = 8 }; /* doubles */

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

/* The first place in a block of LAG_CACHE_LINE doubles more than needed at which a line of the cache begins. */
static inline double *lag_at_cache_line(void *block)
{
    const uintptr_t size = LAG_CACHE_LINE * sizeof(double);
    return (double *)(((uintptr_t)block + size - 1) / size * size);
}

static inline int *lag_take_ints(LagArena *arena, size_t count) { return (int *)lag_take(arena, (count + 1) / 2); }

#endif
