#include "methods/linear_ladder.h"

enum { COST_OF_ROW = 3, COST_OF_SERIES = 120 }; /* in products of two double-doubles, an entry of rung 0: measured */
enum { RUNGS_OF_LARGE = 40, LARGE = 160, SWEEPS = 8, FEWEST_TERMS = 14 };
enum { MOST_ABOVE = 20 }; /* the last rung is climbed 2^MOST_ABOVE times at most */
/* Rung 0 is as long as |A h| <= states / FEW, within limits: terms cost as their square, doublings as their third power. */
static const double FEW = 64, SHORTEST = 0.125, LONGEST = 2;
static const double PRECISION = 4e-33, HIT = 1e-10, LEAST_SHARE = 1e-6, SMALLEST_NORM = 1.0 / 64;

int lag_ladder_possible(const LagModel *model)
{
    return 2 * model->n + model->linear_pattern[0] <= LAG_LADDER_MOST_STATES
        && (model->n_power == 0 || model->linear_pattern[3] == model->n_power);
}

static size_t matrix(const LagLadder *l) { return l->size * l->stride; }

static LagDDs rung_part(const LagLadder *l, int rung, int part)
{
    return lag_dds_from(l->rungs, ((size_t)rung * (size_t)(1 + l->n_forms) + (size_t)part) * matrix(l));
}

static LagDDs row_of(const LagLadder *l, LagDDs matrix_, size_t i) { return lag_dds_from(matrix_, i * l->stride); }

void lag_ladder_layout(LagLadder *l, const LagLinearSystem *system, LagArena *arena)
{
    l->size = (size_t)system->size;
    l->stride = (l->size + 3) / 4 * 4;
    l->n_forms = system->n_forms;
    l->n_rungs = l->size <= LARGE ? LAG_LADDER_MOST_RUNGS : RUNGS_OF_LARGE;
    l->slopes = lag_dds_take(arena, matrix(l));
    for (int f = 0; f < l->n_forms; ++f)
        l->form[f] = lag_dds_take(arena, matrix(l));
    for (int i = 0; i < 2; ++i)
        l->scratch[i] = lag_dds_take(arena, matrix(l));
    l->row = lag_dds_take(arena, l->stride);
    l->rungs = lag_dds_take(arena, (size_t)l->n_rungs * (size_t)(1 + l->n_forms) * matrix(l));
}

/* ---------------------------------------------------------------- the matrices */

static void unpack_form(LagLadder *l, const LagSparse *form, LagDDs to)
{
    lag_dds_clear(to, matrix(l));
    for (int i = 0; i < form->rows; ++i)
        for (int e = form->start[i]; e < form->start[i + 1]; ++e)
            lag_dds_set(row_of(l, to, (size_t)i), (size_t)form->column[e], form->value[e]);
}

/* B. Parlett, C. Reinsch, Numer. Math. 13 (1969): units 2^k of the states in which rows and columns are alike. A state that
 * only drives, or is only driven, may have any unit: it gets one in which it hardly counts. */
static void balance(LagLadder *l, double *unit)
{
    for (size_t i = 0; i < l->size; ++i)
        unit[i] = 1;
    for (int sweep = 0; sweep < SWEEPS; ++sweep)
        for (size_t i = 0; i < l->size; ++i) {
            double from = 0, to = 0;
            for (size_t j = 0; j < l->size; ++j) {
                if (j == i)
                    continue;
                from += fabs(row_of(l, l->slopes, i).hi[j]) * unit[i] / unit[j];
                to += fabs(row_of(l, l->slopes, j).hi[i]) * unit[j] / unit[i];
            }
            from = fmax(from, LEAST_SHARE * to);
            to = fmax(to, LEAST_SHARE * from);
            if (from > 0 && isfinite(from) && isfinite(to))
                unit[i] *= exp2(floor(0.5 * log2(to / from) + 0.5));
        }
}

static double balanced_norm(LagLadder *l)
{
    double *unit = l->row.hi, largest = 0;
    balance(l, unit);
    for (size_t i = 0; i < l->size; ++i) {
        double sum = 0;
        for (size_t j = 0; j < l->size; ++j)
            sum += fabs(row_of(l, l->slopes, i).hi[j]) * unit[i] / unit[j];
        largest = fmax(largest, sum);
    }
    return largest;
}

void lag_ladder_reset(LagLadder *l, LagLinearSystem *system)
{
    const LagDDs unit = l->row;
    lag_dds_clear(l->slopes, matrix(l));
    for (size_t j = 0; j < l->size; ++j) { /* column j of A */
        lag_dds_clear(unit, l->stride);
        unit.hi[j] = 1;
        lag_linear_system_slope(system, unit, row_of(l, l->slopes, j));
    }
    for (int f = 0; f < l->n_forms; ++f)
        unpack_form(l, &system->form[f], l->form[f]);
    l->norm = balanced_norm(l);
    l->base = 0;
    l->built = 0;
}

/* ---------------------------------------------------------------- building rungs */

/* y = a b for matrices row by row; zeros of a cost nothing. */
static void multiply(const LagLadder *l, LagDDs a, LagDDs b, LagDDs y)
{
    lag_dds_clear(y, matrix(l));
    for (size_t i = 0; i < l->size; ++i) {
        const LagDDs factors = row_of(l, a, i);
        for (size_t k = 0; k < l->size; ++k)
            if (factors.hi[k] != 0)
                lag_dds_gather(lag_dds_get(factors, k), row_of(l, b, k), row_of(l, y, i), l->stride);
        lag_dds_settle(row_of(l, y, i), l->size);
    }
}

static void transpose(const LagLadder *l, LagDDs x, LagDDs y)
{
    for (size_t i = 0; i < l->size; ++i)
        for (size_t j = 0; j < l->size; ++j)
            lag_dds_set(row_of(l, y, j), i, lag_dds_get(row_of(l, x, i), j));
}

/* Terms of the exponential series of norm theta. Chains of states that drive each other want some, however short the step. */
static int terms(double theta)
{
    double term = 1;
    int k = 0;
    theta = fmax(theta, SMALLEST_NORM);
    while (term > PRECISION || k < FEWEST_TERMS)
        term *= theta / ++k;
    return k;
}

/* E' = sum of (A' h)^k / k! */
static void sum_exponential(LagLadder *l, double h)
{
    const LagDDs sum = rung_part(l, 0, 0);
    LagDDs term = l->scratch[0], next = l->scratch[1];
    lag_dds_clear(term, matrix(l));
    for (size_t i = 0; i < l->size; ++i)
        row_of(l, term, i).hi[i] = 1;
    lag_dds_copy(term, sum, matrix(l));
    for (int k = 1, last = terms(l->norm * h); k <= last; ++k) {
        const LagDDs done = term;
        multiply(l, l->slopes, term, next);
        lag_dds_scale(next, lag_dd_div(lag_dd(h), lag_dd(k)), matrix(l));
        lag_dds_add(next, sum, matrix(l));
        term = next;
        next = done;
    }
}

/* W = sum of h^(k+1) L^k Q / (k+1)!, with L X = A' X + (A' X)' */
static void sum_form(LagLadder *l, double h, int f)
{
    const LagDDs sum = rung_part(l, 0, 1 + f), term = l->scratch[0], next = l->scratch[1];
    lag_dds_copy(l->form[f], term, matrix(l));
    lag_dds_scale(term, lag_dd(h), matrix(l));
    lag_dds_copy(term, sum, matrix(l));
    for (int k = 2, last = terms(2 * l->norm * h) + 1; k <= last; ++k) {
        multiply(l, l->slopes, term, next);
        transpose(l, next, term);
        lag_dds_add(next, term, matrix(l));
        lag_dds_scale(term, lag_dd_div(lag_dd(h), lag_dd(k)), matrix(l));
        lag_dds_add(term, sum, matrix(l));
    }
}

static void double_rung(LagLadder *l, int k)
{
    const LagDDs E = rung_part(l, k, 0), product = l->scratch[0], turned = l->scratch[1];
    multiply(l, E, E, rung_part(l, k + 1, 0));
    for (int f = 1; f <= l->n_forms; ++f) {
        const LagDDs W = rung_part(l, k, f), sum = rung_part(l, k + 1, f);
        multiply(l, E, W, product); /* E' W; its transpose is W E */
        transpose(l, product, turned);
        multiply(l, E, turned, sum);
        lag_dds_add(W, sum, matrix(l));
    }
}

static void build_to(LagLadder *l, int rung)
{
    if (l->built == 0) {
        const double h = l->length[0];
        sum_exponential(l, h);
        for (int f = 0; f < l->n_forms; ++f)
            sum_form(l, h, f);
        l->built = 1;
    }
    for (; l->built <= rung; ++l->built)
        double_rung(l, l->built - 1);
}

/* ---------------------------------------------------------------- use */

static int doublings(const LagLadder *l, double h)
{
    const double longest = fmin(fmax((double)l->size / FEW, SHORTEST), LONGEST);
    return (int)fmax(0, ceil(log2(fmax(l->norm * h / longest, SMALLEST_NORM))));
}

void lag_ladder_set_base(LagLadder *l, double h)
{
    const int top = doublings(l, h), highest = l->n_rungs - 1;
    l->top = top < highest ? top : highest;
    l->base = ldexp(h, l->top - top);
    l->built = 0;
    for (int k = 0; k < l->n_rungs; ++k)
        l->length[k] = ldexp(l->base, k - l->top);
}

int lag_ladder_reaches(const LagLadder *l, double h)
{
    return isfinite(l->norm) && doublings(l, h) < l->n_rungs + MOST_ABOVE;
}

int lag_ladder_find(const LagLadder *l, double h)
{
    int rung = l->n_rungs - 1;
    while (rung >= 0 && l->length[rung] > h * (1 + HIT))
        --rung;
    return rung;
}

void lag_ladder_climb(LagLadder *l, int rung, LagDDs x, LagDDs y, LagDD *integrals)
{
    build_to(l, rung);
    for (int f = l->n_forms; f >= 0; --f) {
        const LagDDs part = rung_part(l, rung, f);
        lag_dds_clear(y, l->stride);
        for (size_t j = 0; j < l->size; ++j)
            if (x.hi[j] != 0)
                lag_dds_gather(lag_dds_get(x, j), row_of(l, part, j), y, l->stride);
        lag_dds_settle(y, l->size);
        if (f > 0)
            integrals[f - 1] = lag_dd_add(integrals[f - 1], lag_dds_dot(x, y, l->size));
    }
}

const double *lag_ladder_row(const LagLadder *l, int rung, int part, size_t j)
{
    return row_of(l, rung_part(l, rung, part), j).hi;
}

double lag_ladder_cost(const LagLadder *l, double h)
{
    const double n = (double)l->size, entries = n * (double)(l->stride + COST_OF_ROW);
    return entries * ((1 + 2 * l->n_forms) * n * doublings(l, h) + COST_OF_SERIES * (1 + 3 * l->n_forms));
}

double lag_ladder_cost_of_rung(const LagLadder *l) { return (double)(l->size * (l->stride + COST_OF_ROW)) * (1 + l->n_forms); }
