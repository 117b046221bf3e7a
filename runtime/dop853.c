/* Dormand-Prince 8(5,3): E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), II.5, II.6.
 *
 * State y = (q, v, e): e are energy quadratures, carried along but left out of the error estimate. A stage's velocity is
 * written where the slope of its position belongs, so q' = v costs nothing. The slope at the end of a step is the first of
 * the next (slope 12 of 0 .. 12). Slopes 13 to 15 are evaluated only when someone looks inside a step.
 *
 * The state is summed with compensation (W. Kahan, 1965; the two-sum of D. Knuth): y + carry is the state to nearly twice
 * the working precision. Drift of the energy of an oscillator over 300 000 steps: 2e-14 without, 5e-16 with it. (With long
 * steps the rounding of the coefficients is left: 1e-17 a radian.) Needs IEEE arithmetic: no -ffast-math.
 */
#include "dop853.h"

#include <string.h>

#include "dop853_tableau.h"

void lag_dop853_layout(LagDop853 *s, LagArena *arena)
{
    const size_t size = (size_t)s->size;
    s->y = lag_take(arena, size);
    s->carry = lag_take(arena, size);
    s->other = lag_take(arena, size);
    s->other_carry = lag_take(arena, size);
    s->point = lag_take(arena, size);
    s->sum = lag_take(arena, size);
    for (int i = 0; i < LAG_DOP853_SLOPES; ++i)
        s->k[i] = lag_take(arena, size);
    for (int i = 0; i < LAG_DOP853_COEFFICIENTS; ++i)
        s->dense[i] = lag_take(arena, size);
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

/* Slope of the state (q, v); v is copied, unless it is already in its place. */
static int evaluate(LagDop853 *s, double t, const double *q, const double *v, double *k)
{
    if (v != k)
        memcpy(k, v, (size_t)s->n * sizeof *k);
    ++s->evaluations;
    return s->rhs(s->context, t, q, k, k + s->n, k + 2 * s->n);
}

/* Slope i of the step of length h from (t, y). */
static int stage(LagDop853 *s, int i, double t, const double *y, double h)
{
    const int n = s->n;
    double *k = s->k[i];
    combine(s, &lag_dop853_stage[i], 2 * n, s->sum);
    for (int j = 0; j < n; ++j) {
        s->point[j] = y[j] + h * s->sum[j];
        k[j] = y[n + j] + h * s->sum[n + j];
    }
    return evaluate(s, t + lag_dop853_node[i] * h, s->point, k, k);
}

/* other = y + h b k, compensated. */
static void add_step(LagDop853 *s, double h)
{
    combine(s, &lag_dop853_stage[LAG_DOP853_STAGES], s->size, s->sum);
    for (int i = 0; i < s->size; ++i) {
        const double y = s->y[i], step = h * s->sum[i] + s->carry[i], sum = y + step, taken = sum - y;
        s->other[i] = sum;
        s->other_carry[i] = (y - (sum - taken)) + (step - taken);
    }
}

/* Hairer's combination of the two embedded errors, root mean square over positions and rates that move. */
static double estimate(LagDop853 *s, double h, const LagScale *scale, int *worst)
{
    const int size = 2 * s->n;
    double sum5 = 0, sum3 = 0, largest = 0;
    int moving = 0;
    combine(s, &lag_dop853_error5, size, s->sum);
    combine(s, &lag_dop853_error3, size, s->point);
    for (int i = 0; i < size; ++i) {
        const double unit = lag_scale_unit(scale, i, s->y, s->other);
        if (unit == 0)
            continue;
        ++moving;
        const double error5 = s->sum[i] / unit, error3 = s->point[i] / unit;
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

int lag_first_not_finite(const double *x, int n)
{
    int i = 0;
    while (i < n - 1 && isfinite(x[i]))
        ++i;
    return i;
}

int lag_dop853_restart(LagDop853 *s, double t)
{
    s->t = s->t_old = t;
    s->first_slope_is_last = 0;
    return evaluate(s, t, s->y, s->y + s->n, s->k[0]);
}

static void swap(double **a, double **b)
{
    double *c = *a;
    *a = *b;
    *b = c;
}

double lag_dop853_try(LagDop853 *s, double t_new, const LagScale *scale, int *worst)
{
    const double h = t_new - s->t;
    s->t_old = s->t;
    if (s->first_slope_is_last)
        swap(&s->k[0], &s->k[LAG_DOP853_STAGES]);
    s->first_slope_is_last = 0;
    for (int i = 1; i < LAG_DOP853_STAGES; ++i)
        if (!stage(s, i, s->t, s->y, h)) {
            *worst = s->n + lag_first_not_finite(s->k[i] + s->n, s->n);
            return INFINITY;
        }
    add_step(s, h);
    const double error = estimate(s, h, scale, worst);
    return error >= 0 ? error : INFINITY;
}

int lag_dop853_accept(LagDop853 *s, double t_new)
{
    if (!evaluate(s, t_new, s->other, s->other + s->n, s->k[LAG_DOP853_STAGES]))
        return 0;
    swap(&s->y, &s->other);
    swap(&s->carry, &s->other_carry);
    s->t_old = s->t;
    s->t = t_new;
    s->first_slope_is_last = 1;
    s->dense_ready = 0;
    return 1;
}

/* Coefficients of the polynomial that lag_dop853_interpolate evaluates. */
static void prepare_dense(LagDop853 *s)
{
    const double h = s->t - s->t_old, *k_old = s->k[0], *k_new = s->k[LAG_DOP853_STAGES];
    for (int i = LAG_DOP853_STAGES + 1; i < LAG_DOP853_ALL_STAGES; ++i)
        stage(s, i, s->t_old, s->other, h);
    for (int i = 0; i < s->size; ++i) {
        const double step = s->y[i] - s->other[i];
        s->dense[0][i] = step;
        s->dense[1][i] = h * k_old[i] - step;
        s->dense[2][i] = 2 * step - h * (k_new[i] + k_old[i]);
    }
    for (int r = 0; r < LAG_DOP853_DENSE_ROWS; ++r) {
        double *coefficient = s->dense[3 + r];
        combine(s, &lag_dop853_dense[r], s->size, coefficient);
        for (int i = 0; i < s->size; ++i)
            coefficient[i] *= h;
    }
    s->dense_ready = 1;
    ++s->dense_outputs;
}

void lag_dop853_interpolate(LagDop853 *s, double t, double *y)
{
    if (!s->dense_ready)
        prepare_dense(s);
    const double x = (t - s->t_old) / (s->t - s->t_old), rest = 1 - x;
    for (int i = 0; i < s->size; ++i) {
        double sum = 0;
        for (int j = LAG_DOP853_COEFFICIENTS - 1; j >= 0; --j)
            sum = (sum + s->dense[j][i]) * (j % 2 == 0 ? x : rest);
        y[i] = s->other[i] + sum;
    }
}
