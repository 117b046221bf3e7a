#include "methods/linear_series.h"

#include <string.h>

#include "numbers/extremes.h"

enum { COST_OF_TERM = 60, COST_OF_POWERS = 60 }; /* in products of two double-doubles, some 1.5 ns */
enum { MOST_TERMS = 100, WARM_UP = 12, ITERATIONS = 24, USUAL_TERMS = 30 };
static const double LONGEST = 2.5, NEGLIGIBLE = 1e-21, ROUGH = 1e-4, MARGIN = 1.1, MOST_STEPS = 1e12;

/* Gauss-Legendre on (0, 1): the left halves; weights of equal nodes left and right are equal. */
typedef struct {
    int count;
    double longest; /* |A h| up to which they are good for 1e-18 */
    double node[LAG_SERIES_NODES / 2 + 1], weight[LAG_SERIES_NODES / 2 + 1];
} Gauss;
static const Gauss GAUSS[] = {
    {2, 1e-5, {0.21132486540518712}, {0.5}},
    {5, 0.02, {0.046910077030668004, 0.23076534494715845, 0.5},
     {0.11846344252809454, 0.23931433524968324, 0.28444444444444444}},
    {10, INFINITY, /* INFINITY: up to LONGEST, where it is good for 5e-17 */
     {0.013046735741414140, 0.067468316655507744, 0.16029521585048780, 0.28330230293537640, 0.42556283050918439},
     {0.033335672154344069, 0.074725674575290296, 0.10954318125799102, 0.13463335965499818, 0.14776211235737644}},
};

static double gauss_node(const Gauss *rule, int i)
{
    return 2 * i < rule->count ? rule->node[i] : 1 - rule->node[rule->count - 1 - i];
}

static double gauss_weight(const Gauss *rule, int i) { return rule->weight[2 * i < rule->count ? i : rule->count - 1 - i]; }

void lag_series_layout(LagSeries *s, const LagLinearSystem *system, int n_power, LagArena *arena)
{
    s->size = (size_t)system->size;
    s->n = (size_t)system->n;
    s->n_power = n_power;
    s->from = lag_dds_take(arena, s->size);
    s->term = lag_dds_take(arena, s->size);
    s->next = lag_dds_take(arena, s->size);
    s->sum = lag_dds_take(arena, s->size);
    s->node = lag_take(arena, n_power > 0 ? 2 * s->n * LAG_SERIES_NODES : 0);
}

static double length(LagDDs x, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; ++i)
        sum += x.hi[i] * x.hi[i];
    return sqrt(sum);
}

/* Growth of a vector under A: power iteration with nothing but its length, for a spectrum of +-i w has no largest member. */
static double fastest(LagSeries *s, LagLinearSystem *system)
{
    double total = 0;
    unsigned seed = 1;
    lag_dds_clear(s->term, s->size);
    for (size_t i = 0; i < 2 * s->n; ++i) {
        seed = 1664525U * seed + 1013904223U;
        s->term.hi[i] = (double)(seed >> 8) / (1 << 24) - 0.5;
    }
    for (int k = 0; k < ITERATIONS; ++k) {
        lag_linear_system_slope(system, s->term, s->next);
        const double growth = length(s->next, 2 * s->n);
        if (!(growth > 0))
            return 0;
        total += k < WARM_UP ? 0 : log(growth);
        for (size_t i = 0; i < 2 * s->n; ++i)
            lag_dds_set(s->term, i, lag_dd(s->next.hi[i] / growth));
    }
    return MARGIN * exp(total / (ITERATIONS - WARM_UP));
}

static double largest_entry(const LagSparse *matrix)
{
    double largest = 0;
    for (int e = 0; e < matrix->start[matrix->rows]; ++e)
        largest = fmax(largest, fabs(matrix->value[e].hi));
    return largest;
}

void lag_series_reset(LagSeries *s, LagLinearSystem *system, double norm)
{
    const LagSparse *F = &system->F, *G = &system->G, *L = &system->lower;
    s->entries = F->start[F->rows] + G->start[G->rows] + 2 * L->start[L->rows] + 2 * (double)s->size;
    s->rate = norm > 0 ? norm : fmax(fastest(s, system), largest_entry(G));
}

/* How much the largest term counts: among positions, among rates, in any load. */
static double share(const LagSeries *s)
{
    double largest = 0;
    for (size_t part = 0; part < 2; ++part) {
        const double term = lag_largest(s->term.hi + part * s->n, s->n);
        largest = fmax(largest, term > 0 ? term / lag_largest(s->sum.hi + part * s->n, s->n) : 0);
    }
    for (size_t i = 2 * s->n; i < s->size; ++i)
        largest = fmax(largest, s->term.hi[i] != 0 ? fabs(s->term.hi[i] / s->sum.hi[i]) : 0);
    return largest;
}

static void add_to_nodes(LagSeries *s, const Gauss *rule, double *power_of_node)
{
    for (int g = 0; g < rule->count; ++g) {
        lag_add_multiple(power_of_node[g], s->term.hi, s->node + 2 * s->n * (size_t)g, 2 * s->n);
        power_of_node[g] *= gauss_node(rule, g);
    }
}

/* The next term of the series, h/k A times the one before. A term that hardly counts needs no low part. */
static void next_term(LagSeries *s, LagLinearSystem *system, LagDD factor, int is_rough)
{
    const LagDDs done = s->term;
    if (is_rough) {
        lag_linear_system_rough_slope(system, s->term.hi, s->next.hi);
        for (size_t i = 0; i < s->size; ++i)
            s->next.hi[i] *= factor.hi;
        memset(s->next.lo, 0, s->size * sizeof *s->next.lo);
    } else {
        lag_linear_system_slope(system, s->term, s->next);
        lag_dds_scale(s->next, factor, s->size);
    }
    s->term = s->next;
    s->next = done;
}

static void integrate(LagSeries *s, const Gauss *rule, double t, double h, LagDD *integrals)
{
    double power[2] = {0, 0};
    for (int g = 0; g < rule->count; ++g) {
        double *node = s->node + 2 * s->n * (size_t)g;
        s->powers(s->context, t + gauss_node(rule, g) * h, node, node + s->n, power);
        for (int i = 0; i < s->n_power; ++i)
            integrals[i] = lag_dd_add(integrals[i], lag_dd_product(gauss_weight(rule, g) * h, power[i]));
    }
}

/* from -> sum. Returns 0 when the series does not end. */
static int step(LagSeries *s, LagLinearSystem *system, double t, LagDD h, LagDD *integrals)
{
    const Gauss *rule = GAUSS;
    double power_of_node[LAG_SERIES_NODES];
    while (s->rate * fabs(h.hi) > rule->longest)
        ++rule;
    for (int g = 0; g < LAG_SERIES_NODES; ++g)
        power_of_node[g] = 1;
    if (s->n_power > 0)
        memset(s->node, 0, 2 * s->n * (size_t)rule->count * sizeof *s->node);
    lag_dds_copy(s->from, s->term, s->size);
    lag_dds_clear(s->sum, s->size);
    double counts = 1;
    for (int k = 0, quiet = 0; quiet < 2; ++k) {
        if (k == MOST_TERMS)
            return 0;
        if (k > 0)
            next_term(s, system, lag_dd_div(h, lag_dd(k)), counts < ROUGH);
        lag_dds_add(s->term, s->sum, s->size);
        counts = share(s);
        quiet = counts <= NEGLIGIBLE ? quiet + 1 : 0;
        if (s->n_power > 0)
            add_to_nodes(s, rule, power_of_node);
    }
    if (s->n_power > 0)
        integrate(s, rule, t, h.hi, integrals);
    return 1;
}

static double steps(const LagSeries *s, double h) { return fmax(1, ceil(s->rate * fabs(h) / LONGEST)); }

int lag_series_move(LagSeries *s, LagLinearSystem *system, double t, LagDD h, LagDDs x, LagDDs y, LagDD *integrals)
{
    for (double count = steps(s, h.hi); count < MOST_STEPS; count *= 2) {
        const LagDD part = lag_dd_div(h, lag_dd(count));
        LagDD found[2] = {{0, 0}, {0, 0}};
        double done = 0;
        lag_dds_copy(x, s->from, s->size);
        while (done < count && step(s, system, t + done * part.hi, part, found)) {
            lag_dds_copy(s->sum, s->from, s->size);
            ++done;
        }
        if (done < count)
            continue; /* the rate was thought too small */
        lag_dds_copy(s->from, y, s->size);
        for (int i = 0; i < s->n_power; ++i)
            integrals[i] = lag_dd_add(integrals[i], found[i]);
        return 1;
    }
    return 0;
}

double lag_series_cost(const LagSeries *s, double h)
{
    const double theta = s->rate * fabs(h), terms = theta > 0.1 ? USUAL_TERMS : theta > 1e-6 ? USUAL_TERMS / 3 : 4;
    const double powers = s->n_power > 0 ? (theta > 0.02 ? 10 : theta > 1e-5 ? 5 : 2) * (2.0 * (double)s->n + COST_OF_POWERS) : 0;
    return steps(s, h) * (terms * (3 * s->entries + 8 * (double)s->size + COST_OF_TERM) + powers);
}
