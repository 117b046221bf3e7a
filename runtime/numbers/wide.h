/* Eight states at once, in as many registers as they need: stages that do not wait for each other (pirk.c).
 *
 * Number i of eight states is eight numbers in a row. One evaluation of eight states takes as long as one of a single state where
 * registers hold eight numbers, as its operations wait for each other; half as long again where they hold four.
 */
#ifndef LAG_WIDE_H
#define LAG_WIDE_H

#include "numbers/lanes.h"
#include "numbers/sines.h"

enum { LAG_ABREAST = 8 };

#if defined(LAG_HAS_VECTORS) && (defined(__AVX512F__) || !defined(__AVX__))
#ifdef __AVX512F__
enum { LAG_WIDE = 8 };
#define LAG_WIDE_OF(number) \
    ((LagWide){(number), (number), (number), (number), (number), (number), (number), (number)})
#else
enum { LAG_WIDE = 2 };
#define LAG_WIDE_OF(number) ((LagWide){(number), (number)})
#endif
typedef double LagWide __attribute__((vector_size(8 * LAG_WIDE)));
typedef int64_t LagWideBits __attribute__((vector_size(8 * LAG_WIDE)));
typedef uint64_t LagWideWords __attribute__((vector_size(8 * LAG_WIDE)));
#define LAG_WIDE_ABS(a) ((LagWide)((LagWideBits)(a) & INT64_MAX))
#define LAG_WIDE_SELECT(condition, a, b) \
    ((LagWide)(((LagWideBits)(condition) & (LagWideBits)(a)) | (~(LagWideBits)(condition) & (LagWideBits)(b))))
#define LAG_WIDE_WORDS(a) ((LagWideWords)(a))
#define LAG_WIDE_OF_WORDS(words) ((LagWide)(words))
#define LAG_SINES lag_sines_of_wide
#define LAG_SINES_NUMBERS LagWide
#define LAG_SINES_WORDS LagWideWords
#define LAG_SINES_WORDS_OF(a) LAG_WIDE_WORDS(a)
#define LAG_SINES_OF_WORDS(words) LAG_WIDE_OF_WORDS(words)
#include "numbers/sines_kernel.h"
#else
enum { LAG_WIDE = LAG_LANES };
typedef LagLanes LagWide;
typedef LagLaneWords LagWideWords;
#define LAG_WIDE_WORDS(a) LAG_LANES_WORDS(a)
#define LAG_WIDE_OF_WORDS(words) LAG_LANES_OF_WORDS(words)
#define LAG_WIDE_OF(number) LAG_LANES_OF(number)
#define LAG_WIDE_ABS(a) LAG_LANES_ABS(a)
#define LAG_WIDE_SELECT(condition, a, b) LAG_LANES_SELECT(condition, a, b)
#define lag_sines_of_wide lag_sines_of_lanes
#endif

/* a b + c: rounded once where the compiler may take it that processors do so in one instruction. What is made of it has the same digits
 * on all of these, whatever the width of their registers. */
#if defined(LAG_HAS_VECTORS) && defined(__AVX512F__) && defined(__FMA__) && !defined(__clang__)
#define LAG_WIDE_FUSED(a, b, c) __builtin_ia32_vfmaddpd512_mask(a, b, c, 0xff, 4) /* all lanes, rounded as is set */
#elif defined(LAG_HAS_VECTORS) && defined(__FMA__) && !defined(__clang__)
#define LAG_WIDE_FUSED(a, b, c) __builtin_ia32_vfmaddpd256(a, b, c)
#elif defined(__FMA__) || defined(__ARM_FEATURE_FMA)
#define LAG_WIDE_FUSED(a, b, c) lag_wide_fused(a, b, c)
static inline LagWide lag_wide_fused(LagWide a, LagWide b, LagWide c)
{
    double x[LAG_WIDE], y[LAG_WIDE], z[LAG_WIDE];
    memcpy(x, &a, sizeof x);
    memcpy(y, &b, sizeof y);
    memcpy(z, &c, sizeof z);
    LAG_UNROLL_ALL
    for (int i = 0; i < LAG_WIDE; ++i)
        z[i] = fma(x[i], y[i], z[i]);
    memcpy(&c, z, sizeof c);
    return c;
}
#else
#define LAG_WIDE_FUSED(a, b, c) ((a) * (b) + (c))
#endif

/* The larger and the smaller one; b where one of them is no number. */
#if defined(LAG_HAS_VECTORS) && defined(__AVX512F__) && !defined(__clang__)
#define LAG_WIDE_MAX(a, b) __builtin_ia32_maxpd512_mask(a, b, b, 0xff, 4)
#define LAG_WIDE_MIN(a, b) __builtin_ia32_minpd512_mask(a, b, b, 0xff, 4)
#elif defined(LAG_HAS_VECTORS) && defined(__AVX__) && !defined(__clang__)
#define LAG_WIDE_MAX(a, b) __builtin_ia32_maxpd256(a, b)
#define LAG_WIDE_MIN(a, b) __builtin_ia32_minpd256(a, b)
#else
#define LAG_WIDE_MAX(a, b) LAG_WIDE_SELECT((a) > (b), a, b)
#define LAG_WIDE_MIN(a, b) LAG_WIDE_SELECT((a) < (b), a, b)
#endif

/* As numbers, which lie where none of a caller's pointers do, and need not lie at a line of the cache. */
#ifdef LAG_HAS_VECTORS
typedef double LagWidePlace __attribute__((vector_size(8 * LAG_WIDE), aligned(8)));
#else
typedef double LagWidePlace;
#endif

static inline LagWide lag_wide_read(const double *place) { return *(const LagWidePlace *)place; }

static inline void lag_wide_write(double *place, LagWide a) { *(LagWidePlace *)place = a; }

/* Whether some number is not 0. */
static inline int lag_wide_is_some(LagWide a)
{
#if defined(LAG_HAS_VECTORS) && defined(__AVX512F__) && !defined(__clang__)
    return __builtin_ia32_cmppd512_mask(a, LAG_WIDE_OF(0), 4, 0xff, 4) != 0; /* unequal, or no number */
#else
    double each[LAG_WIDE];
    memcpy(each, &a, sizeof each);
    int some = 0;
    for (int i = 0; i < LAG_WIDE; ++i)
        some |= each[i] != 0;
    return some;
#endif
}

/* sum of a[j] times row j of a table whose rows are `pitch` long, for the columns from `lane` on: in two chains. */
LAG_UNROLLED LagWide lag_wide_weighed(const double *a, const double *table, int count, int pitch, int lane)
{
    LagWide even = LAG_WIDE_OF(0), odd = LAG_WIDE_OF(0);
    LAG_UNROLL_ALL
    for (int j = 0; j < count; j += 2) {
        even += LAG_WIDE_OF(a[j]) * lag_wide_read(table + j * pitch + lane);
        odd += LAG_WIDE_OF(a[j + 1]) * lag_wide_read(table + (j + 1) * pitch + lane);
    }
    return even + odd;
}

/* The sum of eight numbers, which are lost: by halves, so that few operations wait for each other. */
static inline double lag_wide_total(double *each)
{
    LAG_UNROLL_ALL
    for (int half = LAG_ABREAST / 2; half > 0; half /= 2)
        LAG_UNROLL_ALL
        for (int i = 0; i < half; ++i)
            each[i] += each[i + half];
    return each[0];
}

#endif
