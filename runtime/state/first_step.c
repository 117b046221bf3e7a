/* After E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), II.4: how soon do the
 * accelerations change? Their algorithm compares y with y', which says nothing at rest in the origin, where most
 * mechanisms start. Here a parabola of length h is tried, shortened tenfold until the accelerations at its end differ from
 * those at its beginning by less than half; so only ratios are compared and units do not matter.
 */
#include "state/first_step.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"

static const double LARGE_CHANGE = 0.5, SHRINK = 0.1;

static void note_largest(double *largest, double value) { *largest = value > *largest ? value : *largest; }

/* Change of the accelerations between k (here) and k_end (after h), relative to what moves coordinates of the same kind:
 * their accelerations, or their velocities. A kind without either, but for rounding, says nothing, nor does one that they move by less than
 * `faint` units of error: a bar that meets the ground at one end is first turned by rounding. */
static double compare(const LagScale *scale, double h, double faint, const double *k, const double *k_end)
{
    const int n = scale->n;
    double largest = 0;
    memset(scale->motion, 0, (size_t)scale->kinds * sizeof(double));
    for (int i = 0; i < n; ++i) {
        const double motion = lag_max(fabs(k[i]), h * fabs(k[n + i]));
        if (motion > h * scale->onset[i])
            note_largest(&scale->motion[scale->kind[i]], motion);
    }
    for (int i = 0; i < n; ++i) {
        const double motion = scale->motion[scale->kind[i]], change = fabs(k_end[n + i] - k[n + i]) - scale->onset[i];
        if (motion > 0 && h * motion >= faint * scale->tolerance * scale->floor[i])
            note_largest(&largest, h * change / motion);
    }
    return largest;
}

/* The same along a parabola of length h. */
static double change_over(LagMotion *m, const LagScale *scale, double h, double faint)
{
    const int n = m->n;
    const double *k = m->slope;
    double *k_end = m->sum;
    for (int i = 0; i < n; ++i) {
        m->point[i] = m->y[i] + h * (k[i] + h / 2 * k[n + i]);
        k_end[i] = k[i] + h * k[n + i];
    }
    return lag_motion_slope(m, m->t + h, m->point, k_end, k_end) ? compare(scale, h, faint, k, k_end) : INFINITY;
}

double lag_slowness(LagMotion *m, const LagScale *scale, double longest, double faint)
{
    double h = longest, change = change_over(m, scale, h, faint);
    while (!(change < LARGE_CHANGE) && m->t + SHRINK * h > m->t) {
        h *= SHRINK;
        change = change_over(m, scale, h, faint);
    }
    return change > 0 ? h / sqrt(change) : h;
}

double lag_first_step(const LagScale *scale, double slowness, int order)
{
    return slowness * pow(scale->tolerance, 1.0 / order);
}
