/* Near a singular position of a constrained mechanism (a parallelogram folded flat) rounding is magnified, and the shorter
 * the step, the more of its stages feel it: shrinking leads ever deeper in. The motion itself is smooth there. So the step
 * is tried again with projected slopes, at several lengths that straddle the place in different ways; if none is good
 * enough, the best of them is that can be had, as long as its error stays below FORGIVEN: the run tells how often it missed its
 * tolerance. Where nothing is singular the motion is only quick: much shorter steps are tried first. What the projection moves a
 * step by is an error as well. */
#include "steps/attempts.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "state/ends.h"
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
enum { HOPELESS = 4 };
static const double NEARLY = 10, TO_OTHERS = 0.35;
/* By which the shortest of the lengths has a smaller error, and a still shorter attempt again, where these are none of rounding. */
static const double FALL = 0.01, FALL_AGAIN = 0.2;
/* The share of usual steps, and of those tried before, below which steps across are tried where a singular position lies within so many of
 * those due; how much longer than these they are at least, and than usual ones at most; the error with which they may pass: in units
 * below the user's tolerance, or rounding as it is there. */
static const double SINKS = 0.3, AHEAD = 4, ACROSS = 6, FARTHEST = 1.5, PASSES = 15, ROUNDED = 1e-11;

LagAttempts lag_attempts_begin(LagRun *run)
{
    LagAttempts attempts;
    attempts.rejected = attempts.depth = 0;
    attempts.planned = run->step;
    attempts.allowed = 1;
    attempts.last = attempts.early = INFINITY;
    attempts.way = -1;
    attempts.leaps = 0;
    run->careful = 0;
    return attempts;
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

/* Steps that shrink as the motion comes near a singular position never pass it: each is good and ends before it, where rounding is
 * magnified more than where it began. So they are tried across before they are short. */
static int sinks(LagRun *run, const LagAttempts *attempts, double shorter)
{
    const LagBranch *s = &run->branch;
    const double least = SINKS * (s->sunk > 0 ? s->sunk : s->step), ahead = lag_min(AHEAD * shorter, attempts->planned);
    return !run->careful && attempts->leaps == 0 && shorter < least && lag_singular_is_ahead(run, ahead);
}

static void begin_ways(LagRun *run, LagAttempts *attempts, double planned)
{
    run->careful = 1;
    memset(attempts->errors, 0, sizeof attempts->errors);
    memset(attempts->tries, 0, sizeof attempts->tries);
    attempts->planned = planned;
}

/* Lengths from more than the usual one down to a little more than what was due: the longer they are, the less rounding is magnified at both ends. */
static double length_of(const LagRun *run, const LagAttempts *attempts, int way)
{
    if (attempts->leaps != 1)
        return attempts->planned * WAY[way];
    const double least = ACROSS * attempts->back, place = way < LAG_WAYS ? way : way - LAG_WAYS + 0.5; /* then those between */
    return least * pow(fmax(1, FARTHEST * run->branch.step / least), 1 - place / (LAG_WAYS - 1));
}

/* Back to the length that was due. */
static double leave_ways(LagRun *run, LagAttempts *attempts)
{
    run->careful = 0;
    run->branch.sunk = attempts->back;
    attempts->leaps = 2;
    attempts->way = -1;
    attempts->allowed = 1;
    return attempts->back;
}

static int may_pass(const LagRun *run, double error) { return error <= PASSES || error * run->scale.tolerance <= ROUNDED; }

/* A length not yet tried; then that of the least error, which is allowed now. Should it fail by its projection, that is its error
 * from then on. */
static double next_way(LagRun *run, LagAttempts *attempts, double shorter)
{
    const int ways = attempts->leaps == 1 ? LAG_MOST_WAYS : LAG_WAYS;
    int best = 0;
    for (int i = 1; i < ways && attempts->tries[best] > 0; ++i)
        if (attempts->tries[i] == 0 || attempts->errors[i] < attempts->errors[best])
            best = i;
    const int is_new = attempts->tries[best] == 0;
    if (!is_new && attempts->leaps == 1 && (!may_pass(run, attempts->errors[best]) || attempts->tries[best] > 1))
        return leave_ways(run, attempts);
    if (!is_new && attempts->leaps != 1 && may_plunge(run, attempts)) {
        attempts->way = -1;
        attempts->allowed = 1;
        return ldexp(attempts->planned * WAY[LAG_WAYS - 1], -++attempts->depth);
    }
    attempts->way = is_new || attempts->errors[best] * run->scale.tolerance < FORGIVEN ? best : -1;
    if (attempts->way < 0)
        return shorter;
    ++attempts->tries[best];
    attempts->allowed = is_new ? 1 : fmax(1, 2 * attempts->errors[best]);
    return length_of(run, attempts, best);
}

/* Near singular positions at once, with a length that leads across, and for good: there will be more of them. Where time has no
 * shorter steps (what was held is let go, and begins from nothing), there is nothing to wait for. */
int lag_attempts_leave(LagRun *run, const LagAttempts *attempts, double h, double error, double shorter)
{
    const int is_loop = run->model->n_multipliers > 0, leaves = run->methods.table->leaves_trouble;
    const int is_last = shorter < lag_step_smallest(run->motion.t);
    if (!leaves)
        return 0;
    const int does_sink = is_loop && sinks(run, attempts, shorter);
    if (is_loop && !is_last && !does_sink && is_mendable(run, attempts, h, error))
        return 0;
    if (attempts->rejected < HOPELESS && !is_last && !does_sink && (!is_loop || lag_singularity(run, attempts->planned) < NEARLY))
        return 0;
    run->step = is_loop ? TO_OTHERS * fmax(attempts->planned, run->calm_step) : shorter;
    run->calm_step *= is_loop ? TO_OTHERS : 1;
    return (is_loop && lag_turn_fall_back(run)) || lag_turn_pass(run);
}

double lag_attempts_next(LagRun *run, LagAttempts *attempts, double h, double error, double shorter)
{
    const int is_mended = is_mendable(run, attempts, h, error), leaves = run->methods.table->leaves_trouble;
    attempts->last = error;
    if (run->model->n_multipliers == 0 || leaves)
        return shorter;
    if (sinks(run, attempts, shorter)) {
        begin_ways(run, attempts, attempts->planned);
        attempts->leaps = 1;
        attempts->back = shorter;
        return next_way(run, attempts, shorter);
    }
    if (is_mended)
        return shorter;
    if (!run->careful) {
        begin_ways(run, attempts, fmax(attempts->planned, run->calm_step));
        attempts->rejected = 1;
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
    run->troubled = was_rejected ? run->troubled + 1 : 0;
    /* after a plunge the calm step stays for a while: should a singular position be near after all, it leads across */
    const int has_plunged = attempts->depth > 0 && attempts->depth < IN_VAIN;
    run->plunges = run->plunged < PLUNGED - LATELY ? has_plunged : run->plunges + has_plunged;
    run->plunged = has_plunged ? PLUNGED : run->plunged - (run->plunged > 0);
    if (!was_rejected)
        run->calm_step = fmax(h, run->plunged > 0 ? run->calm_step : run->calm_step / 2);
}
