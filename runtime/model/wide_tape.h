/* Tapes for eight states at once (wide.h): the digits are those of one state after another. */
#ifndef LAG_WIDE_TAPE_H
#define LAG_WIDE_TAPE_H

#include "model/tape.h"

/* What holds: d and c are those of all states; sines that one state has from the mathematical library are made of all states at once, as
 * all others are, which changes last digits. */
enum { LAG_TAPE_SHARED = 1, LAG_TAPE_ALL_SINES = 2 };

/* in: t, q, v, u, d, c; out: as the tape's; work: eight times that of a single state; holds: LAG_TAPE_... */
void lag_wide_tape_run(const LagTape *tape, const double *const *in, int holds, double *const *out, double *work);

#endif
