#include "methods/transition_matrices.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "numbers/lanes.h"

static const double SHORT = 0.35; /* |A h| up to which the polynomial is good to rounding: 0.35^13/13! = 2e-16 */
static const double HIT = 1e-10;  /* a length that is meant to be a rung's */
static const double PRECISION = 1e-17, PRECISION_OF_FORMS = 1e-16;
enum { PART = 4, NODES = 5 };

/* Gauss-Legendre on (0, 1): integrals of powers over |A h| <= SHORT to 1e-16. */
static const double NODE[NODES] = {0.046910077030668004, 0.23076534494715845, 0.5, 0.76923465505284155, 0.953089922969332};
static const double WEIGHT[NODES] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324,
                                     0.11846344252809454};

int lag_transition_possible(const LagModel *model)
{
    if (!model->linear_pattern || model->n_switches > 0)
        return 0;
    const LagLinearPattern pattern = lag_linear_pattern(model);
    return pattern.size <= LAG_TRANSITION_MOST_STATES && !pattern.changes && pattern.n_forms == model->n_power;
}

void lag_transition_layout(LagTransitionMatrices *s, const LagModel *model, LagArena *arena)
{
    const size_t n = (size_t)model->n, n_linear = model->linear.n_work, n_waves = model->waves.n_work;
    s->model = model;
    s->pattern = lag_linear_pattern(model);
    s->size = (size_t)s->pattern.size;
    s->stride = (s->size + PART - 1) / PART * PART;
    s->n_forms = 0;
    for (int f = 0; f < s->pattern.n_forms; ++f)
        if (s->pattern.form[f].start[s->size] > 0)
            s->place[s->n_forms++] = f;
    s->A = lag_take(arena, lag_transition_entries(s));
    for (int f = 0; f < s->n_forms; ++f)
        s->form[f] = lag_take(arena, lag_transition_entries(s));
    s->rungs = lag_take(arena, LAG_TRANSITION_RUNGS * (size_t)(1 + s->n_forms) * lag_transition_entries(s));
    for (int i = 0; i < LAG_TRANSITION_POWERS; ++i)
        s->power[i] = lag_take(arena, lag_transition_entries(s));
    s->terms = lag_take(arena, LAG_TRANSITION_TERMS * s->stride);
    s->mass = lag_take(arena, n * n);
    s->values = lag_take(arena, (size_t)model->linear.out_size[0]);
    s->work = lag_take(arena, n_linear > n_waves ? n_linear : n_waves);
    s->p = lag_take(arena, (size_t)model->n_parameters);
}

/* ---------------------------------------------------------------- products */

/* Y = X A for one or two columns of A: sums of two do not wait for each other. A column is `lanes` groups of numbers, the same sums
 * however many lanes a register has. */
LAG_UNROLLED void product_of(const double *X, const double *A, size_t size, size_t lanes, size_t columns, double *Y)
{
    enum { MOST = LAG_TRANSITION_MOST_STATES / LAG_LANES };
    const size_t stride = lanes * LAG_LANES;
    LagLanes sum[2][MOST];
    for (size_t c = 0; c < columns; ++c)
        LAG_UNROLL_ALL
        for (size_t l = 0; l < lanes; ++l)
            sum[c][l] = LAG_LANES_OF(0);
    for (size_t k = 0; k < size; ++k)
        LAG_UNROLL_ALL
        for (size_t l = 0; l < lanes; ++l) {
            LagLanes x;
            memcpy(&x, X + (k * lanes + l) * LAG_LANES, sizeof x);
            LAG_UNROLL_ALL
            for (size_t c = 0; c < columns; ++c)
                sum[c][l] += x * LAG_LANES_OF(A[c * stride + k]);
        }
    for (size_t c = 0; c < columns; ++c)
        memcpy(Y + c * stride, sum[c], lanes * sizeof *sum[c]);
}

LAG_UNROLLED void products_of(const double *X, const double *Y, size_t size, size_t columns, size_t lanes, double *Z)
{
    const size_t stride = lanes * LAG_LANES;
    size_t j = 0;
    for (; j + 1 < columns; j += 2)
        product_of(X, Y + j * stride, size, lanes, 2, Z + j * stride);
    if (j < columns)
        product_of(X, Y + j * stride, size, lanes, 1, Z + j * stride);
}

/* Z = X Y for so many columns of Y. */
static void multiply(const LagTransitionMatrices *s, const double *X, const double *Y, size_t columns, double *Z)
{
    switch (s->stride) {
    case PART: products_of(X, Y, s->size, columns, PART / LAG_LANES, Z); break;
    case 2 * PART: products_of(X, Y, s->size, columns, 2 * PART / LAG_LANES, Z); break;
    default: products_of(X, Y, s->size, columns, 3 * PART / LAG_LANES, Z);
    }
}

static double dot(const LagTransitionMatrices *s, const double *x, const double *y)
{
    double sum[PART] = {0, 0, 0, 0};
    for (size_t i = 0; i < s->stride; i += PART)
        for (size_t k = 0; k < PART; ++k)
            sum[k] += x[i + k] * y[i + k];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* ---------------------------------------------------------------- rungs */

static double *rung_part(const LagTransitionMatrices *s, int rung, int part)
{
    return s->rungs + (size_t)(rung * (1 + s->n_forms) + part) * lag_transition_entries(s);
}

static void transpose(const LagTransitionMatrices *s, const double *X, double *Y)
{
    for (size_t j = 0; j < s->size; ++j)
        for (size_t i = 0; i < s->size; ++i)
            Y[i * s->stride + j] = X[j * s->stride + i];
}

/* Y = factor (X + X'), column by column. */
static void add_transposed(const LagTransitionMatrices *s, const double *X, double factor, double *Y)
{
    for (size_t j = 0; j < s->size; ++j)
        for (size_t i = 0; i <= j; ++i)
            Y[j * s->stride + i] = Y[i * s->stride + j] = factor * (X[j * s->stride + i] + X[i * s->stride + j]);
}

/* y += factor x, for a whole matrix. */
static void add_matrix(const LagTransitionMatrices *s, double factor, const double *x, double *y)
{
    const LagLanes weight = LAG_LANES_OF(factor);
    for (size_t i = 0; i < lag_transition_entries(s); i += LAG_LANES) {
        LagLanes from, to;
        memcpy(&from, x + i, sizeof from);
        memcpy(&to, y + i, sizeof to);
        to += weight * from;
        memcpy(y + i, &to, sizeof to);
    }
}

/* P = b0 + b1 B + b2 B^2 + b3 B^3 + b4 B^4, over the reciprocals of factorials b, plus what P holds. */
static void add_powers(LagTransitionMatrices *s, const double *b, int last, double *P)
{
    for (int k = 1; k <= last; ++k)
        add_matrix(s, b[k], s->power[k - 1], P);
    for (size_t i = 0; i < s->size; ++i)
        P[i * s->stride + i] += b[0];
}

/* F = sum of (A h)^k / k! from k = 1 to 12, of the powers up to the fourth. */
static void expand_exponential(LagTransitionMatrices *s, double h, double *F)
{
    static const double LOW[] = {0, 1, 1. / 2, 1. / 6};
    static const double MIDDLE[] = {1. / 24, 1. / 120, 1. / 720, 1. / 5040};
    static const double HIGH[] = {1. / 40320, 1. / 362880, 1. / 3628800, 1. / 39916800, 1. / 479001600};
    double *const B = s->power[0], *const square = s->power[1], *const P = s->power[4];
    for (size_t i = 0; i < lag_transition_entries(s); ++i)
        B[i] = h * s->A[i];
    multiply(s, B, B, s->size, square);
    multiply(s, B, square, s->size, s->power[2]);
    multiply(s, square, square, s->size, s->power[3]);
    memset(P, 0, lag_transition_entries(s) * sizeof *P);
    add_powers(s, HIGH, 4, P);
    multiply(s, s->power[3], P, s->size, F);
    add_powers(s, MIDDLE, 3, F);
    multiply(s, s->power[3], F, s->size, P);
    memcpy(F, P, lag_transition_entries(s) * sizeof *F);
    add_powers(s, LOW, 3, F);
}

/* W = sum of h^(k+1) L^k Q / (k+1)!, with L X = X A + (X A)'. */
static void expand_form(LagTransitionMatrices *s, double h, const double *Q, double *W)
{
    const double theta = lag_max(2 * s->norm * h, 1e-3);
    double *const B = s->power[0], *const term = s->power[1], *const next = s->power[2], size = 1;
    for (size_t i = 0; i < lag_transition_entries(s); ++i)
        W[i] = term[i] = h * Q[i];
    for (int k = 2; size > PRECISION_OF_FORMS; ++k) {
        multiply(s, term, B, s->size, next);
        add_transposed(s, next, 1.0 / k, term);
        add_matrix(s, 1, term, W);
        size *= theta / k;
    }
}

static void double_rung(LagTransitionMatrices *s, int k)
{
    const double *F = rung_part(s, k, 0);
    double *const turned = s->power[0], *const T = s->power[1], *const other = s->power[2];
    double *const twice = rung_part(s, k + 1, 0);
    multiply(s, F, F, s->size, twice);
    add_matrix(s, 2, F, twice);
    if (s->n_forms > 0)
        transpose(s, F, turned);
    for (int f = 1; f <= s->n_forms; ++f) { /* E' W E = W + T + T' + F' T with T = W F */
        const double *W = rung_part(s, k, f);
        double *const sum = rung_part(s, k + 1, f);
        multiply(s, W, F, s->size, T);
        multiply(s, turned, T, s->size, sum);
        add_transposed(s, T, 1, other);
        add_matrix(s, 2, W, sum);
        add_matrix(s, 1, other, sum);
    }
}

static void build_to(LagTransitionMatrices *s, int rung)
{
    if (s->n_built == 0) {
        expand_exponential(s, s->length[0], rung_part(s, 0, 0));
        for (int f = 0; f < s->n_forms; ++f)
            expand_form(s, s->length[0], s->form[f], rung_part(s, 0, 1 + f));
        s->n_built = 1;
    }
    for (; s->n_built <= rung; ++s->n_built)
        double_rung(s, s->n_built - 1);
}

int lag_transition_is_short(const LagTransitionMatrices *s, double h) { return s->norm * h <= SHORT; }

void lag_transition_plan(LagTransitionMatrices *s, double h)
{
    double length = h;
    for (int k = 0; k < LAG_TRANSITION_RUNGS && !lag_transition_is_short(s, length); ++k)
        length /= 2;
    s->is_planned = 1;
    if (length == s->length[0])
        return;
    for (int k = 0; k < LAG_TRANSITION_RUNGS; ++k)
        s->length[k] = ldexp(length, k);
    s->n_built = 0;
}

/* ---------------------------------------------------------------- use */

static void add(const LagTransitionMatrices *s, const double *more, LagMoving *moving)
{
    for (size_t i = 0; i < s->stride; ++i) {
        moving->x[i] += more[i];
        moving->sum[i] += more[i];
    }
}

static void climb(LagTransitionMatrices *s, int rung, LagMoving *moving)
{
    double image[LAG_TRANSITION_MOST_STATES];
    build_to(s, rung);
    for (int f = 0; f < s->n_forms; ++f) {
        multiply(s, rung_part(s, rung, 1 + f), moving->x, 1, image);
        moving->gain[s->place[f]] += dot(s, moving->x, image);
    }
    multiply(s, rung_part(s, rung, 0), moving->x, 1, image);
    add(s, image, moving);
}

/* Of a step from `terms` on: powers at its nodes. */
static void integrate(LagTransitionMatrices *s, double h, int last, LagMoving *moving)
{
    double x[LAG_TRANSITION_MOST_STATES], image[LAG_TRANSITION_MOST_STATES];
    for (int g = 0; g < NODES; ++g) {
        memcpy(x, s->terms + (size_t)last * s->stride, s->stride * sizeof *x);
        for (int k = last - 1; k >= 0; --k)
            for (size_t i = 0; i < s->stride; ++i)
                x[i] = x[i] * NODE[g] + s->terms[(size_t)k * s->stride + i];
        for (int f = 0; f < s->n_forms; ++f) {
            multiply(s, s->form[f], x, 1, image);
            moving->gain[s->place[f]] += WEIGHT[g] * h * dot(s, x, image);
        }
    }
}

/* A short step by the series of the exponential, term by term. */
static void creep(LagTransitionMatrices *s, double h, LagMoving *moving)
{
    const double theta = lag_max(s->norm * fabs(h), 1e-3);
    double more[LAG_TRANSITION_MOST_STATES], size = 1;
    int last = 0;
    memcpy(s->terms, moving->x, s->stride * sizeof *s->terms);
    memset(more, 0, sizeof more);
    do {
        double *const term = s->terms + (size_t)(last + 1) * s->stride;
        multiply(s, s->A, term - s->stride, 1, term);
        size *= theta / ++last;
        for (size_t i = 0; i < s->stride; ++i) {
            term[i] *= h / last;
            more[i] += term[i];
        }
    } while ((size > PRECISION || last < 4) && last + 1 < LAG_TRANSITION_TERMS);
    if (s->n_forms > 0)
        integrate(s, h, last, moving);
    add(s, more, moving);
}

/* The longest rung of at most this length; -1: even rung 0 is longer. */
static int find_rung(const LagTransitionMatrices *s, double h)
{
    const double longest = h * (1 + HIT);
    int rung = s->is_planned ? LAG_TRANSITION_RUNGS - 1 : -1;
    while (rung >= 0 && s->length[rung] > longest)
        --rung;
    return rung;
}

void lag_transition_move(LagTransitionMatrices *s, double h, double ignored, LagMoving *moving)
{
    memset(moving->sum, 0, s->stride * sizeof *moving->sum);
    moving->gain[0] = moving->gain[1] = 0;
    for (int rung = find_rung(s, h); rung >= 0; rung = find_rung(s, h)) {
        climb(s, rung, moving);
        h -= s->length[rung];
    }
    moving->has_rest = !(fabs(h) <= ignored);
    moving->lag = moving->has_rest ? 0 : h;
    if (moving->has_rest)
        creep(s, h, moving);
}
