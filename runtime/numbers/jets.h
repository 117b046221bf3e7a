/* Recurrences for Taylor coefficients: w(t0 + h) = w_0 + w_1 h + w_2 h^2 + ... is a jet, its coefficients lie one after another.
 *
 * Each function gives the coefficient of order k > 0, or the sum in it, from those of lower order. Scene code calls them with a
 * constant order, so that all loops are unrolled: three to four times as fast.
 * Source: A. Jorba, M. Zou, Experimental Mathematics 14 (2005), section 2.
 */
#ifndef LAG_JETS_H
#define LAG_JETS_H

#include <string.h>

#include "numbers/lanes.h"

enum { LAG_JET_STRIDE = 20, LAG_JET_ORDER = 18 };

/* sum of a_j b_(k - j) for j = first .. last, in two chains, long ones in four: as lanes where the compiler has vectors. */
#ifdef LAG_HAS_VECTORS
typedef double LagPair __attribute__((vector_size(16)));

LAG_UNROLLED double lag_jet_chains(const double *a, const double *b, int first, int last, int k)
{
    LagPair sum = {0, 0}, x, y;
    int j = first;
    if (last - first >= 7) {
        LagLanes four = {0, 0, 0, 0}, u, w;
        LAG_UNROLL
        for (; j < last - 2; j += 4) {
            memcpy(&u, a + j, sizeof u);
            memcpy(&w, b + k - j - 3, sizeof w);
            four += u * __builtin_shufflevector(w, w, 3, 2, 1, 0);
        }
        sum = __builtin_shufflevector(four, four, 0, 1) + __builtin_shufflevector(four, four, 2, 3);
    }
    LAG_UNROLL
    for (; j < last; j += 2) {
        memcpy(&x, a + j, sizeof x);
        memcpy(&y, b + k - j - 1, sizeof y);
        sum += x * __builtin_shufflevector(y, y, 1, 0);
    }
    return j == last ? sum[0] + a[j] * b[k - j] + sum[1] : sum[0] + sum[1];
}
#else
LAG_UNROLLED double lag_jet_chains(const double *a, const double *b, int first, int last, int k)
{
    double even = 0, odd = 0, third = 0, fourth = 0;
    int j = first;
    for (; last - first >= 7 && j < last - 2; j += 4) {
        even += a[j] * b[k - j];
        odd += a[j + 1] * b[k - j - 1];
        third += a[j + 2] * b[k - j - 2];
        fourth += a[j + 3] * b[k - j - 3];
    }
    even += third;
    odd += fourth;
    LAG_UNROLL
    for (; j < last; j += 2) {
        even += a[j] * b[k - j];
        odd += a[j + 1] * b[k - j - 1];
    }
    return j == last ? even + a[j] * b[k - j] + odd : even + odd;
}
#endif

/* sum of a_j b_(k - j) for j = first .. k, first < k. Its ends come last and one by one: they wait for the latest coefficients,
 * which a pair read at once would wait for even longer. */
LAG_UNROLLED double lag_jet_sum(const double *a, const double *b, int first, int k)
{
    const double ends = a[first] * b[k - first] + a[k] * b[0];
    if (k == first + 1)
        return ends;
    if (k == first + 2)
        return a[first + 1] * b[1] + ends;
    const double inner = a[first + 1] * b[k - first - 1] + a[k - 1] * b[1];
    return k == first + 3 ? inner + ends : lag_jet_chains(a, b, first + 2, k - 2, k) + inner + ends;
}

/* w = a b */
LAG_UNROLLED double lag_jet_product(const double *a, const double *b, int k) { return lag_jet_sum(a, b, 0, k); }

/* What a_1 .. a_k add: w = c/a asks for it with b = w, and w' = b u' with a_j = j u_j, k times over. */
LAG_UNROLLED double lag_jet_inner(const double *a, const double *b, int k)
{
    return k > 1 ? lag_jet_sum(a, b, 1, k) : a[1] * b[0];
}

/* w = a^2 */
LAG_UNROLLED double lag_jet_square(const double *a, int k)
{
    const double most = k > 4 ? lag_jet_chains(a, a, 2, (k - 1) / 2, k) : 0;
    const double sum = k > 2 ? most + a[1] * a[k - 1] : 0, twice = 2 * (sum + a[0] * a[k]);
    return k % 2 == 0 ? twice + a[k / 2] * a[k / 2] : twice;
}

/* w = sqrt(u): what w_1 .. w_(k-1) add to u_k. */
LAG_UNROLLED double lag_jet_between(const double *w, int k)
{
    const double most = k > 4 ? lag_jet_chains(w, w, 2, (k - 1) / 2, k) : 0, sum = k > 2 ? most + w[1] * w[k - 1] : 0;
    return k % 2 == 0 ? 2 * sum + w[k / 2] * w[k / 2] : 2 * sum;
}

/* w = u^exponent */
LAG_UNROLLED double lag_jet_power(const double *u, const double *w, double exponent, int k)
{
    double sum = 0;
    LAG_UNROLL
    for (int j = 0; j < k; ++j)
        sum += (exponent * (k - j) - j) * u[k - j] * w[j];
    return sum * (1.0 / k) * (1 / u[0]);
}

/* All bits of a number but its sign: none are set in 0. */
static inline uint64_t lag_size_bits(double c)
{
    uint64_t bits;
    memcpy(&bits, &c, sizeof bits);
    return bits << 1;
}

/* Whether a coefficient and the three before it are 0. */
static inline int lag_jet_ends(const double *c, int k)
{
    return (lag_size_bits(c[0]) | lag_size_bits(c[-k]) | lag_size_bits(c[-2 * k]) | lag_size_bits(c[-3 * k])) == 0;
}

/* sum of c_k h^k from k = 0 to the order: Horner in four chains, so that hardly one multiplication waits for another. */
static inline double lag_jet_value(const double *c, int pitch, int order, double h)
{
    const double square = h * h, fourth = square * square;
    const int rest = order % 4;
    int k = order - rest;
    const double *b = c + k * pitch;
    double a0 = b[0], a1 = rest > 0 ? b[pitch] : 0, a2 = rest > 1 ? b[2 * pitch] : 0, a3 = rest > 2 ? b[3 * pitch] : 0;
    for (k -= 4; k >= 0; k -= 4) {
        b -= 4 * pitch;
        a0 = a0 * fourth + b[0];
        a1 = a1 * fourth + b[pitch];
        a2 = a2 * fourth + b[2 * pitch];
        a3 = a3 * fourth + b[3 * pitch];
    }
    return (a0 + a1 * h) + (a2 + a3 * h) * square;
}

#ifdef LAG_HAS_VECTORS
/* Q (0, w): sums of products of the parts of Q, which lie in fours by orders, and each part of w. */
LAG_UNROLLED void lag_jet_turned(const double *quad, const double *w, int k, double *product)
{
    const LagLanes for_x = {-1, 1, 1, -1}, for_y = {-1, -1, 1, 1}, for_z = {-1, 1, -1, 1};
    const double *const u = w + LAG_JET_STRIDE, *const v = u + LAG_JET_STRIDE;
    LagLanes x = LAG_LANES_OF(0), y = x, z = x, four;
    for (int j = 1; j < k; ++j) {
        memcpy(&four, quad + 4 * j, sizeof four);
        x = LAG_LANES_FUSED(four, LAG_LANES_OF(w[k - j]), x);
        y = LAG_LANES_FUSED(four, LAG_LANES_OF(u[k - j]), y);
        z = LAG_LANES_FUSED(four, LAG_LANES_OF(v[k - j]), z);
    }
    for (int j = k; j >= 0; j -= k > 0 ? k : 1) { /* the latest coefficients last */
        memcpy(&four, quad + 4 * j, sizeof four);
        x = LAG_LANES_FUSED(four, LAG_LANES_OF(w[k - j]), x);
        y = LAG_LANES_FUSED(four, LAG_LANES_OF(u[k - j]), y);
        z = LAG_LANES_FUSED(four, LAG_LANES_OF(v[k - j]), z);
    }
    const LagLanes sum = for_x * __builtin_shufflevector(x, x, 1, 0, 3, 2) + for_y * __builtin_shufflevector(y, y, 2, 3, 0, 1)
        + for_z * __builtin_shufflevector(z, z, 3, 2, 1, 0);
    memcpy(product, &sum, sizeof sum);
}
#else
LAG_UNROLLED void lag_jet_turned(const double *quad, const double *w, int k, double *product)
{
    double sums[3][4] = {{0}};
    for (int j = 0; j <= k; ++j)
        for (int i = 0; i < 3; ++i)
            for (int m = 0; m < 4; ++m)
                sums[i][m] += quad[4 * j + m] * w[i * LAG_JET_STRIDE + k - j];
    product[0] = -sums[0][1] - sums[1][2] - sums[2][3];
    product[1] = sums[0][0] - sums[1][3] + sums[2][2];
    product[2] = sums[0][3] + sums[1][0] - sums[2][1];
    product[3] = -sums[0][2] + sums[1][1] + sums[2][0];
}
#endif

/* The coefficients of order k + 1 of a quaternion Q with Q' = Q (0, w)/2: four jets, and once more in fours, order by order; the
 * three jets of w lie one after another. */
LAG_UNROLLED void lag_jet_turn(double *q, double *quad, const double *w, int k)
{
    double *next = quad + 4 * (k + 1), product[4];
    lag_jet_turned(quad, w, k, product);
    for (int m = 0; m < 4; ++m)
        q[m * LAG_JET_STRIDE + k + 1] = next[m] = product[m] * (0.5 / (k + 1));
}

/* to_i = factor from_i: the next coefficients of a state whose jets lie order by order. */
static inline void lag_jet_rows(double *to, const double *from, double factor, int n)
{
    int i = 0;
    for (; i + LAG_LANES <= n; i += LAG_LANES) {
        LagLanes c;
        memcpy(&c, from + i, sizeof c);
        c *= LAG_LANES_OF(factor);
        memcpy(to + i, &c, sizeof c);
    }
    for (; i < n; ++i)
        to[i] = factor * from[i];
}

#endif
