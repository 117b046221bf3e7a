/* The embedded method of order s with s stages: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II (1996), IV.8.
 * Its error h/gamma (f_0 + sum e_i Z_i/h) is multiplied by (1 - h J/gamma)^-1, so that it stays bounded for stiff components;
 * once more, by an evaluation, in first steps and after rejections.
 */
#include <math.h>

#include "methods/radau.h"
#include "steps/step.h"

/* error = (mu - J)^-1 (slope of rates + sum e_i Z_i/h; position part), for rates `force` and positions `place` of the
 * residual: (mu - J_v - J_q/mu) e_v = force + J_q place/mu, e_q = (place + e_v)/mu. */
static void filter(LagRadau *s, int n, double mu, const double *place, double *force)
{
    for (int k = 0; k < n; ++k)
        s->w_im[k] = place[k] / mu;
    lag_border_solve(&s->border, &s->matrix, 0, force, NULL, s->w_im, s->error + n, NULL);
    for (int k = 0; k < n; ++k)
        s->error[k] = (place[k] + s->error[n + k]) / mu;
}

static double norm(const LagRadau *s, const LagMotion *m, const LagScale *scale, int *worst)
{
    double sum = 0, largest = 0;
    int moving = 0;
    for (int i = 0; i < 2 * m->n; ++i) {
        const double unit = lag_radau_unit(s, m, scale, i, m->other);
        if (unit == 0)
            continue;
        ++moving;
        const double error = s->error[i] / unit;
        sum += error * error;
        if (fabs(error) > largest) {
            largest = fabs(error);
            *worst = i;
        }
    }
    return sum > 0 ? sqrt(sum / moving) : sum;
}

double lag_radau_error(LagRadau *s, LagRun *run, double h, int again, int *worst)
{
    LagMotion *m = &run->motion;
    const int n = m->n, stages = s->tableau->stages;
    const double mu = s->tableau->eigenvalue[0] / h;
    double *place = s->filtered, *force = s->filtered + n;
    for (int k = 0; k < n; ++k) {
        double sum = 0;
        place[k] = 0;
        for (int i = 0; i < stages; ++i) {
            sum += s->tableau->error[i] * s->trial.rate[i * n + k];
            place[k] += s->tableau->error_place[i] * s->trial.rate[i * n + k];
        }
        force[k] = sum / h + s->slope[n + k];
    }
    filter(s, n, mu, place, force);
    double error = norm(s, m, &run->scale, worst);
    if (!(error >= 1) || !again)
        return error >= 0 ? error : INFINITY;
    for (int k = 0; k < n; ++k) {
        m->point[k] = m->y[k] + s->error[k];
        m->point[n + k] = m->y[n + k] + s->error[n + k];
        place[k] += s->error[n + k];
    }
    if (!lag_motion_slope(m, m->t, m->point, m->point + n, m->sum))
        return error;
    for (int k = 0; k < n; ++k)
        force[k] += m->sum[n + k] - s->slope[n + k];
    filter(s, n, mu, place, force);
    error = norm(s, m, &run->scale, worst);
    return error >= 0 ? error : INFINITY;
}
