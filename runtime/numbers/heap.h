/* A heap (J.W.J. Williams, Comm. ACM 7, 1964) of numbered items: the least key is at hand, of like keys that of the lower number. */
#ifndef LAG_HEAP_H
#define LAG_HEAP_H

#include "base/arena.h"

typedef struct {
    double *key; /* of each item; whoever changes one calls lag_heap_update */
    int *item, *place; /* none is before that at (place - 1)/2; of an item that is in the heap its place */
    int size;
} LagHeap;

void lag_heap_layout(LagHeap *heap, size_t items, LagArena *arena);

/* Puts in the items from 0 on. */
void lag_heap_fill(LagHeap *heap, int items);

/* Puts an item in that was taken out. */
void lag_heap_put(LagHeap *heap, int item);
void lag_heap_take(LagHeap *heap, int item);
void lag_heap_update(LagHeap *heap, int item);

#endif
