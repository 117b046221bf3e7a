/* The user gives one number, `tolerance`; units and sizes are the model's own affair. A unit of error is
 *
 *     CAUTION tolerance max(|y_i|, OWN largest |y_i| so far, GROUP largest |y_j| so far of any coordinate of its kind)
 *
 * so that scenes in micrometres and in light-seconds are the same to the integrator, a passage through zero is not resolved
 * to zero, and a coordinate that hardly moves is not resolved below what matters to its likes. Angles count as pi at most:
 * a wheel that has turned a million times is still known to a fraction of a turn.
 *
 * A rate cannot be known better than rounding of its position allows over a step: eps |q_i| / h. Without this floor a stiff
 * spring (1e6 N/m on 1 kg) at tolerance 1e-14 took 3.3 million steps of noise, with it 60 thousand, to the same accuracy.
 *
 * The constants were chosen on Kepler orbits (e = 0.6, 0.99), pendulums, linear vibration, double pendulums and a stiff
 * spring pendulum, for fewest evaluations to a given error. CAUTION makes a tolerance of 1e-12 mean 1e-9 in the end, in
 * motions that do not lose more digits by themselves.
 */
#include "scale.h"

#include <float.h>
#include <string.h>

#include "extremes.h"
#include "model.h"

static const double OWN = 0.3, GROUP = 0.01, CAUTION = 0.05, SMALLEST = 2e-15, ANGLE_CAP = 3.141592653589793;

double lag_scale_caution(double tolerance) { return fmax(CAUTION * tolerance, SMALLEST); }

void lag_scale_init(LagScale *scale, int n, const int *kind, double tolerance)
{
    scale->n = n;
    scale->kind = kind;
    scale->tolerance = lag_scale_caution(tolerance);
    scale->kinds = 0;
    for (int i = 0; i < n; ++i)
        if (kind[i] >= scale->kinds)
            scale->kinds = kind[i] + 1;
}

void lag_scale_layout(LagScale *scale, LagArena *arena)
{
    const size_t size = 2 * (size_t)scale->n, kinds = (size_t)scale->kinds;
    scale->cap = lag_take(arena, size);
    scale->largest = lag_take(arena, size);
    scale->floor = lag_take(arena, size);
    scale->group = lag_take(arena, 2 * kinds);
    scale->noise = lag_take(arena, (size_t)scale->n);
    scale->motion = lag_take(arena, kinds);
    scale->change = lag_take(arena, kinds);
}

void lag_scale_reset(LagScale *scale)
{
    const int n = scale->n;
    const size_t size = 2 * (size_t)n * sizeof(double);
    memset(scale->largest, 0, size);
    memset(scale->floor, 0, size);
    memset(scale->noise, 0, size / 2);
    memset(scale->group, 0, 2 * (size_t)scale->kinds * sizeof(double));
    scale->rate_rounding = scale->step = 0;
    scale->is_resting = 1;
    for (int i = 0; i < n; ++i) {
        scale->cap[i] = scale->kind[i] == LAG_KIND_ANGLE ? ANGLE_CAP : INFINITY;
        scale->cap[n + i] = INFINITY;
    }
}

static double *group_of(const LagScale *scale, int i)
{
    const int n = scale->n;
    return i < n ? scale->group + scale->kind[i] : scale->group + scale->kinds + scale->kind[i - n];
}

void lag_scale_note(LagScale *scale, const double *y)
{
    const int size = 2 * scale->n;
    for (int i = 0; i < size; ++i) {
        double *group = group_of(scale, i);
        const double magnitude = lag_scale_magnitude(scale, i, y[i], scale->largest[i]);
        scale->largest[i] = magnitude;
        *group = magnitude > *group ? magnitude : *group;
    }
    for (int i = 0; i < size; ++i)
        scale->floor[i] = lag_max(OWN * scale->largest[i], GROUP * *group_of(scale, i));
    scale->is_resting = 0;
    for (int k = scale->kinds; k < 2 * scale->kinds; ++k)
        scale->is_resting |= scale->group[k] == 0;
}

void lag_scale_foresee(const LagScale *scale, const double *y_new)
{
    const int n = scale->n;
    memset(scale->motion, 0, (size_t)scale->kinds * sizeof(double));
    for (int i = 0; i < n; ++i) {
        double *rate = &scale->motion[scale->kind[i]];
        *rate = lag_max(fabs(y_new[n + i]), *rate);
    }
    for (int i = 0; i < n; ++i)
        if (*group_of(scale, n + i) == 0)
            scale->floor[n + i] = GROUP * scale->motion[scale->kind[i]];
}

int lag_scale_at_rest(const LagScale *scale)
{
    for (int k = 0; k < 2 * scale->kinds; ++k)
        if (scale->group[k] > 0)
            return 0;
    return 1;
}

void lag_scale_set_step(LagScale *scale, double h)
{
    scale->rate_rounding = DBL_EPSILON / h;
    scale->step = h;
}
