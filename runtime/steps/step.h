/* One accepted step of a run, by the method in use; and what all methods share in taking one. */
#ifndef LAG_STEP_H
#define LAG_STEP_H

#include "state/ends.h"
#include "state/state.h"

LagStatus lag_step(LagRun *run);

/* The `step` of methods that estimate their error (adaptive.c). */
LagStatus lag_step_adaptive(LagRun *run);

/* Whether so many strides of the method in use lie between the steps like the present one: a power of two. */
static inline int lag_step_is_every(const LagRun *run, int strides)
{
    return (run->statistics.steps & (strides * run->methods.table->stride - 1)) == 0;
}

/* Notes the step of length h that was just accepted. */
void lag_step_record(LagRun *run, double h);

#endif
