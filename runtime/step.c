#include "step.h"

#include <float.h>
#include <math.h>

#include "account.h"
#include "segment.h"

/* Measured like the constants of scale.c: at a safety of 0.8 fewer rejections pay for shorter steps, and then a memory of
 * the last error (PI control: K. Gustafsson, 1991) gains nothing. */
static const double SAFETY = 0.8, EXPONENT = 1.0 / 8, SHRINK = 1.0 / 3, GROW = 6, NOT_FINITE_SHRINK = 0.25;
static const double SMALLEST_ERROR = 1e-10, CUT = 0.9;
/* The end of a rejected step, wrong by less than this, still tells how large the motion will be. Without it, a motion that
 * sets in smoothly from rest (a road that begins to rise) is resolved against its own first picometres, below rounding. */
static const double FORESEEN = 1e-3;

/* Shorter steps do not move t. */
static double smallest_step(double t) { return fmax(4 * DBL_EPSILON * fabs(t), DBL_MIN); }

/* Where a step of length h ends: the one place where steps are cut short. Two steps of equal length rather than a long
 * one and a tiny one lead up to a limit. */
static double end_of_step(const LagRun *run, double h)
{
    const double t = run->solver.t, limit = fmin(run->segment_end, run->settings.t_stop), left = limit - t;
    if (h >= left)
        return limit;
    return t + (2 * h > left ? left / 2 : h);
}

static double shrunk(double h, double error)
{
    return h * (error < INFINITY ? fmax(SHRINK, SAFETY * pow(error, -EXPONENT)) : NOT_FINITE_SHRINK);
}

/* The next step after one of length h; not longer right after a rejection. A step that was only cut short teaches nothing
 * against the longer one that was planned. */
static double proposal(const LagRun *run, double h, double error, int rejected)
{
    const double factor = fmax(SHRINK, SAFETY * pow(fmax(error, SMALLEST_ERROR), -EXPONENT));
    const double planned = h < CUT * run->step ? run->step : 0;
    const double next = fmax(planned, h * fmin(rejected ? 1 : GROW, factor));
    return run->settings.max_step > 0 ? fmin(next, run->settings.max_step) : next;
}

static void record(LagRun *run, double h)
{
    LagStatistics *s = &run->statistics;
    s->smallest_step = s->steps == 0 ? h : fmin(s->smallest_step, h);
    s->largest_step = fmax(s->largest_step, h);
    ++s->steps;
    run->segment_over = run->solver.t == run->segment_end;
    lag_scale_note(&run->scale, run->solver.y);
    lag_scale_set_step(&run->scale, h);
    double entries[LAG_ACCOUNT_SIZE];
    if (run->settings.energy_every_step)
        lag_account_note(run, run->solver.t, run->solver.y, entries);
}

LagStatus lag_step(LagRun *run)
{
    LagDop853 *solver = &run->solver;
    const int n = run->model->n;
    int worst = 0;
    if (run->segment_over) {
        const LagStatus status = lag_segment_next(run);
        if (status != LAG_OK)
            return status;
    }
    if (run->settings.max_steps > 0 && run->statistics.steps >= run->settings.max_steps)
        return lag_fail(run, LAG_TOO_MANY_STEPS, -1, 0, 0);
    run->step = fmax(run->step, smallest_step(solver->t));
    for (int rejected = 0;; rejected = 1) {
        const double t = solver->t, t_new = end_of_step(run, run->step), h = t_new - t;
        const double error = lag_dop853_try(solver, t_new, &run->scale, &worst);
        run->statistics.worst = worst;
        if (error <= 1 && lag_project_step(run, t_new, &worst) && lag_dop853_accept(solver, t_new)) {
            run->step = proposal(run, h, error, rejected);
            record(run, h);
            return LAG_OK;
        }
        ++run->statistics.rejected;
        if (error * run->scale.tolerance < FORESEEN)
            lag_scale_note(&run->scale, solver->other);
        run->step = shrunk(h, error <= 1 ? INFINITY : error);
        if (run->step < smallest_step(t))
            return lag_fail(run, LAG_STEP_TOO_SMALL, worst < n ? worst : worst - n, worst >= n, 0);
    }
}
