/* Instructions that compute the same, told from others: a value has one number, the first place where it stands. */
#ifndef LAG_NUMBERING_H
#define LAG_NUMBERING_H

#include <stddef.h>
#include <stdint.h>

#include "base/arena.h"

typedef struct {
    int32_t op, out, a, b;
} LagInstruction;

typedef struct {
    LagInstruction *found; /* operands by their places in this list */
    int32_t count;
    double *constants; /* of CONST, whose a is a place in this list */
    int32_t n_constants;
    int32_t *slots; /* 1 + places in `found`; 0 where there is none */
    int32_t n_slots; /* a power of 2 */
} LagNumbering;

/* Room for so many instructions; constants are the caller's. */
void lag_numbering_layout(LagNumbering *s, int32_t count, LagArena *arena);

/* The place of what is the same, which is added where there is none. `commutes`: operands may change places. `constant`: of
 * CONST, whose place among the constants is found here, else NULL. */
int32_t lag_number(LagNumbering *s, LagInstruction made, int commutes, const double *constant);

/* How many places there are in instructions of four numbers each, as arrange.h has them. */
int32_t lag_count_places(const int32_t *read, int32_t count);

#endif
