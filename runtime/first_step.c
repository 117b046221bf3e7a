/* After E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), II.4: how soon do the
 * accelerations change? Their algorithm compares y with y', which says nothing at rest in the origin, where most
 * mechanisms start. Here a parabola of length h is tried, shortened tenfold until the accelerations at its end differ from
 * those at its beginning by less than half; so only ratios are compared and units do not matter.
 */
#include "first_step.h"

#include <math.h>

static const double LARGE_CHANGE = 0.5, SHRINK = 0.1;

/* Change of the accelerations of one kind between k (here) and k_end (after h), relative to what moves coordinates of this
 * kind: their acceleration, or their velocity. A kind without either says nothing. */
static double change_of_kind(const LagDop853 *s, const LagScale *scale, int kind, double h, const double *k, const double *k_end)
{
    double motion = 0, change = 0;
    for (int i = 0; i < s->n; ++i) {
        if (scale->kind[i] != kind)
            continue;
        const double a = k[s->n + i], a_end = k_end[s->n + i];
        motion = fmax(motion, fmax(fabs(k[i]), h * fabs(a)));
        change = fmax(change, h * fabs(a_end - a));
    }
    return motion > 0 ? change / motion : 0;
}

static double change_over(LagDop853 *s, const LagScale *scale, double h)
{
    const int n = s->n;
    const double *k = s->k[0];
    double *k_end = s->k[1], change = 0;
    for (int i = 0; i < n; ++i) {
        s->point[i] = s->y[i] + h * (k[i] + h / 2 * k[n + i]);
        k_end[i] = k[i] + h * k[n + i];
    }
    ++s->evaluations;
    if (!s->rhs(s->context, s->t + h, s->point, k_end, k_end + n, k_end + 2 * n))
        return INFINITY;
    for (int i = 0; i < n; ++i)
        change = fmax(change, change_of_kind(s, scale, scale->kind[i], h, k, k_end));
    return change;
}

double lag_first_step(LagDop853 *s, const LagScale *scale, double longest)
{
    double h = longest, change = change_over(s, scale, h);
    while (!(change < LARGE_CHANGE) && s->t + SHRINK * h > s->t) {
        h *= SHRINK;
        change = change_over(s, scale, h);
    }
    const double slowness = change > 0 ? h / sqrt(change) : longest;
    return fmin(longest, slowness * pow(scale->tolerance, 1.0 / 8));
}
