/* Near a singular position of a constrained mechanism (a parallelogram folded flat) rounding is magnified, and the shorter
 * the step, the more of its stages feel it: shrinking leads ever deeper in. The motion itself is smooth there. So the step
 * is tried again with projected slopes, at several lengths that straddle the place in different ways; if none is good
 * enough, the best of them is, as long as its error stays below FORGIVEN. */
#include "attempts.h"

#include <math.h>

enum { WAYS = 8, PATIENT = 2 };
static const double WAY[WAYS] = {1, 0.77, 1.29, 0.6, 0.45, 0.9, 1.1, 0.35}, FORGIVEN = 1e-8;
/* An ordinary rejection: not one of several in a row, of a step much longer than the last good ones or with an error that a
 * shorter one mends. */
static const double MUCH_LONGER = 1.5, MENDABLE = 50;

LagAttempts lag_attempts_begin(LagRun *run)
{
    const LagAttempts attempts = {0, run->step, run->step, INFINITY, 1};
    run->careful = 0;
    return attempts;
}

double lag_attempts_next(LagRun *run, LagAttempts *attempts, double h, double error, double shorter)
{
    const int is_first = run->troubled < PATIENT && attempts->rejected == 1;
    const int is_ordinary = is_first && (error < MENDABLE || h > MUCH_LONGER * run->calm_step);
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

void lag_attempts_end(LagRun *run, const LagAttempts *attempts, double h, double error)
{
    const int was_rejected = attempts->rejected > 0;
    run->careful = 0;
    run->statistics.tolerance_missed += error > 1;
    run->troubled = was_rejected ? run->troubled + 1 : 0;
    run->calm_step = was_rejected ? run->calm_step : fmax(h, run->calm_step / 2);
}
