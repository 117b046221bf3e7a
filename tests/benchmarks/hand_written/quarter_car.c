/* p: m1, m2, k1, k2, c1, speed. q: height of the wheel, of the car. */
#include "rhs.h"

void prepare(const double *p, double *c)
{
    c[0] = 1 / p[0];
    c[1] = 1 / p[1];
    for (int k = 0; k < 4; ++k)
        c[2 + k] = p[2 + k];
}

static inline int slopes(const double *const *in, double *const *out, int with_powers)
{
    const double *q = in[1], *v = in[2], *c = in[5];
    const double x = c[5] * in[0][0] - 5, angle = 6.283185307179586 * x;
    const int is_on_bump = x > 0 && x < 1;
    const double road = is_on_bump ? 0.04 * (1 - cos(angle)) : 0, tyre = c[3] * (q[0] - road), rate = v[1] - v[0];
    const double damper = c[4] * rate, strut = c[2] * (q[1] - q[0]) + damper;
    out[0][0] = (strut - tyre) * c[1];
    out[0][1] = -strut * c[0];
    if (with_powers) {
        out[1][0] = damper * rate;
        out[1][1] = is_on_bump ? -0.04 * 6.283185307179586 * c[5] * sin(angle) * tyre : 0;
    }
    return 0;
}
