/* The embedded method of order s with s stages: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II (1996), IV.8.
 * Its error h/gamma (f_0 + sum e_i Z_i/h) is multiplied by (1 - h J/gamma)^-1, so that it stays bounded for stiff components;
 * once more, by an evaluation, in first steps and after rejections.
 */
#include <math.h>
#include <string.h>

#include "methods/radau.h"
#include "model/attitude_places.h"
#include "steps/step.h"

/* Of an angle that turns more than this in a step, rad, and of what goes so many times as far as any of its kind was, accelerations are
 * looked at between the stages; where, and how far aside for the slope there; by how many units of error of its rate, over the
 * step, and by which share of themselves they may be off: a polynomial is less exact there than at the end. */
static const double TURN = 5, FAR = 5, EARLY = 0.41, LATE = 0.83, ASIDE = 0.01, MOST_APART = 100, SHARE = 0.1;

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

/* Of attitudes, whose positions go other ways than their rates. */
static void place_attitudes(const LagRadau *s, const LagMotion *m, double *place)
{
    for (int i = 0; i < 3 * m->n_attitudes; ++i) {
        const int k = lag_attitude_place(m->attitudes, i / 3) + i % 3;
        place[k] = 0;
        for (int j = 0; j < s->tableau->stages; ++j)
            place[k] += s->tableau->error_place[j] * s->trial.way[j * m->n + k];
    }
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
    place_attitudes(s, m, place);
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

/* Lengths in first steps alone: what begins at rest goes many times as far with each step as before, and what is held moves by rounding. */
static int goes_far(const LagRadau *s, const LagRun *run, int i)
{
    const LagMotion *m = &run->motion;
    const LagScale *scale = &run->scale;
    const double known = fmax(fabs(m->y[i]), scale->group[scale->kind[i]]), way = fabs(m->other[i] - m->y[i]);
    const int is_first = !s->has_last && known > 0 && run->sliding.count == 0;
    return isfinite(scale->cap[i]) ? way > TURN : is_first && way > FAR * known;
}

/* Whether accelerations at the share x of the step are those of its polynomial, of what goes far. */
static int fits_at(LagRadau *s, LagRun *run, double h, double x)
{
    LagMotion *m = &run->motion;
    const int n = m->n;
    double *change = s->error; /* of rates, if accelerations were over the step what they are there */
    lag_collocation_at(&s->trial, m, m->y, x + ASIDE, m->point);
    memcpy(change, m->point + n, (size_t)n * sizeof *change);
    lag_collocation_at(&s->trial, m, m->y, x - ASIDE, m->point);
    for (int i = 0; i < n; ++i)
        change[i] = (change[i] - m->point[n + i]) / (2 * ASIDE);
    lag_collocation_at(&s->trial, m, m->y, x, m->point);
    if (!lag_motion_slope(m, m->t + x * h, m->point, m->point + n, m->sum))
        return 0;
    for (int i = 0; i < n; ++i) {
        const double now = h * m->sum[n + i], share = SHARE * fmax(fabs(now), fabs(change[i]));
        const double most = fmax(share, MOST_APART * lag_radau_unit(s, m, &run->scale, n + i, m->other));
        if (goes_far(s, run, i) && !(fabs(now - change[i]) <= most))
            return 0;
    }
    return 1;
}

int lag_radau_is_solution(LagRadau *s, LagRun *run, double h)
{
    for (int i = 0; i < run->motion.n; ++i)
        if (goes_far(s, run, i))
            return fits_at(s, run, h, EARLY) && fits_at(s, run, h, LATE);
    return 1;
}
