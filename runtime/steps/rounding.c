/* Where the equations magnify rounding (long chains of links, whose far angles are small differences), accelerations are
 * uncertain by much more than their last digit. Errors of rates below what that makes of them in a step are noise: no shorter
 * step has smaller ones. A state is moved by rounding errors of its coordinates, and the change of the accelerations tells.
 *
 * A chain of 100 links at tolerance 1e-12: steps of 1e-8 s, with no end in sight, become steps of 1e-4 s. The first hundredth
 * of a second of 2 000 links at 1e-8: 11 steps in place of 4 396.
 *
 * What symmetry alone keeps at rest (the angle of a hinge through which all forces pass) is moved by nothing but rounding: its
 * accelerations change by about themselves where the state, or what is computed of parameters, changes in its last digits. Positions
 * are known no better than that then: a block that falls through a hinge took 16 million steps of rounding, a body of 16 parts with
 * springs that falls freely 63 000 in a tenth of a second.
 */
#include "steps/rounding.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "state/state.h"
#include "steps/roots.h"
#include "steps/step.h"

/* Uncertainties in a step that count as one unit of error: errors of noise must stay well below it, or steps would go on
 * shrinking. What each coordinate has at least of the largest of its kind. Of FEW coordinates tolerances above COARSE are
 * near noise only where rates are nothing else, at rest: that is soon enough seen after an interval. */
static const double UNIT = 32, SHARE = 0.1, COARSE = 1e-11;
enum { INTERVAL = 64, FEW = 100 };
/* Moves of the last digits; accelerations that are no more than so many changes by these are rounding. */
enum { MOVES = 4 };
static const double CHANGES = 8;

/* The state with each coordinate moved by rounding of the largest of its kind, or of an angle of 1. */
static void move(const LagMotion *m, const LagScale *scale, double *moved)
{
    const int n = m->n;
    for (int i = 0; i < n; ++i) {
        const double sign = i % 3 == 0 ? -DBL_EPSILON : DBL_EPSILON, *group = scale->group + scale->kind[i];
        const int is_angle = isfinite(scale->cap[i]);
        moved[i] = m->y[i] + sign * (is_angle ? lag_max(1, *group) : *group);
        moved[n + i] = m->y[n + i] + sign * group[scale->kinds];
    }
}

/* Whether coordinate i moves, by no more than rounding of accelerations as they may be makes of it. */
static int may_be_idle(const LagRun *run, const double *all, int i)
{
    const LagMotion *m = &run->motion;
    const LagScale *scale = &run->scale;
    const int n = m->n;
    const double noise = all[i], moves = lag_max(scale->largest[i], scale->largest[n + i]), lasts = fabs(m->t - run->settings.t_start);
    return moves > 0 && lasts > 0 && fabs(m->slope[n + i]) <= noise && scale->largest[n + i] <= noise * lasts;
}

/* By what number i is multiplied in a move. */
static double last_digits(int i, int move)
{
    return 1 + ((i + move) % 3 - 1) * move * DBL_EPSILON;
}

/* What depends on parameters alone has rounding as well: what falls freely has none of its own where its parts do not move. */
static void move_parameters(LagRun *run, int move)
{
    const int count = run->model->n_hoisted;
    memcpy(run->c_kept, run->c, (size_t)count * sizeof *run->c);
    for (int i = 0; i < count; ++i)
        run->c[i] *= last_digits(i, move);
}

/* Accelerations that are nothing but rounding. */
static void look_for_idle(LagRun *run, const double *noise)
{
    LagMotion *m = &run->motion;
    LagScale *scale = &run->scale;
    const int n = m->n;
    double *moved = m->point, *slope = m->sum;
    int any = 0;
    for (int i = 0; i < n && !any; ++i)
        any = may_be_idle(run, noise, i);
    for (int move = 1; any && move <= MOVES; ++move) {
        for (int i = 0; i < 2 * n; ++i)
            moved[i] = m->y[i] * last_digits(i, move);
        move_parameters(run, move);
        const int is_finite = lag_motion_slope(m, m->t, moved, moved + n, slope);
        memcpy(run->c, run->c_kept, (size_t)run->model->n_hoisted * sizeof *run->c);
        if (!is_finite)
            return;
        for (int i = 0; i < n; ++i) {
            const double change = fabs(slope[n + i] - m->slope[n + i]);
            if (!(fabs(m->slope[n + i]) <= CHANGES * change) || !may_be_idle(run, noise, i))
                continue;
            scale->idle[i] = lag_max(UNIT * change, scale->idle[i]);
            scale->noise[i] = lag_max(scale->idle[i], scale->noise[i]);
        }
    }
}

/* m->slope, and by how much rounding of the state changes accelerations. Returns 0 where they have no value. */
static int find_noise(LagRun *run, double *noise)
{
    LagMotion *m = &run->motion;
    const LagScale *scale = &run->scale;
    const int n = m->n;
    double *largest = scale->motion, *moved = m->point, *slope = m->sum;
    move(m, scale, moved);
    if (!lag_motion_slope(m, m->t, m->y, m->y + n, m->slope) || !lag_motion_slope(m, m->t, moved, moved + n, slope))
        return 0;
    memset(largest, 0, (size_t)scale->kinds * sizeof *largest);
    for (int i = 0; i < n; ++i) {
        double *most = &largest[scale->kind[i]];
        noise[i] = lag_max(UNIT * fabs(slope[n + i] - m->slope[n + i]), scale->onset[i]);
        *most = lag_max(noise[i], *most);
    }
    for (int i = 0; i < n; ++i)
        noise[i] = lag_max(noise[i], SHARE * largest[scale->kind[i]]);
    return 1;
}

void lag_rounding_look(LagRun *run)
{
    if (lag_roots_are_close(run, run->step)) /* what turns round there is no noise */
        return;
    if (find_noise(run, run->scale.noise))
        look_for_idle(run, run->scale.noise);
}

void lag_rounding_watch(LagRun *run)
{
    const int64_t steps = run->statistics.steps;
    const int may_matter = steps > 0 || run->scale.tolerance < COARSE || run->model->n > FEW;
    if (may_matter && lag_step_is_every(run, INTERVAL))
        lag_rounding_look(run);
}

void lag_rounding_watch_idle(LagRun *run)
{
    double *noise = run->motion.other;
    if (run->statistics.steps > 0 && lag_step_is_every(run, INTERVAL) && find_noise(run, noise))
        look_for_idle(run, noise);
}
