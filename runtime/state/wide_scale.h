/* Units of error (scale.h) of eight motions at once, each by what it has been itself. */
#ifndef LAG_WIDE_SCALE_H
#define LAG_WIDE_SCALE_H

#include "numbers/wide.h"
#include "state/scale.h"

/* As in LagScale, LAG_ABREAST numbers for each of its own. */
typedef struct {
    int n, kinds;
    const int *kind;
    double tolerance;
    double *cap;                    /* 2 n: the same for all motions */
    double *largest, *floor, *size; /* 2 n */
    double *group;                  /* 2 kinds */
    double *noise, *onset, *idle;   /* n */
} LagWideScale;

void lag_wide_scale_layout(LagWideScale *scale, const LagScale *like, LagArena *arena);

/* What is known of one motion, in and out. */
void lag_wide_scale_load(LagWideScale *scale, int lane, const LagScale *from);
void lag_wide_scale_store(const LagWideScale *scale, int lane, LagScale *to);

/* A motion of which nothing is known. */
void lag_wide_scale_forget(LagWideScale *scale, int lane);

/* Of the lanes from `lane` on, as many as LagWide holds: takes notice of the states y that were reached. */
void lag_wide_scale_note(LagWideScale *scale, int lane, const double *y);

LAG_UNROLLED LagWide lag_wide_max(LagWide a, LagWide b) { return LAG_WIDE_MAX(a, b); }

LAG_UNROLLED LagWide lag_wide_min(LagWide a, LagWide b) { return LAG_WIDE_MIN(a, b); }

LAG_UNROLLED LagWide lag_wide_of(const double *numbers, int i, int lane)
{
    return lag_wide_read(numbers + (size_t)i * LAG_ABREAST + lane);
}

/* The larger one of two states' magnitudes of component i. */
LAG_UNROLLED LagWide lag_wide_magnitude(const LagWideScale *s, int i, LagWide a, LagWide b)
{
    const LagWide most = lag_wide_max(LAG_WIDE_ABS(a), LAG_WIDE_ABS(b));
    const LagWide seen = LAG_WIDE_SELECT(most < LAG_WIDE_OF(LAG_SCALE_NOTHING), LAG_WIDE_OF(0), most);
    return lag_wide_min(seen, LAG_WIDE_OF(s->cap[i]));
}

/* Units of position i and of its rate, in steps that begin or end at the states y_old and y_new, after one of the length `step`;
 * `uncertain` is DBL_EPSILON / step. */
LAG_UNROLLED void lag_wide_scale_units(const LagWideScale *s, int i, int lane, const double *y_old, const double *y_new, LagWide step,
                                       LagWide uncertain, LagWide *place, LagWide *rate)
{
    const int r = s->n + i;
    const LagWide tolerance = LAG_WIDE_OF(s->tolerance);
    const LagWide way = lag_wide_magnitude(s, i, lag_wide_of(y_old, i, lane), lag_wide_of(y_new, i, lane));
    const LagWide speed = lag_wide_magnitude(s, r, lag_wide_of(y_old, r, lane), lag_wide_of(y_new, r, lane));
    const LagWide least = lag_wide_max(lag_wide_of(s->onset, i, lane), lag_wide_of(s->idle, i, lane));
    const LagWide unseen = step * step * least, noise = step * lag_wide_of(s->noise, i, lane);
    const LagWide rounding = uncertain * lag_wide_max(way, lag_wide_of(s->size, i, lane));
    *place = lag_wide_max(tolerance * lag_wide_max(way, lag_wide_of(s->floor, i, lane)), unseen);
    *rate = lag_wide_max(tolerance * lag_wide_max(speed, lag_wide_of(s->floor, r, lane)), lag_wide_max(rounding, noise));
}

#endif
