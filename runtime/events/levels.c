/* What compares nothing but held rates is told numerically: directions of rates that change what is held are taken off the
 * others, and a condition that none of these changes, nor time and place, is as far from its level as it is where all that is held is
 * exactly so. Where loops tie rates, only what follows from what is held alone is found.
 */
#include "events/levels.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "numbers/extremes.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double SAME = 1e-9;   /* of changes by rates of 1 in SI units: conditions are compared by these */
static const double ASIDE = 1e-3;  /* m, or rad: what is held may not change with positions */
static const double LATER = 1;     /* s: nor with time */
static const double EDGE = 1e-290; /* where both sides of <= are equal, levels are less */
static const double PARALLEL = 1e-12; /* square of what is left of a direction of unit length */

static int is_candidate(const LagRun *run, int k) { return !run->impacts.has_contact[k] && run->model->on_level[k] >= LAG_RATES_ALONE; }

/* All conditions at rates v[n], where positions are moved and time goes on by so much. */
static void look(LagRun *run, double aside, double later, const double *v, double *g)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    for (int i = 0; i < m->n; ++i)
        s->state[i] = m->y[i] + (i % 2 ? -aside : aside);
    lag_conditions_by(run, m->t + later, s->state, v, s->slope + m->n, g, s->rate_inside);
}

static double product(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += a[i] * b[i];
    return sum;
}

static void take_off(double *v, const double *row, double along, int n)
{
    for (int i = 0; i < n; ++i)
        v[i] -= along * row[i];
}

/* How what is held changes with each rate: into the rows of impacts.level_way. */
static void find_slopes(LagRun *run)
{
    const LagSliding *s = &run->sliding;
    const int n = run->model->n;
    double *v = run->impacts.state;
    memcpy(v, run->motion.y + n, (size_t)n * sizeof *v);
    for (int i = 0; i < n; ++i) {
        v[i] += 1;
        look(run, 0, 0, v, run->switches.g_inside);
        v[i] = run->motion.y[n + i];
        for (int j = 0; j < s->count; ++j)
            run->impacts.level_way[i + j * n] = run->switches.g_inside[s->which[j]] - run->switches.g_begin[s->which[j]];
    }
}

/* These orthonormal, and rates at which all that is held is none, into switches.slope. Returns how many rows there are. */
static int find_directions(LagRun *run)
{
    const LagSliding *s = &run->sliding;
    const int n = run->model->n;
    double *way = run->impacts.level_way, *v = run->switches.slope;
    int rank = 0;
    memcpy(v, run->motion.y + n, (size_t)n * sizeof *v);
    for (int j = 0; j < s->count; ++j) {
        double *row = way + rank * n, g = run->switches.g_begin[s->which[j]];
        memmove(row, way + j * n, (size_t)n * sizeof *row);
        const double size = product(row, row, n);
        g += product(row, v, n) - product(row, run->motion.y + n, n);
        for (int other = 0; other < rank; ++other)
            take_off(row, way + other * n, product(row, way + other * n, n), n);
        const double square = product(row, row, n);
        if (!(square > PARALLEL * size))
            continue;
        take_off(v, row, g / square, n);
        for (int i = 0; i < n; ++i)
            row[i] /= sqrt(square);
        ++rank;
    }
    return rank;
}

/* Events whose conditions do not change between two looks, in switches.g_inside and g_before, stay in impacts.is_level. */
static void keep_same(LagRun *run)
{
    const LagSwitches *s = &run->switches;
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int i = lag_when(run->model, k);
        run->impacts.is_level[k] &= fabs(s->g_inside[i] - s->g_before[i]) <= SAME;
    }
}

/* Whether what is held stays so where the latest look was. */
static int is_held_there(const LagRun *run)
{
    for (int j = 0; j < run->sliding.count; ++j)
        if (!(fabs(run->switches.g_inside[run->sliding.which[j]]) <= SAME))
            return 0;
    return 1;
}

/* Of candidates, those that only what is held changes, which is on their level. */
static void find(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    const int n = model->n;
    double *v = run->impacts.state;
    find_slopes(run);
    const int rank = find_directions(run);
    const double *still = s->slope;
    look(run, 0, 0, still, s->g_before);
    for (int k = 0; k < model->n_whens; ++k)
        run->impacts.is_level[k] &= fabs(s->g_before[lag_when(model, k)]) <= lag_max(s->unknown[lag_when(model, k)], EDGE);
    look(run, ASIDE, LATER, still, s->g_inside);
    if (!is_held_there(run))
        memset(run->impacts.is_level, 0, (size_t)model->n_whens * sizeof(int));
    keep_same(run);
    for (int pattern = 0; pattern < lag_conditions_patterns(n); ++pattern) {
        const int bit = pattern == 0 ? 0 : 1 << (pattern - 1);
        for (int i = 0; i < n; ++i)
            v[i] = i & bit ? -1 : 1;
        for (int j = 0; j < rank; ++j)
            take_off(v, run->impacts.level_way + j * n, product(v, run->impacts.level_way + j * n, n), n);
        for (int i = 0; i < n; ++i)
            v[i] += still[i];
        look(run, 0, 0, v, s->g_inside);
        keep_same(run);
    }
}

void lag_levels_enter(LagRun *run)
{
    LagSwitches *s = &run->switches;
    LagImpacts *impacts = &run->impacts;
    const LagModel *model = run->model;
    int some = 0;
    if (model->n_whens == 0)
        return;
    memset(impacts->is_level, 0, (size_t)model->n_whens * sizeof *impacts->is_level);
    if (run->sliding.count == 0 || model->n_delays > 0 || !model->on_level)
        return;
    look(run, 0, 0, run->motion.y + model->n, s->g_begin);
    for (int k = 0; k < model->n_whens; ++k)
        some |= impacts->is_level[k] = is_candidate(run, k);
    if (some)
        find(run);
    for (int k = 0; k < model->n_whens; ++k) {
        const int i = lag_when(model, k), is_true = model->on_level[k] & 1;
        if (!impacts->is_level[k] || is_true == s->held[i])
            continue;
        if (run->started && is_true) {
            s->turned[i] = LAG_JUMPS;
            run->segment_over = 1;
        } else
            s->held[i] = is_true;
    }
}

int lag_levels_wait(const LagRun *run, int i)
{
    const LagSwitches *s = &run->switches;
    const int k = i - lag_when(run->model, 0);
    if (run->impacts.has_contact[k] || run->model->on_level[k] != LAG_RATES_ALONE || !(fabs(s->g[i]) <= s->unknown[i]))
        return 0;
    for (int j = 0; j < lag_when(run->model, 0); ++j)
        if (s->turned[j])
            return 1;
    return 0;
}
