/* The Dormand-Prince method 8(5,3) for q'' = a(t, q, q'), one step at a time. */
#ifndef LAG_DOP853_H
#define LAG_DOP853_H

#include "method.h"

enum { LAG_DOP853_SLOPES = 16, LAG_DOP853_COEFFICIENTS = 7 };

typedef struct {
    double *k[LAG_DOP853_SLOPES];
    double *dense[LAG_DOP853_COEFFICIENTS];
    int first_slope_is_last; /* slope 12 of the step before is slope 0 of the next one */
    int dense_ready;
} LagDop853;

extern const LagMethod lag_dop853;

#endif
