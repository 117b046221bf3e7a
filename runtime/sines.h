/* Sines and cosines of four angles at once, by one sequence of operations: the same digits on every machine and in every build,
 * where mathematical libraries differ in the last one. Four take as long as one of glibc's; one alone takes longer.
 *
 * An angle is reduced to r, |r| <= pi/4, by multiples of pi/2 in three parts of 33, 33 and 53 bits (Cody and Waite 1980), r itself
 * in two parts; sin r and cos r are polynomials of r^2, interpolated at Chebyshev nodes in 60 digits. Errors stay below 0.9 units
 * of the last place. Angles beyond 1e6, infinite and NaN ones go to the mathematical library one by one.
 */
#ifndef LAG_SINES_H
#define LAG_SINES_H

#include "lanes.h"

#define LAG_LARGEST_ANGLE 1e6 /* so many quarter turns have at most 20 bits: their products with 33 bits are exact */

/* Of angles up to LAG_LARGEST_ANGLE. */
static inline void lag_sines_of_lanes(const LagLanes *angle, LagLanes *sine, LagLanes *cosine)
{
    const double rounding = 6755399441055744.0; /* 1.5 * 2^52: a sum with it is a whole number, in the lowest bits */
    const LagLanes shifted = *angle * 0.6366197723675814 + rounding, turns = shifted - rounding;
    const LagLanes first = *angle - turns * 1.5707963267341256, second = turns * 6.077100506303966e-11;
    const LagLanes rest = first - second;
    const LagLanes third = turns * 2.0222662487959506e-21 - ((first - rest) - second);
    const LagLanes r = rest - third, tail = (rest - r) - third;
    const LagLanes z = r * r, z2 = z * z, z4 = z2 * z2, half = z * 0.5, near = 1.0 - half;
    const LagLanes p = (z * 0.008333333333330948 - 0.16666666666666666) + z2 * (z * 2.7557316101617874e-06 - 0.00019841269836756774)
                       + z4 * (z * 1.5918115263265974e-10 - 2.505113165023518e-08);
    const LagLanes q = (z * -0.0013888888888887398 + 0.041666666666666664)
                       + z2 * (z * -2.7557317271145144e-07 + 2.480158729876456e-05)
                       + z4 * (z * -1.1382623647474604e-11 + 2.087614614655861e-09);
    const LagLanes s = r + (r * z * p + tail * near), c = near + (((1.0 - near) - half) + (z2 * q - r * tail));
    /* After an odd number of quarter turns they change places; after two the sine changes its sign, and after one the cosine. */
    const LagLaneWords count = LAG_LANES_WORDS(shifted), s_words = LAG_LANES_WORDS(s), c_words = LAG_LANES_WORDS(c);
    const LagLaneWords swap = (s_words ^ c_words) & -(count & 1), sign = (count << 62) & LAG_LANES_SIGN;
    *sine = LAG_LANES_OF_WORDS(s_words ^ swap ^ sign);
    *cosine = LAG_LANES_OF_WORDS(c_words ^ swap ^ sign ^ (count << 63));
}

/* Of four angles. */
static inline void lag_four_sines(double a, double b, double c, double d, double *sine, double *cosine)
{
    const double angle[4] = {a, b, c, d};
#ifdef LAG_HAS_VECTORS
    const LagLanes lanes = {a, b, c, d};
    LagLanes sines, cosines;
    lag_sines_of_lanes(&lanes, &sines, &cosines);
    memcpy(sine, &sines, sizeof sines);
    memcpy(cosine, &cosines, sizeof cosines);
#else
    for (int i = 0; i < 4; ++i)
        lag_sines_of_lanes(angle + i, sine + i, cosine + i);
#endif
    if (fabs(a) + fabs(b) + fabs(c) + fabs(d) <= LAG_LARGEST_ANGLE)
        return;
    for (int i = 0; i < 4; ++i)
        if (!(fabs(angle[i]) <= LAG_LARGEST_ANGLE)) {
            sine[i] = sin(angle[i]);
            cosine[i] = cos(angle[i]);
        }
}

#endif
