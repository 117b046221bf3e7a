/* A function as CasADi keeps it -> a tape: what is the same is computed once, sines and cosines stand together, and places of w
 * are taken again. compiler/lagrangia/compile/instructions.py does the same, where there is no run time; a test compares both.
 */
#ifndef LAG_ARRANGE_H
#define LAG_ARRANGE_H

#include <stdint.h>

#include "model/model.h"

enum { LAG_ARRANGED, LAG_ARRANGE_NO_MEMORY, LAG_ARRANGE_UNKNOWN };
/* What is known of an operation besides its LagOp. */
enum { LAG_ARRANGE_OP = 0xff, LAG_ARRANGE_BINARY = 0x100, LAG_ARRANGE_COMMUTES = 0x200 };

/* `read`: four numbers an instruction, {operation, place, operand, operand}; of INPUT {.., place, argument, element}, of OUTPUT
 * {.., result, operand, element}, of CONST {.., place, the number as 8 bytes}. `kinds` by operation: LagOp with flags, -1 for
 * those that tapes lack. `code` and `constants` have room for all instructions; `sizes`: how many there are of both, then of w.
 */
LAG_API int lag_arrange(const int32_t *read, int32_t count, const int32_t *kinds, int32_t n_kinds, int32_t *code,
                        double *constants, int32_t *sizes);

#endif
