/* Near a singular position of a constrained mechanism (a parallelogram folded flat) rounding is magnified, and the shorter
 * the step, the more of its stages feel it: shrinking leads ever deeper in. The motion itself is smooth there. So the step
 * is tried again with projected slopes, at several lengths that straddle the place in different ways; if none is good
 * enough, the best of them is that can be had, as long as its error stays below FORGIVEN: the run tells how often it missed its
 * tolerance. Where nothing is singular the motion is only quick: much shorter steps are tried first. What the projection moves a
 * step by is an error as well. */
#include "steps/attempts.h"

#include <math.h>
#include <string.h>

#include "state/ends.h"
#include "state/first_step.h"
#include "steps/singular.h"
#include "steps/turns.h"

enum { PATIENT = 2, TOLERANT = 5, MOST_TRIES = 3, DEPTHS = 30, IN_VAIN, PLUNGED = 100, LATELY = 8, MOST_PLUNGES = 4 };
static const double WAY[LAG_WAYS] = {1, 0.77, 1.29, 0.6, 0.45, 0.9, 1.1, 0.35}, FORGIVEN = 1e-5, SINGULAR = 100;
/* An ordinary rejection is one that a shorter step mends. Errors (relative to the state) above NOISE cannot be rounding: there
 * it is enough that the error falls as the step does, and that the steps have not been getting ever shorter. Below, it is the first
 * at this place, its error is not far off, or the step is much longer than the last good ones; and above FAINT_NOISE steps
 * may be rejected in a row, nearly good ones some times below, unless they have been getting ever shorter. */
static const double NOISE = 1e-6, FAINT_NOISE = 1e-9, MENDED = 0.25, SUNK = 0.1, MUCH_LONGER = 1.5, MENDABLE = 50, MILD = 2;
/* Rejections in a row: methods of low order do not find into a motion that sets in out of nothing, and sweeps may not come nearer. What
 * is nearly singular to steps as long as those of sweeps; the length that others begin with there, as a share of the planned one. */
enum { HOPELESS = 4, SINKING = 3 };
static const double NEARLY = 10, TO_OTHERS = 0.35, SHARE = 0.75, DEEP = 0.1;
/* By which the shortest of the lengths has a smaller error, and a still shorter attempt again, where these are none of rounding. */
static const double FALL = 0.01, FALL_AGAIN = 0.2;

LagAttempts lag_attempts_begin(LagRun *run)
{
    LagAttempts attempts;
    attempts.rejected = attempts.depth = 0;
    attempts.planned = run->step;
    attempts.allowed = 1;
    attempts.last = attempts.early = INFINITY;
    attempts.way = -1;
    run->careful = 0;
    return attempts;
}

/* Whether positions that are nearly singular may reject steps: of loops; where narrow places do as well, those of steps that are
 * shorter than these, if there is such a position. */
static int may_be_singular(LagRun *run, const LagAttempts *attempts, double h)
{
    const int is_loop = run->model->n_multipliers > 0;
    if (!is_loop || !(run->motion.t < run->looks.until))
        return is_loop;
    return h < run->looks.width && !(lag_singularity(run, fmax(attempts->planned, run->calm_step)) < NEARLY);
}

static int is_ordinary(const LagRun *run, const LagAttempts *attempts, double h, double error)
{
    if (run->careful)
        return 0;
    if (error < INFINITY && error * run->scale.tolerance > NOISE)
        return error < MENDED * attempts->last && (run->troubled < PATIENT || h > SUNK * run->calm_step);
    const int is_clear = error * run->scale.tolerance > FAINT_NOISE || (error < MILD && run->troubled < TOLERANT);
    const int is_calm = run->troubled < PATIENT || (is_clear && h > SUNK * run->calm_step);
    return is_calm && attempts->rejected == 1 && (error < MENDABLE || h > MUCH_LONGER * run->calm_step);
}

/* Whether a shorter step is expected to be good. */
static int is_mendable(const LagRun *run, const LagAttempts *attempts, double h, double error)
{
    return is_ordinary(run, attempts, h, error) && error > attempts->allowed;
}

/* Whether the errors tried so far are of rounding: shorter steps would lead to where it is magnified more, as they have done again
 * and again. Where forces have corners, errors do not fall either; nor do those of implicit steps over something quick, and of the
 * explicit ones that stand in for these. */
static int is_noise(const LagRun *run, const LagAttempts *attempts)
{
    const double shortest = attempts->errors[LAG_WAYS - 1];
    const int falls = shortest < FALL * attempts->errors[0] || attempts->early < FALL_AGAIN * shortest;
    const int is_explicit = run->methods.solver != LAG_SOLVER_IMPLICIT && run->stiffness.passes == 0;
    const int may_be = is_explicit && !run->model->has_corners && run->plunges >= MOST_PLUNGES;
    return may_be && shortest * run->scale.tolerance < NOISE && !falls;
}

/* Whether still shorter steps are worth trying. What is near is asked once a step. */
static int may_plunge(LagRun *run, LagAttempts *attempts)
{
    if (attempts->depth == 0 && is_noise(run, attempts))
        return 0;
    if (attempts->depth == 0 && !(lag_singularity(run, attempts->planned) < SINGULAR))
        attempts->depth = IN_VAIN;
    return attempts->depth < DEPTHS;
}

/* A length not yet tried; then that of the least error, which is allowed now. Should it fail by its projection, that is its error
 * from then on. */
static double next_way(LagRun *run, LagAttempts *attempts, double shorter)
{
    int best = 0;
    for (int i = 1; i < LAG_WAYS && attempts->tries[best] > 0; ++i)
        if (attempts->tries[i] == 0 || attempts->errors[i] < attempts->errors[best])
            best = i;
    const int is_new = attempts->tries[best] == 0;
    if (!is_new && may_plunge(run, attempts)) {
        attempts->way = -1;
        attempts->allowed = 1;
        return ldexp(attempts->planned * WAY[LAG_WAYS - 1], -++attempts->depth);
    }
    attempts->way = is_new || attempts->errors[best] * run->scale.tolerance < FORGIVEN ? best : -1;
    if (attempts->way < 0)
        return shorter;
    ++attempts->tries[best];
    attempts->allowed = is_new ? 1 : fmax(1, 2 * attempts->errors[best]);
    return attempts->planned * WAY[best];
}

/* Steps that take a share of what is left again and again lead into a singular position, however small their errors are. */
static int is_sinking(LagRun *run, const LagAttempts *attempts)
{
    if (attempts->rejected == 1) {
        const int goes_on = run->sinking > 0 && attempts->planned < SHARE * run->refused;
        run->sinking = goes_on ? run->sinking + 1 : 1;
        run->sunk_from = goes_on ? run->sunk_from : attempts->planned;
        run->refused = attempts->planned;
    }
    return run->sinking >= SINKING && attempts->planned < DEEP * run->sunk_from;
}

/* Whether the method knows that a shorter step is good: said once a step. */
static int is_clear(const LagRun *run, const LagAttempts *attempts)
{
    const LagMethod *method = run->methods.table;
    return attempts->rejected == 1 && method->is_clear && method->is_clear(run->methods.self);
}

/* Near singular positions at once, with a length that leads across, and for good: there will be more of them. Where time has no
 * shorter steps (what was held is let go, and begins from nothing), there is nothing to wait for; nor where a linkage is driven in
 * time, as a crank by its slide: short steps lead so near its dead points that rounding decides. There the others
 * begin with steps of their own length. */
int lag_attempts_leave(LagRun *run, const LagAttempts *attempts, double h, double error, double shorter)
{
    const int is_loop = may_be_singular(run, attempts, h), leaves = run->methods.table->leaves_trouble;
    const int knows_time = is_loop && run->model->loops_know_time;
    const int is_last = shorter < lag_step_smallest(run->motion.t);
    if (!leaves)
        return 0;
    const int sinks = is_loop && is_sinking(run, attempts);
    if (!knows_time && !is_last && !sinks) {
        if (is_loop && (is_mendable(run, attempts, h, error) || is_clear(run, attempts)))
            return 0;
        if (attempts->rejected < HOPELESS && (!is_loop || lag_singularity(run, attempts->planned) < NEARLY))
            return 0;
    }
    run->step = is_loop ? TO_OTHERS * fmax(attempts->planned, run->calm_step) : shorter;
    run->calm_step *= is_loop ? TO_OTHERS : 1;
    if (!(is_loop && lag_turn_fall_back(run)) && !lag_turn_pass(run))
        return 0;
    if (knows_time) {
        const double slowness = lag_slowness(&run->motion, &run->scale, run->step, 0);
        run->calm_step = run->step = fmax(run->step, lag_first_step(&run->scale, slowness, run->methods.table->order));
    }
    return 1;
}

double lag_attempts_next(LagRun *run, LagAttempts *attempts, double h, double error, double shorter)
{
    const int is_mended = is_mendable(run, attempts, h, error);
    attempts->last = error;
    if (!may_be_singular(run, attempts, h) || is_mended || run->methods.table->leaves_trouble)
        return shorter;
    if (!run->careful) {
        run->careful = 1;
        memset(attempts->errors, 0, sizeof attempts->errors);
        memset(attempts->tries, 0, sizeof attempts->tries);
        attempts->rejected = 1;
        attempts->planned = fmax(attempts->planned, run->calm_step);
        attempts->early = h < WAY[LAG_WAYS - 1] * attempts->planned ? error : INFINITY;
    }
    if (attempts->way >= 0)
        attempts->errors[attempts->way] = attempts->tries[attempts->way] < MOST_TRIES ? error : INFINITY;
    return next_way(run, attempts, shorter);
}

void lag_attempts_end(LagRun *run, const LagAttempts *attempts, double h, double error)
{
    const int was_rejected = attempts->rejected > 0;
    run->careful = 0;
    run->statistics.tolerance_missed += error > 1;
    run->sinking = h > run->refused ? 0 : run->sinking;
    run->troubled = was_rejected ? run->troubled + 1 : 0;
    /* after a plunge the calm step stays for a while: should a singular position be near after all, it leads across */
    const int has_plunged = attempts->depth > 0 && attempts->depth < IN_VAIN;
    run->plunges = run->plunged < PLUNGED - LATELY ? has_plunged : run->plunges + has_plunged;
    run->plunged = has_plunged ? PLUNGED : run->plunged - (run->plunged > 0);
    if (!was_rejected)
        run->calm_step = fmax(h, run->plunged > 0 ? run->calm_step : run->calm_step / 2);
}
