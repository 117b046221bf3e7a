/* Recurrences for Taylor coefficients: w(t0 + h) = w_0 + w_1 h + w_2 h^2 + ... is a jet, its coefficients lie one after another.
 *
 * Each function gives the coefficient of order k > 0, or the sum in it, from those of lower order.
 * Source: A. Jorba, M. Zou, Experimental Mathematics 14 (2005), section 2.
 */
#ifndef LAG_JETS_H
#define LAG_JETS_H

enum { LAG_JET_STRIDE = 20, LAG_JET_ORDER = 18 };

/* Scene code calls these with a constant order, so that all loops are unrolled: three to four times as fast. */
#if defined(__clang__)
#define LAG_UNROLLED static inline __attribute__((always_inline))
#define LAG_UNROLL _Pragma("unroll")
#elif defined(__GNUC__)
#define LAG_UNROLLED static inline __attribute__((always_inline))
#define LAG_UNROLL _Pragma("GCC unroll 20")
#else
#define LAG_UNROLLED static inline
#define LAG_UNROLL
#endif

/* sum of a_j b_(k - j) for j = first .. k, in two chains. */
LAG_UNROLLED double lag_jet_sum(const double *a, const double *b, int first, int k)
{
    double even = 0, odd = 0;
    int j = first;
    LAG_UNROLL
    for (; j < k; j += 2) {
        even += a[j] * b[k - j];
        odd += a[j + 1] * b[k - j - 1];
    }
    return j == k ? even + odd + a[k] * b[0] : even + odd;
}

/* w = a b */
LAG_UNROLLED double lag_jet_product(const double *a, const double *b, int k) { return lag_jet_sum(a, b, 0, k); }

/* What a_1 .. a_k add: w = c/a asks for it with b = w, and w' = b u' with a_j = j u_j, k times over. */
LAG_UNROLLED double lag_jet_inner(const double *a, const double *b, int k) { return lag_jet_sum(a, b, 1, k); }

/* w = a^2 */
LAG_UNROLLED double lag_jet_square(const double *a, int k)
{
    double sum = 0;
    LAG_UNROLL
    for (int j = 0; 2 * j < k; ++j)
        sum += a[j] * a[k - j];
    return k % 2 == 0 ? 2 * sum + a[k / 2] * a[k / 2] : 2 * sum;
}

/* w = sqrt(u): what w_1 .. w_(k-1) add to u_k. */
LAG_UNROLLED double lag_jet_between(const double *w, int k)
{
    double sum = 0;
    LAG_UNROLL
    for (int j = 1; 2 * j < k; ++j)
        sum += w[j] * w[k - j];
    return k % 2 == 0 ? 2 * sum + w[k / 2] * w[k / 2] : 2 * sum;
}

/* w = u^exponent */
LAG_UNROLLED double lag_jet_power(const double *u, const double *w, double exponent, int k)
{
    double sum = 0;
    LAG_UNROLL
    for (int j = 0; j < k; ++j)
        sum += (exponent * (k - j) - j) * u[k - j] * w[j];
    return sum / (k * u[0]);
}

#endif
