/* How large an error counts as one unit of tolerance, for each position and rate. */
#ifndef LAG_SCALE_H
#define LAG_SCALE_H

#include <math.h>

#include "arena.h"

typedef struct {
    int n;
    const int *kind; /* n: coordinates of one kind share an order of magnitude */
    double tolerance;
    double *cap;     /* 2 n: magnitudes above this one count no more */
    double *largest; /* 2 n: magnitude seen so far */
    double *floor;   /* 2 n */
} LagScale;

void lag_scale_layout(LagScale *scale, LagArena *arena);
void lag_scale_reset(LagScale *scale);

/* Takes notice of a state (q, v) that was reached. */
void lag_scale_note(LagScale *scale, const double *y);

/* Error of component i, between two states, that counts as 1; 0 when the component never moved. */
static inline double lag_scale_of(const LagScale *scale, int i, double y_old, double y_new)
{
    const double a = fabs(y_old), b = fabs(y_new), magnitude = a > b ? a : b, capped = magnitude < scale->cap[i] ? magnitude : scale->cap[i];
    return scale->tolerance * (capped > scale->floor[i] ? capped : scale->floor[i]);
}

#endif
