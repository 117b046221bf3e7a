/* Powers to three digits (rough_power.h) of as many numbers as a register holds. */
#ifndef LAG_WIDE_POWER_H
#define LAG_WIDE_POWER_H

#include <float.h>

#include "numbers/wide.h"

/* As lag_rough_log2. */
LAG_UNROLLED LagWide lag_wide_log2(LagWide x)
{
    const LagWideWords bits = LAG_WIDE_WORDS(x), two52 = (LagWideWords)LAG_WIDE_WORDS(LAG_WIDE_OF(4503599627370496.0));
    const LagWide exponent = LAG_WIDE_OF_WORDS((bits >> 52) | two52) - LAG_WIDE_OF(4503599627370496.0 + 1023);
    const LagWide m = LAG_WIDE_OF_WORDS((bits & 0xfffffffffffff) | 0x3ff0000000000000) - LAG_WIDE_OF(1);
    const LagWide cubic = LAG_WIDE_FUSED(m, LAG_WIDE_OF(0.15922016), LAG_WIDE_OF(-0.58208551));
    return LAG_WIDE_FUSED(m, LAG_WIDE_FUSED(m, cubic, LAG_WIDE_OF(1.42286536)), exponent);
}

/* 1/x for 0 < x, of ordinary size, in a quarter of the time of a division. */
LAG_UNROLLED LagWide lag_wide_rough_inverse(LagWide x)
{
    const LagWide two = LAG_WIDE_OF(2), most = LAG_WIDE_MIN(x, LAG_WIDE_OF(1e300));
    LagWide found = LAG_WIDE_OF_WORDS((uint64_t)0x7fde623822fc16e6 - LAG_WIDE_WORDS(most)); /* within 0.051 */
    found = found * LAG_WIDE_FUSED(-most, found, two);
    return found * LAG_WIDE_FUSED(-most, found, two);
}

/* The logarithm of x^exponent for x >= 0: -infinity where x is no ordinary number for its smallness, infinity where for its size. */
LAG_UNROLLED LagWide lag_wide_log2_of_power(LagWide x, double exponent)
{
    const LagWide infinite = LAG_WIDE_OF((double)INFINITY), found = LAG_WIDE_OF(exponent) * lag_wide_log2(x);
    const LagWide few = LAG_WIDE_SELECT(x >= LAG_WIDE_OF(DBL_MIN), found, -infinite);
    return LAG_WIDE_SELECT(x > LAG_WIDE_OF(DBL_MAX), infinite, few);
}

/* 2^y for |y| < 1000: of the nearest whole number, in fewer operations that wait for each other than those of lag_wide_exp2. */
LAG_UNROLLED LagWide lag_wide_exp2_of_few(LagWide y)
{
    const LagWide shift = LAG_WIDE_OF(6755399441055744.0), shifted = y + shift, part = y - (shifted - shift);
    const LagWide scale = LAG_WIDE_OF_WORDS((LAG_WIDE_WORDS(shifted) + 1023) << 52);
    const LagWide cubic = LAG_WIDE_FUSED(part, LAG_WIDE_OF(0.05459282), LAG_WIDE_OF(0.24221784));
    return scale * LAG_WIDE_FUSED(part, LAG_WIDE_FUSED(part, cubic, LAG_WIDE_OF(0.6933686)), LAG_WIDE_OF(1));
}

/* 2^y for small y, and for infinite ones. */
LAG_UNROLLED LagWide lag_wide_exp2(LagWide y)
{
    const LagWide shift = LAG_WIDE_OF(6755399441055744.0), zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1);
    const LagWide nearest = (y + shift) - shift, whole = nearest - LAG_WIDE_SELECT(nearest > y, one, zero), part = y - whole;
    const LagWide scale = LAG_WIDE_OF_WORDS((LAG_WIDE_WORDS(whole + shift) + 1023) << 52);
    const LagWide cubic = LAG_WIDE_FUSED(part, LAG_WIDE_OF(0.07924493), LAG_WIDE_OF(0.22486495));
    const LagWide found = scale * LAG_WIDE_FUSED(part, LAG_WIDE_FUSED(part, cubic, LAG_WIDE_OF(0.69589012)), one);
    const LagWide few = LAG_WIDE_SELECT(y >= LAG_WIDE_OF(-DBL_MAX), found, zero);
    return LAG_WIDE_SELECT(y > LAG_WIDE_OF(DBL_MAX), LAG_WIDE_OF((double)INFINITY), few);
}

/* x^exponent for x >= 0 and small exponents: 0 where x is no ordinary number for its smallness, infinity where for its size. */
LAG_UNROLLED LagWide lag_wide_power_of(LagWide x, double exponent) { return lag_wide_exp2(lag_wide_log2_of_power(x, exponent)); }

#endif
