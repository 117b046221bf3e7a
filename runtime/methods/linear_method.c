/* A step leads to the next row, event or corner of the inputs. Whichever is cheaper takes it there: the series, or rungs of
 * the ladder and the series for the rest. A rung for a length of step is built when the series has cost as much for steps of
 * this length as building it does: never more than twice the least effort.
 *
 * Times that are meant to be equally far apart are so but for rounding. The state then moves by equal steps and lags behind
 * its time by no more than the time's own rounding, which does not add up, and is made up for at the end of a segment.
 */
#include "methods/linear_method.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "steps/step.h"

static const double SAME = 1e-9, IGNORED = 4 * DBL_EPSILON;
static const double PACE = 0.4; /* what a step of many equal ones costs, in rungs: many go in plain doubles */
enum { EQUAL_STEPS = 16 }; /* so many, and more of larger scenes, make it likely that enough follow */

static const LagRun *run_of(const LagMotion *m) { return m->context; }

static void powers(void *context, double t, const double *q, double *v, double *power)
{
    LagRun *run = context;
    lag_accelerations(run, t, q, v, run->acceleration, power);
}

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    LagLinearMethod *s = self;
    const LagModel *model = run_of(m)->model;
    lag_linear_system_layout(&s->system, model, arena);
    const size_t size = (size_t)s->system.size, n_w = (size_t)s->system.n_w;
    s->has_ladder = lag_ladder_possible(model);
    if (s->has_ladder)
        lag_ladder_layout(&s->ladder, &s->system, arena);
    if (s->has_ladder)
        lag_pace_layout(&s->pace, &s->ladder, arena);
    lag_series_layout(&s->series, &s->system, model->n_power, arena);
    s->series.powers = powers;
    s->series.context = m->context;
    s->x = lag_dds_take(arena, size);
    s->moved = lag_dds_take(arena, size);
    s->loads = lag_dds_take(arena, n_w);
    s->loads_old = lag_dds_take(arena, n_w);
}

static void restart(void *self, LagMotion *m)
{
    LagLinearMethod *s = self;
    (void)m;
    s->is_fresh = 1;
}

/* Equations and loads of the segment that begins. Returns 0 when the mass matrix is not positive definite. */
static int begin(LagLinearMethod *s, LagRun *run)
{
    int is_new;
    s->is_fresh = 0;
    s->equal_steps = 0;
    if (run->statistics.steps == 0)
        s->lag = lag_dd(0);
    if (!lag_linear_system_build(&s->system, run->p, run->d, &is_new))
        return 0;
    if (is_new) {
        if (s->has_ladder)
            lag_ladder_reset(&s->ladder, &s->system);
        lag_series_reset(&s->series, &s->system, s->has_ladder ? s->ladder.norm : 0);
        s->usual = s->spent = 0;
    }
    lag_linear_system_loads(&s->system, &run->inputs, run->motion.t, run->d, run->u, s->loads);
    return 1;
}

static int is_same(double a, double b) { return fabs(a - b) <= SAME * b; }

/* Whether rungs are to be used for a step of length h, after noting what it costs. */
static int ladder_pays(LagLinearMethod *s, double h)
{
    if (!s->has_ladder)
        return 0;
    const double by_series = lag_series_cost(&s->series, h), rung = PACE * lag_ladder_cost_of_rung(&s->ladder);
    if (is_same(h, s->ladder.base))
        return rung < by_series;
    if (!is_same(h, s->usual)) {
        s->usual = h;
        s->times = 0;
        s->spent = s->span = 0;
    }
    ++s->times;
    s->span += h;
    s->spent += by_series;
    if (s->spent > lag_ladder_cost(&s->ladder, h) && rung < by_series) {
        lag_ladder_set_base(&s->ladder, s->span / s->times); /* free of most of the rounding of times */
        return 1;
    }
    return s->ladder.base > 0 && s->ladder.built > 0
        && lag_ladder_cost_of_rung(&s->ladder) * (2 + log2(fmax(1, h / s->ladder.length[0]))) < by_series;
}

static void swap(LagDDs *a, LagDDs *b)
{
    const LagDDs c = *a;
    *a = *b;
    *b = c;
}

/* s->x moves on by h from the time t, but for a rest of at most `ignored`, which is left in *lag. */
static int move(LagLinearMethod *s, double t, LagDD h, double ignored, LagDD *integrals, LagDD *lag)
{
    *lag = lag_dd(0);
    if (s->has_ladder && !lag_ladder_reaches(&s->ladder, h.hi))
        return 0;
    if (h.hi > 0 && ladder_pays(s, h.hi)) { /* a row where the step began lies 0 away: rungs of no length lead nowhere */
        for (int rung = lag_ladder_find(&s->ladder, h.hi); rung >= 0; rung = lag_ladder_find(&s->ladder, h.hi)) {
            const double length = s->ladder.length[rung];
            lag_ladder_climb(&s->ladder, rung, s->x, s->moved, integrals);
            swap(&s->x, &s->moved);
            h = lag_dd_sub(h, lag_dd(length));
            t += length;
        }
    }
    if (fabs(h.hi) <= ignored) {
        *lag = h;
        return 1;
    }
    const int is_done = lag_series_move(&s->series, &s->system, t, h, s->x, s->moved, integrals);
    swap(&s->x, &s->moved);
    return is_done;
}

static void fill(LagLinearMethod *s, const LagMotion *m, const double *y, const double *carry, LagDDs loads)
{
    const size_t states = 2 * (size_t)m->n;
    memcpy(s->x.hi, y, states * sizeof *y);
    memcpy(s->x.lo, carry, states * sizeof *y);
    lag_dds_copy(loads, lag_dds_from(s->x, states), (size_t)s->system.n_w);
}

typedef struct {
    const double *y, *carry;
    LagDDs loads;
    double t;
    LagDD lag;
} Place;

/* The state there, moved to the time t, in s->x; the quadratures with their integrals. */
static int move_from(LagLinearMethod *s, LagMotion *m, Place from, double t, double ignored, LagDD *quadratures, LagDD *lag)
{
    const size_t states = 2 * (size_t)m->n;
    fill(s, m, from.y, from.carry, from.loads);
    for (int i = 0; i < m->size - 2 * m->n; ++i)
        quadratures[i] = lag_dd_sum(from.y[states + (size_t)i], from.carry[states + (size_t)i]);
    if (!move(s, from.t, lag_dd_add(lag_dd_sum(t, -from.t), from.lag), ignored, quadratures, lag))
        return 0;
    lag_dds_settle(s->x, states);
    return 1;
}

/* ---------------------------------------------------------------- many equal steps */

/* Whether the next step is one of many like it, from a state that the pace may start from. */
static int in_pace(LagLinearMethod *s, const LagMotion *m, double t_new, double ignored)
{
    const LagDD h = lag_dd_add(lag_dd_sum(t_new, -m->t), s->lag);
    const int enough = EQUAL_STEPS + 2 * s->system.size;
    if (!s->has_ladder || s->ladder.base == 0 || s->ladder.built <= s->ladder.top || !(fabs(h.hi - s->ladder.base) <= ignored)) {
        s->equal_steps = 0;
        return 0;
    }
    if (++s->equal_steps == enough) {
        fill(s, m, m->y, m->carry, s->loads);
        lag_pace_try(&s->pace, &s->ladder, (size_t)m->n, s->x);
        lag_pace_set(&s->pace, s->x);
    }
    return s->equal_steps >= enough && s->pace.is_trusted;
}

static void pace_step(LagLinearMethod *s, LagMotion *m, double t_new)
{
    const size_t states = 2 * (size_t)m->n, n_w = (size_t)s->system.n_w;
    double gain[2] = {0, 0};
    LagPace *pace = &s->pace;
    lag_pace_step(pace, gain);
    memcpy(m->other, pace->x, states * sizeof *m->other);
    memset(m->other_carry, 0, states * sizeof *m->other);
    for (int i = 0; i < m->size - 2 * m->n; ++i) {
        const LagDD sum = lag_dd_sum(m->y[states + (size_t)i], m->carry[states + (size_t)i] + gain[i]);
        m->other[states + (size_t)i] = sum.hi;
        m->other_carry[states + (size_t)i] = sum.lo;
    }
    memcpy(s->loads_old.hi, pace->x + states, n_w * sizeof *pace->x);
    memset(s->loads_old.lo, 0, n_w * sizeof *pace->x);
    swap(&s->loads, &s->loads_old);
    s->lag_old = s->lag;
    s->lag = lag_dd_sub(lag_dd_add(lag_dd_sum(t_new, -m->t), s->lag), lag_dd(s->ladder.base));
}

/* The present state, as the ladder gives it, in place of the pace's. */
static void set_right(LagLinearMethod *s, LagMotion *m)
{
    const size_t states = 2 * (size_t)m->n;
    LagPace *pace = &s->pace;
    LagDD integrals[2];
    if (pace->count > 0 && memcmp(m->y, pace->x, states * sizeof *m->y) != 0)
        pace->count = 0; /* somebody put another state there */
    if (pace->count == 0)
        return;
    lag_pace_settle(pace, &s->ladder, integrals);
    pace->is_trusted = lag_pace_agrees(pace, (size_t)m->n, integrals);
    lag_dds_settle(pace->state, pace->size);
    memcpy(m->y, pace->state.hi, states * sizeof *m->y);
    memcpy(m->carry, pace->state.lo, states * sizeof *m->y);
    lag_dds_copy(lag_dds_from(pace->state, states), s->loads, (size_t)s->system.n_w);
    for (int i = 0; i < m->size - 2 * m->n; ++i) {
        const LagDD more = lag_dd_sub(integrals[i], lag_dd(pace->sum[i]));
        const LagDD sum = lag_dd_add(lag_dd_sum(m->y[states + (size_t)i], m->carry[states + (size_t)i]), more);
        m->y[states + (size_t)i] = sum.hi;
        m->carry[states + (size_t)i] = sum.lo;
    }
    lag_pace_set(pace, pace->state);
}

/* ---------------------------------------------------------------- steps */

static int try_step(LagLinearMethod *s, LagMotion *m, double t_new, double ignored)
{
    const Place here = {m->y, m->carry, s->loads, m->t, s->lag};
    const size_t states = 2 * (size_t)m->n;
    LagDD quadratures[2] = {{0, 0}, {0, 0}};
    LagDD lag;
    double probe = 0;
    if (!move_from(s, m, here, t_new, ignored, quadratures, &lag))
        return 0;
    memcpy(m->other, s->x.hi, states * sizeof *m->other);
    memcpy(m->other_carry, s->x.lo, states * sizeof *m->other);
    for (int i = 0; i < m->size - 2 * m->n; ++i) {
        m->other[states + (size_t)i] = quadratures[i].hi;
        m->other_carry[states + (size_t)i] = quadratures[i].lo;
    }
    for (int i = 0; i < m->size; ++i)
        probe += 0 * m->other[i];
    if (probe != 0)
        return 0;
    lag_dds_copy(lag_dds_from(s->x, states), s->loads_old, (size_t)s->system.n_w);
    swap(&s->loads, &s->loads_old);
    s->lag_old = s->lag;
    s->lag = lag;
    return 1;
}

/* m->other is the state at t_new. */
static int take(LagLinearMethod *s, LagMotion *m, double t_new, double ignored)
{
    if (!in_pace(s, m, t_new, ignored)) {
        set_right(s, m);
        return try_step(s, m, t_new, ignored);
    }
    pace_step(s, m, t_new);
    return 1;
}

static LagStatus step(LagRun *run)
{
    LagLinearMethod *s = run->methods.self;
    LagMotion *m = &run->motion;
    const double t = m->t, t_new = lag_step_aim(run), ignored = t_new == run->segment_end ? 0 : IGNORED * fabs(t_new);
    if (run->statistics.steps == 0)
        s->pace.count = 0;
    if (s->is_fresh || s->pace.count == LAG_PACE_STEPS)
        set_right(s, m);
    if (s->is_fresh && !begin(s, run)) {
        s->is_fresh = 1;
        return lag_fail(run, LAG_NOT_FINITE, 0, 1, 0);
    }
    if (!take(s, m, t_new, ignored))
        return lag_step_give_up(run, lag_first_not_finite(m->other, 2 * m->n));
    lag_motion_take(m, t_new);
    lag_step_record(run, t_new - t);
    return LAG_OK;
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagLinearMethod *s = self;
    const Place before = {m->other, m->other_carry, s->loads_old, m->t_old, s->lag_old};
    LagDD quadratures[2] = {{0, 0}, {0, 0}}, lag;
    move_from(s, m, before, t, 0, quadratures, &lag);
    memcpy(y, s->x.hi, 2 * (size_t)m->n * sizeof *y);
    for (int i = 0; i < m->size - 2 * m->n; ++i)
        y[2 * m->n + i] = quadratures[i].hi;
    ++m->dense_outputs;
}

const LagMethod lag_linear_method = {
    .name = "linear", .order = 8, .layout = layout, .restart = restart, .step = step, .interpolate = interpolate, .stride = 1,
    .is_exact = 1,
};
