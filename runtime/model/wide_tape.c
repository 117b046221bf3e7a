/* Two ways to spend the time of a tape's instruction are to find out which one it is and to carry it out: here the first serves eight
 * states. In registers of eight numbers an instruction takes hardly longer than that of a single state. */
#include "model/wide_tape.h"

#include "numbers/wide.h"

enum { FIELDS = 4, SHARED = 4 }; /* inputs from there on may be those of all states */

static double *slot(double *work, int32_t number) { return work + (size_t)number * LAG_ABREAST; }

#define EACH(result)                                                     \
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {           \
        const LagWide x = lag_wide_read(a + lane);                       \
        lag_wide_write(o + lane, result);                                \
    }

#define EACH_OF_TWO(result)                                              \
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {           \
        const LagWide x = lag_wide_read(a + lane), y = lag_wide_read(b + lane); \
        lag_wide_write(o + lane, result);                                \
    }

static void fill(double *o, double value)
{
    for (int i = 0; i < LAG_ABREAST; ++i)
        o[i] = value;
}

/* Of one angle in eight states. */
static void sines(const double *angle, double *sine, double *cosine)
{
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const LagWide x = lag_wide_read(angle + lane);
        LagWide s, c;
        lag_sines_of_wide(&x, &s, &c);
        lag_wide_write(sine + lane, s);
        lag_wide_write(cosine + lane, c);
    }
    for (int i = 0; i < LAG_ABREAST; ++i)
        if (!(fabs(angle[i]) <= LAG_LARGEST_ANGLE)) {
            sine[i] = sin(angle[i]);
            cosine[i] = cos(angle[i]);
        }
}

/* The sine or cosine, and the next one where it is of the same angle and computed with it; how many more that are. */
static int32_t run_sines(const int32_t *first, int are_all, double *work)
{
    const int32_t *next = first + FIELDS;
    const double *a = slot(work, first[2]);
    double sine[LAG_ABREAST], cosine[LAG_ABREAST];
    if (first[3] == 0 && !are_all) {
        double *o = slot(work, first[1]);
        for (int i = 0; i < LAG_ABREAST; ++i)
            o[i] = first[0] == LAG_OP_SIN ? sin(a[i]) : cos(a[i]);
        return 0;
    }
    const int is_pair = first[3] > 1 && next[2] == first[2];
    sines(a, sine, cosine);
    memcpy(slot(work, first[1]), first[0] == LAG_OP_SIN ? sine : cosine, sizeof sine);
    if (is_pair)
        memcpy(slot(work, next[1]), next[0] == LAG_OP_SIN ? sine : cosine, sizeof sine);
    return is_pair;
}

static void run_uncommon(int32_t op, const double *a, const double *b, double *o)
{
    for (int i = 0; i < LAG_ABREAST; ++i)
        o[i] = lag_tape_uncommon(op, a[i], b[i]);
}

void lag_wide_tape_run(const LagTape *tape, const double *const *in, int holds, double *const *out, double *work)
{
    const int32_t *end = tape->code + FIELDS * tape->n_instructions;
    for (const int32_t *i = tape->code; i < end; i += FIELDS) {
        double *o = slot(work, i[0] == LAG_OP_OUTPUT ? 0 : i[1]);
        const double *a = slot(work, i[2]), *b = slot(work, i[3]);
        switch (i[0]) {
        case LAG_OP_INPUT:
            if ((holds & LAG_TAPE_SHARED) && i[2] >= SHARED)
                fill(o, in[i[2]][i[3]]);
            else
                memcpy(o, in[i[2]] + (size_t)i[3] * LAG_ABREAST, LAG_ABREAST * sizeof *o);
            break;
        case LAG_OP_OUTPUT: memcpy(out[i[1]] + (size_t)i[3] * LAG_ABREAST, a, LAG_ABREAST * sizeof *a); break;
        case LAG_OP_CONST: fill(o, tape->constants[i[2]]); break;
        case LAG_OP_ASSIGN: EACH(x) break;
        case LAG_OP_ADD: EACH_OF_TWO(x + y) break;
        case LAG_OP_SUB: EACH_OF_TWO(x - y) break;
        case LAG_OP_MUL: EACH_OF_TWO(x * y) break;
        case LAG_OP_DIV: EACH_OF_TWO(x / y) break;
        case LAG_OP_NEG: EACH(-x) break;
        case LAG_OP_SQ: EACH(x * x) break;
        case LAG_OP_TWICE: EACH(LAG_WIDE_OF(2.0) * x) break;
        case LAG_OP_INV: EACH(LAG_WIDE_OF(1.0) / x) break;
        case LAG_OP_SIN:
        case LAG_OP_COS: i += FIELDS * run_sines(i, holds & LAG_TAPE_ALL_SINES, work); break;
        default: run_uncommon(i[0], a, b, o); break;
        }
    }
}
