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

static inline int slopes(const double *const *in, double *const *out, int with_powers)
{
    const double *q = in[1], *v = in[2], *c = in[5];
    const double s = sin(q[1]), co = cos(q[1]), force = 50 * sin(3 * in[0][0]);
    const double rise = c[1] * s, turn = c[1] * co * v[1], slow = v[0] - turn, quick = v[0] + turn;
    const double brake1 = c[6] * slow, brake2 = c[7] * quick;
    const double left = c[4] * (q[0] - rise) + brake1, right = c[5] * (q[0] + rise) + brake2;
    out[0][0] = (force - left - right) * c[0];
    out[0][1] = co * (c[1] * (left - right) + c[3] * force) * c[2];
    if (with_powers) {
        out[1][0] = brake1 * slow + brake2 * quick;
        out[1][1] = force * (v[0] + c[3] * co * v[1]);
    }
    return 0;
}
