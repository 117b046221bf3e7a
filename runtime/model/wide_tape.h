/* Tapes for eight states at once (wide.h): the digits are those of one state after another. */
#ifndef LAG_WIDE_TAPE_H
#define LAG_WIDE_TAPE_H

#include "model/tape.h"

/* in: t, q, v, u, d, c, the last two of all states where they are shared; out: as the tape's; work: eight times that of a single
 * state. */
void lag_wide_tape_run(const LagTape *tape, const double *const *in, int is_shared, double *const *out, double *work);

#endif
