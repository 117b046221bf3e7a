/* What compares nothing but what is held is told numerically: directions of rates that change what is held are taken off the others, and a
 * condition that none of these changes, nor time and places that change so, is as far from its level as it is where all that is held is
 * exactly so. What is held must be so at these places and times, too, where it is the rate of a place then. Where loops tie rates, only
 * what follows from what is held alone is found.
 */
#include "events/levels.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "numbers/extremes.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double SAME = 1e-9;   /* of changes by rates of 1 in SI units: conditions are compared by these */
static const double ASIDE = 0.03;  /* of a way of 1 m, or rad */
static const double LATER = 0.6180339887498949, LATER_BY = 0.41421356237309503; /* s: no periods that anything has */
static const double SPREAD = 0.7320508075688772; /* of sizes of rates */
static const double EDGE = 1e-290; /* where both sides of <= are equal, levels are less */

static int is_candidate(const LagRun *run, int k)
{
    const int on_level = run->model->on_level[k], is_one = on_level >= LAG_RATES_ALONE || on_level == LAG_PLACES_ALONE;
    return !run->impacts.has_contact[k] && is_one && !lag_compares_several(run->model, k);
}

/* All conditions at places q[n] and rates v[n], so much later. */
static void look(LagRun *run, double later, const double *q, const double *v, double *g)
{
    LagSwitches *s = &run->switches;
    lag_conditions_by(run, run->motion.t + later, q, v, s->slope + run->model->n, g, s->rate_inside);
}

/* Directions of what is held, and rates at which all of it is none, into switches.slope. */
static void find_held(LagRun *run)
{
    LagHeldWays *ways = &run->impacts.ways;
    const int n = run->model->n;
    lag_held_ways_find(run, run->switches.g_begin);
    for (int j = 0; j < ways->count; ++j)
        ways->left[j] = run->switches.g_begin[ways->which[j]];
    memcpy(run->switches.slope, run->motion.y + n, (size_t)n * sizeof *run->switches.slope);
    lag_held_ways_put(ways, n, run->switches.slope);
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

/* Rates that leave what is held as it is, into v (n), and places that they lead to into switches.state. */
static void go_free(LagRun *run, int pattern, double *v)
{
    const int n = run->model->n, bit = pattern == 0 ? 0 : 1 << (pattern - 1);
    for (int i = 0; i < n; ++i) { /* as no sums, products or squares are alike in all patterns */
        const double size = 0.5 + fmod(SPREAD * (i + 1) + LATER_BY * (pattern + 1), 1);
        v[i] = i & bit ? -size : size;
    }
    lag_held_ways_leave(&run->impacts.ways, n, v);
    for (int i = 0; i < n; ++i) {
        run->switches.state[i] = run->motion.y[i] + ASIDE * v[i];
        v[i] += run->switches.slope[i];
    }
}

/* Of candidates, those that only what is held changes, which is on their level. */
static void find(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    double *v = run->impacts.state;
    find_held(run);
    look(run, 0, run->motion.y, s->slope, s->g_before);
    for (int k = 0; k < model->n_whens; ++k)
        run->impacts.is_level[k] &= fabs(s->g_before[lag_when(model, k)]) <= lag_max(s->unknown[lag_when(model, k)], EDGE);
    for (int pattern = -1; pattern < lag_conditions_patterns(model->n); ++pattern) {
        go_free(run, pattern < 0 ? 0 : pattern, v);
        look(run, LATER + pattern * LATER_BY, s->state, pattern < 0 ? s->slope : v, s->g_inside);
        if (!is_held_there(run))
            memset(run->impacts.is_level, 0, (size_t)model->n_whens * sizeof(int));
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
    look(run, 0, run->motion.y, run->motion.y + model->n, s->g_begin);
    for (int k = 0; k < model->n_whens; ++k)
        some |= impacts->is_level[k] = is_candidate(run, k);
    if (some)
        find(run);
    for (int k = 0; k < model->n_whens; ++k) {
        const int i = lag_when(model, k), is_true = model->on_level[k] & 1;
        if (impacts->is_level[k] && is_true != s->held[i] && model->on_level[k] != LAG_PLACES_ALONE)
            lag_conditions_take(run, i, is_true);
    }
}

int lag_levels_wait(LagRun *run, int i)
{
    const LagSwitches *s = &run->switches;
    const int k = i - lag_when(run->model, 0), on_level = run->model->on_level[k], several = lag_compares_several(run->model, k);
    const int is_one = on_level == LAG_RATES_ALONE || on_level == LAG_PLACES_ALONE;
    int turns = 0;
    for (int j = 0; j < lag_when(run->model, 0); ++j)
        turns |= s->turned[j] != LAG_STAYS;
    return turns && !run->impacts.has_contact[k] && (is_one || several) &&
           fabs(s->g[i]) <= (several ? lag_edges_unknown(run, i) : s->unknown[i]);
}

int lag_levels_meet(LagRun *run, int k, double g)
{
    const int is_on_it = g <= EDGE && run->model->on_level[k] >= LAG_RATES_ALONE && !lag_compares_several(run->model, k);
    return run->started && g > 0 && (is_on_it || lag_levels_wait(run, lag_when(run->model, k)));
}
