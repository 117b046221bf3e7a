/* The larger and the smaller of two numbers, in one instruction: fmax and fmin are calls, for the sake of NaN. Here a NaN in `a` is
 * passed over and one in `b` is kept. */
#ifndef LAG_EXTREMES_H
#define LAG_EXTREMES_H

#include <math.h>
#include <stddef.h>

static inline double lag_max(double a, double b) { return a > b ? a : b; }

static inline double lag_min(double a, double b) { return a < b ? a : b; }

/* Of |x|; 0 for none. NaN is passed over. */
static inline double lag_largest(const double *x, size_t count)
{
    double largest[4] = {0, 0, 0, 0};
    size_t i = 0;
    for (; i + 3 < count; i += 4)
        for (size_t k = 0; k < 4; ++k)
            largest[k] = lag_max(fabs(x[i + k]), largest[k]);
    for (; i < count; ++i)
        largest[0] = lag_max(fabs(x[i]), largest[0]);
    return lag_max(lag_max(largest[0], largest[1]), lag_max(largest[2], largest[3]));
}

#endif
