/* p: m1, L1, m2, L2. q: angle of the upper bar, bend of the elbow. */
#include "rhs.h"

void prepare(const double *p, double *c)
{
    c[0] = p[0] * p[1] * p[1] / 3 + p[2] * p[1] * p[1];
    c[1] = p[2] * p[3] * p[3] / 3;
    c[2] = p[2] * p[1] * p[3] / 2;
    c[3] = 9.81 * (p[0] / 2 + p[2]) * p[1];
    c[4] = 9.81 * p[2] * p[3] / 2;
    c[5] = c[0] * c[1];
}

static inline int slopes(const double *const *in, double *const *out, int with_powers)
{
    const double *q = in[1], *v = in[2], *c = in[5];
    const double b = c[2] * cos(q[1]), e = c[2] * sin(q[1]), w1 = v[0], w2 = v[0] + v[1];
    const double x = e * w2 * w2 - c[3] * cos(q[0]), y = -e * w1 * w1 - c[4] * cos(q[0] + q[1]);
    const double scale = 1 / (c[5] - b * b), upper = (c[1] * x - b * y) * scale, lower = (c[0] * y - b * x) * scale;
    (void)with_powers; /* nothing drives or brakes it */
    out[0][0] = upper;
    out[0][1] = lower - upper;
    return 0;
}
