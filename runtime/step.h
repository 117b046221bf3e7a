/* One accepted step of a run, by the method in use; and what all methods share in taking one. */
#ifndef LAG_STEP_H
#define LAG_STEP_H

#include "state.h"

LagStatus lag_step(LagRun *run);

/* The `step` of methods that estimate their error (adaptive.c). */
LagStatus lag_step_adaptive(LagRun *run);

/* Where a step of length h ends: the one place where steps are cut short. Two steps of equal length rather than a long
 * one and a tiny one lead up to a limit. */
double lag_step_end(const LagRun *run, double h);

/* The next row, event or stop: where a step ends that may have any length. */
double lag_step_aim(const LagRun *run);

/* Shorter steps do not move t. */
double lag_step_smallest(double t);

/* Whether so many strides of the method in use lie between the steps like the present one: a power of two. */
static inline int lag_step_is_every(const LagRun *run, int strides)
{
    return (run->statistics.steps & (strides * run->methods.table->stride - 1)) == 0;
}

/* Errors are to be measured for steps of length h. */
void lag_step_set_units(LagRun *run, double h);

/* Notes the step of length h that was just accepted. */
void lag_step_record(LagRun *run, double h);

/* More steps than anybody waits for: component `worst` of (q, v) is to blame, -1: none. */
LagStatus lag_step_no_progress(LagRun *run, int worst, double steps);

/* No step is small enough: component `worst` of (q, v) is to blame. */
LagStatus lag_step_give_up(LagRun *run, int worst);

#endif
