/* The first and the last fiftieth of a step have no stage. What is narrower and lies there, as the place where friction that is rubbed
 * smooth turns round, changes no coefficient: it shows where the accelerations at both ends are not those that the stages tell. */
#include "methods/pirk_edges.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "methods/pirk.h"

/* Lagrange's polynomials at the end of a step; at its beginning the same ones, from behind. */
static const double EDGE[LAG_ABREAST] = {
    -0.032020422845832404, 0.11217721020871642, -0.2208713667044389, 0.3537304181064418, -0.5126556338013685, 0.7101568903172424,
    -0.9912041583117163, 1.5806870630309555};
static const double GAP = 0.019855071751231884; /* share of a step without stages */
/* By the last coefficients of a series: what the next ones, which are 0 at all stages, have at the ends where it is smooth. */
static const double SMOOTH = 4;

/* By how much rates may be off, in units, for what lies beyond the stages, where `found` are the accelerations at an end. */
static double missed(const LagPirk *s, const LagMotion *m, const double *found, int is_end)
{
    double most = 0;
    for (int c = 0; c < m->n; ++c) {
        const double *a = s->known + c * LAG_ABREAST;
        double told = 0;
        for (int j = 0; j < LAG_ABREAST; ++j)
            told += EDGE[is_end ? j : LAG_ABREAST - 1 - j] * a[j];
        most = lag_max(fabs(found[c] - told) * s->weight[c], most);
    }
    return GAP * most;
}

double lag_pirk_edges(LagPirk *s, LagMotion *m, double t_new)
{
    const int n = m->n;
    double *k = s->reached;
    s->has_end = lag_motion_slope(m, t_new, m->other, m->other + n, k);
    if (!s->has_end)
        return 0;
    const double begin = s->slope_time == m->t ? missed(s, m, s->slope, 0) : 0, most = lag_max(missed(s, m, k + n, 1), begin);
    return most > SMOOTH * GAP * s->last ? most : 0;
}

void lag_pirk_keep_end(LagPirk *s, const LagMotion *m, double t_new)
{
    if (s->has_end)
        memcpy(s->slope, s->reached + m->n, (size_t)(m->size - m->n) * sizeof *s->slope);
    s->slope_time = s->has_end ? t_new : NAN;
    s->has_end = 0;
}
