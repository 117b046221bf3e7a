#include "run/guard_values.h"

#include <math.h>

static const double ROUGH = 0.05; /* of the change: what parabolas may miss */

static double least_of(const double *g)
{
    double least = INFINITY;
    for (int k = 0; k < LAG_GUARD_VALUES; ++k)
        least = fmin(g[k], least);
    return least;
}

double lag_guard_values_change(const double *g)
{
    double most = -INFINITY;
    for (int k = 0; k < LAG_GUARD_VALUES; ++k)
        most = fmax(g[k], most);
    return most - least_of(g);
}

int lag_guard_values_are_far(const double *g, double more) { return least_of(g) > lag_guard_values_change(g) + more; }

/* Whether the parabola through three neighbours, which tells what is between them to `rough`, dips below 0 there, and none of them
 * does. */
static int dips(const double *g, double rough)
{
    const double a = g[0], b = g[1], c = g[2], slope = c - a, bend = a - 2 * b + c;
    return a >= 0 && b >= 0 && c >= 0 && fabs(slope) <= 2 * bend && b - slope * slope / (8 * bend) < rough;
}

int lag_guard_values_are_smooth(const double *g)
{
    const double left = (3 * g[0] + 6 * g[2] - g[4]) / 8 - g[1], right = (-g[0] + 6 * g[2] + 3 * g[4]) / 8 - g[3];
    const double rough = ROUGH * lag_guard_values_change(g);
    return fmax(fabs(left), fabs(right)) <= rough && !dips(g, rough) && !dips(g + 1, rough) && !dips(g + 2, rough);
}
