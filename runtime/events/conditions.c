#include "events/conditions.h"

#include <float.h>
#include <string.h>

#include "events/cones.h"
#include "events/loaded.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"

static const double SOME_TIME = 1e-3; /* where no step tells of one */
static const double KICKED = 100; /* errors allowed */
static const double MOST_UNKNOWN = 1e-3; /* of the margin of a force in the plane, which is 1 at most */
enum { ROUNDINGS = 256 };

void lag_conditions_by(LagRun *run, double t, const double *q, const double *v, const double *a, double *g, double *rate)
{
    lag_conditions_of_motion(run, t, q, v, a, g, rate);
    if (run->model->n_loaded > 0)
        lag_loaded_put(run, t, q, v, g);
}

void lag_conditions_at(LagRun *run, double t, const double *y, const double *a, double *g, double *rate)
{
    lag_conditions_by(run, t, y, y + run->model->n, a, g, rate);
    if (run->impacts.edges.is_in_force)
        lag_edges_decide(run, t, y, a, g, rate);
}

static void look_at(LagRun *run, double t, const double *y, double *g, double *rate)
{
    const int n = run->model->n;
    double *slope = run->switches.slope;
    const int is_held = run->sliding.count == 0 || lag_motion_slope(&run->motion, t, y, y + n, slope);
    lag_conditions_at(run, t, y, slope + n, g, rate);
    if (run->sliding.count > 0)
        lag_sliding_margins(run, is_held, g);
}

/* Of a contact, by the number of its condition, that of its gap and whether something rests: the event comes where its gap has closed
 * and all else holds; while something rests, it is over where all else fails. */
static void set_contact(int i, int gap, int rests, double *g, double *rate)
{
    if (rests) {
        g[i] = -g[i];
        rate[i] = -rate[i];
    } else if (g[gap] < g[i]) {
        g[i] = g[gap];
        rate[i] = rate[gap];
    }
}

static inline void put_far(const LagSwitches *s, int i, double *g, double *rate)
{
    g[i] = s->held[i] > 0 ? 1 : -1;
    rate[i] = 0;
}

/* Conditions that are not asked for, which none but events have where switches are live. */
static void set_far(LagRun *run, double *g, double *rate)
{
    const LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    const int whens = model->n_whens, all = model->n_switches, first = lag_when(model, 0), gaps = lag_gap(model, 0);
    const int *slides = s->slides, *has_contact = run->impacts.has_contact;
    for (int i = 0; i < first && s->is_live; ++i)
        put_far(s, i, g, rate);
    for (int k = 0; k < whens; ++k)
        if (has_contact[k])
            set_contact(first + k, gaps + k, slides[lag_contact(model, k)], g, rate);
        else if (run->impacts.is_level[k])
            put_far(s, first + k, g, rate);
    for (int i = gaps; i < all; ++i)
        if (!slides[i])
            put_far(s, i, g, rate);
}

void lag_conditions(LagRun *run, double t, const double *y, double *g, double *rate)
{
    look_at(run, t, y, g, rate);
    if (run->model->n_whens > 0)
        set_far(run, g, rate);
}

void lag_conditions_of_events(LagRun *run, double *g, double *rate)
{
    const LagMotion *m = &run->motion;
    if (run->model->switches_need_acceleration)
        lag_motion_slope(&run->motion, m->t, m->y, m->y + m->n, run->switches.slope);
    lag_conditions_at(run, m->t, m->y, run->switches.slope + m->n, g, rate);
}

void lag_conditions_with_rates(LagRun *run, double t, const double *y, double *g, double *rate)
{
    const double step = run->motion.t > run->motion.t_old ? run->motion.t - run->motion.t_old : run->step;
    if (run->model->switches_need_acceleration && run->sliding.count == 0)
        lag_motion_slope(&run->motion, t, y, y + run->model->n, run->switches.slope);
    lag_conditions(run, t, y, g, rate);
    if (run->model->n_loaded > 0)
        lag_loaded_rates(run, t, y, step > 0 ? step : SOME_TIME, g, rate);
    if (run->sliding.count > 0)
        lag_sliding_margin_rates(run, t, y, run->switches.slope, step > 0 ? step : SOME_TIME, rate);
}

void lag_conditions_units(const LagRun *run, const double *y, double share, double *error)
{
    for (int i = 0; i < 2 * run->model->n; ++i)
        error[i] = share * lag_scale_unit(&run->scale, i, y, y);
}

int lag_conditions_patterns(int components)
{
    int count = 1;
    while (count < LAG_PATTERNS && 1 << (count - 1) < components)
        ++count;
    return count;
}

void lag_conditions_disturb(const LagRun *run, const double *y, const double *error, int pattern, double *state)
{
    const int bit = pattern == 0 ? 0 : 1 << (pattern - 1);
    for (int i = 0; i < 2 * run->model->n; ++i)
        state[i] = i & bit ? y[i] - error[i] : y[i] + error[i];
    for (int k = 0; k < run->model->n_kept; ++k) {
        const int i = run->model->n + run->model->kept[k];
        state[i] = y[i];
    }
}

void lag_conditions_find_unknown(LagRun *run, double t, const double *y)
{
    LagSwitches *s = &run->switches;
    const LagScale scale = run->scale;
    const double share = ROUNDINGS * DBL_EPSILON / scale.tolerance;
    if (run->model->switches_need_acceleration) /* a slip is known as well where it stops, in steps as short as can be, as anywhere */
        run->scale.rate_rounding = run->scale.step = run->scale.reach = 0;
    memset(s->unknown, 0, (size_t)run->model->n_switches * sizeof *s->unknown);
    look_at(run, t, y, s->g_begin, s->rate_begin); /* which the next step begins with anew */
    lag_conditions_units(run, y, share, s->error);
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * run->model->n); ++pattern) {
        lag_conditions_disturb(run, y, s->error, pattern, s->state);
        look_at(run, t, s->state, s->g_inside, s->rate_inside);
        for (int i = 0; i < run->model->n_switches; ++i)
            s->unknown[i] = lag_max(fabs(s->g_inside[i] - s->g_begin[i]), s->unknown[i]);
    }
    run->scale = scale;
    for (int k = 0; k < run->sliding.count; ++k)
        s->unknown[run->sliding.which[k]] = lag_min(MOST_UNKNOWN, s->unknown[run->sliding.which[k]]);
    for (int k = 0; k < run->model->n_whens; ++k) { /* the events of contacts are those of their gaps, too */
        double *unknown = &s->unknown[lag_when(run->model, k)];
        *unknown = lag_max(s->unknown[lag_gap(run->model, k)], *unknown);
    }
}

double lag_conditions_error(const LagRun *run, double unknown)
{
    return unknown * run->scale.tolerance / (ROUNDINGS * DBL_EPSILON);
}

double lag_conditions_rounding(const LagRun *run, double error) { return error / run->scale.tolerance * (ROUNDINGS * DBL_EPSILON); }

void lag_conditions_note_kick(LagRun *run, int i)
{
    LagSwitches *s = &run->switches;
    const int may_be = run->model->n_whens > 0 && run->model->switches_need_acceleration && i < lag_when(run->model, 0);
    const double before = may_be && run->impacts.coarse > 0 ? run->sliding.before[i] : 0; /* an importer's steps go past it, too */
    if (may_be && s->turned[i] == LAG_CHANGES && !s->slides[i] && fabs(s->g[i]) > lag_max(KICKED * run->sliding.error[i], before))
        s->turned[i] = s->g[i] > 0 ? LAG_TO_1 : LAG_TO_0;
}

void lag_conditions_come(LagRun *run, int i)
{
    run->switches.turned[i] = LAG_JUMPS;
    run->segment_over = run->impacts.comes_next = 1;
}

void lag_conditions_take(LagRun *run, int i, int is_true)
{
    if (run->started && is_true)
        lag_conditions_come(run, i);
    else
        run->switches.held[i] = is_true;
}
