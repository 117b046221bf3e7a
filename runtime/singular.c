#include "singular.h"

#include <math.h>
#include <string.h>

#include "evaluate.h"
#include "extremes.h"
#include "function.h"

static const double PART = 1e-3; /* of a step: so far both displacements go */

void lag_singular_layout(LagRun *run, LagArena *arena)
{
    run->probe = lag_take(arena, run->model->n_multipliers > 0 ? 5 * (size_t)run->model->n : 0);
}

/* The accelerations at positions q and the present rates, less those of `before`. Returns 0 when they have no value. */
static int change(LagRun *run, const double *q, const double *before, double *a)
{
    LagMotion *m = &run->motion;
    double *v = run->probe + 4 * (size_t)m->n; /* corrected in place by some */
    memcpy(v, m->y + m->n, (size_t)m->n * sizeof *v);
    ++m->evaluations;
    if (!lag_accelerations(run, m->t, q, v, a, run->power))
        return 0;
    for (int i = 0; before && i < m->n; ++i)
        a[i] -= before[i];
    return 1;
}

/* From the present positions to q, as far as `size`: across the constraints, in a direction like any other. */
static int go_across(LagRun *run, double size, double *q, double *correction)
{
    const LagMotion *m = &run->motion;
    const double *in[] = {&m->t, q, run->u, run->d, run->c};
    unsigned seed = 1;
    for (int i = 0; i < m->n; ++i) {
        seed = 1664525U * seed + 1013904223U;
        q[i] = m->y[i] + size * ((double)(seed >> 8) / (1 << 23) - 1);
    }
    if (lag_call(&run->model->place, in, &correction, run->work) != 0)
        return 0;
    const double length = lag_largest(correction, (size_t)m->n);
    for (int i = 0; i < m->n; ++i)
        q[i] = m->y[i] - correction[i] * size / length;
    return length > 0 && isfinite(length);
}

double lag_singularity(LagRun *run, double h)
{
    const LagMotion *m = &run->motion;
    const int n = m->n, was_careful = run->careful;
    double *a = run->probe, *changed = a + n, *q = changed + n, *correction = q + n, ratio = INFINITY;
    const double size = PART * h * lag_largest(m->y + n, (size_t)n);
    run->careful = 0;
    for (int i = 0; i < n; ++i)
        q[i] = m->y[i] + PART * h * m->y[n + i];
    if (size > 0 && change(run, m->y, NULL, a) && change(run, q, a, changed)) {
        const double along = lag_largest(changed, (size_t)n);
        if (go_across(run, size, q, correction) && change(run, q, a, changed))
            ratio = lag_largest(changed, (size_t)n) / along;
    }
    run->careful = was_careful;
    return ratio;
}
