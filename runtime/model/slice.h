/* Slices of tapes: the instructions that some of the outputs need, in their order; the numbers are those of the whole tape. */
#ifndef LAG_SLICE_H
#define LAG_SLICE_H

#include "base/arena.h"
#include "model/tape.h"

enum { LAG_FEWEST_SLICED = 2000 }; /* instructions */

typedef struct {
    const LagFunction *function;
    int *from;   /* 2 n_instructions: which ones write the operands, -1: none */
    int *output; /* which one writes an output; of output k from `first`[k] on */
    int *first;  /* n_out */
    int *mark;   /* n_instructions: the slice that took it last */
    int *found;  /* those of the slice that is made; room for n_work */
    int slices;
} LagSlicer;

typedef struct {
    LagTape tape;
    int32_t *code;
} LagSlice;

/* Whether slices of a function save time: shorter tapes are run whole sooner than they are read. */
static inline int lag_has_slices(const LagFunction *function)
{
    return function->tape && !function->code && function->tape->n_instructions >= LAG_FEWEST_SLICED;
}

/* Takes nothing where there are no slices. */
void lag_slicer_layout(LagSlicer *slicer, const LagFunction *function, LagArena *arena);

/* Reads the tape. */
void lag_slicer_begin(LagSlicer *slicer);

/* Room for as much as the tape has. */
void lag_slice_layout(LagSlice *slice, const LagFunction *function, LagArena *arena);

/* Begins an empty slice; nothing else is added to another one until it ends. */
void lag_slice_begin(LagSlicer *slicer, LagSlice *slice);

/* Adds an output and what it needs. */
void lag_slice_add(LagSlicer *slicer, LagSlice *slice, int output, int element);

void lag_slice_end(LagSlicer *slicer, LagSlice *slice);

#endif
