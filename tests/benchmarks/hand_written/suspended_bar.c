/* p: m, L, a, k1, k2, c1, c2. q: height of the centre, tilt. */
#include "rhs.h"

void prepare(const double *p, double *c)
{
    c[0] = 1 / p[0];
    c[1] = p[1] / 2;
    c[2] = 1 / (p[0] * p[1] * p[1] / 12);
    c[3] = p[2] - p[1] / 2;
    for (int k = 0; k < 4; ++k)
        c[4 + k] = p[3 + k];
}

int rhs(const double *const *in, double *const *out, double *w)
{
    const double *q = in[1], *v = in[2], *c = in[5];
    const double s = sin(q[1]), co = cos(q[1]), force = 50 * sin(3 * in[0][0]);
    const double rise = c[1] * s, turn = c[1] * co * v[1];
    const double left = c[4] * (q[0] - rise) + c[6] * (v[0] - turn), right = c[5] * (q[0] + rise) + c[7] * (v[0] + turn);
    (void)w;
    out[0][0] = (force - left - right) * c[0];
    out[0][1] = co * (c[1] * (left - right) + c[3] * force) * c[2];
    return 0;
}
