#include "model/wide_jet_tape.h"

#include <math.h>
#include <string.h>

#include "model/attitude_places.h"
#include "model/tape.h"
#include "numbers/wide_jets.h"

enum { AT_ONCE = 4 }; /* sums in one loop: their addresses stay in registers */

static int known(const LagModel *model) { return 1 + 2 * model->n + model->n_inputs + 4 * model->n_attitudes; }

static const int *code_end(const LagModel *model) { return model->jet_code + LAG_JET_FIELDS * model->n_jet_instructions; }

/* The jets whose products an instruction sums, two a sum; returns how many sums. */
static int sums_of(const int *i, int *pairs)
{
    switch (i[0]) {
    case LAG_JET_PRODUCT: case LAG_JET_PRODUCT_AND: case LAG_JET_PRODUCT_FROM: case LAG_JET_LOWER:
        pairs[0] = i[2], pairs[1] = i[3];
        return 1;
    case LAG_JET_SQUARE: pairs[0] = pairs[1] = i[2]; return 1;
    case LAG_JET_QUOTIENT:
    case LAG_JET_NUMBER_OVER: pairs[0] = i[3], pairs[1] = i[1]; return 1;
    case LAG_JET_SQRT: pairs[0] = pairs[1] = i[1]; return 1;
    case LAG_JET_INTEGRAL: case LAG_JET_MINUS_INTEGRAL: case LAG_JET_SINE: case LAG_JET_COSINE:
        pairs[0] = i[3], pairs[1] = i[4];
        return 1;
    case LAG_JET_ANGLE: pairs[0] = i[4], pairs[1] = i[6], pairs[2] = i[5], pairs[3] = i[7]; return 2;
    default: return 0;
    }
}

void lag_wide_series_layout(LagWideSeries *s, const LagModel *model, LagArena *arena)
{
    const int slots = model->n_jet_slots > model->n_jets ? model->n_jet_slots : model->n_jets;
    int pairs[4];
    s->model = model;
    s->n_sums = 0;
    for (const int *i = model->jet_code; i < code_end(model); i += LAG_JET_FIELDS)
        s->n_sums += sums_of(i, pairs);
    s->between = lag_take(arena, (size_t)s->n_sums * LAG_ABREAST);
    s->numbers = lag_take(arena, (size_t)model->series.out_size[0] * LAG_ABREAST);
    s->jets = lag_take(arena, (size_t)model->n_jets * LAG_WIDE_JET);
    s->line = lag_take(arena, (size_t)slots * LAG_ABREAST);
    s->sums = lag_take_ints(arena, 2 * ((size_t)s->n_sums + LAG_ABREAST) / LAG_ABREAST * LAG_ABREAST); /* whole lines of the cache */
    if (!s->sums)
        return;
    int *place = s->sums;
    for (const int *i = model->jet_code; i < code_end(model); i += LAG_JET_FIELDS)
        place += 2 * sums_of(i, place);
}

static void values_of(int op, const double *x, double *w)
{
    if (op == LAG_OP_SIN)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
            lag_wide_write(w + lane, lag_wide_sine(lag_wide_read(x + lane)));
    else if (op == LAG_OP_COS)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
            lag_wide_write(w + lane, lag_wide_cosine(lag_wide_read(x + lane)));
    else
        for (int i = 0; i < LAG_ABREAST; ++i)
            w[i] = lag_tape_uncommon(op, x[i], 0);
}

#define X(field) lag_wide_read(line + (size_t)i[field] * LAG_ABREAST + lane)
#define N(field) lag_wide_read(numbers + (size_t)i[field] * LAG_ABREAST + lane)
#define EACH(result)                                             \
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)      \
        lag_wide_write(w + lane, result);                        \
    break
#define EACH_ALONE(result)                                       \
    for (int k = 0; k < LAG_ABREAST; ++k)                         \
        w[k] = result;                                           \
    break

static void run_first(LagWideSeries *s)
{
    const LagWide zero = LAG_WIDE_OF(0), two = LAG_WIDE_OF(2);
    const double *numbers = s->numbers;
    double *const line = s->line;
    for (const int *i = s->model->jet_code; i < code_end(s->model); i += LAG_JET_FIELDS) {
        double *w = line + (size_t)i[1] * LAG_ABREAST;
        const double *x = line + (size_t)i[2] * LAG_ABREAST;
        switch (i[0]) {
        case LAG_JET_NUMBER: EACH(N(2));
        case LAG_JET_DERIVATIVE: EACH(zero);
        case LAG_JET_NEG: EACH(-X(2)); case LAG_JET_TWICE: EACH(two * X(2));
        case LAG_JET_ADD: EACH(X(2) + X(3)); case LAG_JET_SUB: EACH(X(2) - X(3));
        case LAG_JET_ADD_NUMBER: EACH(X(2) + N(3));
        case LAG_JET_SUB_NUMBER: EACH(X(2) - N(3));
        case LAG_JET_NUMBER_SUB: EACH(N(2) - X(3));
        case LAG_JET_SCALE: EACH(N(2) * X(3));
        case LAG_JET_OVER_NUMBER: EACH(X(2) / N(3));
        case LAG_JET_IF: EACH(LAG_WIDE_SELECT(N(2) != zero, X(3), zero));
        case LAG_JET_FIRST_AND: EACH(X(2) * X(3) + X(4));
        case LAG_JET_OVER_REST: EACH(X(2) / (N(4) - N(5) * (X(3) * X(3))));
        case LAG_JET_SCALE_AND: EACH(N(2) * X(3) + X(4));
        case LAG_JET_SCALE_FROM: EACH(X(4) - N(2) * X(3)); case LAG_JET_SCALE_LESS: EACH(N(2) * X(3) - X(4));
        case LAG_JET_PRODUCT: EACH(X(2) * X(3));
        case LAG_JET_SQUARE: EACH(X(2) * X(2));
        case LAG_JET_QUOTIENT: EACH(X(2) / X(3));
        case LAG_JET_NUMBER_OVER: EACH(N(2) / X(3));
        case LAG_JET_SQRT: EACH_ALONE(sqrt(x[k]));
        case LAG_JET_POWER: EACH_ALONE(pow(x[k], numbers[i[3] * LAG_ABREAST + k]));
        case LAG_JET_INTEGRAL: case LAG_JET_MINUS_INTEGRAL: values_of(i[5], x, w); break;
        case LAG_JET_SINE: values_of(LAG_OP_SIN, x, w); break;
        case LAG_JET_COSINE: values_of(LAG_OP_COS, x, w); break;
        case LAG_JET_PRODUCT_AND: EACH(X(2) * X(3) + X(4));
        case LAG_JET_PRODUCT_FROM: EACH(X(4) - X(2) * X(3));
        case LAG_JET_LOWER: EACH(zero);
        case LAG_JET_ANGLE: EACH_ALONE(atan2(x[k], line[i[3] * LAG_ABREAST + k]));
        default: EACH(LAG_WIDE_OF((double)NAN));
        }
    }
}

/* What lies between the ends of as many sums as one loop serves. */
LAG_UNROLLED void sum(const double *jets, const int *sums, int count, int k, double *between)
{
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const double *a[AT_ONCE], *b[AT_ONCE];
        LagWide total[AT_ONCE];
        LAG_UNROLL_ALL
        for (int m = 0; m < count; ++m) {
            a[m] = jets + (size_t)sums[2 * m] * LAG_WIDE_JET + lane;
            b[m] = jets + (size_t)sums[2 * m + 1] * LAG_WIDE_JET + lane;
            total[m] = LAG_WIDE_OF(0);
        }
        for (int j = 2; j < k - 1; ++j)
            LAG_UNROLL_ALL
            for (int m = 0; m < count; ++m)
                total[m] = LAG_WIDE_FUSED(LAG_WIDE_TERM(a[m], j), LAG_WIDE_TERM(b[m], k - j), total[m]);
        LAG_UNROLL_ALL
        for (int m = 0; m < count; ++m)
            lag_wide_write(between + m * LAG_ABREAST + lane, lag_wide_ends(total[m], a[m], b[m], k));
    }
}

/* The same of a square: its half. */
static void half_sum(const double *jets, int slot, int k, double *between)
{
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const double *a = jets + (size_t)slot * LAG_WIDE_JET + lane;
        LagWide half = LAG_WIDE_OF(0);
        for (int j = 2; 2 * j < k; ++j)
            half = LAG_WIDE_FUSED(LAG_WIDE_TERM(a, j), LAG_WIDE_TERM(a, k - j), half);
        lag_wide_write(between + lane, lag_wide_half_ends(half, a, k));
    }
}

/* How many sums, AT_ONCE at most, are none of squares. */
static int count_apart(const int *sums, int most)
{
    int count = 0;
    while (count < most && sums[2 * count] != sums[2 * count + 1])
        ++count;
    return count;
}

static void sum_all(LagWideSeries *s, int k)
{
    for (int m = 0, taken; m < s->n_sums; m += taken) {
        const int *sums = s->sums + 2 * m, left = s->n_sums - m, apart = count_apart(sums, left < AT_ONCE ? left : AT_ONCE);
        double *between = s->between + m * LAG_ABREAST;
        taken = apart == AT_ONCE ? AT_ONCE : apart > 1 ? 2 : 1;
        switch (apart) {
        case 0: half_sum(s->jets, sums[0], k, between); break;
        case 1: sum(s->jets, sums, 1, k, between); break;
        case AT_ONCE: sum(s->jets, sums, AT_ONCE, k, between); break;
        default: sum(s->jets, sums, 2, k, between); break;
        }
    }
}

#undef EACH
#define JET(field) (jets + (size_t)i[field] * LAG_WIDE_JET + lane)
#define FIRST(field) lag_wide_read(JET(field))
#define BETWEEN(number) lag_wide_read(between + (number) * LAG_ABREAST + lane)
#define PRODUCT(a, b) LAG_WIDE_PRODUCT(BETWEEN(0), FIRST(a), X(a), FIRST(b), X(b))
#define PRODUCT_AND(a, b, c) LAG_WIDE_PRODUCT(BETWEEN(0) + X(c), FIRST(a), X(a), FIRST(b), X(b))
#define PRODUCT_FROM(a, b, c) LAG_WIDE_PRODUCT(X(c) - BETWEEN(0), -FIRST(a), -X(a), FIRST(b), X(b))
#define INVERSE(a) (one / FIRST(a))
#define OVER_FIRST(w, b) LAG_WIDE_FUSED(X(b), -FIRST(w) * INVERSE(b), -(BETWEEN(0) * INVERSE(b)))
#define INNER(number, a, b) LAG_WIDE_INNER(BETWEEN(number), X(a), FIRST(b))
/* The result goes into the line, and among the jets where lower orders are asked for again. */
#define EACH(result)                                                 \
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {        \
        const LagWide next = result;                                 \
        lag_wide_write(w + lane, next);                              \
        lag_wide_write(kept + lane, next);                           \
    }                                                                \
    break

static void run_order(LagWideSeries *s, int k)
{
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1), two = LAG_WIDE_OF(2), half = LAG_WIDE_OF(0.5);
    const LagWide order = LAG_WIDE_OF((double)k), share = LAG_WIDE_OF(1.0 / k);
    const double *numbers = s->numbers, *between = s->between;
    double *const line = s->line, *const jets = s->jets;
    for (const int *i = s->model->jet_code; i < code_end(s->model); i += LAG_JET_FIELDS) {
        double *w = line + (size_t)i[1] * LAG_ABREAST;
        double *kept = i[1] < s->model->n_jets ? jets + (size_t)i[1] * LAG_WIDE_JET + (size_t)k * LAG_ABREAST : w;
        switch (i[0]) {
        case LAG_JET_NUMBER: EACH(zero);
        case LAG_JET_DERIVATIVE: EACH(order * X(2));
        case LAG_JET_NEG: EACH(-X(2)); case LAG_JET_TWICE: EACH(two * X(2));
        case LAG_JET_ADD: EACH(X(2) + X(3)); case LAG_JET_SUB: EACH(X(2) - X(3));
        case LAG_JET_ADD_NUMBER: case LAG_JET_SUB_NUMBER: EACH(X(2));
        case LAG_JET_NUMBER_SUB: EACH(-X(3));
        case LAG_JET_SCALE: EACH(N(2) * X(3));
        case LAG_JET_OVER_NUMBER: EACH(X(2) / N(3));
        case LAG_JET_IF: EACH(LAG_WIDE_SELECT(N(2) != zero, X(3), zero));
        case LAG_JET_FIRST_AND: EACH(LAG_WIDE_FUSED(FIRST(2), X(3), X(4)));
        case LAG_JET_OVER_REST: EACH(X(2) * (one / (N(4) - N(5) * (FIRST(3) * FIRST(3)))));
        case LAG_JET_SCALE_AND: EACH(LAG_WIDE_FUSED(N(2), X(3), X(4)));
        case LAG_JET_SCALE_FROM: EACH(LAG_WIDE_FUSED(-N(2), X(3), X(4))); case LAG_JET_SCALE_LESS: EACH(LAG_WIDE_FUSED(N(2), X(3), -X(4)));
        case LAG_JET_PRODUCT: EACH(PRODUCT(2, 3));
        case LAG_JET_SQUARE: EACH(lag_wide_square(BETWEEN(0), JET(2), X(2), k));
        case LAG_JET_QUOTIENT: EACH(LAG_WIDE_FUSED(X(2), INVERSE(3), OVER_FIRST(1, 3)));
        case LAG_JET_NUMBER_OVER: EACH(OVER_FIRST(1, 3));
        case LAG_JET_SQRT: EACH(LAG_WIDE_FUSED(X(2), half * INVERSE(1), -(lag_wide_half(BETWEEN(0), JET(1), k) * INVERSE(1))));
        case LAG_JET_POWER: EACH(lag_wide_power(JET(2), JET(1), N(3), k));
        case LAG_JET_INTEGRAL: case LAG_JET_SINE: EACH(INNER(0, 3, 4) * share);
        case LAG_JET_MINUS_INTEGRAL: case LAG_JET_COSINE: EACH(INNER(0, 3, 4) * -share);
        case LAG_JET_PRODUCT_AND: EACH(PRODUCT_AND(2, 3, 4));
        case LAG_JET_PRODUCT_FROM: EACH(PRODUCT_FROM(2, 3, 4));
        case LAG_JET_LOWER: EACH(INNER(0, 2, 3));
        case LAG_JET_ANGLE: EACH((INNER(0, 4, 6) - INNER(1, 5, 7)) * share);
        default: EACH(LAG_WIDE_OF((double)NAN));
        }
        between += sums_of(i, (int[4]){0}) * LAG_ABREAST;
    }
}

void lag_wide_series_turn(LagWideSeries *s, int k)
{
    const LagModel *model = s->model;
    for (int i = 0; i < model->n_attitudes; ++i)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
            lag_wide_jet_turn(s->jets + (size_t)lag_wide_quaternion(model, i) * LAG_WIDE_JET + lane,
                              s->jets + (size_t)(1 + model->n + lag_attitude_place(model->attitudes, i)) * LAG_WIDE_JET + lane, k);
}

/* The coefficients of q and v of the next order. */
static void next_state(LagWideSeries *s, int k)
{
    const int n = s->model->n;
    const LagWide share = LAG_WIDE_OF(1.0 / (k + 1));
    double *const next = s->jets + LAG_WIDE_JET + (k + 1) * LAG_ABREAST; /* time comes first */
    for (int i = 0; i < n; ++i)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
            const LagWide rate = LAG_WIDE_TERM(s->jets + (size_t)(1 + n + i) * LAG_WIDE_JET + lane, k);
            const LagWide change = lag_wide_read(s->line + (size_t)s->model->jet_rates[i] * LAG_ABREAST + lane);
            lag_wide_write(next + (size_t)i * LAG_WIDE_JET + lane, rate * share);
            lag_wide_write(next + (size_t)(n + i) * LAG_WIDE_JET + lane, change * share);
        }
    lag_wide_series_turn(s, k);
}

void lag_wide_series_begin(LagWideSeries *s)
{
    if (s->model->wide_taylor)
        s->model->wide_taylor(0, 1, s->numbers, s->jets, s->line);
    else
        run_first(s);
}

void lag_wide_series_go_on(LagWideSeries *s, int first, int end)
{
    if (s->model->wide_taylor) {
        s->model->wide_taylor(first, end, s->numbers, s->jets, s->line);
        return;
    }
    for (int k = first; k < end; ++k) {
        for (int slot = 0; slot < known(s->model); ++slot)
            memcpy(s->line + (size_t)slot * LAG_ABREAST, s->jets + (size_t)slot * LAG_WIDE_JET + (size_t)k * LAG_ABREAST,
                   LAG_ABREAST * sizeof *s->line);
        sum_all(s, k);
        run_order(s, k);
        next_state(s, k);
    }
}
