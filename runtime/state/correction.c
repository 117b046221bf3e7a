#include "state/correction.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "numbers/lanes.h"
#include "state/state.h"

static const double ROUNDINGS = 1e3; /* of the natural size of a coordinate: what is left of a gap there is none */
enum { LONG = 16 }; /* coordinates from which on lanes pay for units */

/* What a position or rate is measured by: the largest seen so far; angles have a natural unit. Their cap tells them. */
static inline double size_of(const LagRun *run, int i)
{
    const double seen = lag_max(fabs(run->projection.state[i]), run->scale.largest[i]);
    return run->scale.cap[i] < INFINITY ? lag_max(seen, 1) : seen;
}

/* As lag_correction_size, of *first .. end - 1 as long as there are LAG_LANES; *first: how far it came. */
static double size_of_many(const LagRun *run, int *first, int end)
{
    const LagLanes zero = LAG_LANES_OF(0), one = LAG_LANES_OF(1), infinity = LAG_LANES_OF(INFINITY);
    LagLanes largest = zero;
    int i = *first;
    for (; i + LAG_LANES <= end; i += LAG_LANES) {
        LagLanes length, size, seen, cap, nothing;
        memcpy(&length, run->projection.correction + i, sizeof length);
        memcpy(&size, run->projection.state + i, sizeof size);
        memcpy(&seen, run->scale.largest + i, sizeof seen);
        memcpy(&cap, run->scale.cap + i, sizeof cap);
        length = LAG_LANES_ABS(length);
        size = LAG_LANES_ABS(size);
        size = LAG_LANES_MAX(size, seen);
        size = LAG_LANES_SELECT(cap < infinity, LAG_LANES_MAX(size, one), size);
        nothing = LAG_LANES_SELECT(length > zero, one, zero);
        size = LAG_LANES_SELECT(size > zero, length / size, nothing);
        size = LAG_LANES_SELECT(length < infinity, size, infinity);
        largest = LAG_LANES_MAX(size, largest);
    }
    *first = i;
    return lag_lanes_largest(&largest, 0);
}

double lag_correction_size(const LagRun *run, int first)
{
    const int end = first + run->model->n;
    double largest = size_of_many(run, &first, end);
    for (int i = first; i < end; ++i) {
        const double length = fabs(run->projection.correction[i]), size = size_of(run, i);
        if (!(length < INFINITY))
            return INFINITY;
        if (length > largest * size) /* divisions take longer than all the rest */
            largest = size > 0 ? length / size : lag_max(1, largest);
    }
    return largest;
}

int lag_correction_is_fine(const LagRun *run, int first, int count)
{
    const LagProjection *s = &run->projection;
    const int is_long = run->model->n >= LONG;
    if (is_long)
        lag_scale_units(&run->scale, run->motion.y, s->state, s->unit);
    for (int i = first; i < first + count; ++i)
        if (fabs(s->correction[i]) > (is_long ? s->unit[i] : lag_scale_unit(&run->scale, i, run->motion.y, s->state)))
            return 0;
    return 1;
}

int lag_correction_is_rounding(const LagRun *run)
{
    for (int i = 0; i < run->model->n; ++i) {
        const double size = lag_max(size_of(run, i), run->scale.size[i]);
        if (!(fabs(run->projection.correction[i]) <= ROUNDINGS * DBL_EPSILON * size))
            return 0;
    }
    return 1;
}

static int apply_many(const LagProjection *s, int first, int end)
{
    int i = first;
    for (; i + LAG_LANES <= end; i += LAG_LANES) {
        LagLanes y, step, carry, sum, taken;
        memcpy(&y, s->state + i, sizeof y);
        memcpy(&step, s->correction + i, sizeof step);
        memcpy(&carry, s->carry + i, sizeof carry);
        step += carry;
        sum = y + step;
        taken = sum - y;
        carry = (y - (sum - taken)) + (step - taken);
        memcpy(s->state + i, &sum, sizeof sum);
        memcpy(s->carry + i, &carry, sizeof carry);
    }
    return i;
}

void lag_correction_apply(LagRun *run, int first)
{
    LagProjection *s = &run->projection;
    const int end = first + run->model->n;
    for (int i = apply_many(s, first, end); i < end; ++i) {
        const double y = s->state[i], step = s->correction[i] + s->carry[i], sum = y + step, taken = sum - y;
        s->state[i] = sum;
        s->carry[i] = (y - (sum - taken)) + (step - taken);
    }
}
