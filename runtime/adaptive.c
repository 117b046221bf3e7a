/* Steps whose length follows the error that the method estimates. */
#include <math.h>

#include "step.h"

/* Measured like the constants of scale.c: at a safety of 0.8 fewer rejections pay for shorter steps, and then a memory of
 * the last error (PI control: K. Gustafsson, 1991) gains nothing. */
static const double SAFETY = 0.8, SHRINK = 1.0 / 3, GROW = 6, NOT_FINITE_SHRINK = 0.25;
static const double SMALLEST_ERROR = 1e-10, CUT = 0.9;
/* The end of a rejected step, wrong by less than this, still tells how large the motion will be. Without it, a motion that
 * sets in smoothly from rest (a road that begins to rise) is resolved against its own first picometres, below rounding. */
static const double FORESEEN = 1e-3;
/* Where a jump that nobody announced sets a scene in motion, the first motion has no size to compare errors with, however
 * short the step. After so many rejections the motion of the step just tried is taken for its size. */
enum { PATIENCE = 3 };

/* Factor for a step whose error was `error` units. */
static double factor(const LagRun *run, double error)
{
    return fmax(SHRINK, SAFETY * pow(error, -1.0 / run->methods.table->order));
}

static double shrunk(const LagRun *run, double h, double error)
{
    return h * (error < INFINITY ? factor(run, error) : NOT_FINITE_SHRINK);
}

/* The next step after one of length h; not longer right after a rejection. A step that was only cut short teaches nothing
 * against the longer one that was planned. */
static double proposal(const LagRun *run, double h, double error, int rejected)
{
    const double planned = h < CUT * run->step ? run->step : 0;
    const double next = fmax(planned, h * fmin(rejected ? 1 : GROW, factor(run, fmax(error, SMALLEST_ERROR))));
    return run->settings.max_step > 0 ? fmin(next, run->settings.max_step) : next;
}

/* Near a singular position of a constrained mechanism (a parallelogram folded flat) rounding is magnified, and the shorter
 * the step, the more of its stages feel it: shrinking leads ever deeper in. The motion itself is smooth there. So the step
 * is tried again with projected slopes, at several lengths that straddle the place in different ways; if none is good
 * enough, the best of them is, as long as its error stays below FORGIVEN. */
enum { WAYS = 8, PATIENT = 2 };
static const double WAY[WAYS] = {1, 0.77, 1.29, 0.6, 0.45, 0.9, 1.1, 0.35}, FORGIVEN = 1e-8;
/* An ordinary rejection: not one of several in a row, of a step much longer than the last good ones or with an error that a
 * shorter one mends. */
static const double MUCH_LONGER = 1.5, MENDABLE = 50;

typedef struct {
    int rejected;
    double planned;     /* length first tried */
    double best, least; /* the length with the least error, and that error */
    double allowed;     /* error, in units */
} Attempts;

static double next_attempt(LagRun *run, Attempts *attempts, double h, double error)
{
    const double shorter = shrunk(run, h, error <= attempts->allowed ? INFINITY : error); /* finite error, but not the slope */
    const int is_ordinary = run->troubled < PATIENT && attempts->rejected == 1 && (error < MENDABLE || h > MUCH_LONGER * run->calm_step);
    if (run->model->n_multipliers == 0 || (is_ordinary && error > attempts->allowed))
        return shorter;
    if (!run->careful) {
        run->careful = 1;
        attempts->rejected = 1;
        attempts->planned = fmax(attempts->planned, run->calm_step);
    }
    if (error < attempts->least) {
        attempts->least = error;
        attempts->best = h;
    }
    if (attempts->rejected <= WAYS)
        return attempts->planned * WAY[attempts->rejected - 1];
    if (attempts->rejected > WAYS + 1 || !(attempts->least * run->scale.tolerance < FORGIVEN))
        return shorter;
    attempts->allowed = fmax(1, 2 * attempts->least);
    return attempts->best;
}

static void settle(LagRun *run, const Attempts *attempts, double h, double error)
{
    const int was_rejected = attempts->rejected > 0;
    run->careful = 0;
    run->statistics.tolerance_missed += error > 1;
    run->step = proposal(run, h, fmin(error, 1), was_rejected);
    run->troubled = was_rejected ? run->troubled + 1 : 0;
    run->calm_step = was_rejected ? run->calm_step : fmax(h, run->calm_step / 2);
    lag_step_record(run, h);
}

LagStatus lag_step_adaptive(LagRun *run)
{
    const LagMethod *method = run->methods.table;
    LagMotion *motion = &run->motion;
    void *self = run->methods.self;
    int worst = 0;
    run->step = fmax(run->step, lag_step_smallest(motion->t));
    Attempts attempts = {0, run->step, run->step, INFINITY, 1};
    run->careful = 0;
    for (;;) {
        const double t = motion->t, t_new = lag_step_end(run, run->step), h = t_new - t;
        double error = method->attempt(self, motion, t_new, &run->scale, &worst);
        run->statistics.worst = worst;
        if (error <= attempts.allowed && !lag_project_step(run, t_new, &worst))
            error = INFINITY;
        if (error <= attempts.allowed && method->accept(self, motion, t_new)) {
            settle(run, &attempts, h, error);
            return LAG_OK;
        }
        ++run->statistics.rejected;
        ++attempts.rejected;
        if (error * run->scale.tolerance < FORESEEN || (attempts.rejected > PATIENCE && lag_scale_at_rest(&run->scale)))
            lag_scale_note(&run->scale, motion->other);
        run->step = next_attempt(run, &attempts, h, error);
        if (run->step < lag_step_smallest(t))
            return lag_step_give_up(run, worst);
    }
}
