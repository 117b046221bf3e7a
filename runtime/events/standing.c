#include "events/standing.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "events/sliding.h"
#include "events/switches.h"
#include "numbers/extremes.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double OF_SINE = 1e-12; /* of pi times a number that is whole */
static const double LEAST = 1e-290; /* where both sides are equal, levels of what jumps are less: EDGE of levels.py */
enum { ROUNDINGS = 64 }; /* last digits of a coordinate, which are its own: what is far away has larger ones */
static const double MOMENT = 1e-3, SOME_TIME = 1e-6; /* of a step; s, where no step tells of one */

double lag_standing_value(const LagModel *model, int i)
{
    const int level = i < lag_when(model, 0) ? model->at_level[i] : LAG_LEVEL_EITHER;
    return level == LAG_LEVEL_EITHER || level == LAG_LEVEL_WHOLE ? 0.5 : 0.5 * level;
}

double lag_standing_alone(const LagModel *model, int i, double g)
{
    const int is_sided = i < lag_when(model, 0) && model->at_level[i] != LAG_LEVEL_EITHER;
    return fabs(g) <= (is_sided ? LEAST : 0) ? lag_standing_value(model, i) : g > 0;
}

/* How far the condition of switch i may be from its level on it. */
static double known_of(const LagRun *run, int i)
{
    return lag_max(run->model->at_level[i] == LAG_LEVEL_WHOLE ? OF_SINE : LEAST, run->switches.unknown[i]);
}

/* What is held has no rate but rounding, nor has what is balanced, which does not leave by it in a run. */
static int is_still(const LagRun *run, int i, double rate)
{
    const LagSettings *settings = &run->settings;
    const double lasts = isfinite(settings->t_stop) ? settings->t_stop - settings->t_start : lag_max(1, fabs(run->motion.t));
    const double rounding = run->switches.rounding[i];
    return run->sliding.count > 0 ? fabs(rate) <= lag_max(known_of(run, i), rounding) : fabs(rate) * lasts <= lag_max(LEAST, rounding);
}

/* Whether it is so a moment later, too. */
static int stays_still(const LagRun *run, int i)
{
    const double rate = run->switches.rate_inside[i], change = rate - run->switches.rate[i];
    return is_still(run, i, rate) && (run->sliding.count > 0 || fabs(change) <= fabs(run->switches.rate[i]));
}

/* Whether switch i is on its level where its condition is g, and was not let go to one side of it. */
static int is_candidate(const LagRun *run, int i, double g)
{
    const LagSwitches *s = &run->switches;
    if (s->turned[i] == LAG_TO_0 || s->turned[i] == LAG_TO_1)
        return 0;
    return run->model->at_level[i] != LAG_LEVEL_EITHER && !s->slides[i] && !s->is_idle[i] && fabs(g) <= known_of(run, i);
}

/* A length of time that is short by that of steps. */
static double moment_of(const LagRun *run)
{
    return lag_min(run->step > 0 ? MOMENT * run->step : SOME_TIME, MOMENT * (run->segment_end - run->motion.t));
}

/* The last digits of each coordinate, which are its own, into switches.error. */
static void find_last_digits(LagRun *run)
{
    for (int i = 0; i < 2 * run->motion.n; ++i)
        run->switches.error[i] = ROUNDINGS * DBL_EPSILON * fabs(run->motion.y[i]);
}

/* By how much switches.error of a state changes its conditions, which are g there, or by rates their rates: `most` becomes at least that.
 * Uses switches.state, .g_begin and .rate_begin, which the next step begins with anew. */
static void note_changes(LagRun *run, double t, const double *y, const double *g, int by_rates, double *most)
{
    LagSwitches *s = &run->switches;
    const int n = run->motion.n;
    const double *const found = by_rates ? s->rate_begin : s->g_begin;
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * n); ++pattern) {
        lag_conditions_disturb(run, y, s->error, pattern, s->state);
        lag_conditions_by(run, t, s->state, s->state + n, s->slope + n, s->g_begin, s->rate_begin);
        for (int i = 0; i < lag_when(run->model, 0); ++i)
            most[i] = lag_max(fabs(found[i] - g[i]), most[i]);
    }
}

/* By how much last digits change conditions that may stand, or their rates where something slides, into switches.rounding. */
static void find_rounding(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    const int slides = run->sliding.count > 0;
    int some = 0;
    memset(s->rounding, 0, (size_t)run->model->n_switches * sizeof *s->rounding);
    for (int i = 0; i < lag_when(run->model, 0); ++i)
        some |= is_candidate(run, i, s->g[i]);
    if (!some)
        return;
    find_last_digits(run);
    note_changes(run, m->t, m->y, slides ? s->rate : s->g, slides, s->rounding);
}

void lag_standing_know(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    double *most = s->g_before;
    if (!lag_standing_is_held(run))
        return;
    lag_conditions_by(run, m->t, m->y, m->y + m->n, s->slope + m->n, s->g_inside, s->rate_inside);
    memset(most, 0, (size_t)run->model->n_switches * sizeof *most);
    find_last_digits(run);
    note_changes(run, m->t, m->y, s->g_inside, 0, most);
    for (int i = 0; i < lag_when(run->model, 0); ++i)
        if (s->stands[i])
            s->unknown[i] = lag_max(most[i], s->unknown[i]);
}

/* What may stand: what has no rate but rounding, or has one side's where its condition has a corner, and is not off its level a moment
 * later. Into switches.stands; returns whether there are some. */
static int find_candidates(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    const int n = m->n;
    int some = 0, quick = 0;
    find_rounding(run);
    for (int i = 0; i < lag_when(run->model, 0) && !s->is_live; ++i) {
        const int may = is_candidate(run, i, s->g[i]);
        s->stands[i] = may && is_still(run, i, s->rate[i]);
        some |= s->stands[i];
        quick |= may && !s->stands[i];
    }
    if (!quick)
        return some;
    const double moment = moment_of(run);
    memcpy(s->state + n, m->y + n, (size_t)n * sizeof *s->state);
    for (int i = 0; i < n; ++i)
        s->state[i] = m->y[i] + moment * m->y[n + i];
    lag_conditions_by(run, m->t + moment, s->state, s->state + n, s->slope + n, s->g_inside, s->rate_inside);
    for (int i = 0; i < lag_when(run->model, 0); ++i) {
        s->stands[i] |= is_candidate(run, i, s->g[i]) && is_candidate(run, i, s->g_inside[i]);
        some |= s->stands[i];
    }
    return some;
}

/* Last digits of the shares of what slides, as accelerations, into switches.noise. */
static void find_noise_of_shares(LagRun *run)
{
    const LagSliding *s = &run->sliding;
    const int n = run->model->n;
    double *noise = run->switches.noise;
    memset(noise, 0, (size_t)n * sizeof *noise);
    for (int k = 0; k < s->count; ++k)
        for (int i = 0; i < n; ++i)
            noise[i] += ROUNDINGS * DBL_EPSILON * fabs(s->way[i + k * n]) * lag_max(s->unit[k], fabs(*lag_share(run, s->which[k])));
}

/* Accelerations at t, into switches.slope, of which those are none that last digits of the present state and of shares make, which is
 * switches.noise: forces may be balanced. */
static void find_accelerations(LagRun *run, double t)
{
    LagSwitches *s = &run->switches;
    LagMotion *m = &run->motion;
    const int n = m->n;
    double *a = s->slope + n, *noise = s->noise;
    lag_motion_slope(m, t, m->y, m->y + n, s->slope);
    find_noise_of_shares(run);
    find_last_digits(run);
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * n); ++pattern) {
        lag_conditions_disturb(run, m->y, s->error, pattern, s->state);
        if (!lag_motion_slope(m, t, s->state, s->state + n, m->sum))
            continue;
        for (int i = 0; i < n; ++i)
            noise[i] = lag_max(fabs(m->sum[n + i] - a[i]), noise[i]);
    }
    for (int i = 0; i < n; ++i)
        a[i] = fabs(a[i]) <= noise[i] ? 0 : a[i];
}

/* By how much noise of accelerations changes rates a moment later, at switches.state, where something slides: into switches.rounding. */
static void find_noise_of_rates(LagRun *run, double moment)
{
    LagSwitches *s = &run->switches;
    const int n = run->motion.n;
    double *there = run->sliding.state_here;
    memcpy(there, s->state, 2 * (size_t)n * sizeof *there);
    for (int i = 0; i < n; ++i) {
        s->error[i] = 0;
        s->error[n + i] = ROUNDINGS * DBL_EPSILON * fabs(there[n + i]) + moment * s->noise[i];
    }
    note_changes(run, run->motion.t + moment, there, s->rate_inside, 1, s->rounding);
}

/* The rates of all conditions a moment later, into switches.rate_inside. */
static void look_ahead(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    const int n = m->n;
    const double moment = moment_of(run);
    const double *a = s->slope + n;
    find_accelerations(run, m->t + moment);
    for (int i = 0; i < n; ++i) {
        s->state[i] = m->y[i] + moment * (m->y[n + i] + moment * a[i] / 2);
        s->state[n + i] = m->y[n + i] + moment * a[i];
    }
    lag_conditions_by(run, m->t + moment, s->state, s->state + n, a, s->g_inside, s->rate_inside);
    if (run->sliding.count > 0)
        find_noise_of_rates(run, moment);
}

int lag_standing_find(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const int first = lag_when(run->model, 0);
    int changes = 0;
    memset(s->stands, 0, (size_t)run->model->n_switches * sizeof *s->stands);
    const int some = find_candidates(run);
    if (some)
        look_ahead(run);
    for (int i = 0; i < first && some; ++i) {
        if (!s->stands[i])
            continue;
        s->stands[i] = stays_still(run, i);
        const double goes = is_still(run, i, s->rate[i]) ? s->rate_inside[i] > 0 : s->held[i];
        const double held = s->stands[i] ? lag_standing_value(run->model, i) : goes;
        changes |= held != s->held[i];
        s->held[i] = held;
    }
    if (changes)
        lag_switches_recall(run);
    return changes;
}

void lag_standing_rest(LagRun *run)
{
    for (int k = 0; k < run->model->n_rests; ++k)
        if (run->switches.stands[run->model->rests[k]])
            *lag_rest(run, k) = 1;
}

int lag_standing_some(const LagRun *run)
{
    for (int i = 0; i < lag_when(run->model, 0); ++i)
        if (run->switches.stands[i])
            return 1;
    return 0;
}

int lag_standing_is_held(const LagRun *run) { return run->sliding.count > 0 && lag_standing_some(run); }

int lag_standing_lasts(const LagRun *run, int i)
{
    const LagSwitches *s = &run->switches;
    return s->stands[i] && is_candidate(run, i, s->g[i]) && is_still(run, i, s->rate[i]);
}
