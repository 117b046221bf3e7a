#include "events/jumps.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/cones.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "state/state.h"

/* What of accelerations is rounding. */
static const double UNKNOWN = 1024 * DBL_EPSILON;
static const double NO_FORCE = 1e-13; /* of a force of the size of others: what others hold, a contact does not */
static const double MOMENT = 1e-3;    /* s */
static const double ANY = 1e300;      /* of two together it is known later whether there is enough */
static const double LITTLE = 1e-3;    /* of the largest change of an acceleration by a contact */
static const double TANGENT = 1e-3;   /* of a change of shares: accelerations change nearly in proportion, and many digits are left */

void lag_sliding_rates(LagRun *run, double t, const double *y)
{
    const int n = run->model->n;
    lag_motion_slope(&run->motion, t, y, y + n, run->switches.slope);
    lag_conditions_of_motion(run, t, y, y + n, run->switches.slope + n, run->sliding.g, run->sliding.rate);
}

/* Takes notice of accelerations without the jumps, in slope_without, and of the latest ones, with one: rounding of what slides is that
 * of a difference of such ones. What is infinite there, as 0/0 of a force at rest, excuses no errors. */
static void note_noise(LagRun *run)
{
    LagScale *scale = &run->scale;
    const int n = run->model->n;
    const double *with = run->switches.slope + n, *without = run->sliding.slope_without + n;
    for (int i = 0; i < n; ++i) {
        const double size = lag_max(fabs(with[i]), fabs(without[i]));
        scale->onset[i] = lag_max(isfinite(size) ? UNKNOWN * size : 0, scale->onset[i]);
        scale->noise[i] = lag_max(scale->onset[i], scale->noise[i]);
    }
}

/* What slides has energies of the size of what jumps would set in motion, as candidate j does. */
static void note_sizes(LagRun *run, double t, const double *y, int count, int j)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    double energies[3];
    note_noise(run);
    for (int i = 0; i < n; ++i) {
        s->state_here[i] = y[i];
        s->state_here[n + i] = 2 * (run->switches.slope[n + i] - s->slope_without[n + i]);
    }
    lag_energies(run, t, s->state_here, energies);
    s->energy = lag_max(fabs(energies[0]), s->energy);
    s->is_light[j] = energies[0] == 0 && s->jump[j + j * count] < 0;
}

/* How much another share of candidate j changes all rates and accelerations, by the share: into its columns. */
static void probe(LagRun *run, double t, const double *y, int count, int j, double change)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    *lag_share(run, s->which[j]) = s->base[j] + change;
    lag_sliding_rates(run, t, y);
    for (int k = 0; k < count; ++k)
        s->jump[k + j * count] = (s->rate[s->which[k]] - s->middle[k]) / change;
    for (int i = 0; i < n; ++i)
        s->way[i + j * n] = (run->switches.slope[n + i] - s->slope_without[n + i]) / change;
    *lag_share(run, s->which[j]) = s->base[j];
}

/* A force of a contact that changes accelerations by as much as they are without it, or usually: v^2/q. Those with it, 1, are the
 * latest. */
static double force_of_size(const LagRun *run)
{
    const double *without = run->sliding.slope_without, *with = run->switches.slope, *size = run->scale.floor;
    const int n = run->model->n;
    double most = 0, change = 0;
    for (int i = n; i < 2 * n; ++i)
        change = lag_max(fabs(with[i] - without[i]), change);
    for (int i = n; i < 2 * n; ++i) {
        const double place = lag_max(size[i - n], size[i] * MOMENT); /* what has just begun has no size yet */
        const double usual = place > 0 ? size[i] * size[i] / place : 0, own = lag_max(fabs(without[i]), usual);
        if (fabs(with[i] - without[i]) > LITTLE * change)
            most = lag_max(own / fabs(with[i] - without[i]), most);
    }
    return most > 0 && most < INFINITY ? most : 1;
}

/* What shares of candidate j are measured by. */
static void find_unit(LagRun *run, double t, const double *y, int count, int j)
{
    LagSliding *s = &run->sliding;
    const int is_jump = lag_may_have_all(run, s->which[j]);
    if (!is_jump)
        probe(run, t, y, count, j, 1);
    s->unit[j] = is_jump ? 1 : force_of_size(run);
    s->least[j] = !is_jump ? NO_FORCE * s->unit[j] : lag_cones_have(run, s->which[j]) ? -ANY : 0;
}

/* What the share of candidate j is changed by. */
static double find_change(const LagRun *run, int j, LagJumpsAt where)
{
    const double change = lag_share_step(run, j);
    return run->model->shares_bend && where == LAG_ELSEWHERE ? TANGENT * change : change;
}

void lag_jumps_begin(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k) {
        const int is_jump = lag_may_have_all(run, s->which[k]);
        s->is_new[k] = s->most_jump[s->which[k]] == 0;
        s->share[k] = is_jump ? 0.5 : 0;
        s->limit[k] = !is_jump ? INFINITY : lag_cones_have(run, s->which[k]) ? ANY : 1;
        *lag_share(run, s->which[k]) = s->share[k];
    }
}

void lag_jumps_find(LagRun *run, double t, const double *y, int count, LagJumpsAt where)
{
    LagSliding *s = &run->sliding;
    lag_sliding_rates(run, t, y);
    memcpy(s->slope_without, run->switches.slope, 2 * (size_t)run->model->n * sizeof *y);
    for (int k = 0; k < count; ++k) {
        s->middle[k] = s->rate[s->which[k]];
        s->base[k] = *lag_share(run, s->which[k]);
    }
    for (int j = 0; j < count; ++j) {
        if (where == LAG_FIRST)
            find_unit(run, t, y, count, j);
        probe(run, t, y, count, j, find_change(run, j, where));
        if (where != LAG_ELSEWHERE)
            note_sizes(run, t, y, count, j);
    }
    for (int k = 0; k < count; ++k) {
        double *jump = &s->jump[k + k * count];
        const double size = fabs(*jump) * s->unit[k], most = lag_max(size, s->most_jump[s->which[k]]);
        if (where != LAG_ELSEWHERE)
            s->most_jump[s->which[k]] = most;
        const int other = s->partner[s->which[k]]; /* both components are one slip's */
        if (where != LAG_ELSEWHERE && other >= 0)
            s->most_jump[other] = lag_max(most, s->most_jump[other]);
        const int rests = run->switches.slides[s->which[k]] && size + fabs(s->middle[k]) < LAG_VANISHED * most;
        *jump = rests ? -LAG_VANISHED * most / s->unit[k] : *jump; /* nothing holds it, or need to: friction may come again */
    }
}
