/* The interpreter of jets: one switch for the coefficients of order 0, one for the others. What takes the time, sums of products,
 * is compiled for each order, as in the code of scenes. */
#include "model/jet_tape.h"

#include <math.h>
#include <string.h>

#include "model/attitude_places.h"
#include "model/tape.h"
#include "numbers/jets.h"
#include "numbers/sines.h"

typedef struct {
    double (*product)(const double *a, const double *b);
    double (*inner)(const double *a, const double *b);
    double (*square)(const double *a);
    double (*between)(const double *w);
} Sums;

#define ALL_ORDERS(EACH) \
    EACH(1) EACH(2) EACH(3) EACH(4) EACH(5) EACH(6) EACH(7) EACH(8) EACH(9) EACH(10) EACH(11) EACH(12) EACH(13) EACH(14) EACH(15) \
    EACH(16) EACH(17)
#define DEFINE(k)                                                                                          \
    static double product_##k(const double *a, const double *b) { return lag_jet_product(a, b, k); }        \
    static double inner_##k(const double *a, const double *b) { return lag_jet_inner(a, b, k); }            \
    static double square_##k(const double *a) { return lag_jet_square(a, k); }                              \
    static double between_##k(const double *w) { return lag_jet_between(w, k); }
#define LIST(k) {product_##k, inner_##k, square_##k, between_##k},

ALL_ORDERS(DEFINE)

static const Sums SUMS[LAG_JET_ORDER] = {{NULL, NULL, NULL, NULL}, ALL_ORDERS(LIST)};

/* Where coefficients lie: those of one order are `stride` apart from slot to slot. */
typedef struct {
    double *now; /* of the present order */
    double *jets; /* of order 0, where jets lie one after another */
    size_t stride;
    const double *numbers;
} Place;

size_t lag_jet_room(const LagModel *model)
{
    if (model->jet_pitch > 1)
        return (size_t)model->jet_pitch;
    return (size_t)(model->jet_code ? model->n_jet_slots : model->n_jets + 4 * model->n_attitudes);
}

size_t lag_jet_scratch(const LagModel *model)
{
    const size_t angles = 2 * (size_t)((model->n_angles + 3) / 4 * 4);
    return angles + (model->jet_pitch > 1 ? (size_t)model->n_jet_slots : 0);
}

static double value_of(int op, double x) { return op == LAG_OP_SIN ? sin(x) : op == LAG_OP_COS ? cos(x) : lag_tape_uncommon(op, x, 0); }

/* Sines and cosines of all angles, four at a time. */
static void all_sines(const LagModel *model, const Place *p, double *sine, double *cosine)
{
    const int size = (model->n_angles + 3) / 4 * 4;
    if (size == 0)
        return;
    memset(cosine, 0, (size_t)size * sizeof *cosine); /* the angles, at first */
    const int *end = model->jet_code + LAG_JET_FIELDS * model->n_jet_instructions;
    for (const int *i = model->jet_code; i < end; i += LAG_JET_FIELDS)
        if (i[0] == LAG_JET_SINE)
            cosine[i[5]] = p->now[(size_t)i[2] * p->stride];
    for (int k = 0; k < size; k += 4) {
        const double a = cosine[k], b = cosine[k + 1], c = cosine[k + 2], d = cosine[k + 3];
        lag_four_sines(a, b, c, d, sine + k, cosine + k);
    }
}

#define X(field) x[(size_t)i[field] * stride]
#define N(field) p->numbers[i[field]]

static void run_first(const LagModel *model, const Place *p, const double *sine, const double *cosine)
{
    double *const x = p->now;
    const size_t stride = p->stride;
    const int *end = model->jet_code + LAG_JET_FIELDS * model->n_jet_instructions;
    for (const int *i = model->jet_code; i < end; i += LAG_JET_FIELDS) {
        double *w = &X(1);
        switch (i[0]) {
        case LAG_JET_NUMBER: *w = N(2); break;
        case LAG_JET_DERIVATIVE: *w = 0; break;
        case LAG_JET_NEG: *w = -X(2); break;
        case LAG_JET_TWICE: *w = 2 * X(2); break;
        case LAG_JET_ADD: *w = X(2) + X(3); break; case LAG_JET_SUB: *w = X(2) - X(3); break;
        case LAG_JET_ADD_NUMBER: *w = X(2) + N(3); break;
        case LAG_JET_SUB_NUMBER: *w = X(2) - N(3); break;
        case LAG_JET_NUMBER_SUB: *w = N(2) - X(3); break;
        case LAG_JET_SCALE: *w = N(2) * X(3); break;
        case LAG_JET_OVER_NUMBER: *w = X(2) / N(3); break;
        case LAG_JET_IF: *w = N(2) != 0 ? X(3) : 0; break;
        case LAG_JET_FIRST_AND: *w = X(2) * X(3) + X(4); break;
        case LAG_JET_OVER_REST: *w = X(2) / (N(4) - N(5) * (X(3) * X(3))); break;
        case LAG_JET_SCALE_AND: *w = N(2) * X(3) + X(4); break;
        case LAG_JET_SCALE_FROM: *w = X(4) - N(2) * X(3); break; case LAG_JET_SCALE_LESS: *w = N(2) * X(3) - X(4); break;
        case LAG_JET_PRODUCT: *w = X(2) * X(3); break;
        case LAG_JET_SQUARE: *w = X(2) * X(2); break;
        case LAG_JET_QUOTIENT: *w = X(2) / X(3); break;
        case LAG_JET_NUMBER_OVER: *w = N(2) / X(3); break;
        case LAG_JET_SQRT: *w = sqrt(X(2)); break;
        case LAG_JET_POWER: *w = pow(X(2), N(3)); break;
        case LAG_JET_INTEGRAL: case LAG_JET_MINUS_INTEGRAL: *w = value_of(i[5], X(2)); break;
        case LAG_JET_SINE: *w = sine[i[5]]; break;
        case LAG_JET_COSINE: *w = cosine[i[5]]; break;
        case LAG_JET_ANGLE: *w = atan2(X(2), X(3)); break;
        case LAG_JET_PRODUCT_AND: *w = X(2) * X(3) + X(4); break;
        case LAG_JET_PRODUCT_FROM: *w = X(4) - X(2) * X(3); break;
        case LAG_JET_LOWER: *w = 0; break;
        default: *w = NAN; break;
        }
    }
}

#define JET(field) (p->jets + (size_t)i[field] * LAG_JET_STRIDE)

static void run_later(const LagModel *model, const Place *p, int k)
{
    const Sums *sums = &SUMS[k];
    double *const x = p->now;
    const size_t stride = p->stride;
    const double share = 1.0 / k;
    const int *end = model->jet_code + LAG_JET_FIELDS * model->n_jet_instructions;
    for (const int *i = model->jet_code; i < end; i += LAG_JET_FIELDS) {
        double *w = &X(1);
        switch (i[0]) {
        case LAG_JET_NUMBER: *w = 0; break;
        case LAG_JET_DERIVATIVE: *w = k * X(2); break;
        case LAG_JET_NEG: *w = -X(2); break;
        case LAG_JET_TWICE: *w = 2 * X(2); break;
        case LAG_JET_ADD: *w = X(2) + X(3); break; case LAG_JET_SUB: *w = X(2) - X(3); break;
        case LAG_JET_ADD_NUMBER: case LAG_JET_SUB_NUMBER: *w = X(2); break;
        case LAG_JET_NUMBER_SUB: *w = -X(3); break;
        case LAG_JET_SCALE: *w = N(2) * X(3); break;
        case LAG_JET_OVER_NUMBER: *w = X(2) / N(3); break;
        case LAG_JET_IF: *w = N(2) != 0 ? X(3) : 0; break;
        case LAG_JET_FIRST_AND: *w = *JET(2) * X(3) + X(4); break;
        case LAG_JET_OVER_REST: *w = X(2) * (1 / (N(4) - N(5) * (*JET(3) * *JET(3)))); break;
        case LAG_JET_SCALE_AND: *w = N(2) * X(3) + X(4); break;
        case LAG_JET_SCALE_FROM: *w = X(4) - N(2) * X(3); break; case LAG_JET_SCALE_LESS: *w = N(2) * X(3) - X(4); break;
        case LAG_JET_PRODUCT: *w = sums->product(JET(2), JET(3)); break;
        case LAG_JET_SQUARE: *w = sums->square(JET(2)); break;
        case LAG_JET_QUOTIENT: *w = (X(2) - sums->inner(JET(3), JET(1))) * (1 / *JET(3)); break;
        case LAG_JET_NUMBER_OVER: *w = sums->inner(JET(3), JET(1)) * (-1 / *JET(3)); break;
        case LAG_JET_SQRT: *w = (X(2) - sums->between(JET(1))) * (0.5 / *JET(1)); break;
        case LAG_JET_POWER: *w = lag_jet_power(JET(2), JET(1), N(3), k); break;
        case LAG_JET_INTEGRAL: case LAG_JET_SINE: *w = sums->inner(JET(3), JET(4)) * share; break;
        case LAG_JET_MINUS_INTEGRAL: case LAG_JET_COSINE: *w = sums->inner(JET(3), JET(4)) * -share; break;
        case LAG_JET_ANGLE: *w = (sums->inner(JET(4), JET(6)) - sums->inner(JET(5), JET(7))) * share; break;
        case LAG_JET_PRODUCT_AND: *w = sums->product(JET(2), JET(3)) + X(4); break;
        case LAG_JET_PRODUCT_FROM: *w = X(4) - sums->product(JET(2), JET(3)); break;
        case LAG_JET_LOWER: *w = sums->inner(JET(2), JET(3)); break;
        default: *w = NAN; break;
        }
    }
}

/* The coefficients of q and v of the next order. */
static void next_state(const LagModel *model, const Place *p, int k, double *jets)
{
    const int n = model->n;
    const double share = 1.0 / (k + 1);
    const size_t pitch = (size_t)model->jet_pitch, stride = pitch > 1 ? 1 : LAG_JET_STRIDE;
    double *const next = jets + (size_t)(k + 1) * pitch + stride; /* time comes first */
    const double *v = jets + (size_t)k * pitch + (size_t)(1 + n) * stride;
    for (int i = 0; i < n; ++i)
        next[(size_t)i * stride] = v[(size_t)i * stride] * share;
    for (int i = 0; i < n; ++i)
        next[(size_t)(n + i) * stride] = p->now[(size_t)model->jet_rates[i] * p->stride] * share;
    for (int i = 0; i < model->n_attitudes; ++i)
        lag_jet_turn(jets + (size_t)(1 + 2 * n + model->n_inputs + 4 * i) * LAG_JET_STRIDE,
                     jets + (size_t)(model->n_jets + 4 * i) * LAG_JET_STRIDE,
                     jets + (size_t)(1 + n + lag_attitude_place(model->attitudes, i)) * LAG_JET_STRIDE, k);
}

void lag_jet_tape_run(const LagModel *model, int first, int end, const double *numbers, double *jets, double *scratch)
{
    const int is_row = model->jet_pitch > 1, size = (model->n_angles + 3) / 4 * 4;
    const size_t known = (size_t)(1 + 2 * model->n + model->n_inputs + 4 * model->n_attitudes);
    double *const sine = scratch, *const cosine = scratch + size, *const line = scratch + 2 * size;
    for (int k = first; k < end; ++k) {
        double *const row = jets + (size_t)k * (size_t)model->jet_pitch;
        const Place p = {is_row ? line : row, jets, is_row ? 1 : LAG_JET_STRIDE, numbers};
        if (is_row)
            memcpy(line, row, known * sizeof *line);
        if (k == 0) {
            all_sines(model, &p, sine, cosine);
            run_first(model, &p, sine, cosine);
        } else {
            run_later(model, &p, k);
        }
        if (is_row)
            memcpy(row + known, line + known, ((size_t)model->n_jets - known) * sizeof *line);
        next_state(model, &p, k, jets);
    }
}
