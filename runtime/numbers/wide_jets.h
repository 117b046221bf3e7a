/* The recurrences of jets.h for eight motions at once: a coefficient is eight numbers in a row, and those of a jet lie one after
 * another.
 *
 * What waits for the latest coefficients are the ends of the sums of products, a_0 b_k + a_k b_0. What lies between them is known when
 * an order begins, most of it before the one before has ended: one loop serves several sums from j = 2 to k - 2, then come a_1 b_(k - 1)
 * and a_(k - 1) b_1. That is the order of additions everywhere, each with its product in one rounding, so that digits are those of every
 * processor that rounds so, by scene code and by instructions.
 */
#ifndef LAG_WIDE_JETS_H
#define LAG_WIDE_JETS_H

#include "numbers/jets.h"
#include "numbers/wide.h"

/* From one jet to the next; the coefficient of order k of a jet, of the lanes from that on which `jet` points to. */
#define LAG_WIDE_JET (LAG_JET_STRIDE * LAG_ABREAST)
#define LAG_WIDE_TERM(jet, k) lag_wide_read((jet) + (k) * LAG_ABREAST)

/* From what lies between the ends: the sums over j = 0 .. k, and over j = 1 .. k. */
#define LAG_WIDE_PRODUCT(between, a_0, a_k, b_0, b_k) LAG_WIDE_FUSED(a_k, b_0, LAG_WIDE_FUSED(a_0, b_k, between))
#define LAG_WIDE_INNER(between, a_k, b_0) LAG_WIDE_FUSED(a_k, b_0, between)

/* What lies between the ends of a sum over j = 0 .. k, from that of j = 2 to k - 2. */
LAG_UNROLLED LagWide lag_wide_ends(LagWide sum, const double *a, const double *b, int k)
{
    if (k > 1)
        sum = LAG_WIDE_FUSED(LAG_WIDE_TERM(a, 1), LAG_WIDE_TERM(b, k - 1), sum);
    if (k > 2)
        sum = LAG_WIDE_FUSED(LAG_WIDE_TERM(a, k - 1), LAG_WIDE_TERM(b, 1), sum);
    return sum;
}

/* The same of a square, whose half is summed, from that of j = 2 to before k/2; and a square from its half without a_(k/2)^2. */
LAG_UNROLLED LagWide lag_wide_half_ends(LagWide half, const double *a, int k)
{
    return k > 2 ? LAG_WIDE_FUSED(LAG_WIDE_TERM(a, 1), LAG_WIDE_TERM(a, k - 1), half) : half;
}

LAG_UNROLLED LagWide lag_wide_twice(LagWide half, const double *a, int k)
{
    const LagWide middle = LAG_WIDE_TERM(a, k / 2), twice = half + half;
    return k % 2 == 0 ? LAG_WIDE_FUSED(middle, middle, twice) : twice;
}

/* Half a square from the same, whose latest coefficients come last. */
LAG_UNROLLED LagWide lag_wide_half(LagWide half, const double *a, int k)
{
    const LagWide middle = LAG_WIDE_TERM(a, k / 2);
    return k % 2 == 0 ? LAG_WIDE_FUSED(LAG_WIDE_OF(0.5) * middle, middle, half) : half;
}

/* w = a^2, whose latest coefficient is multiplied last */
LAG_UNROLLED LagWide lag_wide_square(LagWide half, const double *a, LagWide a_k, int k)
{
    const LagWide a_0 = LAG_WIDE_TERM(a, 0);
    return LAG_WIDE_FUSED(a_0 + a_0, a_k, lag_wide_twice(half, a, k));
}

/* w = u^exponent */
LAG_UNROLLED LagWide lag_wide_power(const double *u, const double *w, LagWide exponent, int k)
{
    LagWide sum = LAG_WIDE_OF(0);
    for (int j = 0; j < k; ++j)
        sum = LAG_WIDE_FUSED((exponent * LAG_WIDE_OF((double)(k - j)) - LAG_WIDE_OF((double)j)) * LAG_WIDE_TERM(u, k - j),
                             LAG_WIDE_TERM(w, j), sum);
    return sum * LAG_WIDE_OF(1.0 / k) * (LAG_WIDE_OF(1) / LAG_WIDE_TERM(u, 0));
}

/* The coefficients of order k + 1 of a quaternion Q with Q' = Q (0, w)/2; its four jets and the three of w lie in rows. */
LAG_UNROLLED void lag_wide_jet_turn(double *q, const double *w, int k)
{
    enum { NEXT = LAG_WIDE_JET };
    LagWide sum[4] = {LAG_WIDE_OF(0), LAG_WIDE_OF(0), LAG_WIDE_OF(0), LAG_WIDE_OF(0)};
    for (int j = 0; j <= k; ++j) {
        const LagWide a = LAG_WIDE_TERM(q, j), b = LAG_WIDE_TERM(q + NEXT, j), c = LAG_WIDE_TERM(q + 2 * NEXT, j);
        const LagWide d = LAG_WIDE_TERM(q + 3 * NEXT, j), x = LAG_WIDE_TERM(w, k - j), y = LAG_WIDE_TERM(w + NEXT, k - j);
        const LagWide z = LAG_WIDE_TERM(w + 2 * NEXT, k - j);
        sum[0] = LAG_WIDE_FUSED(-b, x, LAG_WIDE_FUSED(-c, y, LAG_WIDE_FUSED(-d, z, sum[0])));
        sum[1] = LAG_WIDE_FUSED(a, x, LAG_WIDE_FUSED(c, z, LAG_WIDE_FUSED(-d, y, sum[1])));
        sum[2] = LAG_WIDE_FUSED(a, y, LAG_WIDE_FUSED(d, x, LAG_WIDE_FUSED(-b, z, sum[2])));
        sum[3] = LAG_WIDE_FUSED(a, z, LAG_WIDE_FUSED(b, y, LAG_WIDE_FUSED(-c, x, sum[3])));
    }
    for (int m = 0; m < 4; ++m)
        lag_wide_write(q + m * NEXT + (k + 1) * LAG_ABREAST, sum[m] * LAG_WIDE_OF(0.5 / (k + 1)));
}

/* Sines and cosines of as many angles as a register holds. */
LAG_UNROLLED void lag_wide_circular(const LagWide *angle, LagWide *sine, LagWide *cosine)
{
    lag_sines_of_wide(angle, sine, cosine);
    const LagWide size = LAG_WIDE_ABS(*angle), most = LAG_WIDE_OF(LAG_LARGEST_ANGLE);
    if (!lag_wide_is_some(LAG_WIDE_SELECT(size <= most, LAG_WIDE_OF(0), LAG_WIDE_OF(1))))
        return;
    double x[LAG_WIDE], s[LAG_WIDE], c[LAG_WIDE];
    memcpy(x, angle, sizeof x);
    memcpy(s, sine, sizeof s);
    memcpy(c, cosine, sizeof c);
    for (int i = 0; i < LAG_WIDE; ++i)
        if (!(fabs(x[i]) <= LAG_LARGEST_ANGLE)) {
            s[i] = sin(x[i]);
            c[i] = cos(x[i]);
        }
    memcpy(sine, s, sizeof s);
    memcpy(cosine, c, sizeof c);
}

LAG_UNROLLED LagWide lag_wide_sine(LagWide angle)
{
    LagWide sine, cosine;
    lag_wide_circular(&angle, &sine, &cosine);
    return sine;
}

LAG_UNROLLED LagWide lag_wide_cosine(LagWide angle)
{
    LagWide sine, cosine;
    lag_wide_circular(&angle, &sine, &cosine);
    return cosine;
}

#endif
