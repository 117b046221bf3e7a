/* Square roots in the forces: where what stands under one touches 0 (two points pass through each other) these jump, and no condition
 * changes its sign. Methods that look at the forces of a step at few places, or not at all, may step over it. */
#ifndef LAG_ROOTS_H
#define LAG_ROOTS_H

#include <stdint.h>

#include "base/arena.h"
#include "model/model.h"
#include "state/settings.h"
#include "base/status.h"

/* What is told of a step by a parabola through its ends: of the larger one there. */
#define LAG_ROOTS_SUSPECT 0.1

typedef struct {
    double *g, *rate, *g_old, *rate_old, *g_in, *rate_in, *g_ahead; /* n_roots: at both ends of a step, inside it, and beyond */
    double *state;  /* size */
    int64_t known;  /* the steps of the run after which g and rate were those of its state; and the events until then */
    int64_t events;
} LagRoots;

void lag_roots_layout(LagRoots *roots, const LagModel *model, int size, LagArena *arena);

/* Whether a condition has changed in the latest step of a method that holds none, or it came near to such a place. */
int lag_roots_cross(LagRun *run);

/* The latest step was none of the run. */
void lag_roots_forget(LagRun *run);

/* The latest step is taken back; the next one is to be so long. */
void lag_roots_take_back(LagRun *run, double step);

/* Equal steps are no good where forces bend or jump: another method goes on for good, with error control. Takes its first step. */
LagStatus lag_roots_leave(LagRun *run);

/* A step was taken. Where it came too near to such a place for its method it is taken back, and others go on that come nearer in
 * steps as short as their errors ask for; the first of them is taken. */
LagStatus lag_roots_watch(LagRun *run);

/* Whether the latest step, one of length h that is much shorter than others, ended within few of its lengths of such a place. */
int lag_roots_are_close(LagRun *run, double h);

/* Looks at what is under the roots at present: g and rate. */
void lag_roots_look(LagRun *run);

/* Whether something under a root was much less at some place of the latest step than at an end. */
int lag_roots_pass(LagRun *run);

#endif
