/* Steps whose length follows the error that the method estimates. */
#include <math.h>

#include "steps/attempts.h"
#include "numbers/extremes.h"
#include "state/onset.h"
#include "numbers/rough_power.h"
#include "steps/rounding.h"
#include "steps/step.h"

/* Measured like the constants of scale.c: at a safety of 0.8 fewer rejections pay for shorter steps, and then a memory of
 * the last error (PI control: K. Gustafsson, 1991) gains nothing. */
static const double SAFETY = 0.8, SHRINK = 1.0 / 3, FIRST_GROW = 6, GROW = 3, NOT_FINITE_SHRINK = 0.25;
static const double SMALLEST_ERROR = 1e-10, CUT = 0.9;
/* The end of a rejected step, wrong by less than this, still tells how large the motion will be. Without it, a motion that
 * sets in smoothly from rest (a road that begins to rise) is resolved against its own first picometres, below rounding. */
static const double FORESEEN = 1e-3;

/* Factor for a step whose error was `error` units. */
static double factor(const LagRun *run, double error)
{
    const LagMethod *method = run->methods.table;
    return lag_max(SHRINK, method->factor ? method->factor(run->methods.self) : SAFETY * lag_rough_power(error, -1.0 / method->order));
}

static double shrunk(const LagRun *run, double h, double error)
{
    return h * (error < INFINITY ? factor(run, error) : NOT_FINITE_SHRINK);
}

/* The next step after one of length h; not longer right after a rejection. A step that was only cut short teaches nothing
 * against the longer one that was planned. */
static double proposal(LagRun *run, double h, double error, int rejected)
{
    const double planned = h < CUT * run->step ? run->step : 0, wish = factor(run, lag_max(error, SMALLEST_ERROR));
    const double next = lag_max(planned, h * lag_min(rejected ? 1 : run->is_starting ? FIRST_GROW : GROW, wish));
    run->is_starting = run->is_starting && wish > GROW;
    return run->settings.max_step > 0 ? lag_min(next, run->settings.max_step) : next;
}

static void settle(LagRun *run, const LagAttempts *attempts, double h, double error)
{
    run->step = proposal(run, h, lag_min(error, 1), attempts->rejected > 0);
    lag_attempts_end(run, attempts, h, error);
    lag_step_record(run, h);
}

LagStatus lag_step_adaptive(LagRun *run)
{
    const LagMethod *method = run->methods.table;
    LagMotion *motion = &run->motion;
    void *self = run->methods.self;
    int worst = 0;
    lag_rounding_watch(run);
    run->step = lag_max(run->step, lag_step_smallest(motion->t));
    LagAttempts attempts = lag_attempts_begin(run);
    for (;;) {
        const double t = motion->t, t_new = lag_step_end(run, run->step), h = t_new - t;
        double error = method->attempt(self, motion, t_new, &run->scale, &worst);
        run->statistics.worst = worst;
        if (error <= attempts.allowed && !lag_project_waits(run, t_new))
            error = lag_max(lag_project_step(run, t_new, attempts.allowed, &worst), error);
        if (error <= attempts.allowed && method->accept(self, motion, t_new)) {
            settle(run, &attempts, h, error);
            return LAG_OK;
        }
        ++run->statistics.rejected;
        if (!(error > attempts.allowed && error < INFINITY) && lag_switches_release(run))
            continue;
        ++attempts.rejected;
        if (lag_project_is_near(run, t_new, motion->other))
            lag_onset_learn(motion, &run->scale, t_new, error * run->scale.tolerance, FORESEEN);
        const double shorter = shrunk(run, h, error <= attempts.allowed ? INFINITY : error);
        if (lag_attempts_leave(run, &attempts, h, error, shorter))
            return run->methods.table->step(run);
        run->step = lag_attempts_next(run, &attempts, h, error, shorter);
        if (run->step < lag_step_smallest(t))
            return lag_step_give_up(run, worst);
    }
}
