/* A load that rises smoothly from nothing is less than its own rounding at first: 1 - cos(20 t) is 0 until 1e-16 can be told from 1,
 * and goes up in steps of that. No step is short enough to resolve them. What the loads will be tells how much they are: at rest
 * nothing else acts.
 *
 * The end of a step tried from rest tells how large the motion will be, unless the step was explicit and stiff and ended anywhere,
 * faster than the loads at its end could have made anything: then these tell.
 */
#include "state/onset.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "numbers/extremes.h"

/* Loads are sums and products of several rounded numbers. */
static const double ROUNDINGS = 8, SANE = 2, SOON = 100, FAINT = LAG_ONSET_FAINT;
enum { LOOKS = 16 };
/* Where a jump or a corner that nobody announced sets coordinates of a kind in motion, this has no size to compare errors with but
 * rounding, however short the step: they grow by SUDDEN. After so many rejections, whatever steps lead up to it in between,
 * the motion of the step just tried, or what loads make of it, is taken for its size. */
enum { PATIENCE = 3, LINKS = 3, TRIES = 8 };
static const double SUDDEN = 1e6;
/* Accelerations that change by less in an iteration have settled; how much shorter a motion is then tried. */
static const double SETTLED = 0.25, SHORTER = 0.25;

/* scale->motion: what moves each kind now. Returns whether nothing moves one of them. */
static int find_still(const LagMotion *m, const LagScale *scale)
{
    int is_still = 0;
    memcpy(scale->motion, scale->group + scale->kinds, (size_t)scale->kinds * sizeof *scale->motion);
    for (int i = 0; i < m->n; ++i) {
        double *moving = &scale->motion[scale->kind[i]];
        *moving = lag_max(fabs(m->slope[m->n + i]), *moving);
    }
    for (int i = 0; i < m->n; ++i)
        is_still |= scale->motion[scale->kind[i]] < FAINT;
    return is_still;
}

void lag_onset_look(LagMotion *m, LagScale *scale, double end)
{
    const int n = m->n;
    const double t = m->t, whole = isfinite(end) ? end - t : fmax(1, fabs(t));
    if (!scale->is_resting || !find_still(m, scale))
        return;
    for (int look = 1; look <= LOOKS; ++look) {
        if (!lag_motion_slope(m, t + look * (whole / (LOOKS + 1)), m->y, m->y + n, m->sum))
            continue;
        for (int i = 0; i < n; ++i)
            if (scale->motion[scale->kind[i]] < FAINT)
                scale->onset[i] = lag_max(ROUNDINGS * DBL_EPSILON * fabs(m->sum[n + i]), scale->onset[i]);
    }
    for (int i = 0; i < n; ++i)
        scale->noise[i] = lag_max(scale->onset[i], scale->noise[i]);
}

/* By how much the rates of a kind that the loads do not move from here may change: on the way they may meet what does, but no wall. */
static double most_change(const LagMotion *m, const LagScale *scale, int kind)
{
    double fastest = 0;
    for (int i = 0; i < m->n; ++i)
        if (scale->kind[i] == kind)
            fastest = lag_max(fabs(m->y[m->n + i]), fastest);
    return fastest > 0 ? SOON * fastest : INFINITY;
}

/* Whether each kind ended with rates that the loads can account for. scale->motion: what they do; ->change: the end. */
static int is_sane(const LagMotion *m, const LagScale *scale)
{
    const int n = m->n;
    const size_t size = (size_t)scale->kinds * sizeof(double);
    memset(scale->motion, 0, size);
    memset(scale->change, 0, size);
    for (int i = 0; i < n; ++i) {
        double *by_loads = &scale->motion[scale->kind[i]], *at_end = &scale->change[scale->kind[i]];
        *by_loads = lag_max(fabs(m->point[n + i] - m->y[n + i]), *by_loads);
        *at_end = lag_max(fabs(m->other[n + i] - m->y[n + i]), *at_end);
    }
    for (int k = 0; k < scale->kinds; ++k)
        if (!(scale->change[k] <= (scale->motion[k] > 0 ? SANE * scale->motion[k] : most_change(m, scale, k))))
            return 0;
    return 1;
}

/* Takes notice of the motion that the step just tried has brought about, or that the loads at its end would. */
static void foresee(LagMotion *m, LagScale *scale, double t_new)
{
    const int n = m->n;
    const double h = t_new - m->t;
    if (!lag_motion_slope(m, t_new, m->y, m->y + n, m->sum))
        return;
    for (int i = 0; i < n; ++i) {
        m->point[i] = m->y[i] + h / 2 * h * m->sum[n + i];
        m->point[n + i] = m->y[n + i] + h * m->sum[n + i];
    }
    lag_scale_note(scale, is_sane(m, scale) ? m->other : m->point);
}

/* Whether coordinates of a kind, or their rates, become in the step just tried what they have never been by far, and nothing that
 * accelerates them as the step begins accounts for it. */
static int is_sudden(LagMotion *m, const LagScale *scale, double h)
{
    const int n = m->n;
    int is_known = 0;
    for (int i = 0; i < n; ++i) {
        const double *group = scale->group + scale->kind[i], place = fabs(m->other[i]), rate = fabs(m->other[n + i]);
        if (!(place > SUDDEN * group[0]) && !(rate > SUDDEN * group[scale->kinds]))
            continue;
        if (!is_known && !lag_motion_slope(m, m->t, m->y, m->y + n, m->sum))
            return 0;
        is_known = 1;
        if (rate > SUDDEN * fabs(h * m->sum[n + i]))
            return 1;
    }
    return 0;
}

/* The motion over h, into m->point: by accelerations that change evenly from those here to those at its end, which are iterated
 * (Picard). Returns whether they have settled, kind by kind. */
static int foresee_motion(LagMotion *m, const LagScale *scale, double h)
{
    const int n = m->n;
    const size_t size = (size_t)scale->kinds * sizeof(double);
    double *const before = m->other, *const after = m->sum + n;
    memcpy(after, m->slope + n, (size_t)n * sizeof *after);
    for (int links = 0; links <= LINKS; ++links) {
        memcpy(before, after, (size_t)n * sizeof *before);
        for (int i = 0; i < n; ++i) {
            const double here = m->slope[n + i], change = after[i] - here;
            m->point[i] = m->y[i] + h * (m->slope[i] + h * (here / 2 + change / 6));
            m->point[n + i] = m->y[n + i] + h * (here + change / 2);
        }
        if (!lag_motion_slope(m, m->t + h, m->point, m->point + n, m->sum))
            return 0;
        if (memcmp(before, after, (size_t)n * sizeof *after) == 0)
            break;
    }
    memset(scale->motion, 0, size);
    memset(scale->change, 0, size);
    for (int i = 0; i < n; ++i) {
        double *motion = &scale->motion[scale->kind[i]], *change = &scale->change[scale->kind[i]];
        *motion = lag_max(fabs(after[i]), *motion);
        *change = lag_max(fabs(after[i] - before[i]), *change);
    }
    for (int k = 0; k < scale->kinds; ++k)
        if (scale->change[k] > SETTLED * scale->motion[k])
            return 0;
    return 1;
}

/* A car that meets a kerb with one wheel begins to pitch with the fifth power of time: in units of its pitch by rounding before, a
 * method of low order would need millions of steps. What moves it comes through the wheel and its spring: each iteration goes one
 * link further. */
void lag_onset_expect(LagMotion *m, LagScale *scale, double h)
{
    const int n = m->n;
    int tries = 0, is_sudden = 0;
    for (; !foresee_motion(m, scale, h); h *= SHORTER)
        if (++tries == TRIES)
            return;
    for (int i = 0; i < n; ++i) {
        const double *group = scale->group + scale->kind[i];
        is_sudden |= fabs(m->point[i]) > SUDDEN * group[0] || fabs(m->point[n + i]) > SUDDEN * group[scale->kinds];
    }
    if (is_sudden)
        lag_scale_note(scale, m->point);
}

void lag_onset_learn(LagMotion *m, LagScale *scale, double t_new, double error, double foreseen)
{
    if (error < foreseen)
        lag_scale_note(scale, m->other);
    else if ((lag_scale_at_rest(scale) || is_sudden(m, scale, t_new - m->t)) && ++scale->surprises > PATIENCE)
        foresee(m, scale, t_new);
}

void lag_onset_blur(LagMotion *m, LagScale *scale, double moment)
{
    const int n = m->n;
    if (!lag_motion_slope(m, m->t + moment, m->y, m->y + n, m->sum))
        return;
    for (int i = 0; i < n; ++i) {
        scale->onset[i] = lag_max(fabs(m->sum[n + i] - m->slope[n + i]), scale->onset[i]);
        scale->noise[i] = lag_max(scale->onset[i], scale->noise[i]);
    }
}
