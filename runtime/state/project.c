/* Projection: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed. (2006), IV.4; velocities as well:
 * E. Eich, SIAM J. Numer. Anal. 30 (1993). It moves a state by no more than the step's own error, so it keeps the order.
 *
 * The model's functions `place` and `steer` give Newton corrections; they are repeated as long as they shrink. Corrections
 * are compared with the coordinates they belong to, not residuals with each other: these have units of their own. One that
 * did not make the next one smaller is noise, as it is near singular positions (parallelograms folded flat), where rounding of
 * Phi is magnified a million times: it is taken back. One at rounding level is left undone, so that the compensated sum keeps
 * its digits.
 *
 * The state is projected before the slope at its end is evaluated: that slope is the next step's first, and the dense
 * output meets the projected states at both ends.
 */
#include "state/project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "state/correction.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "model/function.h"
#include "state/holds.h"
#include "state/state.h"

/* Relative to the size of a coordinate: rounding; a correction whose square is below rounding; noise near singular
 * positions. In units of error: what a good step may be corrected by; a unit counts as no less than FINEST of the magnitude
 * that matters, since velocities are corrected by noise, too, near singular positions. */
static const double ROUNDING = 4 * DBL_EPSILON, SQUARE_IS_ROUNDING = 1e-9, NOISE = 1e-6;
/* What a step's projection may leave of its error, in its tolerance; rows are projected to rounding. */
static const double LEFT_BY_STEPS = 1e-3;
static const double MOST_UNITS = 100, FINEST = 1e-11, NEAR_SINGULAR = 1e-9, FALL = 0.75;
/* After a step that was projected by less than so many units of error the next one need not be; more in a row would cost digits
 * near singular positions. */
static const double DRIFT = 0.05, WAITS = 10; /* the latter by residuals */
static const double NEAR = 0.1; /* of coordinates and rates: corrections of a state that has not run away */
enum { PLACE_ITERATIONS = 8, STEER_ITERATIONS = 2, BOTH_ITERATIONS = 4 };

typedef enum { POSITIONS, RATES } Level;

void lag_projection_layout(LagProjection *s, const LagModel *model, LagArena *arena)
{
    const size_t n = model->n_multipliers > 0 ? (size_t)model->n : 0;
    s->state = lag_take(arena, 2 * n);
    s->carry = lag_take(arena, 2 * n);
    s->before = lag_take(arena, n);
    s->before_carry = lag_take(arena, n);
    s->correction = lag_take(arena, 2 * n);
    s->unit = lag_take(arena, 2 * n);
    s->phi = lag_take(arena, (size_t)model->n_holonomic);
    s->rate = lag_take(arena, (size_t)model->n_multipliers);
    lag_closure_layout(&s->measure, model, arena);
}

static int first_of(const LagRun *run, Level level) { return level == POSITIONS ? 0 : run->model->n; }

/* The correction at a state. Returns 0 when there is none. */
static int evaluate(LagRun *run, Level level, double t, const double *y)
{
    const LagModel *model = run->model;
    const double *q = y, *v = y + model->n;
    const double *place[] = {&t, q, run->u, run->d, run->c}, *steer[] = {&t, q, v, run->u, run->d, run->c};
    double *out[] = {run->projection.correction + first_of(run, level)};
    lag_inputs_at(&run->inputs, t, run->u);
    return lag_call(level == POSITIONS ? &model->place : &model->steer, level == POSITIONS ? place : steer, out, run->work) == 0;
}

/* The largest distance between two states in units of error. */
static double distance(const LagRun *run, const double *from, const double *to, int *worst)
{
    double largest = 0;
    for (int i = 0; i < 2 * run->model->n; ++i) {
        const double length = fabs(to[i] - from[i]);
        const double unit = lag_max(lag_scale_unit(&run->scale, i, from, to), FINEST * run->scale.floor[i]);
        if (length > largest * unit) {
            largest = length / unit;
            *worst = i;
        }
    }
    return largest;
}

static void remember(LagProjection *s, int n, const double *state, const double *carry)
{
    memcpy(s->before, state, (size_t)n * sizeof *state);
    memcpy(s->before_carry, carry, (size_t)n * sizeof *carry);
}

static void take_back(const LagProjection *s, int n, double *state, double *carry)
{
    memcpy(state, s->before, (size_t)n * sizeof *state);
    memcpy(carry, s->before_carry, (size_t)n * sizeof *carry);
}

/* Whether a correction of positions leaves nothing but rounding, or `left`; of rates, corrected by linear equations, nothing is left. */
static int is_settled(double size, double left) { return size <= SQUARE_IS_ROUNDING || size * size <= left; }

/* Corrects the projection's state until what is left, relative to the coordinates, is below `left` or rounding. Returns 1 when
 * it is where it should be. */
static int correct(LagRun *run, Level level, double t, double left)
{
    LagProjection *s = &run->projection;
    const int n = run->model->n, first = first_of(run, level), most = level == POSITIONS ? PLACE_ITERATIONS : STEER_ITERATIONS;
    double *state = s->state + first, *carry = s->carry + first;
    double last = INFINITY;
    for (int i = 0; i < most; ++i) {
        const double size = evaluate(run, level, t, s->state) ? lag_correction_size(run, first) : INFINITY;
        if (size <= ROUNDING)
            return 1;
        if (!(size < FALL * last)) {
            const int is_closed = level == POSITIONS && lag_correction_is_rounding(run);
            if (last < INFINITY)
                take_back(s, n, state, carry);
            if (is_closed)
                return 1; /* of a coordinate that is hardly more than rounding of the others */
            break;
        }
        remember(s, n, state, carry);
        lag_correction_apply(run, first);
        ++run->statistics.projections;
        last = size;
        if ((level == RATES || is_settled(size, left)) && lag_correction_is_fine(run, first, n))
            return 1; /* it is too short to harm were it noise */
    }
    return level == RATES ? last < INFINITY : last < NOISE;
}

/* Corrects both levels by `nearest`. Returns 0 where that is in doubt or corrections do not fall as they should. */
static int correct_both(LagRun *run, double t, double left)
{
    LagProjection *s = &run->projection;
    const int n = run->model->n;
    const double *in[] = {&t, s->state, s->state + n, run->u, run->d, run->c};
    double doubt = 0, last = INFINITY, *out[] = {s->correction, s->correction + n, s->phi, s->rate, s->latest.energies, &doubt};
    lag_inputs_at(&run->inputs, t, run->u);
    for (int i = 0; i < BOTH_ITERATIONS; ++i) {
        if (lag_call(&run->model->nearest, in, out, run->work) != 0 || doubt != 0)
            return 0;
        const double size = lag_correction_size(run, 0), pace = lag_correction_size(run, n);
        if (size > ROUNDING)
            lag_correction_apply(run, 0);
        if (pace > ROUNDING)
            lag_correction_apply(run, n);
        run->statistics.projections += (size > ROUNDING) + (pace > ROUNDING);
        s->is_exact = size * pace <= ROUNDING && is_settled(size, 0);
        if (size * pace <= lag_max(left, ROUNDING) && is_settled(size, left) && lag_correction_is_fine(run, 0, 2 * n))
            return 1;
        if (!(lag_max(size, pace) < FALL * last))
            return 0;
        last = lag_max(size, pace);
    }
    return 0;
}

/* Projects (y, carry) at t, unless it goes farther than `most` units of error. Returns how far it goes, if that matters; INFINITY
 * where it fails. */
static double project(LagRun *run, double t, double most, double left, double *y, double *carry, int *worst)
{
    LagProjection *s = &run->projection;
    const size_t size = 2 * (size_t)run->model->n * sizeof *y;
    memcpy(s->state, y, size);
    memcpy(s->carry, carry, size);
    s->is_complete = lag_present(&run->model->nearest) && run->doubtful == 0 && correct_both(run, t, left);
    if (!s->is_complete) {
        memcpy(s->state, y, size);
        memcpy(s->carry, carry, size);
        if ((run->model->n_holonomic > 0 && !correct(run, POSITIONS, t, left)) || !correct(run, RATES, t, left))
            return INFINITY;
    }
    const double units = most < INFINITY ? distance(run, y, s->state, worst) : 0;
    if (units <= most) {
        memcpy(y, s->state, size);
        memcpy(carry, s->carry, size);
    }
    return units;
}

static void note_residuals(LagRun *run)
{
    LagProjection *s = &run->projection;
    s->latest.gap = lag_largest(s->phi, (size_t)run->model->n_holonomic);
    s->latest.rate = lag_largest(s->rate, (size_t)run->model->n_multipliers);
}

int lag_project_is_near(LagRun *run, double t, const double *y)
{
    const LagModel *model = run->model;
    const double h = t - run->motion.t, past = run->motion.t - run->settings.t_start;
    int is_near = model->n_whens == 0 || h <= past || lag_scale_at_rest(&run->scale);
    if (model->n_multipliers == 0)
        return is_near;
    memcpy(run->projection.state, y, 2 * (size_t)model->n * sizeof *y);
    for (Level level = model->n_holonomic > 0 ? POSITIONS : RATES; level <= RATES && is_near; ++level)
        is_near = evaluate(run, level, t, y) && lag_correction_size(run, first_of(run, level)) < NEAR;
    return is_near;
}

/* Residuals of a state at t, s->phi and s->rate. */
static int find_residuals(LagRun *run, double t, const double *y)
{
    const double *in[] = {&t, y, y + run->model->n, run->u, run->d, run->c};
    double *out[] = {run->projection.phi, run->projection.rate};
    lag_inputs_at(&run->inputs, t, run->u);
    return lag_call(&run->model->residual, in, out, run->work) == 0;
}

int lag_project_waits(LagRun *run, double t)
{
    LagProjection *s = &run->projection;
    const double *y = run->motion.other;
    const double most = WAITS * run->scale.tolerance;
    const int may_wait = s->waits && run->sliding.count == 0 && !run->careful && t < run->settings.t_stop;
    s->waits = 0;
    return may_wait && find_residuals(run, t, y) && lag_closure_open(run, t, y, s->phi, s->rate, most) <= most;
}

double lag_project_step(LagRun *run, double t, double allowed, int *worst)
{
    LagProjection *s = &run->projection;
    lag_project_forget(run);
    lag_holds_project(run, run->motion.t, run->motion.y, t, run->motion.other, run->motion.other_carry);
    if (run->model->n_multipliers == 0)
        return 0;
    const double good = run->careful ? lag_max(NEAR_SINGULAR / run->scale.tolerance, MOST_UNITS) : MOST_UNITS;
    const double most = lag_max(allowed, good), left = LEFT_BY_STEPS * run->scale.tolerance;
    const double units = project(run, t, most, left, run->motion.other, run->motion.other_carry, worst);
    s->waits = units < DRIFT;
    if (s->is_complete && s->is_exact) {
        note_residuals(run);
        s->end = s->latest;
        s->end_time = t;
    }
    return units <= good ? 0 : run->careful ? units : INFINITY;
}

void lag_project_present(LagRun *run)
{
    int worst;
    if (run->model->n_multipliers > 0)
        project(run, run->motion.t, INFINITY, 0, run->motion.y, run->motion.carry, &worst);
    run->projection.waits = 0;
    lag_project_forget(run);
    lag_closure_forget(&run->projection.measure);
}

void lag_project_forget(LagRun *run) { run->projection.end_time = NAN; }

void lag_project_inside(LagRun *run, double t, double *y)
{
    int worst;
    if (run->model->n_multipliers == 0)
        return;
    memset(run->inside_carry, 0, 2 * (size_t)run->model->n * sizeof *y);
    project(run, t, INFINITY, 0, y, run->inside_carry, &worst);
}

/* Projects the state of a row. Returns 0 where its residuals are not known. */
static int close_row(LagRun *run, double t, double *y)
{
    LagProjection *s = &run->projection;
    lag_project_inside(run, t, y);
    if (!s->is_complete) {
        lag_energies(run, t, y, s->latest.energies);
        if (run->model->n_multipliers == 0 || !find_residuals(run, t, y))
            return 0;
    }
    note_residuals(run);
    return 1;
}

double lag_project_row(LagRun *run, double t, double *y, double *energies, double most)
{
    LagProjection *s = &run->projection;
    LagStatistics *statistics = &run->statistics;
    const int is_end = t == run->motion.t && t == s->end_time, is_known = is_end || close_row(run, t, y);
    const LagClosure *row = is_end ? &s->end : &s->latest;
    memcpy(energies, row->energies, sizeof row->energies);
    if (is_known) {
        statistics->constraint_residual = lag_max(row->gap, statistics->constraint_residual);
        statistics->constraint_rate_residual = lag_max(row->rate, statistics->constraint_rate_residual);
    }
    return is_end || !is_known ? 0 : lag_closure_open(run, t, y, s->phi, s->rate, most);
}
