/* Functions as lists of instructions, for scenes that no C compiler has seen.
 *
 * A tape is a flat int32 array, four numbers an instruction {op, out, a, b}, working on one vector w:
 *     INPUT   w[out] = in[a][b]          CONST  w[out] = constants[a]
 *     OUTPUT  out[out][b] = w[a]         others w[out] = op(w[a], w[b])    (unary ones ignore b)
 * SIN and COS have in b how many instructions, this one among them, are sines and cosines that are computed together (sines.h);
 * 0: alone, by the mathematical library.
 */
#ifndef LAG_TAPE_H
#define LAG_TAPE_H

#include <stdint.h>

#include "model/model.h"

typedef enum {
    LAG_OP_INPUT, LAG_OP_OUTPUT, LAG_OP_CONST, LAG_OP_ASSIGN,
    LAG_OP_ADD, LAG_OP_SUB, LAG_OP_MUL, LAG_OP_DIV, LAG_OP_NEG, LAG_OP_SQ, LAG_OP_TWICE, LAG_OP_INV,
    LAG_OP_SQRT, LAG_OP_SIN, LAG_OP_COS, LAG_OP_TAN, LAG_OP_ASIN, LAG_OP_ACOS, LAG_OP_ATAN, LAG_OP_ATAN2,
    LAG_OP_EXP, LAG_OP_LOG, LAG_OP_POW, LAG_OP_CONSTPOW,
    LAG_OP_FABS, LAG_OP_SIGN, LAG_OP_FMIN, LAG_OP_FMAX, LAG_OP_FLOOR, LAG_OP_CEIL, LAG_OP_FMOD, LAG_OP_COPYSIGN,
    LAG_OP_LT, LAG_OP_LE, LAG_OP_EQ, LAG_OP_NE, LAG_OP_NOT, LAG_OP_AND, LAG_OP_OR, LAG_OP_IF_ELSE_ZERO,
    LAG_OP_SINH, LAG_OP_COSH, LAG_OP_TANH, LAG_OP_ASINH, LAG_OP_ACOSH, LAG_OP_ATANH, LAG_OP_ERF,
    LAG_OP_COUNT
} LagOp;

enum { LAG_MOST_SINES = 32 }; /* so many are computed together at once */

struct LagTape {
    int32_t n_instructions, n_constants;
    const int32_t *code; /* 4 n_instructions */
    const double *constants;
};

/* Whether every index of the function's tape stays inside its vectors and every op is known. */
LAG_API int lag_tape_valid(const LagFunction *function);

/* The rarer half of the instructions: equations of motion are made of the others, most of them. */
double lag_tape_uncommon(int32_t op, double x, double y);

LAG_API void lag_tape_run(const LagTape *tape, const double *const *in, double *const *out, double *work);

#endif
