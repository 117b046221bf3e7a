/* Double-double numbers: the unevaluated sum hi + lo of two doubles, 32 digits.
 *
 * T.J. Dekker, Numer. Math. 18 (1971); D.E. Knuth, The Art of Computer Programming 2, 4.2.2; Y. Hida, X.S. Li, D.H. Bailey,
 * ARITH-15 (2001). Needs IEEE arithmetic without contraction. A matrix exponential made of plain doubles loses the slow
 * modes beside stiff ones: with stiffnesses in a ratio of 1e12, twelve of sixteen digits.
 */
#ifndef LAG_DD_H
#define LAG_DD_H

#include <math.h>

typedef struct {
    double hi, lo;
} LagDD;

static inline LagDD lag_dd(double x)
{
    const LagDD y = {x, 0};
    return y;
}

/* a + b for |a| >= |b|. */
static inline LagDD lag_dd_quick(double a, double b)
{
    const double sum = a + b;
    const LagDD y = {sum, b - (sum - a)};
    return y;
}

/* a + b, exactly. */
static inline LagDD lag_dd_sum(double a, double b)
{
    const double sum = a + b, taken = sum - a;
    const LagDD y = {sum, (a - (sum - taken)) + (b - taken)};
    return y;
}

/* The upper 26 bits of a. */
static inline double lag_dd_upper(double a)
{
    const double c = 134217729.0 * a;
    return c - (c - a);
}

/* a b, exactly. */
static inline LagDD lag_dd_product(double a, double b)
{
    const double p = a * b, ah = lag_dd_upper(a), al = a - ah, bh = lag_dd_upper(b), bl = b - bh;
    const LagDD y = {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
    return y;
}

static inline LagDD lag_dd_neg(LagDD a)
{
    const LagDD y = {-a.hi, -a.lo};
    return y;
}

static inline LagDD lag_dd_add(LagDD a, LagDD b)
{
    LagDD s = lag_dd_sum(a.hi, b.hi);
    const LagDD t = lag_dd_sum(a.lo, b.lo);
    s = lag_dd_quick(s.hi, s.lo + t.hi);
    return lag_dd_quick(s.hi, s.lo + t.lo);
}

static inline LagDD lag_dd_sub(LagDD a, LagDD b) { return lag_dd_add(a, lag_dd_neg(b)); }

static inline LagDD lag_dd_mul(LagDD a, LagDD b)
{
    const LagDD p = lag_dd_product(a.hi, b.hi);
    return lag_dd_quick(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline LagDD lag_dd_scale(LagDD a, double b) /* b a */
{
    const LagDD p = lag_dd_product(a.hi, b);
    return lag_dd_quick(p.hi, p.lo + a.lo * b);
}

static inline LagDD lag_dd_div(LagDD a, LagDD b)
{
    const double q1 = a.hi / b.hi;
    LagDD rest = lag_dd_sub(a, lag_dd_scale(b, q1));
    const double q2 = rest.hi / b.hi;
    rest = lag_dd_sub(rest, lag_dd_scale(b, q2));
    const LagDD y = lag_dd_quick(q1, q2);
    return lag_dd_add(y, lag_dd(rest.hi / b.hi));
}

static inline int lag_dd_less(LagDD a, LagDD b) { return a.hi < b.hi || (a.hi == b.hi && a.lo < b.lo); }
static inline int lag_dd_is_zero(LagDD a) { return a.hi == 0; }

LagDD lag_dd_sqrt(LagDD a);
LagDD lag_dd_exp(LagDD a);
LagDD lag_dd_log(LagDD a);
void lag_dd_sin_cos(LagDD a, LagDD *sine, LagDD *cosine);
LagDD lag_dd_atan2(LagDD y, LagDD x);
LagDD lag_dd_pow(LagDD a, LagDD b);
LagDD lag_dd_floor(LagDD a);

#endif
