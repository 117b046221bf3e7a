/* p: M, m, L, ks, cs, kp, cp. q: place of the cart, angle of the pole from upright. */
#include "rhs.h"

void prepare(const double *p, double *c)
{
    const double l = p[2] / 2;
    c[0] = p[0] + p[1];
    c[1] = p[1] * l;
    c[2] = p[1] * p[2] * p[2] / 12 + p[1] * l * l;
    c[3] = 9.81 * c[1];
    for (int k = 0; k < 4; ++k)
        c[4 + k] = p[3 + k];
    c[8] = c[0] * c[2];
}

static inline int slopes(const double *const *in, double *const *out, int with_powers)
{
    const double *q = in[1], *v = in[2], *c = in[5];
    const double s = sin(q[1]), b = c[1] * cos(q[1]), push = c[4] * q[0] + c[5] * v[0] - c[6] * q[1] - c[7] * v[1];
    const double x = push - c[1] * s * v[1] * v[1], y = c[3] * s;
    const double scale = 1 / (c[8] - b * b);
    out[0][0] = (c[2] * x + b * y) * scale;
    out[0][1] = (c[0] * y + b * x) * scale;
    if (with_powers) {
        out[1][0] = 0;
        out[1][1] = push * v[0];
    }
    return 0;
}
