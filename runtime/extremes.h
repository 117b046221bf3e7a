/* The larger and the smaller of two numbers, in one instruction: fmax and fmin are calls, for the sake of NaN. Here a NaN in `a` is
 * passed over and one in `b` is kept. */
#ifndef LAG_EXTREMES_H
#define LAG_EXTREMES_H

static inline double lag_max(double a, double b) { return a > b ? a : b; }

static inline double lag_min(double a, double b) { return a < b ? a : b; }

#endif
