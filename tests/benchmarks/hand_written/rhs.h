/* What a scene written by hand exports: constants c from parameters p, and at t, q, v = in[0 ... 2], c = in[5] the accelerations
 * out[0], and beside them the powers out[1] that dampers take out and sources put in: the arguments of the generated function.
 * A scene states prepare and slopes. */
#ifndef RHS_H
#define RHS_H

#include <math.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

EXPORT void prepare(const double *p, double *c);
EXPORT int accelerations(const double *const *in, double *const *out, double *w);
EXPORT int with_powers(const double *const *in, double *const *out, double *w);

static inline int slopes(const double *const *in, double *const *out, int with_powers);

int accelerations(const double *const *in, double *const *out, double *w)
{
    (void)w;
    return slopes(in, out, 0);
}

int with_powers(const double *const *in, double *const *out, double *w)
{
    (void)w;
    return slopes(in, out, 1);
}

#endif
