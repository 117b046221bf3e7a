/* Accelerations keep what is held only as well as steps follow them: errors of a support's motion, and rounding, add up. What lies has a
 * gap of 0. What sticks has a rate of 0, and where that is the rate of a place, the place at which it was held: between two states the
 * place changes by the integral of that rate along any way between them, so that of the straight one tells what a step got wrong. A rate
 * that no place has (a wheel that turns on the spot) gives different integrals along different ways, and is all that is put back then.
 * States are moved along the ways of the forces that hold, which are linear in the shares (sliding.h).
 */
#include "state/holds.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "state/state.h"

enum { NODES = 7, MOST_TURNS = 3 };
/* Of Gauss's quadrature: M. Abramowitz, I.A. Stegun, Handbook of mathematical functions, table 25.4. */
static const double NODE[NODES] = {-0.949107912342758525, -0.741531185599394440, -0.405845151377397167, 0,
                                   0.405845151377397167, 0.741531185599394440, 0.949107912342758525};
static const double WEIGHT[NODES] = {0.129484966168869693, 0.279705391489276668, 0.381830050505118945, 0.417959183673469388,
                                     0.381830050505118945, 0.279705391489276668, 0.129484966168869693};
static const double ROUND_TRIP = 0.03; /* of the largest positions so far */
static const double CLOSED = 1e-10;    /* of the ways there and back: rounding, and quadrature */
static const double ASTRAY = 100;      /* units of error: as in project.c */
static const double SQUARE_IS_ROUNDING = 1e-8; /* of a correction, by the size of what is corrected */
static const double MOMENT = 1e-3;     /* s, where no step tells of one */
static const double FAINT = 4 * DBL_EPSILON; /* of the sizes of coordinates: the work of moving them so far is rounding */
static const double CANCELLED = 16 * DBL_EPSILON; /* of two that are equal and opposite */
static const double ROUNDING = 4096 * DBL_EPSILON; /* of gaps, by their sizes: stiff springs would make much of putting it right */

/* g at (t, q, v) into sliding.g. */
static void find_g(LagRun *run, double t, const double *q, const double *v)
{
    lag_conditions_of_motion(run, t, q, v, run->switches.slope + run->model->n, run->sliding.g, run->sliding.rate);
}

/* Integrals of g of those held along the straight way from one (t, q) to another, into sum; and of |g|, if asked for. */
static void integrate(LagRun *run, double t_from, const double *from, double t, const double *q, double *sum, double *size)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    const double h = t - t_from;
    double *here = s->state_here;
    for (int k = 0; k < s->count; ++k)
        sum[k] = 0;
    for (int node = 0; node < NODES && h != 0; ++node) {
        const double share = (1 + NODE[node]) / 2;
        for (int i = 0; i < n; ++i) {
            here[i] = from[i] + share * (q[i] - from[i]);
            here[n + i] = (q[i] - from[i]) / h;
        }
        find_g(run, t_from + share * h, here, here + n);
        for (int k = 0; k < s->count; ++k) {
            const double part = h * WEIGHT[node] / 2 * s->g[s->which[k]];
            sum[k] += part;
            if (size)
                size[k] += fabs(part);
        }
    }
}

/* Corner `corner` of a way round from q at t, of the size of motions so far. */
static double find_corner(LagRun *run, int corner, double t, const double *q, double *place)
{
    const double step = run->step > 0 && run->step < INFINITY ? run->step : MOMENT, size = lag_min(step, 1);
    for (int i = 0; i < run->model->n; ++i) {
        const double largest = run->scale.cap[i] < INFINITY || run->scale.largest[i] == 0 ? 1 : run->scale.largest[i];
        place[i] = q[i] + (corner == 0 ? 0 : ROUND_TRIP * largest * sin(1 + corner * (2 * i + 1)));
    }
    return t + (corner == 0 ? 0 : corner == 1 ? size : -0.4 * size);
}

/* Which of those held that are not known yet are rates of places: integrals vanish all the way round. */
static void find_places(LagRun *run)
{
    LagSliding *s = &run->sliding;
    const LagMotion *m = &run->motion;
    double *from = s->state_before, *to = s->slope_before, *round = s->drift, *size = s->drift + s->most;
    memset(round, 0, 2 * (size_t)s->most * sizeof *round);
    double t_from = find_corner(run, 0, m->t, m->y, from);
    for (int corner = 1; corner <= 3; ++corner) {
        const double t = find_corner(run, corner % 3, m->t, m->y, to);
        integrate(run, t_from, from, t, to, s->change, size);
        for (int k = 0; k < s->count; ++k)
            round[k] += s->change[k];
        t_from = t;
        lag_swap(&from, &to);
    }
    for (int k = 0; k < s->count; ++k)
        if (s->holds[s->which[k]] == LAG_HELD_UNKNOWN)
            s->holds[s->which[k]] = fabs(round[k]) <= CLOSED * size[k] ? LAG_HELD_PLACE : LAG_HELD_RATE;
}

/* Rates that are not linear in those of coordinates are left alone: half of the state's and none tell. */
static void find_bent(LagRun *run)
{
    LagSliding *s = &run->sliding;
    const LagMotion *m = &run->motion;
    const int n = m->n;
    double *v = s->state_here, *g = s->drift;
    for (int k = 0; k < s->count; ++k)
        g[k] = 0;
    for (int turn = -1; turn <= 1; ++turn) {
        for (int i = 0; i < n; ++i)
            v[i] = m->y[n + i] + turn * (1 + fabs(m->y[n + i])) * sin(1 + i);
        find_g(run, m->t, m->y, v);
        for (int k = 0; k < s->count; ++k)
            g[k] += turn == 0 ? -2 * s->g[s->which[k]] : s->g[s->which[k]];
    }
    for (int k = 0; k < s->count; ++k)
        if (s->holds[s->which[k]] == LAG_HELD_UNKNOWN && !(fabs(g[k]) <= CLOSED * (fabs(s->g[s->which[k]]) + 1)))
            s->holds[s->which[k]] = LAG_HELD_NEITHER;
}

/* The gap of what lies; -1: it does not. */
static int gap_of(const LagRun *run, int i)
{
    const int k = i - lag_contact(run->model, 0);
    return k >= 0 && run->impacts.has_contact[k] == LAG_CONTACT ? lag_gap(run->model, k) : -1;
}

void lag_holds_enter(LagRun *run)
{
    LagSliding *s = &run->sliding;
    int some = 0;
    for (int k = 0; k < s->count; ++k) {
        int *holds = &s->holds[s->which[k]];
        *holds = gap_of(run, s->which[k]) >= 0 ? LAG_HELD_PLACE : *holds;
        some |= *holds == LAG_HELD_UNKNOWN;
    }
    if (!some)
        return;
    find_bent(run);
    find_places(run);
}

/* How g of those held changes along the ways at a state: into the factors of `held`. */
static void factor(LagRun *run, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n, count = s->count;
    double *v = s->state_here;
    memset(v, 0, (size_t)n * sizeof *v);
    find_g(run, t, y, v);
    for (int k = 0; k < count; ++k)
        s->change[k] = s->g[s->which[k]];
    s->held.size = count;
    for (int j = 0; j < count; ++j) {
        for (int i = 0; i < n; ++i)
            v[i] = s->unit[j] * s->way[i + j * n];
        find_g(run, t, y, v);
        for (int k = 0; k < count; ++k)
            s->held.re[k + j * count] = s->g[s->which[k]] - s->change[k];
    }
    lag_dense_lu_factor(&s->held);
}

/* Moves y (n) so that what is `left` (count) goes. Returns how far, by the sizes of what is moved; infinity where that is too far. */
static double move(LagRun *run, int first, const double *now, double *left, double *y, double *carry)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    double largest = 0;
    lag_dense_lu_solve(&s->held, left, NULL);
    memset(s->state_here, 0, (size_t)n * sizeof *y);
    for (int j = 0; j < s->count; ++j)
        for (int i = 0; i < n; ++i)
            s->state_here[i] -= left[j] * s->unit[j] * s->way[i + j * n];
    for (int i = 0; i < n; ++i) {
        const double change = fabs(s->state_here[i]), size = lag_max(run->scale.largest[first + i], fabs(y[first + i]));
        if (!(change <= ASTRAY * lag_scale_unit(&run->scale, first + i, now, y)))
            return INFINITY;
        largest = change > 0 ? lag_max(change / size, largest) : largest;
    }
    for (int i = 0; i < n; ++i) {
        const double before = y[first + i], step = s->state_here[i] + carry[first + i], after = before + step, taken = after - before;
        const int is_rounding = fabs(after) <= CANCELLED * fabs(step); /* of what is held at 0 */
        y[first + i] = is_rounding ? 0 : after;
        carry[first + i] = is_rounding ? 0 : (before - (after - taken)) + (step - taken);
    }
    return largest;
}

/* Whether something sticks at a place. */
static int sticks(const LagRun *run)
{
    const LagSliding *s = &run->sliding;
    int some = 0;
    for (int k = 0; k < s->count; ++k)
        some |= s->holds[s->which[k]] == LAG_HELD_PLACE && gap_of(run, s->which[k]) < 0;
    return some;
}

/* Whether the forces of what sticks are those that hold: at places where they are looked for they may be any. */
static int are_known(const LagRun *run)
{
    const LagSliding *s = &run->sliding;
    const double *share = run->d + run->model->n_modes;
    const int contacts = lag_contact(run->model, 0);
    for (int k = 0; k < s->count; ++k)
        if (s->which[k] < contacts && !(share[s->which[k]] >= 0 && share[s->which[k]] <= 1))
            return 0;
    return 1;
}

/* A gap, unless that is rounding. */
static double gap_left(const LagRun *run, int gap)
{
    const LagSliding *s = &run->sliding;
    return fabs(s->g[gap]) <= ROUNDING * s->error[gap] / run->scale.tolerance ? 0 : s->g[gap];
}

/* How far places are from where they were, into drift. */
static void find_drift(LagRun *run, double t_from, const double *from, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    if (sticks(run))
        integrate(run, t_from, from, t, y, s->drift, NULL);
    find_g(run, t, y, y + run->model->n);
    for (int k = 0; k < s->count; ++k) {
        const int gap = gap_of(run, s->which[k]);
        s->drift[k] = gap >= 0 ? gap_left(run, gap) : s->holds[s->which[k]] == LAG_HELD_PLACE ? s->drift[k] : 0;
    }
}

/* Returns how far they are moved, as `move` does. */
static double move_places(LagRun *run, double t_from, const double *from, double t, double *y, double *carry)
{
    double moved = INFINITY, most = 0;
    for (int turn = 0; turn < MOST_TURNS && (turn == 0 || (moved > SQUARE_IS_ROUNDING && moved < INFINITY)); ++turn) {
        find_drift(run, t_from, from, t, y);
        moved = move(run, 0, from, run->sliding.drift, y, carry);
        most = moved < INFINITY ? lag_max(moved, most) : most;
    }
    return most;
}

/* What forces have done on the way that is undone from `before` (n) to y is taken out of the account: where that is short their power is
 * odd in rates, and that of dampers even. */
static void take_back_work(LagRun *run, double t, const double *before, double *y)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n, count = s->count;
    double *way = s->state_here, *slope = s->slope_before;
    for (int i = 0; i < n; ++i)
        way[i] = y[i] - before[i];
    s->count = 0; /* as the shares say */
    for (int sign = 1; sign >= -1; sign -= 2) {
        for (int i = 0; i < n; ++i)
            way[n + i] = sign * way[i];
        if (lag_motion_slope(&run->motion, t, y, way + n, slope))
            for (int k = 2 * n; k < run->motion.size; ++k)
                y[k] += sign * slope[k] / 2;
    }
    s->count = count;
}

void lag_holds_project(LagRun *run, double t_from, const double *from, double t, double *y, double *carry)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    if (s->count == 0 || run->switches.is_live || run->rests || !(t > t_from))
        return;
    factor(run, t, y);
    memcpy(s->state_before, y, (size_t)n * sizeof *y);
    const double moved = move_places(run, t_from, from, t, y, carry);
    if (run->model->n_power == 2 && moved > FAINT && sticks(run) && are_known(run))
        take_back_work(run, t, s->state_before, y);
    find_g(run, t, y, y + n);
    for (int k = 0; k < s->count; ++k)
        s->drift[k] = s->holds[s->which[k]] == LAG_HELD_NEITHER ? 0 : s->g[s->which[k]];
    move(run, n, from, s->drift, y, carry);
}

void lag_holds_inside(LagRun *run, double t, double *y)
{
    const LagMotion *m = &run->motion;
    if (run->sliding.count == 0 || t == m->t)
        return;
    memset(run->inside_carry, 0, 2 * (size_t)run->model->n * sizeof *y);
    lag_holds_project(run, m->t_old, m->other, t, y, run->inside_carry);
}
