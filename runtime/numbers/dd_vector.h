/* Vectors of double-doubles as two arrays, the high parts and the low parts. */
#ifndef LAG_DD_VECTOR_H
#define LAG_DD_VECTOR_H

#include "base/arena.h"
#include "numbers/dd.h"

typedef struct {
    double *hi, *lo;
} LagDDs;

static inline LagDDs lag_dds_take(LagArena *arena, size_t count)
{
    LagDDs x;
    x.hi = lag_take(arena, count);
    x.lo = lag_take(arena, count);
    return x;
}

static inline LagDDs lag_dds_from(LagDDs x, size_t first)
{
    const LagDDs y = {x.hi + first, x.lo + first};
    return y;
}

static inline LagDD lag_dds_get(LagDDs x, size_t i)
{
    const LagDD y = {x.hi[i], x.lo[i]};
    return y;
}

static inline void lag_dds_set(LagDDs x, size_t i, LagDD value)
{
    x.hi[i] = value.hi;
    x.lo[i] = value.lo;
}

/* sum += a b, where the low part of the sum gathers what rounding takes and is not kept small. */
static inline void lag_dd_gather(LagDD *sum, LagDD a, double b_hi, double b_lo)
{
    const LagDD p = lag_dd_product(a.hi, b_hi), s = lag_dd_sum(sum->hi, p.hi);
    sum->hi = s.hi;
    sum->lo += s.lo + (p.lo + (a.hi * b_lo + a.lo * b_hi));
}

void lag_dds_copy(LagDDs x, LagDDs y, size_t count);            /* y = x */
void lag_dds_clear(LagDDs x, size_t count);                     /* x = 0 */
void lag_dds_scale(LagDDs x, LagDD factor, size_t count);      /* x = factor x */
void lag_dds_add(LagDDs x, LagDDs y, size_t count);             /* y += x */
void lag_dds_settle(LagDDs x, size_t count);                    /* high parts take over what low parts gathered */
LagDD lag_dds_dot(LagDDs x, LagDDs y, size_t count);

void lag_add_multiple(double a, const double *x, double *y, size_t count); /* y += a x */

/* y += a x for a multiple of four components, low parts gathering. */
void lag_dds_gather(LagDD a, LagDDs x, LagDDs y, size_t count);

#endif
