/* Step control of E. Hairer, G. Wanner, Stiff differential equations solved by Radau methods, J. Comput. Appl. Math. 111
 * (1999): the number of stages follows the speed at which Newton's iterations converge, the length of steps the embedded
 * error, foreseen from the two latest steps (K. Gustafsson, 1994), and the Jacobian is kept as long as it serves.
 */
#include "methods/radau.h"

#include <math.h>
#include <string.h>

#include "state/account.h"
#include "steps/attempts.h"
#include "state/onset.h"
#include "steps/rounding.h"
#include "steps/step.h"
#include "steps/turns.h"

static const double SAFETY = 0.9, LEAST_FACTOR = 1.0 / 8, MOST_FACTOR = 5, NOT_FINITE_SHRINK = 0.25, DIVERGED_SHRINK = 0.5;
/* A step is kept when it could grow by less than this; contractions below which the Jacobian is kept, more stages pay, and
 * above which fewer do. */
static const double KEPT = 1.2, STILL_GOOD = 1e-3, MORE_STAGES = 0.02, FEWER_STAGES = 0.8;
static const double SMALLEST_ERROR = 1e-10, CUT = 0.9, FORESEEN = 0.5, LEAST_KNOWN_ERROR = 1e-2;
enum { STEPS_BEFORE_CHANGE = 10, HOPELESS = 2 };

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    LagRadau *s = self;
    const LagRun *run = m->context;
    const size_t n = (size_t)m->n, all = LAG_RADAU_STAGES * n;
    lag_implicit_matrix_layout(&s->matrix, run->model, LAG_RADAU_PAIRS, arena);
    lag_border_layout(&s->border, m, LAG_RADAU_PAIRS, arena);
    lag_collocation_layout(&s->trial, m, arena);
    lag_collocation_layout(&s->last, m, arena);
    s->slope = lag_take(arena, (size_t)m->size);
    s->place = lag_take(arena, all);
    s->force = lag_take(arena, all);
    s->change = lag_take(arena, all);
    s->w_re = lag_take(arena, n);
    s->w_im = lag_take(arena, n);
    s->weight = lag_take(arena, 2 * n);
    s->error = lag_take(arena, 2 * n);
    s->filtered = lag_take(arena, 2 * n);
}

static void restart(void *self, LagMotion *m)
{
    LagRadau *s = self;
    memcpy(s->slope, m->slope, (size_t)m->size * sizeof *m->slope);
    s->tableau = &lag_radau_tableau[0];
    s->since_change = 0;
    s->jacobian_is_known = s->has_last = 0;
    s->accepted_step = 0;
    s->patience = 1;
    s->contraction = 0;
}

static double power_of(const LagRadau *s, double error) { return pow(error, 1.0 / (s->tableau->stages + 1)); }

/* Factor from this step to the next: the more iterations it took, the more careful. */
static double factor(const LagRadau *s, double error)
{
    const double most = 2.0 * lag_radau_most_iterations(s->tableau);
    const double safety = fmin(SAFETY, SAFETY * (most + 1) / (most + s->iterations));
    return fmin(MOST_FACTOR, fmax(LEAST_FACTOR, safety / power_of(s, fmax(error, SMALLEST_ERROR))));
}

/* The same as the latest two steps foresee it. */
static double foreseen(const LagRadau *s, double h, double error)
{
    if (s->accepted_step <= 0)
        return MOST_FACTOR;
    const double trend = s->accepted_step / h * power_of(s, error * error / s->accepted_error);
    return fmin(MOST_FACTOR, fmax(LEAST_FACTOR, SAFETY / trend));
}

/* More stages when Newton's iterations converge at once, fewer when they hardly do. */
static void choose_stages(LagRadau *s, int has_failed)
{
    const long now = s->tableau - lag_radau_tableau;
    ++s->since_change;
    if (now > 0 && (has_failed || s->contraction >= FEWER_STAGES)) {
        s->tableau = &lag_radau_tableau[now - 1];
        s->since_change = 0;
    } else if (now + 1 < LAG_RADAU_TABLEAUS && s->contraction < MORE_STAGES && s->since_change >= STEPS_BEFORE_CHANGE) {
        s->tableau = &lag_radau_tableau[now + 1];
        s->since_change = 0;
    }
}

static void swap_steps(LagRadau *s)
{
    const LagCollocation last = s->last;
    s->last = s->trial;
    s->trial = last;
}

/* Takes the step just tried. Returns 0, and takes nothing, when the slope at its end is not finite. */
static int accept(LagRadau *s, LagMotion *m, double t_new)
{
    const int n = m->n;
    if (!lag_motion_slope(m, t_new, m->other, m->other + n, m->sum))
        return 0;
    memcpy(s->trial.slope, s->slope, (size_t)m->size * sizeof *s->slope);
    memcpy(s->slope, m->sum, (size_t)m->size * sizeof *s->slope);
    m->doubt += s->doubt;
    lag_motion_take(m, t_new);
    swap_steps(s);
    s->had_last = s->has_last;
    s->has_last = 1;
    return 1;
}

/* Chooses the next step after one of length h was accepted. */
static void settle(LagRun *run, LagRadau *s, double h, double error, const LagAttempts *attempts, int has_failed)
{
    const int was_cut = h < CUT * run->step;
    const double most = attempts->rejected > 0 ? 1 : MOST_FACTOR, limit = run->settings.max_step;
    const double known = fmin(error, 1); /* a larger one was forgiven */
    double growth = fmin(most, fmin(factor(s, known), foreseen(s, h, known)));
    s->jacobian_is_fresh = 0;
    s->accepted_step = h;
    s->accepted_error = fmax(LEAST_KNOWN_ERROR, known);
    const LagRadauTableau *before = s->tableau;
    choose_stages(s, has_failed);
    s->jacobian_is_known = s->contraction <= STILL_GOOD;
    if (s->jacobian_is_known && s->tableau == before && growth >= 1 && growth <= KEPT)
        growth = 1;
    run->step = was_cut ? fmax(run->step, h * growth) : h * growth;
    run->step = limit > 0 ? fmin(run->step, limit) : run->step;
    ++run->statistics.implicit_steps;
    lag_attempts_end(run, attempts, h, error);
    lag_step_record(run, h);
}

/* Factor to the next length to try after one that failed: by Newton's iterations, or by the error. */
static double shorter(const LagRadau *s, LagConvergence convergence, double asked, double error)
{
    switch (convergence) {
    case LAG_STAGES_CONVERGED: return error > 1 && error < INFINITY ? fmin(factor(s, error), SAFETY) : NOT_FINITE_SHRINK;
    case LAG_STAGES_SLOW: return asked;
    case LAG_STAGES_DIVERGED: return DIVERGED_SHRINK;
    default: return NOT_FINITE_SHRINK;
    }
}

/* Tries a step to t_new: its error in units, infinity when it has none. */
static double attempt(LagRadau *s, LagRun *run, double t_new, LagConvergence *convergence, double *asked, int again, int *worst)
{
    LagMotion *m = &run->motion;
    const double h = t_new - m->t;
    m->t_old = m->t;
    *convergence = LAG_NO_JACOBIAN;
    if (!lag_radau_prepare(s, run, h))
        return INFINITY;
    *convergence = lag_radau_solve(s, run, h, asked, worst);
    if (*convergence != LAG_STAGES_CONVERGED || !lag_radau_finish(s, run, h))
        return INFINITY;
    double error = lag_radau_error(s, run, h, again, worst);
    /* Of the account's integrals, too: motion that is given by time, or even, has hardly errors of its own. Near dead points of linkages
     * that time drives along powers grow beyond all bounds, and shorter steps would not lead across. */
    if (s->missed > error && (!run->model->loops_know_time || run->model->n_multipliers >= run->model->n))
        error = fmax(error, lag_account_count(m, h, lag_radau_knows_powers(s, run, h) ? s->missed : 0));
    run->statistics.worst = *worst;
    return error < INFINITY && !lag_radau_is_solution(s, run, h) ? INFINITY : error;
}

static LagStatus go_on(LagRun *run)
{
    LagRadau *s = run->methods.self;
    LagMotion *m = &run->motion;
    int worst = 0, has_failed = 0;
    run->step = fmax(run->step, lag_step_smallest(m->t));
    LagAttempts attempts = lag_attempts_begin(run);
    for (;;) {
        const double t_new = lag_step_end(run, run->step), h = t_new - m->t;
        double asked = 1;
        LagConvergence convergence;
        double error = attempt(s, run, t_new, &convergence, &asked, attempts.rejected > 0 || !s->has_last, &worst);
        if (error <= attempts.allowed)
            error = fmax(error, lag_project_step(run, t_new, attempts.allowed, &worst));
        if (error <= attempts.allowed && accept(s, m, t_new)) {
            settle(run, s, h, error, &attempts, has_failed);
            return LAG_OK;
        }
        ++run->statistics.rejected;
        if ((convergence == LAG_NO_JACOBIAN || convergence == LAG_STAGES_NOT_FINITE) && lag_switches_release(run))
            continue;
        if (convergence == LAG_NO_JACOBIAN)
            return lag_turn_pass(run) ? run->methods.table->step(run) : lag_step_give_up(run, worst);
        if (convergence != LAG_STAGES_CONVERGED && !s->jacobian_is_fresh) {
            s->jacobian_is_known = 0; /* and the same step again */
            continue;
        }
        ++attempts.rejected;
        has_failed |= convergence != LAG_STAGES_CONVERGED;
        if (convergence == LAG_STAGES_CONVERGED && lag_project_is_near(run, t_new, m->other))
            lag_onset_learn(m, &run->scale, t_new, error * run->scale.tolerance, FORESEEN);
        run->step = lag_attempts_next(run, &attempts, h, error, h * shorter(s, convergence, asked, error));
        if (run->careful && attempts.rejected > HOPELESS && lag_turn_pass(run)) {
            run->step = fmax(attempts.planned, run->calm_step);
            return run->methods.table->step(run);
        }
        if (run->step < lag_step_smallest(m->t))
            return lag_step_give_up(run, worst);
    }
}

static LagStatus step(LagRun *run)
{
    if (run->model->jacobian_waits)
        return lag_fail(run, LAG_WANTS_JACOBIAN, -1, 0, 0);
    lag_rounding_watch_idle(run);
    return go_on(run);
}

static double *slope(void *self) { return ((LagRadau *)self)->slope; }

/* Between the states that a step solves for its order is lower, and stiff springs make much of what is off there: what happens in a step
 * is found again at the end of a shorter one. */
static void take_back(LagRun *run)
{
    LagRadau *s = run->methods.self;
    swap_steps(s);
    s->has_last = s->had_last;
    memcpy(s->slope, s->trial.slope, (size_t)run->motion.size * sizeof *s->slope);
    lag_motion_take_back(&run->motion);
    --run->statistics.steps;
    --run->statistics.steps_by[LAG_SOLVER_IMPLICIT];
    --run->statistics.implicit_steps;
    ++run->statistics.rejected;
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    const LagRadau *s = self;
    lag_collocation_at(&s->last, m, m->other, (t - m->t_old) / (m->t_end - m->t_old), y);
    ++m->dense_outputs;
}

const LagMethod lag_radau = {
    .name = "implicit", .order = 4, .layout = layout, .restart = restart, .step = step, .slope = slope, .interpolate = interpolate,
    .take_back = take_back, .holds_switches = 1, .most_sliding = LAG_MOST_BORDER, .stride = 1,
};
