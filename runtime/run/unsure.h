/* Outputs of rows that rounding decides, near singular positions of constraints. */
#ifndef LAG_UNSURE_H
#define LAG_UNSURE_H

#include "base/arena.h"
#include "model/model.h"
#include "state/settings.h"

typedef struct {
    double *J;        /* n_multipliers x n: constraints on rates by natural rates; then its singular vectors */
    double *reach;    /* n_multipliers: the largest row of J so far */
    double *rate, *still; /* the same: of a displacement; at rest */
    double *state, *place; /* 2 n; n */
    double *one, *other;  /* n_outputs: on both sides of a row */
    double *largest, *spread; /* the same: of those that are known; what is not known of each */
    double multipliers;   /* the largest in rows that are known */
    int repeated;         /* rows of J that only repeat others, at the best place so far */
} LagUnsure;

void lag_unsure_layout(LagUnsure *s, const LagModel *model, LagArena *arena);

void lag_unsure_reset(LagRun *run);

/* Whether constraints repeat each other at the present state that do not beside it: a singular value of their slopes, by their usual size,
 * is no more than `most`. Of scenes up to 40 rows of constraints; else 0. */
int lag_unsure_is_singular(LagRun *run, double most);

/* Of the outputs of a row, whose state y (q, v) is projected, what is not known becomes NaN, and is counted. */
void lag_unsure_row(LagRun *run, double t, const double *y, double *outputs);

#endif
