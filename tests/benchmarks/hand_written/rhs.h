/* What a scene written by hand exports: constants c from parameters p, and the accelerations out[0] at t, q, v = in[0 ... 2],
 * c = in[5]: the arguments of the generated function. */
#ifndef RHS_H
#define RHS_H

#include <math.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

EXPORT void prepare(const double *p, double *c);
EXPORT int rhs(const double *const *in, double *const *out, double *w);

#endif
