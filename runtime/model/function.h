/* Calling a LagFunction, whichever way it is written. */
#ifndef LAG_FUNCTION_H
#define LAG_FUNCTION_H

#include "model/tape.h"

static inline int lag_present(const LagFunction *function) { return function->code || function->tape; }

/* Returns 0 unless the function has no value here. An absent function does nothing. */
static inline int lag_call(const LagFunction *function, const double *const *in, double *const *out, double *work)
{
    if (function->code)
        return function->code(in, out, work);
    if (function->tape)
        lag_tape_run(function->tape, in, out, work);
    return 0;
}

#endif
