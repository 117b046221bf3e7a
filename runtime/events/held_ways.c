#include "events/held_ways.h"

#include <string.h>

#include "events/sliding.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double PARALLEL = 1e-12; /* square of what is left of a direction, by that of the whole */

void lag_held_ways_layout(LagHeldWays *ways, const LagModel *model, LagArena *arena)
{
    const size_t most = model->n_whens > 0 ? (size_t)lag_sliding_most(model) : 0;
    ways->which = lag_take_ints(arena, most);
    ways->base = lag_take_ints(arena, most);
    ways->row = lag_take(arena, most * (size_t)model->n);
    ways->mix = lag_take(arena, most * most);
    ways->left = lag_take(arena, most);
}

static double product(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += a[i] * b[i];
    return sum;
}

static void take_off(double *x, const double *row, double along, int n)
{
    for (int i = 0; i < n; ++i)
        x[i] -= along * row[i];
}

/* How what is held changes with each rate: into the rows. */
static void find_slopes(LagRun *run, const double *g)
{
    LagHeldWays *s = &run->impacts.ways;
    LagSwitches *at = &run->switches;
    const int n = run->model->n;
    double *v = run->impacts.state;
    memcpy(v, run->motion.y + n, (size_t)n * sizeof *v);
    for (int i = 0; i < n; ++i) {
        v[i] += 1;
        lag_conditions_of_motion(run, run->motion.t, run->motion.y, v, at->slope + n, at->g_inside, at->rate_inside);
        v[i] = run->motion.y[n + i];
        for (int j = 0; j < s->count; ++j)
            s->row[i + j * n] = at->g_inside[s->which[j]] - g[s->which[j]];
    }
}

void lag_held_ways_find(LagRun *run, const double *g)
{
    LagHeldWays *s = &run->impacts.ways;
    const int n = run->model->n, count = s->count = run->sliding.count;
    memcpy(s->which, run->sliding.which, (size_t)count * sizeof *s->which);
    find_slopes(run, g);
    s->rank = 0;
    for (int j = 0; j < count; ++j) {
        double *row = s->row + s->rank * n, *mix = s->mix + j * count;
        memmove(row, s->row + j * n, (size_t)n * sizeof *row);
        const double size = product(row, row, n);
        for (int i = 0; i < s->rank; ++i) {
            const double *other = s->row + i * n;
            mix[i] = product(row, other, n) / product(other, other, n);
            take_off(row, other, mix[i], n);
        }
        if (!(product(row, row, n) > PARALLEL * size))
            continue;
        s->base[s->rank] = j;
        mix[s->rank++] = 1;
    }
}

int lag_held_ways_last(const LagRun *run)
{
    const LagHeldWays *s = &run->impacts.ways;
    return s->count == run->sliding.count && memcmp(s->which, run->sliding.which, (size_t)s->count * sizeof *s->which) == 0;
}

void lag_held_ways_put(const LagHeldWays *ways, int n, double *x)
{
    double *left = ways->left;
    for (int i = 0; i < ways->rank; ++i) {
        const double *row = ways->row + i * n;
        const double along = left[ways->base[i]] / product(row, row, n);
        take_off(x, row, along, n);
        for (int later = i + 1; later < ways->rank; ++later)
            left[ways->base[later]] -= ways->mix[i + ways->base[later] * ways->count] * along * product(row, row, n);
    }
}

double lag_held_ways_along(const LagHeldWays *ways, int n, int j, const double *x)
{
    double sum = 0;
    for (int i = 0; i < ways->rank && ways->base[i] <= j; ++i)
        sum += ways->mix[i + j * ways->count] * product(ways->row + i * n, x, n);
    return sum;
}

void lag_held_ways_leave(const LagHeldWays *ways, int n, double *x)
{
    for (int i = 0; i < ways->rank; ++i) {
        const double *row = ways->row + i * n;
        take_off(x, row, product(x, row, n) / product(row, row, n), n);
    }
}
