#include "state/wide_scale.h"

#include <float.h>
#include <string.h>

void lag_wide_scale_layout(LagWideScale *s, const LagScale *like, LagArena *arena)
{
    const size_t n = (size_t)like->n, all = LAG_ABREAST;
    s->n = like->n;
    s->kinds = like->kinds;
    s->kind = like->kind;
    s->tolerance = like->tolerance;
    s->cap = lag_take(arena, (2 * n + all - 1) / all * all); /* what follows begins at a line of the cache */
    s->largest = lag_take(arena, 2 * n * all);
    s->floor = lag_take(arena, 2 * n * all);
    s->size = lag_take(arena, 2 * n * all);
    s->group = lag_take(arena, 2 * (size_t)like->kinds * all);
    s->noise = lag_take(arena, n * all);
    s->onset = lag_take(arena, n * all);
    s->idle = lag_take(arena, n * all);
}

static inline void place(double *wide, double *one, int count)
{
    for (int i = 0; i < count; ++i)
        wide[i * LAG_ABREAST] = one[i];
}

static inline void take(double *wide, double *one, int count)
{
    for (int i = 0; i < count; ++i)
        one[i] = wide[i * LAG_ABREAST];
}

/* The vectors of one motion, and of eight. */
static inline void move(const LagWideScale *s, int lane, const LagScale *one, void (*way)(double *wide, double *one, int count))
{
    const int n = s->n;
    way(s->largest + lane, one->largest, 2 * n);
    way(s->floor + lane, one->floor, 2 * n);
    way(s->size + lane, one->size, n);
    way(s->group + lane, one->group, 2 * s->kinds);
    way(s->noise + lane, one->noise, n);
    way(s->onset + lane, one->onset, n);
    way(s->idle + lane, one->idle, n);
}

void lag_wide_scale_load(LagWideScale *s, int lane, const LagScale *from)
{
    memcpy(s->cap, from->cap, 2 * (size_t)s->n * sizeof *s->cap);
    move(s, lane, from, place);
}

void lag_wide_scale_store(const LagWideScale *s, int lane, LagScale *to) { move(s, lane, to, take); }

static void forget(double *wide, int count)
{
    for (int i = 0; i < count; ++i)
        wide[i * LAG_ABREAST] = 0;
}

void lag_wide_scale_forget(LagWideScale *s, int lane)
{
    const int n = s->n;
    forget(s->largest + lane, 2 * n);
    forget(s->size + lane, 2 * n);
    forget(s->group + lane, 2 * s->kinds);
    forget(s->noise + lane, n);
    forget(s->onset + lane, n);
    forget(s->idle + lane, n);
}

static int group_of(const LagWideScale *s, int i) { return i < s->n ? s->kind[i] : s->kinds + s->kind[i - s->n]; }

void lag_wide_scale_note(LagWideScale *s, int lane, const double *y)
{
    const LagWide rounding = LAG_WIDE_OF(DBL_EPSILON / s->tolerance);
    for (int i = 0; i < 2 * s->n; ++i) {
        double *group = s->group + (size_t)group_of(s, i) * LAG_ABREAST + lane;
        const LagWide seen = lag_wide_magnitude(s, i, lag_wide_of(y, i, lane), lag_wide_of(s->largest, i, lane));
        lag_wide_write(s->largest + (size_t)i * LAG_ABREAST + lane, seen);
        lag_wide_write(group, lag_wide_max(seen, lag_wide_read(group)));
    }
    for (int i = 0; i < 2 * s->n; ++i) {
        const LagWide own = LAG_WIDE_OF(LAG_SCALE_OWN) * lag_wide_of(s->largest, i, lane);
        const LagWide shared = LAG_WIDE_OF(LAG_SCALE_GROUP) * lag_wide_of(s->group, group_of(s, i), lane);
        const LagWide known = rounding * lag_wide_of(s->size, i, lane);
        lag_wide_write(s->floor + (size_t)i * LAG_ABREAST + lane, lag_wide_max(lag_wide_max(own, shared), known));
    }
}
