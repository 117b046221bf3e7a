/* Functions of double-doubles: a Taylor series where the argument is small, or a correction by Newton of the double's value. */
#include "numbers/dd.h"

#include <float.h>

static const LagDD LN2 = {0.6931471805599453, 2.3190468138462996e-17};
/* pi/2 in four parts, for arguments of up to some 1e15. */
static const double HALF_PI[4] = {1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33, 5.562271104316826e-50};
static const double LARGEST_ARGUMENT = 4503599627370496.0; /* 2^52 */
enum { SERIES = 30, HALVINGS = 9, LARGEST_POWER = 1 << 20 };

LagDD lag_dd_sqrt(LagDD a)
{
    if (!(a.hi > 0) || isinf(a.hi))
        return lag_dd(sqrt(a.hi));
    const double x = sqrt(a.hi);
    const LagDD rest = lag_dd_sub(a, lag_dd_product(x, x));
    return lag_dd_quick(x, rest.hi / (2 * x));
}

/* exp(a) = 2^k exp(r)^512 */
LagDD lag_dd_exp(LagDD a)
{
    if (!(fabs(a.hi) < 700))
        return lag_dd(exp(a.hi));
    const double k = floor(a.hi / LN2.hi + 0.5), scale = 1.0 / (1 << HALVINGS);
    LagDD r = lag_dd_sub(a, lag_dd_scale(LN2, k)), term = lag_dd(1), rest = lag_dd(0);
    r.hi *= scale;
    r.lo *= scale;
    for (int i = 1; i <= SERIES && fabs(term.hi) > 1e-36; ++i) {
        term = lag_dd_div(lag_dd_mul(term, r), lag_dd(i));
        rest = lag_dd_add(rest, term);
    }
    for (int i = 0; i < HALVINGS; ++i) /* (1 + x)^2 - 1 */
        rest = lag_dd_add(lag_dd_add(rest, rest), lag_dd_mul(rest, rest));
    LagDD y = lag_dd_add(rest, lag_dd(1));
    y.hi = ldexp(y.hi, (int)k);
    y.lo = ldexp(y.lo, (int)k);
    return y;
}

LagDD lag_dd_log(LagDD a)
{
    LagDD y = lag_dd(log(a.hi));
    if (!isfinite(y.hi))
        return y;
    for (int i = 0; i < 2; ++i) /* y + a exp(-y) - 1 */
        y = lag_dd_add(y, lag_dd_sub(lag_dd_mul(a, lag_dd_exp(lag_dd_neg(y))), lag_dd(1)));
    return y;
}

/* Sum of (-1)^i r^(first + 2 i) / (first + 2 i)! */
static LagDD alternating(LagDD r, int first)
{
    const LagDD square = lag_dd_mul(r, r);
    LagDD term = first == 0 ? lag_dd(1) : r, sum = term;
    for (int i = first + 2; i < SERIES + first + 2 && fabs(term.hi) > 1e-36; i += 2) {
        term = lag_dd_neg(lag_dd_div(lag_dd_mul(term, square), lag_dd((double)i * (i - 1))));
        sum = lag_dd_add(sum, term);
    }
    return sum;
}

void lag_dd_sin_cos(LagDD a, LagDD *sine, LagDD *cosine)
{
    if (!(fabs(a.hi) < LARGEST_ARGUMENT)) {
        *sine = lag_dd(sin(a.hi));
        *cosine = lag_dd(cos(a.hi));
        return;
    }
    const double k = floor(a.hi / HALF_PI[0] + 0.5);
    LagDD r = a;
    for (int i = 0; i < 4; ++i)
        r = lag_dd_sub(r, lag_dd_product(k, HALF_PI[i]));
    const int quarter = (int)(k - 4 * floor(k / 4));
    const LagDD s = alternating(r, 1), c = alternating(r, 0);
    *sine = quarter % 2 == 0 ? s : c;
    *cosine = quarter % 2 == 0 ? c : s;
    if (quarter >= 2)
        *sine = lag_dd_neg(*sine);
    if (quarter == 1 || quarter == 2)
        *cosine = lag_dd_neg(*cosine);
}

/* The angle z0 of the doubles and its correction: tan(z - z0) = (y cos z0 - x sin z0) / (x cos z0 + y sin z0). */
LagDD lag_dd_atan2(LagDD y, LagDD x)
{
    const LagDD z = lag_dd(atan2(y.hi, x.hi));
    LagDD s, c;
    lag_dd_sin_cos(z, &s, &c);
    const LagDD up = lag_dd_sub(lag_dd_mul(y, c), lag_dd_mul(x, s)), down = lag_dd_add(lag_dd_mul(x, c), lag_dd_mul(y, s));
    return isfinite(up.hi) && down.hi > 0 ? lag_dd_add(z, lag_dd_div(up, down)) : z;
}

static LagDD whole_power(LagDD a, int n)
{
    LagDD y = lag_dd(1), square = a;
    for (int left = n < 0 ? -n : n; left > 0; left /= 2) {
        if (left % 2 == 1)
            y = lag_dd_mul(y, square);
        square = lag_dd_mul(square, square);
    }
    return n < 0 ? lag_dd_div(lag_dd(1), y) : y;
}

LagDD lag_dd_pow(LagDD a, LagDD b)
{
    if (b.lo == 0 && b.hi == floor(b.hi) && fabs(b.hi) < LARGEST_POWER)
        return whole_power(a, (int)b.hi);
    return a.hi > 0 ? lag_dd_exp(lag_dd_mul(b, lag_dd_log(a))) : lag_dd(pow(a.hi, b.hi));
}

LagDD lag_dd_floor(LagDD a)
{
    const double f = floor(a.hi);
    return f == a.hi ? lag_dd_quick(f, floor(a.lo)) : lag_dd(f);
}
