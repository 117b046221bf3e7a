/* The latest assembly of a run: what was asked, and what was found. One that begins again from the same is not assembled anew. */
#ifndef LAG_KNOWN_START_H
#define LAG_KNOWN_START_H

#include "base/arena.h"
#include "model/model.h"

typedef struct {
    double *p, *u;         /* parameters; inputs at the start */
    double *guess, *found; /* 2 n: positions and rates, n being lag_start_size */
    int *fixed;            /* 2 n */
    int is_found;
} LagKnownStart;

void lag_known_start_layout(LagKnownStart *known, const LagModel *model, LagArena *arena);

/* Whether this was asked latest, and found: then the guess x becomes it. Else it is looked for from now on. `u` may be NULL. */
int lag_known_start_recall(LagKnownStart *known, const LagModel *model, const double *p, const double *u, const int *fixed,
                           double *x);

void lag_known_start_keep(LagKnownStart *known, const LagModel *model, const double *x);

#endif
