/* Dormand-Prince 8(5,3): E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), II.5, II.6.
 *
 * State y = (q, v, e): e are energy quadratures, carried along but left out of the error estimate. A stage's velocity is
 * written where the slope of its position belongs, so q' = v costs nothing. The slope at the end of a step is the first of
 * the next (slope 12 of 0 .. 12). Slopes 13 to 15 are evaluated only when someone looks inside a step.
 */
#include "dop853.h"

#include <math.h>
#include <string.h>

#include "dop853_tableau.h"
#include "step.h"

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    LagDop853 *s = self;
    for (int i = 0; i < LAG_DOP853_SLOPES; ++i)
        s->k[i] = lag_take(arena, (size_t)m->size);
    for (int i = 0; i < LAG_DOP853_COEFFICIENTS; ++i)
        s->dense[i] = lag_take(arena, (size_t)m->size);
}

/* sum = weights of the row times slopes, for the first `size` components; four at a time, in four independent chains. */
static void combine(const LagDop853 *s, const LagTableauRow *row, int size, double *sum)
{
    for (int i = 0; i < size; i += 4) {
        double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
        for (int j = 0; j < row->count; ++j) {
            const double w = row->weight[j], *k = s->k[row->column[j]] + i;
            s0 += w * k[0];
            s1 += w * k[1];
            s2 += w * k[2];
            s3 += w * k[3];
        }
        sum[i] = s0;
        sum[i + 1] = s1;
        sum[i + 2] = s2;
        sum[i + 3] = s3;
    }
}

/* Slope i of the step of length h from (t, y). */
static int stage(LagDop853 *s, LagMotion *m, int i, double t, const double *y, double h)
{
    const int n = m->n;
    double *k = s->k[i];
    combine(s, &lag_dop853_stage[i], 2 * n, m->sum);
    for (int j = 0; j < n; ++j) {
        m->point[j] = y[j] + h * m->sum[j];
        k[j] = y[n + j] + h * m->sum[n + j];
    }
    return lag_motion_slope(m, t + lag_dop853_node[i] * h, m->point, k, k);
}

static void add_step(LagDop853 *s, LagMotion *m, double h)
{
    combine(s, &lag_dop853_stage[LAG_DOP853_STAGES], m->size, m->sum);
    for (int i = 0; i < m->size; ++i)
        m->sum[i] *= h;
    lag_motion_add(m, m->sum);
}

/* Hairer's combination of the two embedded errors, root mean square over positions and rates that move. */
static double estimate(LagDop853 *s, LagMotion *m, double h, const LagScale *scale, int *worst)
{
    const int size = 2 * m->n;
    double sum5 = 0, sum3 = 0, largest = 0;
    int moving = 0;
    combine(s, &lag_dop853_error5, size, m->sum);
    combine(s, &lag_dop853_error3, size, m->point);
    for (int i = 0; i < size; ++i) {
        const double unit = lag_scale_unit(scale, i, m->y, m->other);
        if (unit == 0)
            continue;
        ++moving;
        const double error5 = m->sum[i] / unit, error3 = m->point[i] / unit;
        sum5 += error5 * error5;
        sum3 += error3 * error3;
        if (fabs(error5) > largest) {
            largest = fabs(error5);
            *worst = i;
        }
    }
    const double denominator = sum5 + 0.01 * sum3;
    return denominator > 0 ? fabs(h) * sum5 / sqrt(denominator * moving) : denominator;
}

static void restart(void *self, LagMotion *m)
{
    LagDop853 *s = self;
    memcpy(s->k[0], m->slope, (size_t)m->size * sizeof *m->slope);
    s->first_slope_is_last = 0;
}

static void swap(double **a, double **b)
{
    double *c = *a;
    *a = *b;
    *b = c;
}

static double attempt(void *self, LagMotion *m, double t_new, const LagScale *scale, int *worst)
{
    LagDop853 *s = self;
    const double h = t_new - m->t;
    m->t_old = m->t;
    if (s->first_slope_is_last)
        swap(&s->k[0], &s->k[LAG_DOP853_STAGES]);
    s->first_slope_is_last = 0;
    for (int i = 1; i < LAG_DOP853_STAGES; ++i)
        if (!stage(s, m, i, m->t, m->y, h)) {
            *worst = m->n + lag_first_not_finite(s->k[i] + m->n, m->n);
            return INFINITY;
        }
    add_step(s, m, h);
    const double error = estimate(s, m, h, scale, worst);
    return error >= 0 ? error : INFINITY;
}

static int accept(void *self, LagMotion *m, double t_new)
{
    LagDop853 *s = self;
    if (!lag_motion_slope(m, t_new, m->other, m->other + m->n, s->k[LAG_DOP853_STAGES]))
        return 0;
    lag_motion_take(m, t_new);
    s->first_slope_is_last = 1;
    s->dense_ready = 0;
    return 1;
}

/* Coefficients of the polynomial that interpolate evaluates. */
static void prepare_dense(LagDop853 *s, LagMotion *m)
{
    const double h = m->t - m->t_old, *k_old = s->k[0], *k_new = s->k[LAG_DOP853_STAGES];
    for (int i = LAG_DOP853_STAGES + 1; i < LAG_DOP853_ALL_STAGES; ++i)
        stage(s, m, i, m->t_old, m->other, h);
    for (int i = 0; i < m->size; ++i) {
        const double step = m->y[i] - m->other[i];
        s->dense[0][i] = step;
        s->dense[1][i] = h * k_old[i] - step;
        s->dense[2][i] = 2 * step - h * (k_new[i] + k_old[i]);
    }
    for (int r = 0; r < LAG_DOP853_DENSE_ROWS; ++r) {
        double *coefficient = s->dense[3 + r];
        combine(s, &lag_dop853_dense[r], m->size, coefficient);
        for (int i = 0; i < m->size; ++i)
            coefficient[i] *= h;
    }
    s->dense_ready = 1;
    ++m->dense_outputs;
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagDop853 *s = self;
    if (!s->dense_ready)
        prepare_dense(s, m);
    const double x = (t - m->t_old) / (m->t - m->t_old), rest = 1 - x;
    for (int i = 0; i < m->size; ++i) {
        double sum = 0;
        for (int j = LAG_DOP853_COEFFICIENTS - 1; j >= 0; --j)
            sum = (sum + s->dense[j][i]) * (j % 2 == 0 ? x : rest);
        y[i] = m->other[i] + sum;
    }
}

const LagMethod lag_dop853 = {"erk", 8, layout, restart, lag_step_adaptive, attempt, accept, interpolate};
