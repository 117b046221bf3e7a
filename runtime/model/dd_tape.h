/* A tape (tape.h) run in double-doubles: numbers that a matrix exponential is made of. */
#ifndef LAG_DD_TAPE_H
#define LAG_DD_TAPE_H

#include "numbers/dd.h"
#include "model/tape.h"

/* Inputs are doubles. The rarest functions (erf, fmod) are those of doubles. */
void lag_dd_tape_run(const LagTape *tape, const double *const *in, LagDD *const *out, LagDD *work);

#endif
