/* Least squares with weights that grow with what is left give the least largest one: C.L. Lawson, Contributions to the theory of linear
 * least maximum approximation (1961). */
#include "events/shares.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "state/state.h"

static const double NARROW = 1e-9;            /* of the larger effect: a second way that is none */
static const double NOISE = 64 * DBL_EPSILON; /* of dg/dt: what of an effect is rounding */
static const double LEAST_WEIGHT = 1e-12, SETTLED = 1e-9;
enum { MOST_TURNS = 200, ENOUGH = 3 };

void lag_shares_layout(LagShareSystem *x, const LagModel *model, int most, LagArena *arena)
{
    const size_t cones = most > 0 ? (size_t)model->n_cones : 0, size = cones > 0 ? (size_t)most : 0;
    x->place = lag_take_ints(arena, (size_t)most);
    x->cones = lag_take_ints(arena, 2 * cones);
    x->is_narrow = lag_take_ints(arena, cones);
    x->way = lag_take(arena, 2 * cones);
    x->weight = lag_take(arena, cones);
    x->untold = lag_take(arena, size * size);
    x->plain = lag_take(arena, size * size);
    x->part = lag_take(arena, size);
    x->n_untold = 0;
    lag_dense_lu_layout(&x->normal, (int)size, 0, arena);
}

void lag_shares_reset(LagRun *run)
{
    for (int k = 0; k < run->model->n_cones; ++k)
        run->sliding.system.weight[k] = 1;
}

int lag_shares_are_untold(const LagRun *run)
{
    const LagShareSystem *x = &run->sliding.system;
    int some = x->n_untold > 0;
    for (int k = 0; k < run->model->n_cones; ++k)
        some |= x->cones[2 * k] >= 0 && x->is_narrow[k];
    return some;
}

/* -------- ways */

static int place_of(const LagShareSystem *x, int size, int i)
{
    for (int row = 0; row < size; ++row)
        if (x->place[row] == i)
            return row;
    return -1;
}

/* Whether cone k, whose components are unknowns a and b, goes one way only, and which. */
static void find_way(LagRun *run, int k, int a, int b)
{
    const LagSliding *s = &run->sliding;
    LagShareSystem *x = &run->sliding.system;
    const int n = s->lu.size;
    const double *A = s->lu.re, across = (A[a + b * n] + A[b + a * n]) / 2, mean = (A[a + a * n] + A[b + b * n]) / 2;
    const double apart = (A[b + b * n] - A[a + a * n]) / 2, radius = hypot(across, apart), angle = atan2(-across, apart) / 2;
    const double rounding = NOISE * lag_max(fabs(s->rate[x->place[a]]), fabs(s->rate[x->place[b]]));
    x->is_narrow[k] = radius - mean >= 0 && -mean - radius <= lag_max(rounding, NARROW * (radius - mean));
    x->way[2 * k] = cos(angle);
    x->way[2 * k + 1] = sin(angle);
}

/* (x[a], x[b]) along the way of cone k into x[a], and nothing into x[b]. */
static void gather(const LagShareSystem *s, int k, double *x, int a, int b)
{
    x[a] = s->way[2 * k] * x[a] + s->way[2 * k + 1] * x[b];
    x[b] = 0;
}

static void scatter(const LagShareSystem *s, int k, double *x, int a, int b)
{
    const double along = x[a];
    x[a] = s->way[2 * k] * along;
    x[b] = s->way[2 * k + 1] * along;
}

/* The system with one unknown for each cone that goes one way only. */
static void reduce(LagRun *run)
{
    LagSliding *s = &run->sliding;
    LagShareSystem *x = &s->system;
    const int n = s->lu.size;
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int a = x->cones[2 * k] = place_of(x, n, run->model->cones[2 * k]);
        const int b = x->cones[2 * k + 1] = place_of(x, n, run->model->cones[2 * k + 1]);
        x->is_narrow[k] = 0;
        if (a < 0 || b < 0)
            x->cones[2 * k] = x->cones[2 * k + 1] = -1;
        else
            find_way(run, k, a, b);
    }
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int a = x->cones[2 * k], b = x->cones[2 * k + 1];
        for (int j = 0; j < n && x->is_narrow[k]; ++j)
            gather(x, k, s->lu.re + (size_t)j * (size_t)n, a, b);
        for (int i = 0; i < n && x->is_narrow[k]; ++i)
            gather(x, k, s->lu.re + i, a * n, b * n);
    }
}

/* -------- what motion does not tell */

/* Whether unknown j is that across a way. */
static int is_across(const LagRun *run, int j)
{
    const LagShareSystem *x = &run->sliding.system;
    for (int k = 0; k < run->model->n_cones; ++k)
        if (x->is_narrow[k] && x->cones[2 * k + 1] == j)
            return 1;
    return 0;
}

/* What undoes unknown j, which depends on others: whether friction in the plane is among it. */
static int find_untold(LagRun *run, int j, double *way)
{
    const LagSliding *s = &run->sliding;
    const LagShareSystem *x = &s->system;
    const int n = s->lu.size;
    double some = 0;
    memcpy(way, x->plain + (size_t)j * (size_t)n, (size_t)n * sizeof *way);
    lag_dense_lu_solve(&s->lu, way, NULL);
    for (int i = 0; i < n; ++i)
        way[i] = (i == j) - way[i];
    for (int k = 0; k < run->model->n_cones; ++k) {
        if (x->is_narrow[k])
            scatter(x, k, way, x->cones[2 * k], x->cones[2 * k + 1]);
        if (x->cones[2 * k] >= 0)
            some = lag_max(lag_max(fabs(way[x->cones[2 * k]]), fabs(way[x->cones[2 * k + 1]])), some);
    }
    return some > 0;
}

void lag_shares_factor(LagRun *run)
{
    LagSliding *s = &run->sliding;
    LagShareSystem *x = &s->system;
    const int n = s->lu.size;
    x->n_untold = 0;
    if (run->model->n_cones == 0) {
        lag_dense_lu_factor(&s->lu);
        return;
    }
    reduce(run);
    memcpy(x->plain, s->lu.re, (size_t)n * (size_t)n * sizeof *x->plain);
    lag_dense_lu_factor(&s->lu);
    for (int j = 0; j < n; ++j)
        if (s->lu.pivot[j] < 0 && !is_across(run, j))
            x->n_untold += find_untold(run, j, x->untold + (size_t)x->n_untold * (size_t)n);
}

void lag_shares_solve(const LagRun *run, double *change)
{
    const LagShareSystem *x = &run->sliding.system;
    const int n_cones = run->sliding.lu.size > 0 ? run->model->n_cones : 0;
    for (int k = 0; k < n_cones; ++k)
        if (x->is_narrow[k])
            gather(x, k, change, x->cones[2 * k], x->cones[2 * k + 1]);
    lag_dense_lu_solve(&run->sliding.lu, change, NULL);
    for (int k = 0; k < n_cones; ++k)
        if (x->is_narrow[k])
            scatter(x, k, change, x->cones[2 * k], x->cones[2 * k + 1]);
}

double lag_shares_along(const LagRun *run, int j)
{
    const LagShareSystem *x = &run->sliding.system;
    const double *rate = run->sliding.rate, *way = x->way;
    const int i = run->sliding.which[j], *cone = run->model->cones;
    for (int k = 0; k < run->model->n_cones; ++k, cone += 2, way += 2)
        if (x->cones[2 * k] >= 0 && x->is_narrow[k] && (cone[0] == i || cone[1] == i))
            return way[cone[1] == i] * (way[0] * rate[cone[0]] + way[1] * rate[cone[1]]);
    return rate[i];
}

/* -------- how it is shared */

/* The sum over friction in the plane of products of components, with weights. */
static double product(const LagRun *run, const double *u, const double *v)
{
    const LagShareSystem *x = &run->sliding.system;
    double sum = 0;
    for (int j = 0; j < 2 * run->model->n_cones; ++j)
        if (x->cones[j] >= 0)
            sum += x->weight[j / 2] * u[x->cones[j]] * v[x->cones[j]];
    return sum;
}

/* Components, which have no force at 1/2, as forces, or back. */
static void shift(const LagRun *run, double *share, double by)
{
    const LagShareSystem *x = &run->sliding.system;
    for (int j = 0; j < 2 * run->model->n_cones; ++j)
        if (x->cones[j] >= 0)
            share[x->cones[j]] += by;
}

static void take_least(LagRun *run, double *force)
{
    LagShareSystem *x = &run->sliding.system;
    const int n = run->sliding.lu.size, count = x->n_untold;
    x->normal.size = count;
    for (int i = 0; i < count; ++i) {
        x->part[i] = product(run, x->untold + i * n, force);
        for (int j = 0; j < count; ++j)
            x->normal.re[i + j * count] = product(run, x->untold + i * n, x->untold + j * n);
    }
    lag_dense_lu_factor(&x->normal);
    lag_dense_lu_solve(&x->normal, x->part, NULL);
    for (int j = 0; j < count; ++j)
        for (int i = 0; i < n; ++i)
            force[i] -= x->part[j] * x->untold[i + j * n];
}

void lag_shares_spread(LagRun *run, double *share)
{
    const LagShareSystem *x = &run->sliding.system;
    if (run->sliding.lu.size == 0 || !lag_shares_are_untold(run))
        return;
    shift(run, share, -0.5);
    for (int k = 0; k < run->model->n_cones; ++k)
        if (x->is_narrow[k]) {
            gather(x, k, share, x->cones[2 * k], x->cones[2 * k + 1]);
            scatter(x, k, share, x->cones[2 * k], x->cones[2 * k + 1]);
        }
    take_least(run, share);
    shift(run, share, 0.5);
}

/* The largest force, by what there is; weights become larger where it is large. */
static double weigh(LagRun *run, const double *share, int changes)
{
    LagShareSystem *x = &run->sliding.system;
    double most = 0, sum = 0;
    for (int turn = 0; turn < 2; ++turn)
        for (int k = 0; k < run->model->n_cones; ++k) {
            if (x->cones[2 * k] < 0)
                continue;
            const double force = hypot(2 * share[x->cones[2 * k]] - 1, 2 * share[x->cones[2 * k + 1]] - 1);
            if (turn == 0)
                sum += x->weight[k] * force;
            else if (changes)
                x->weight[k] = lag_max(LEAST_WEIGHT, x->weight[k] * force / sum);
            most = lag_max(force, most);
        }
    return most;
}

void lag_shares_balance(LagRun *run, double *share)
{
    const LagShareSystem *x = &run->sliding.system;
    double most = x->n_untold > 0 ? weigh(run, share, 0) : 0;
    for (int turn = 0, stays = 0; turn < MOST_TURNS && most > 1 - SETTLED && stays < ENOUGH; ++turn) {
        weigh(run, share, 1);
        lag_shares_spread(run, share);
        const double before = most;
        most = weigh(run, share, 0);
        stays = fabs(most - before) <= SETTLED ? stays + 1 : 0;
    }
}
