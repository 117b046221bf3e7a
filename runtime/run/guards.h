/* Guards: conditions that have to hold during a run, which ends, or warns, where one of them breaks; and those that end it.
 *
 * They are looked at when a step is known, in its dense output, and the motion knows nothing of them: a run that is made alone is the
 * same with guards or without. Runs in lanes (run_lanes.h) may take another method where there are some, for its dense output: the
 * same within the tolerance. A guard is g >= 0; one that ends the run has to have held before it can break.
 */
#ifndef LAG_GUARDS_H
#define LAG_GUARDS_H

#include "base/arena.h"
#include "base/status.h"
#include "model/model.h"
#include "state/settings.h"

typedef struct {
    double *found, *other; /* n_guards + n_seen: g and what the conditions compare, at the latest look; beside it */
    double *places;        /* 5 n_guards: g in a part of the step */
    double *states;        /* 5 x 2 n: q, dq/dt there */
    double *told;          /* n_guards: when a warning broke at first; NaN: it did not */
    double *passed;        /* n_guards: since when it is beyond, by however little; NaN: it is not */
    int *is_armed;         /* n_guards: those that end the run: whether they have held */
    int *is_news;          /* n_guards: a warning that nobody has asked for yet */
    double *state, *beside, *error; /* size */
    double end;            /* the time at which the guard `broken` - 1 ends the run, within the latest step */
    double row;            /* the time of the latest row */
    int broken;
    int is_idle;           /* a motion of our own is only measured: nothing is watched */
} LagGuards;

void lag_guards_layout(LagGuards *s, const LagModel *model, int size, LagArena *arena);

/* A run starts with these parameters: LAG_ASSERTED where they break a guard. */
LagStatus lag_guards_reset(LagRun *run);

/* Those of parameters alone, as they are now. */
LagStatus lag_guards_of_parameters(LagRun *run);

/* At a state (q, v) that no step has led to: the start, or a state of an importer. LAG_ASSERTED, LAG_ENDED where it ends the run. */
LagStatus lag_guards_meet(LagRun *run, double t, const double *y);

/* Whether some guard is of more than parameters, which do not change within a step. */
int lag_guards_watch_motion(const LagModel *model);

/* Looks at the latest step. */
void lag_guards_watch(LagRun *run);

/* Where a guard that may end the run was met first in the latest step, at whose end it is beyond by less than is sure: else INFINITY. */
double lag_guards_pending(const LagRun *run);

/* Up to when rows may be asked for in it: its end, or where a guard ends the run. */
double lag_guards_limit(const LagRun *run);

/* LAG_ASSERTED or LAG_ENDED where a guard ends the run. */
LagStatus lag_guards_tell(LagRun *run);

/* What comes after t has not been. */
void lag_guards_forget(LagRun *run, double t);

/* 1 + the next warning that broke and was not asked for here before, and its time; 0: there is none. */
LAG_API int lag_run_warning(LagRun *run, double *t);

/* n_seen: what the conditions compared where the latest guard broke that ended the run. */
LAG_API const double *lag_run_seen(const LagRun *run);

#endif
