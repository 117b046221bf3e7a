/* How large an error counts as one unit, for each position and rate. */
#ifndef LAG_SCALE_H
#define LAG_SCALE_H

#include <math.h>

#include "base/arena.h"

typedef struct {
    int n, kinds;
    int is_uniform;  /* all are of one kind */
    const int *kind; /* n: coordinates of one kind share an order of magnitude */
    double tolerance;
    double asked; /* that of the user: steps that miss energy are made at a smaller one */
    double rate_rounding; /* rounding error of a position, over the step: relative uncertainty of a rate */
    double step;          /* length of the latest step */
    int is_resting;       /* rates of some kind have all been 0 so far */
    int surprises;        /* steps rejected that would have set some kind in motion out of nothing (onset.c) */
    double *cap;          /* 2 n: magnitudes above this one count no more */
    double *largest;      /* 2 n: magnitude seen so far */
    double *floor;        /* 2 n: magnitude that counts at least */
    double *size;         /* 2 n: natural sizes: positions are known to rounding of these at best; 0 where nothing tells */
    double *group;        /* 2 kinds: largest magnitude of a kind, positions then rates */
    double *noise;        /* n: uncertainty of the accelerations by rounding */
    double *onset;        /* n: that of the loads to come, where nothing moves yet; noise is at least as large */
    double *idle;         /* n: that of accelerations that are nothing but rounding */
    double reach;         /* length of the latest step, where stability bounds it, or something slides; 0: other implicit steps */
    double *motion, *change; /* kinds: scratch of lag_slowness */
} LagScale;

/* The relative error of a step that counts as a unit at this tolerance of the user. */
double lag_scale_caution(double tolerance);

/* `kinds` is one more than the largest kind. */
void lag_scale_init(LagScale *scale, int n, const int *kind, double tolerance);
void lag_scale_layout(LagScale *scale, LagArena *arena);
void lag_scale_reset(LagScale *scale);

/* Natural sizes of the positions (n), as they are known where loops are closed. Before lag_scale_note. */
void lag_scale_size(LagScale *scale, const double *size);

/* Takes notice of a state (q, v) that was reached. */
void lag_scale_note(LagScale *scale, const double *y);

/* Into scale->motion: of each kind the largest magnitude of `values` (n), rates or accelerations. */
void lag_scale_find_motion(const LagScale *scale, const double *values);

/* While rates of some kind rest, those of a state that is being tried say how large they will be. */
void lag_scale_foresee(const LagScale *scale, const double *y_new);

/* Whether nothing has moved yet, so that no motion has a size. */
int lag_scale_at_rest(const LagScale *scale);

/* Takes notice of how long steps are now; implicit ones are bound by no stability. */
void lag_scale_set_step(LagScale *scale, double h, int is_implicit);

/* Rates are known to `most` at least, whatever rounding of positions means in so short a step. */
void lag_scale_know_rates(LagScale *scale, double most);

/* The shares of what a component, and what its group, has been that count at least. */
#define LAG_SCALE_OWN 0.3
#define LAG_SCALE_GROUP 0.01

/* What is smaller counts as 0: numbers end soon below, and with them their digits. */
#define LAG_SCALE_NOTHING 1e-290

static inline double lag_scale_magnitude(const LagScale *scale, int i, double y_old, double y_new)
{
    const double a = fabs(y_old), b = fabs(y_new), magnitude = a > b ? a : b;
    if (magnitude < LAG_SCALE_NOTHING)
        return 0;
    return magnitude < scale->cap[i] ? magnitude : scale->cap[i];
}

/* Error of component i in a step from state y_old to y_new that counts as 1; 0 when the component never moved. */
static inline double lag_scale_unit(const LagScale *scale, int i, const double *y_old, const double *y_new)
{
    const double magnitude = lag_scale_magnitude(scale, i, y_old[i], y_new[i]);
    const double unit = scale->tolerance * (magnitude > scale->floor[i] ? magnitude : scale->floor[i]);
    if (i < scale->n) {
        const double reach = scale->reach, unseen = reach * reach * scale->onset[i], idle = scale->step * scale->step * scale->idle[i];
        const double least = unseen > idle ? unseen : idle;
        return unit > least ? unit : least;
    }
    const int position = i - scale->n;
    const double place = lag_scale_magnitude(scale, position, y_old[position], y_new[position]), size = scale->size[position];
    const double rounding = scale->rate_rounding * (place > size ? place : size);
    const double noise = scale->step * scale->noise[position], least = rounding > noise ? rounding : noise;
    return unit > least ? unit : least;
}

/* The same for all 2 n components of a long state. */
void lag_scale_units(const LagScale *scale, const double *y_old, const double *y_new, double *unit);

#endif
