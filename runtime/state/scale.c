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
 * Constraints hold to rounding of the natural sizes of what they tie together, an angle of 1 and its lever. A mechanism that
 * rests where its coordinates are 0 is moved by nothing but that: its steps would be resolved against 1e-20.
 *
 * The constants were chosen on Kepler orbits (e = 0.6, 0.99), pendulums, linear vibration, double pendulums and a stiff
 * spring pendulum, for fewest evaluations to a given error. CAUTION makes a tolerance of 1e-12 mean 1e-9 in the end, in
 * motions that do not lose more digits by themselves.
 */
#include "state/scale.h"

#include <float.h>
#include <string.h>

#include "numbers/extremes.h"
#include "numbers/lanes.h"
#include "model/model.h"

enum { MANY = 8 }; /* coordinates */
static const double OWN = LAG_SCALE_OWN, GROUP = LAG_SCALE_GROUP, CAUTION = 0.05, SMALLEST = 2e-15, ANGLE_CAP = 3.141592653589793;

double lag_scale_caution(double tolerance) { return fmax(CAUTION * tolerance, SMALLEST); }

void lag_scale_init(LagScale *scale, int n, const int *kind, double tolerance)
{
    scale->n = n;
    scale->kind = kind;
    scale->asked = lag_scale_caution(tolerance);
    scale->tolerance = scale->asked;
    scale->kinds = 0;
    scale->is_uniform = 1;
    for (int i = 0; i < n; ++i) {
        scale->is_uniform &= kind[i] == kind[0];
        if (kind[i] >= scale->kinds)
            scale->kinds = kind[i] + 1;
    }
}

void lag_scale_layout(LagScale *scale, LagArena *arena)
{
    const size_t size = 2 * (size_t)scale->n, kinds = (size_t)scale->kinds;
    scale->cap = lag_take(arena, size);
    scale->largest = lag_take(arena, size);
    scale->floor = lag_take(arena, size);
    scale->size = lag_take(arena, size);
    scale->group = lag_take(arena, 2 * kinds);
    scale->noise = lag_take(arena, (size_t)scale->n);
    scale->onset = lag_take(arena, (size_t)scale->n);
    scale->idle = lag_take(arena, (size_t)scale->n);
    scale->motion = lag_take(arena, kinds);
    scale->change = lag_take(arena, kinds);
}

void lag_scale_reset(LagScale *scale)
{
    const int n = scale->n;
    memset(scale->largest, 0, (size_t)(scale->motion - scale->largest) * sizeof(double)); /* all that lies in between */
    scale->tolerance = scale->asked;
    scale->rate_rounding = scale->step = scale->reach = 0;
    scale->is_resting = 1;
    scale->surprises = 0;
    for (int i = 0; i < n; ++i) {
        scale->cap[i] = scale->kind[i] == LAG_KIND_ANGLE ? ANGLE_CAP : INFINITY;
        scale->cap[n + i] = INFINITY;
    }
}

void lag_scale_size(LagScale *scale, const double *size) { memcpy(scale->size, size, (size_t)scale->n * sizeof *size); }

static double *group_of(const LagScale *scale, int i)
{
    const int n = scale->n;
    return i < n ? scale->group + scale->kind[i] : scale->group + scale->kinds + scale->kind[i - n];
}

/* Takes notice of components of one kind, from `first` on as long as there are LAG_LANES before `end`. Returns how far it came. */
static int note_many(const LagScale *scale, const double *y, int first, int end)
{
    double *group = group_of(scale, first);
    LagLanes most = LAG_LANES_OF(0), value, seen, cap;
    int i = first;
    for (; i + LAG_LANES <= end; i += LAG_LANES) {
        memcpy(&value, y + i, sizeof value);
        memcpy(&seen, scale->largest + i, sizeof seen);
        memcpy(&cap, scale->cap + i, sizeof cap);
        value = LAG_LANES_ABS(value);
        value = LAG_LANES_MAX(value, seen);
        value = LAG_LANES_MIN(value, cap);
        memcpy(scale->largest + i, &value, sizeof value);
        most = LAG_LANES_MAX(value, most);
    }
    *group = lag_lanes_largest(&most, *group);
    return i;
}

static int floor_many(const LagScale *scale, int first, int end)
{
    const LagLanes own = LAG_LANES_OF(OWN), least = LAG_LANES_OF(GROUP * *group_of(scale, first));
    const LagLanes rounding = LAG_LANES_OF(DBL_EPSILON / scale->tolerance);
    int i = first;
    for (; i + LAG_LANES <= end; i += LAG_LANES) {
        LagLanes value, size;
        memcpy(&value, scale->largest + i, sizeof value);
        memcpy(&size, scale->size + i, sizeof size);
        value *= own;
        size *= rounding;
        value = LAG_LANES_MAX(value, least);
        value = LAG_LANES_MAX(value, size);
        memcpy(scale->floor + i, &value, sizeof value);
    }
    return i;
}

static inline void note_each(const LagScale *scale, const double *y, int first, int end)
{
    for (int i = first; i < end; ++i) {
        double *group = group_of(scale, i);
        const double magnitude = lag_scale_magnitude(scale, i, y[i], scale->largest[i]);
        scale->largest[i] = magnitude;
        *group = magnitude > *group ? magnitude : *group;
    }
}

static inline void floor_each(const LagScale *scale, int first, int end)
{
    const double rounding = DBL_EPSILON / scale->tolerance;
    for (int i = first; i < end; ++i)
        scale->floor[i] = lag_max(lag_max(OWN * scale->largest[i], GROUP * *group_of(scale, i)), rounding * scale->size[i]);
}

void lag_scale_note(LagScale *scale, const double *y)
{
    const int n = scale->n, size = 2 * n, is_long = scale->is_uniform && n >= MANY;
    for (int first = 0; first < size && is_long; first += n) {
        note_each(scale, y, note_many(scale, y, first, first + n), first + n);
        floor_each(scale, floor_many(scale, first, first + n), first + n);
    }
    if (!is_long) {
        note_each(scale, y, 0, size);
        floor_each(scale, 0, size);
    }
    int is_resting = 0;
    for (int i = n; i < size && scale->is_resting && !is_resting; ++i)
        is_resting = *group_of(scale, i) == 0;
    scale->is_resting = is_resting;
}

void lag_scale_find_motion(const LagScale *scale, const double *values)
{
    memset(scale->motion, 0, (size_t)scale->kinds * sizeof *scale->motion);
    for (int i = 0; i < scale->n; ++i) {
        double *most = &scale->motion[scale->kind[i]];
        *most = lag_max(fabs(values[i]), *most);
    }
}

void lag_scale_foresee(const LagScale *scale, const double *y_new)
{
    const int n = scale->n;
    lag_scale_find_motion(scale, y_new + n);
    for (int i = 0; i < n; ++i)
        if (*group_of(scale, n + i) == 0)
            scale->floor[n + i] = GROUP * scale->motion[scale->kind[i]];
}

/* Magnitudes as lag_scale_magnitude gives them. */
static inline void magnitudes(const LagScale *scale, int i, const double *y_old, const double *y_new, LagLanes *result)
{
    LagLanes old, new, cap;
    memcpy(&old, y_old + i, sizeof old);
    memcpy(&new, y_new + i, sizeof new);
    memcpy(&cap, scale->cap + i, sizeof cap);
    old = LAG_LANES_ABS(old);
    new = LAG_LANES_ABS(new);
    old = LAG_LANES_MAX(old, new);
    old = LAG_LANES_SELECT(old < LAG_LANES_OF(LAG_SCALE_NOTHING), LAG_LANES_OF(0), old);
    *result = LAG_LANES_MIN(old, cap);
}

static inline void raise_and_scale(const LagScale *scale, int i, LagLanes *magnitude)
{
    LagLanes floor;
    memcpy(&floor, scale->floor + i, sizeof floor);
    *magnitude = LAG_LANES_MAX(*magnitude, floor);
    *magnitude *= LAG_LANES_OF(scale->tolerance);
}

void lag_scale_units(const LagScale *scale, const double *y_old, const double *y_new, double *unit)
{
    const int n = scale->n;
    const LagLanes step = LAG_LANES_OF(scale->step), rate_rounding = LAG_LANES_OF(scale->rate_rounding);
    const LagLanes reach = LAG_LANES_OF(scale->reach * scale->reach);
    int i = 0;
    for (; i + LAG_LANES <= n; i += LAG_LANES) {
        LagLanes places, rates, rounding, noise, size, unseen, idle;
        magnitudes(scale, i, y_old, y_new, &places);
        magnitudes(scale, n + i, y_old, y_new, &rates);
        memcpy(&noise, scale->noise + i, sizeof noise);
        memcpy(&size, scale->size + i, sizeof size);
        memcpy(&unseen, scale->onset + i, sizeof unseen);
        memcpy(&idle, scale->idle + i, sizeof idle);
        rounding = rate_rounding * LAG_LANES_MAX(places, size);
        noise *= step;
        noise = LAG_LANES_MAX(rounding, noise);
        raise_and_scale(scale, i, &places);
        unseen *= reach;
        idle *= step * step;
        unseen = LAG_LANES_MAX(unseen, idle);
        places = LAG_LANES_MAX(places, unseen);
        raise_and_scale(scale, n + i, &rates);
        rates = LAG_LANES_MAX(rates, noise);
        memcpy(unit + i, &places, sizeof places);
        memcpy(unit + n + i, &rates, sizeof rates);
    }
    for (; i < n; ++i) {
        unit[i] = lag_scale_unit(scale, i, y_old, y_new);
        unit[n + i] = lag_scale_unit(scale, n + i, y_old, y_new);
    }
}

int lag_scale_at_rest(const LagScale *scale)
{
    for (int k = 0; k < 2 * scale->kinds; ++k)
        if (scale->group[k] > 0)
            return 0;
    return 1;
}

void lag_scale_set_step(LagScale *scale, double h, int is_implicit)
{
    scale->rate_rounding = DBL_EPSILON / h;
    scale->step = h;
    scale->reach = is_implicit ? 0 : h;
}

void lag_scale_know_rates(LagScale *scale, double most)
{
    double place = 0;
    for (int i = 0; i < scale->n; ++i)
        place = lag_max(lag_max(scale->largest[i], scale->size[i]), place);
    if (place > 0)
        scale->rate_rounding = lag_min(most / place, scale->rate_rounding);
}
