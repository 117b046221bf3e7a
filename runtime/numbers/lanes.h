/* Loops over long vectors, four numbers at a time where the compiler has vectors, one at a time elsewhere.
 *
 * Numbers are read and written by memcpy. Not for a few numbers that were written one by one a moment ago: reading four at once
 * waits until all are in the cache.
 */
#ifndef LAG_LANES_H
#define LAG_LANES_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__clang__) || (defined(__GNUC__) && __GNUC__ >= 12)
#define LAG_HAS_VECTORS
enum { LAG_LANES = 4 };
typedef double LagLanes __attribute__((vector_size(32)));
typedef int64_t LagLaneBits __attribute__((vector_size(32)));
typedef uint64_t LagLaneWords __attribute__((vector_size(32)));
#define LAG_LANES_OF(number) ((LagLanes){(number), (number), (number), (number)})
#define LAG_LANES_ABS(a) ((LagLanes)((LagLaneBits)(a) & INT64_MAX))
/* Where `condition`, a comparison, holds: a, else b. */
#define LAG_LANES_SELECT(condition, a, b) \
    ((LagLanes)(((LagLaneBits)(condition) & (LagLaneBits)(a)) | (~(LagLaneBits)(condition) & (LagLaneBits)(b))))
#define LAG_LANES_WORDS(a) ((LagLaneWords)(a))
#define LAG_LANES_OF_WORDS(words) ((LagLanes)(words))
#else
enum { LAG_LANES = 1 };
typedef double LagLanes;
typedef uint64_t LagLaneWords;
#define LAG_LANES_OF(number) (number)
#define LAG_LANES_ABS(a) fabs(a)
#define LAG_LANES_SELECT(condition, a, b) ((condition) ? (a) : (b))
static inline LagLaneWords LAG_LANES_WORDS(double a)
{
    LagLaneWords words;
    memcpy(&words, &a, sizeof words);
    return words;
}
static inline double LAG_LANES_OF_WORDS(LagLaneWords words)
{
    double a;
    memcpy(&a, &words, sizeof a);
    return a;
}
#endif

/* Functions copied to their callers, whose constants they then know, and loops that are written out: by two, or wholly. */
#if defined(__clang__)
#define LAG_UNROLLED static inline __attribute__((always_inline))
#define LAG_UNROLL _Pragma("unroll 2")
#define LAG_UNROLL_ALL _Pragma("unroll")
#elif defined(__GNUC__)
#define LAG_UNROLLED static inline __attribute__((always_inline))
#define LAG_UNROLL _Pragma("GCC unroll 2")
#define LAG_UNROLL_ALL _Pragma("GCC unroll 16")
#else
#define LAG_UNROLLED static inline
#define LAG_UNROLL
#define LAG_UNROLL_ALL
#endif

/* What callers see to, for compilers that leave out what does not happen then. */
#if defined(__clang__) || defined(__GNUC__)
#define LAG_KNOWN(condition)         \
    do                               \
        if (!(condition))            \
            __builtin_unreachable(); \
    while (0)
#else
#define LAG_KNOWN(condition) ((void)0)
#endif

/* a b + c, rounded once where the compiler may take it that processors do so in one instruction: as in wide.h. */
#if defined(LAG_HAS_VECTORS) && defined(__FMA__) && !defined(__clang__)
#define LAG_LANES_FUSED(a, b, c) __builtin_ia32_vfmaddpd256(a, b, c)
#else
#define LAG_LANES_FUSED(a, b, c) ((a) * (b) + (c))
#endif

#define LAG_LANES_SIGN ((uint64_t)1 << 63)

/* As in extremes.h: a NaN in `a` is passed over. */
#define LAG_LANES_MAX(a, b) LAG_LANES_SELECT((a) > (b), a, b)
#define LAG_LANES_MIN(a, b) LAG_LANES_SELECT((a) < (b), a, b)

/* The largest of the lanes and of `least`. */
static inline double lag_lanes_largest(const LagLanes *lanes, double least)
{
    double each[LAG_LANES];
    memcpy(each, lanes, sizeof each);
    for (int i = 0; i < LAG_LANES; ++i)
        least = each[i] > least ? each[i] : least;
    return least;
}

#endif
