/* The interpreter of tapes (tape.h): one switch in a loop.
 *
 * Meanings are those of CasADi's SX instructions (casadi/core/calculus.hpp), the place tapes come from:
 * truth is any value but 0, `sign` passes NaN on, IF_ELSE_ZERO does not touch b when a is 0 (0 * NaN must be 0).
 */
#include "model/tape.h"

#include <math.h>

#include "numbers/sines.h"

enum { FIELDS = 4 };

static int inside(int32_t index, size_t size) { return index >= 0 && (size_t)index < size; }

static int element_inside(int n_vectors, const int *sizes, int32_t vector, int32_t element)
{
    return inside(vector, (size_t)n_vectors) && inside(element, (size_t)sizes[vector]);
}

static int instruction_valid(const LagFunction *f, const int32_t *instruction)
{
    const int32_t op = instruction[0], out = instruction[1], a = instruction[2], b = instruction[3];
    switch (op) {
    case LAG_OP_INPUT: return inside(out, f->n_work) && element_inside(f->n_in, f->in_size, a, b);
    case LAG_OP_OUTPUT: return inside(a, f->n_work) && element_inside(f->n_out, f->out_size, out, b);
    case LAG_OP_CONST: return inside(out, f->n_work) && inside(a, (size_t)f->tape->n_constants);
    case LAG_OP_SIN:
    case LAG_OP_COS: return inside(out, f->n_work) && inside(a, f->n_work);
    default: return inside(op, LAG_OP_COUNT) && inside(out, f->n_work) && inside(a, f->n_work) && inside(b, f->n_work);
    }
}

static int is_sine(const int32_t *instruction) { return instruction[0] == LAG_OP_SIN || instruction[0] == LAG_OP_COS; }

/* Whether there are as many sines and cosines more as a sine or cosine says. */
static int runs_on(const LagTape *tape, int32_t i)
{
    const int32_t *instruction = tape->code + FIELDS * i, *next = instruction + FIELDS;
    if (!is_sine(instruction) || instruction[3] == 0 || instruction[3] == 1)
        return 1;
    return i + 1 < tape->n_instructions && is_sine(next) && next[3] == instruction[3] - 1;
}

int lag_tape_valid(const LagFunction *function)
{
    const LagTape *tape = function->tape;
    for (int32_t i = 0; i < tape->n_instructions; ++i)
        if (!instruction_valid(function, tape->code + FIELDS * i) || !runs_on(tape, i))
            return 0;
    return 1;
}

static double sign(double x) { return x < 0 ? -1 : x > 0 ? 1 : x; }

static double uncommon(int32_t op, double x, double y)
{
    switch (op) {
    case LAG_OP_SQRT: return sqrt(x);
    case LAG_OP_IF_ELSE_ZERO: return x != 0 ? y : 0;
    case LAG_OP_TAN: return tan(x);
    case LAG_OP_ASIN: return asin(x);
    case LAG_OP_ACOS: return acos(x);
    case LAG_OP_ATAN: return atan(x);
    case LAG_OP_ATAN2: return atan2(x, y);
    case LAG_OP_EXP: return exp(x);
    case LAG_OP_LOG: return log(x);
    case LAG_OP_POW:
    case LAG_OP_CONSTPOW: return pow(x, y);
    case LAG_OP_FABS: return fabs(x);
    case LAG_OP_SIGN: return sign(x);
    case LAG_OP_FMIN: return fmin(x, y);
    case LAG_OP_FMAX: return fmax(x, y);
    case LAG_OP_FLOOR: return floor(x);
    case LAG_OP_CEIL: return ceil(x);
    case LAG_OP_FMOD: return fmod(x, y);
    case LAG_OP_COPYSIGN: return copysign(x, y);
    case LAG_OP_LT: return x < y;
    case LAG_OP_LE: return x <= y;
    case LAG_OP_EQ: return x == y;
    case LAG_OP_NE: return x != y;
    case LAG_OP_NOT: return x == 0;
    case LAG_OP_AND: return x != 0 && y != 0;
    case LAG_OP_OR: return x != 0 || y != 0;
    case LAG_OP_SINH: return sinh(x);
    case LAG_OP_COSH: return cosh(x);
    case LAG_OP_TANH: return tanh(x);
    case LAG_OP_ASINH: return asinh(x);
    case LAG_OP_ACOSH: return acosh(x);
    case LAG_OP_ATANH: return atanh(x);
    case LAG_OP_ERF: return erf(x);
    default: return NAN;
    }
}

/* Apart: as part of the loop below it is a quarter of the time faster. */
double lag_tape_uncommon(int32_t op, double x, double y) { return uncommon(op, x, y); }

/* The sine or cosine, and as many of the next ones as are computed with it; how many these are. */
static int32_t run_sines(const int32_t *first, double *work)
{
    double angle[LAG_MOST_SINES], sine[LAG_MOST_SINES], cosine[LAG_MOST_SINES];
    const int32_t count = first[3] < LAG_MOST_SINES ? first[3] : LAG_MOST_SINES, *end = first + FIELDS * count;
    int n = 0;
    if (count == 0) {
        work[first[1]] = first[0] == LAG_OP_SIN ? sin(work[first[2]]) : cos(work[first[2]]);
        return 0;
    }
    for (const int32_t *i = first; i < end; i += FIELDS)
        if (i == first || i[2] != i[2 - FIELDS])
            angle[n++] = work[i[2]];
    for (int i = n; i % 4; ++i)
        angle[i] = 0;
    for (int i = 0; i < n; i += 4)
        lag_four_sines(angle[i], angle[i + 1], angle[i + 2], angle[i + 3], sine + i, cosine + i);
    int k = -1;
    for (const int32_t *i = first; i < end; i += FIELDS) {
        k += i == first || i[2] != i[2 - FIELDS];
        work[i[1]] = i[0] == LAG_OP_SIN ? sine[k] : cosine[k];
    }
    return count - 1;
}

void lag_tape_run(const LagTape *tape, const double *const *in, double *const *out, double *work)
{
    const int32_t *end = tape->code + FIELDS * tape->n_instructions;
    for (const int32_t *i = tape->code; i < end; i += FIELDS) {
        const int32_t o = i[1], a = i[2], b = i[3];
        switch (i[0]) {
        case LAG_OP_INPUT: work[o] = in[a][b]; break;
        case LAG_OP_OUTPUT: out[o][b] = work[a]; break;
        case LAG_OP_CONST: work[o] = tape->constants[a]; break;
        case LAG_OP_ASSIGN: work[o] = work[a]; break;
        case LAG_OP_ADD: work[o] = work[a] + work[b]; break;
        case LAG_OP_SUB: work[o] = work[a] - work[b]; break;
        case LAG_OP_MUL: work[o] = work[a] * work[b]; break;
        case LAG_OP_DIV: work[o] = work[a] / work[b]; break;
        case LAG_OP_NEG: work[o] = -work[a]; break;
        case LAG_OP_SQ: work[o] = work[a] * work[a]; break;
        case LAG_OP_TWICE: work[o] = 2 * work[a]; break;
        case LAG_OP_INV: work[o] = 1 / work[a]; break;
        case LAG_OP_SQRT: work[o] = sqrt(work[a]); break;
        case LAG_OP_SIN:
        case LAG_OP_COS: i += FIELDS * run_sines(i, work); break;
        case LAG_OP_IF_ELSE_ZERO: work[o] = work[a] != 0 ? work[b] : 0; break;
        default: work[o] = uncommon(i[0], work[a], work[b]); break;
        }
    }
}
