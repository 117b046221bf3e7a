/* Sines and cosines of four angles at once, by one sequence of operations: the same digits on every machine and in every build,
 * where mathematical libraries differ in the last one. Four take as long as one of glibc's; one alone takes longer.
 *
 * An angle is reduced to r, |r| <= pi/4, by multiples of pi/2 in three parts of 33, 33 and 53 bits (Cody and Waite 1980), r itself
 * in two parts; sin r and cos r are polynomials of r^2, interpolated at Chebyshev nodes in 60 digits. Errors stay below 0.9 units
 * of the last place. Angles beyond 1e6, infinite and NaN ones go to the mathematical library one by one.
 */
#ifndef LAG_SINES_H
#define LAG_SINES_H

#include "numbers/lanes.h"

#define LAG_LARGEST_ANGLE 1e6 /* so many quarter turns have at most 20 bits: their products with 33 bits are exact */

#define LAG_SINES lag_sines_of_lanes
#define LAG_SINES_NUMBERS LagLanes
#define LAG_SINES_WORDS LagLaneWords
#define LAG_SINES_WORDS_OF(a) LAG_LANES_WORDS(a)
#define LAG_SINES_OF_WORDS(words) LAG_LANES_OF_WORDS(words)
#include "numbers/sines_kernel.h"

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
