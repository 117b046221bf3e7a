/* Taylor coefficients of the motion by instructions, for scenes that no C compiler has seen: the operations of `taylor`
 * (model.h) in the same order, and so its digits.
 *
 * LAG_JET_FIELDS numbers an instruction: {op, out, operands}. `out` and most operands are slots of jets; numbers are places
 * among those that the function `series` computes, a function is a LagOp, an angle one of n_angles. Slots from n_jets on are
 * jets of which only the present coefficient is asked for.
 */
#ifndef LAG_JET_TAPE_H
#define LAG_JET_TAPE_H

#include "model/model.h"

typedef enum {
    LAG_JET_NUMBER, LAG_JET_DERIVATIVE, LAG_JET_NEG, LAG_JET_TWICE, LAG_JET_ADD, LAG_JET_SUB,
    LAG_JET_ADD_NUMBER, LAG_JET_SUB_NUMBER, LAG_JET_NUMBER_SUB, LAG_JET_SCALE, LAG_JET_OVER_NUMBER, LAG_JET_IF,
    LAG_JET_FIRST_AND, /* a, b, c: a_0 b + c */
    LAG_JET_OVER_REST, /* a, c, n, m: a/(n - m c_0^2) */
    LAG_JET_SCALE_AND, LAG_JET_SCALE_FROM, LAG_JET_SCALE_LESS, /* n, b, c: n b + c, c - n b, and n b - c */
    /* from here on there are sums of products */
    LAG_JET_PRODUCT, LAG_JET_SQUARE, LAG_JET_QUOTIENT, LAG_JET_NUMBER_OVER, LAG_JET_SQRT, LAG_JET_POWER,
    LAG_JET_INTEGRAL, LAG_JET_MINUS_INTEGRAL, /* u, du/dt, slope, function: w' = slope u' or its negative */
    LAG_JET_SINE, LAG_JET_COSINE,             /* u, du/dt, slope, angle: likewise */
    LAG_JET_ANGLE,                            /* a, b, da/dt, db/dt, b/(a^2 + b^2), a/(a^2 + b^2): atan2(a, b) */
    LAG_JET_PRODUCT_AND, LAG_JET_PRODUCT_FROM, /* a, b, c: a b + c, and c - a b */
    LAG_JET_LOWER,                             /* a, b: what the lower coefficients of b add to a b */
    LAG_JET_COUNT
} LagJetOp;

enum { LAG_JET_FIELDS = 8 };

/* Jets that a run has room for; numbers of scratch, besides those of the function `series`. */
size_t lag_jet_room(const LagModel *model);
size_t lag_jet_scratch(const LagModel *model);

/* As LagJets; `numbers` are what `series` computed. */
void lag_jet_tape_run(const LagModel *model, int first, int end, const double *numbers, double *jets, double *scratch);

#endif
