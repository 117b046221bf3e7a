#include "scale.h"

#include <string.h>

#include "model.h"

double LAG_OWN = 1e-2, LAG_GROUP = 1e-3;
static const double ANGLE_CAP = 3.14;

void lag_scale_layout(LagScale *scale, LagArena *arena)
{
    const size_t size = 2 * (size_t)scale->n;
    scale->cap = lag_take(arena, size);
    scale->largest = lag_take(arena, size);
    scale->floor = lag_take(arena, size);
}

void lag_scale_reset(LagScale *scale)
{
    const int n = scale->n;
    memset(scale->largest, 0, 2 * (size_t)n * sizeof *scale->largest);
    memset(scale->floor, 0, 2 * (size_t)n * sizeof *scale->floor);
    for (int i = 0; i < n; ++i) {
        scale->cap[i] = scale->kind[i] == LAG_KIND_ANGLE ? ANGLE_CAP : INFINITY;
        scale->cap[n + i] = INFINITY;
    }
}

/* Largest magnitude among the coordinates (offset 0) or rates (offset n) of one kind. */
static double largest_of_kind(const LagScale *scale, int offset, int kind)
{
    double largest = 0;
    for (int i = 0; i < scale->n; ++i)
        if (scale->kind[i] == kind)
            largest = fmax(largest, scale->largest[offset + i]);
    return largest;
}

void lag_scale_note(LagScale *scale, const double *y)
{
    int grown = 0;
    for (int i = 0; i < 2 * scale->n; ++i) {
        const double magnitude = fmin(fabs(y[i]), scale->cap[i]);
        if (magnitude > scale->largest[i]) {
            scale->largest[i] = magnitude;
            grown = 1;
        }
    }
    if (!grown)
        return;
    for (int i = 0; i < 2 * scale->n; ++i) {
        const int offset = i < scale->n ? 0 : scale->n;
        const double group = largest_of_kind(scale, offset, scale->kind[i - offset]);
        scale->floor[i] = fmax(LAG_OWN * scale->largest[i], LAG_GROUP * group);
    }
}
