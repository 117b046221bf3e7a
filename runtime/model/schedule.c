/* Event times are solved for, never searched. An event time found again because of rounding is not a new event: what lies
 * within a few units in the last place of t, or of the terms of the argument, counts as passed. */
#include "model/schedule.h"

#include <float.h>
#include <math.h>

#include "model/table.h"

static const double ULPS = 8;

double lag_time_resolution(double t) { return ULPS * DBL_EPSILON * fabs(t); }

static double next_integer(double a, double b, double t, double resolution)
{
    const double direction = b > 0 ? 1 : -1, x = a + b * t;
    const double level = b > 0 ? floor(x) : ceil(x);
    for (int i = 0; i <= 2; ++i) {
        const double time = (level + i * direction - a) / b;
        if (time > t + resolution)
            return time;
    }
    return INFINITY; /* the integers are denser than times near t */
}

static double next_knot(const LagTable *table, double a, double b, double t, double resolution)
{
    const double knot = lag_table_next(table, a + b * t, b > 0 ? 1 : -1, fabs(b) * resolution);
    return isfinite(knot) ? (knot - a) / b : INFINITY;
}

static double next_event(const LagModel *model, int kind, double a, double b, double t)
{
    if (b == 0)
        return INFINITY;
    const double resolution = lag_time_resolution(fabs(t) + fabs(a / b)), zero = -a / b;
    if (kind == LAG_EVENT_INTEGER)
        return next_integer(a, b, t, resolution);
    if (kind >= LAG_EVENT_TABLE)
        return next_knot(model->tables + (kind - LAG_EVENT_TABLE), a, b, t, resolution);
    return zero > t + resolution ? zero : INFINITY;
}

double lag_schedule_next(const LagModel *model, const double *a, const double *b, double t)
{
    double next = INFINITY;
    for (int i = 0; i < model->n_events; ++i)
        next = fmin(next, next_event(model, model->event_kind[i], a[i], b[i], t));
    return next;
}
