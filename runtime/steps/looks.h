/* Narrow places: bumps and steps of forces, smooth ones, that lie between all stages of a step that is much longer than they are wide.
 * The functions that make them tell where they are by what stands inside (compiler: narrow_places.py): g is 0 there, or turns round. */
#ifndef LAG_LOOKS_H
#define LAG_LOOKS_H

#include "base/arena.h"
#include "base/status.h"
#include "model/model.h"
#include "state/settings.h"

typedef struct {
    double *g, *pace; /* (LAG_LOOKS + 2) n_looks: along the latest step, and in between */
    double *ahead;    /* n_looks */
    double *state, *slope, *seen; /* size; size; LAG_SIGHTS size */
    double until;     /* where the latest place that was passed over is behind: before, shorter steps mend what is rejected */
    double width;     /* of that place, in time */
} LagLooks;

enum { LAG_LOOKS = 8, LAG_SIGHTS = 7 };

void lag_looks_layout(LagLooks *looks, const LagModel *model, int size, LagArena *arena);

/* A step was taken. Where it passed over a narrow place in which forces are others than around it, it is taken back, and shorter ones
 * lead there. */
LagStatus lag_looks_watch(LagRun *run);

#endif
