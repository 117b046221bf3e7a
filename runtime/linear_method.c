/* A step leads to the next row, event or corner of the inputs. Whichever is cheaper takes it there: the series, or rungs of
 * the ladder and the series for the rest. A rung for a length of step is built when the series has cost as much for steps of
 * this length as building it does: never more than twice the least effort.
 *
 * Times that are meant to be equally far apart are so but for rounding. The state then moves by equal steps and lags behind
 * its time by less than the time's own rounding, which does not add up, and is made up for at the end of a segment.
 */
#include "linear_method.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "evaluate.h"
#include "step.h"

static const double SAME = 1e-9, FIRST_STEP = 1;

static const LagRun *run_of(const LagMotion *m) { return m->context; }

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    LagLinearMethod *s = self;
    const LagModel *model = run_of(m)->model;
    lag_linear_system_layout(&s->system, model, arena);
    const size_t size = (size_t)s->system.size, n_w = (size_t)s->system.n_w;
    s->has_ladder = lag_ladder_possible(model);
    if (s->has_ladder)
        lag_ladder_layout(&s->ladder, &s->system, arena);
    lag_series_layout(&s->series, &s->system, model->n_power, arena);
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

static void powers(void *context, double t, const double *q, double *v, double *power)
{
    LagRun *run = context;
    lag_accelerations(run, t, q, v, run->acceleration, power);
}

/* Equations and loads of the segment that begins. Returns 0 when the mass matrix is not positive definite. */
static int begin(LagLinearMethod *s, LagRun *run)
{
    int is_new;
    s->is_fresh = 0;
    if (run->statistics.steps == 0)
        s->lag = lag_dd(0);
    s->series.powers = powers;
    s->series.context = run;
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
    const double by_series = lag_series_cost(&s->series, h);
    if (is_same(h, s->ladder.base))
        return lag_ladder_cost_of_rung(&s->ladder) < by_series;
    if (!is_same(h, s->usual)) {
        s->usual = h;
        s->spent = 0;
    }
    s->spent += by_series;
    if (s->spent > lag_ladder_cost(&s->ladder, h) && lag_ladder_cost_of_rung(&s->ladder) < by_series) {
        lag_ladder_set_base(&s->ladder, h);
        return 1;
    }
    return s->ladder.base > 0 && s->ladder.built > 0
        && lag_ladder_cost_of_rung(&s->ladder) * (2 + log2(fmax(1, h / lag_ladder_length(&s->ladder, 0)))) < by_series;
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
    if (ladder_pays(s, h.hi)) {
        for (int rung = lag_ladder_find(&s->ladder, h.hi); rung >= 0; rung = lag_ladder_find(&s->ladder, h.hi)) {
            const double length = lag_ladder_length(&s->ladder, rung);
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

typedef struct {
    const double *y, *carry;
    LagDDs loads;
    double t;
    LagDD lag;
} Place;

/* The state there, moved to the time t, in s->x; the quadratures with their integrals. */
static int move_from(LagLinearMethod *s, LagMotion *m, Place from, double t, double ignored, LagDD *quadratures, LagDD *lag)
{
    const size_t states = 2 * (size_t)m->n, n_w = (size_t)s->system.n_w;
    memcpy(s->x.hi, from.y, states * sizeof *from.y);
    memcpy(s->x.lo, from.carry, states * sizeof *from.y);
    lag_dds_copy(from.loads, lag_dds_from(s->x, states), n_w);
    for (int i = 0; i < m->size - 2 * m->n; ++i)
        quadratures[i] = lag_dd_sum(from.y[states + (size_t)i], from.carry[states + (size_t)i]);
    if (!move(s, from.t, lag_dd_add(lag_dd_sum(t, -from.t), from.lag), ignored, quadratures, lag))
        return 0;
    lag_dds_settle(s->x, states);
    return 1;
}

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

static double aim(const LagRun *run)
{
    const double t = run->motion.t, end = fmin(run->segment_end, run->settings.t_stop);
    double target = run->wanted > t && run->wanted < end ? run->wanted : end;
    if (isinf(target))
        target = t + fmax(FIRST_STEP, fabs(t));
    return run->settings.max_step > 0 ? fmin(target, t + run->settings.max_step) : target;
}

static LagStatus step(LagRun *run)
{
    LagLinearMethod *s = run->methods.self;
    LagMotion *m = &run->motion;
    const double t = m->t, t_new = aim(run);
    if (s->is_fresh && !begin(s, run)) {
        s->is_fresh = 1;
        return lag_fail(run, LAG_NOT_FINITE, 0, 1, 0);
    }
    if (!try_step(s, m, t_new, t_new == run->segment_end ? 0 : DBL_EPSILON * fabs(t_new)))
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

const LagMethod lag_linear_method = {"linear", 8, layout, restart, step, NULL, NULL, interpolate};
