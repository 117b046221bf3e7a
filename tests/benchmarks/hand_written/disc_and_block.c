/* p: m, I, r, k1, k2. q: place of the block, angle of the disc. */
#include "rhs.h"

void prepare(const double *p, double *c)
{
    c[0] = 1 / p[0];
    c[1] = 1 / p[1];
    c[2] = p[2];
    c[3] = p[3];
    c[4] = p[4];
}

static inline int slopes(const double *const *in, double *const *out, int with_powers)
{
    const double *q = in[1], *v = in[2], *c = in[5];
    const double pull = c[4] * (c[2] * q[1] - q[0]), moment = 0.5 * sin(2 * in[0][0]);
    out[0][0] = (pull - c[3] * q[0]) * c[0];
    out[0][1] = (moment - c[2] * pull) * c[1];
    if (with_powers) {
        out[1][0] = 0;
        out[1][1] = moment * v[1];
    }
    return 0;
}
