#include "events/edges.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "events/levels.h"
#include "events/sliding.h"
#include "numbers/extremes.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double EDGE = 64 * DBL_EPSILON; /* of what is compared: rounding of what is put where it is held is less */
static const double LATER = 0.6180339887498949; /* s */
static const double SAME = 1e-9; /* in SI units */
enum { MOVES, STANDS, CLOSED }; /* is_place: its place changes, or is not known; it is where it was; it is that of a gap */

void lag_edges_layout(LagEdges *edges, const LagModel *model, LagArena *arena)
{
    const size_t n = model->n_whens > 0 ? (size_t)model->n : 0, all = n > 0 ? (size_t)model->n_switches : 0;
    edges->is_place = lag_take_ints(arena, n > 0 ? (size_t)lag_sliding_most(model) : 0);
    edges->place = lag_take(arena, n);
    edges->state = lag_take(arena, 2 * n);
    edges->g = lag_take(arena, all);
    edges->rate = lag_take(arena, all);
}

static int is_several(const LagRun *run, int k)
{
    return !run->impacts.has_contact[k] && lag_compares_several(run->model, k);
}

static int have_several(const LagRun *run)
{
    for (int k = 0; k < run->model->n_whens; ++k)
        if (is_several(run, k))
            return 1;
    return 0;
}

/* The contact whose gap's rate is held at place j of what slides; -1: none. */
static int contact_at(const LagRun *run, int j)
{
    const int k = run->impacts.ways.which[j] - lag_contact(run->model, 0);
    return k >= 0 && run->impacts.has_contact[k] == LAG_CONTACT ? k : -1;
}

/* Into ways.left: how far rates of what is held are from where they are held, by g. Returns 0 where an impulse has moved one. */
static int find_left(LagRun *run, const double *g)
{
    LagHeldWays *ways = &run->impacts.ways;
    for (int j = 0; j < ways->count; ++j) {
        ways->left[j] = g[ways->which[j]];
        if (!(fabs(ways->left[j]) <= LAG_SLIDING_FAR * lag_sliding_drift(run, ways->which[j])))
            return 0;
    }
    return 1;
}

/* The same of places. */
static void find_left_of_places(LagRun *run, const double *q, const double *g)
{
    LagHeldWays *ways = &run->impacts.ways;
    const LagEdges *s = &run->impacts.edges;
    const int n = run->model->n;
    double *moved = run->impacts.edges.state;
    for (int i = 0; i < n; ++i)
        moved[i] = q[i] - s->place[i];
    for (int j = 0; j < ways->count; ++j)
        ways->left[j] = s->is_place[j] == CLOSED   ? g[lag_gap(run->model, contact_at(run, j))]
                        : s->is_place[j] == STANDS ? lag_held_ways_along(ways, n, j, moved)
                                                   : 0;
}

/* The state y (q, v), with conditions g, where what is held is so exactly, into edges.state. Returns 0 where it is held no more. */
static int put(LagRun *run, const double *y, const double *g)
{
    LagHeldWays *ways = &run->impacts.ways;
    const int n = run->model->n;
    double *state = run->impacts.edges.state;
    if (!find_left(run, g))
        return 0;
    memcpy(state + n, y + n, (size_t)n * sizeof *state);
    lag_held_ways_put(ways, n, state + n);
    find_left_of_places(run, y, g);
    memcpy(state, y, (size_t)n * sizeof *state);
    lag_held_ways_put(ways, n, state);
    return 1;
}

void lag_edges_decide(LagRun *run, double t, const double *y, const double *a, double *g, double *rate)
{
    LagEdges *s = &run->impacts.edges;
    const LagModel *model = run->model;
    if ((run->sliding.count > 0 && !lag_held_ways_last(run)) || !put(run, y, g))
        return;
    run->u_slope[LAG_N_U(model)] = EDGE;
    lag_conditions_by(run, t, s->state, s->state + model->n, a, s->g, s->rate);
    run->u_slope[LAG_N_U(model)] = 0;
    for (int k = 0; k < model->n_whens; ++k)
        if (is_several(run, k)) {
            g[lag_when(model, k)] = s->g[lag_when(model, k)];
            rate[lag_when(model, k)] = s->rate[lag_when(model, k)];
        }
}

/* Whether what was held is so still, where it was. */
static int is_same(const LagRun *run)
{
    const LagHeldWays *ways = &run->impacts.ways;
    const double *q = run->motion.y, *place = run->impacts.edges.place;
    for (int j = 0; j < ways->rank; ++j) {
        double along = 0;
        for (int i = 0; i < run->model->n; ++i)
            along += ways->row[i + j * run->model->n] * (q[i] - place[i]);
        if (!(fabs(along) <= SAME))
            return 0;
    }
    return 1;
}

/* Which places are held. */
static void find_places(LagRun *run)
{
    LagHeldWays *ways = &run->impacts.ways;
    LagEdges *s = &run->impacts.edges;
    const LagMotion *m = &run->motion;
    memcpy(s->state + m->n, m->y + m->n, (size_t)m->n * sizeof *s->state);
    if (find_left(run, s->g))
        lag_held_ways_put(ways, m->n, s->state + m->n);
    lag_conditions_by(run, m->t + LATER, m->y, s->state + m->n, run->switches.slope + m->n, s->g, s->rate);
    for (int j = 0; j < ways->count; ++j)
        s->is_place[j] = contact_at(run, j) >= 0 ? CLOSED : fabs(s->g[ways->which[j]]) <= SAME ? STANDS : MOVES;
}

void lag_edges_find(LagRun *run)
{
    LagEdges *s = &run->impacts.edges;
    const LagMotion *m = &run->motion;
    const int was = s->is_placed && lag_held_ways_last(run);
    s->is_in_force = s->is_placed = 0;
    if (run->sliding.count == 0 || run->model->n_delays > 0 || !have_several(run))
        return;
    lag_conditions_by(run, m->t, m->y, m->y + m->n, run->switches.slope + m->n, s->g, s->rate);
    lag_held_ways_find(run, s->g);
    if (!was || !is_same(run))
        memcpy(s->place, m->y, (size_t)m->n * sizeof *s->place);
    find_places(run);
    s->is_in_force = s->is_placed = 1;
}

void lag_edges_enter(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    if (!run->impacts.edges.is_in_force)
        return;
    lag_conditions_by(run, m->t, m->y, m->y + m->n, s->slope + m->n, s->g_inside, s->rate_inside);
    lag_edges_decide(run, m->t, m->y, s->slope + m->n, s->g_inside, s->rate_inside);
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int i = lag_when(run->model, k), is_true = s->g_inside[i] > 0;
        if (is_several(run, k) && !(fabs(s->g_inside[i]) <= s->unknown[i]) && is_true != (s->held[i] > 0))
            lag_conditions_take(run, i, is_true);
    }
}

double lag_edges_unknown(LagRun *run, int i)
{
    LagEdges *s = &run->impacts.edges;
    const LagMotion *m = &run->motion;
    double unknown = run->switches.unknown[i];
    lag_conditions_units(run, m->y, lag_conditions_rounding(run, 1), run->switches.error);
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * m->n); ++pattern) {
        lag_conditions_disturb(run, m->y, run->switches.error, pattern, s->state);
        lag_conditions_by(run, m->t, s->state, s->state + m->n, run->switches.slope + m->n, s->g, s->rate);
        unknown = lag_max(fabs(s->g[i] - run->switches.g[i]), unknown);
    }
    return unknown;
}

int lag_edges_keep(const LagRun *run, int k, double g)
{
    const double unknown = run->switches.unknown[lag_when(run->model, k)];
    return is_several(run, k) && run->started && (run->impacts.edges.is_placed || fabs(g) <= unknown);
}
