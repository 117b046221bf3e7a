#include "steps/singular.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "numbers/extremes.h"
#include "model/function.h"

static const double PART = 1e-3; /* of a step: so far both displacements go */
static const double HELD = 1e-3; /* of the largest part of a displacement: less has nothing to do with constraints */

void lag_singular_layout(LagRun *run, LagArena *arena)
{
    run->probe = lag_take(arena, run->model->n_multipliers > 0 ? 6 * (size_t)run->model->n : 0);
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

/* A displacement across the constraints, in a direction like any other; its largest part is `size`. */
static int across(LagRun *run, double size, double *q, double *normal)
{
    const LagMotion *m = &run->motion;
    const double *in[] = {&m->t, q, run->u, run->d, run->c};
    unsigned seed = 1;
    lag_inputs_at(&run->inputs, m->t, run->u);
    for (int i = 0; i < m->n; ++i) {
        seed = 1664525U * seed + 1013904223U;
        q[i] = m->y[i] + size * ((double)(seed >> 8) / (1 << 23) - 1);
    }
    if (lag_call(&run->model->place, in, &normal, run->work) != 0)
        return 0;
    const double length = lag_largest(normal, (size_t)m->n);
    for (int i = 0; i < m->n; ++i)
        normal[i] *= size / length;
    return length > 0 && isfinite(length);
}

/* The largest change among coordinates that the constraints tell from others. */
static double largest_held(const double *a, const double *normal, double size, int n)
{
    double most = 0;
    for (int i = 0; i < n; ++i)
        if (fabs(normal[i]) > HELD * size)
            most = lag_max(fabs(a[i]), most);
    return most;
}

/* What the motion, by its rates and accelerations, does over a part of a step of length h, into q less the present state: it may
 * begin at rest. Returns its largest part. */
static double along(const LagMotion *m, double h, const double *a, double *q)
{
    double largest = 0;
    for (int i = 0; i < m->n; ++i) {
        q[i] = PART * h * (m->y[m->n + i] + h / 2 * a[i]);
        largest = lag_max(fabs(q[i]), largest);
    }
    return largest;
}

/* Below which a displacement is rounding of the positions. */
static double rounding(const LagRun *run)
{
    const double *size = run->scale.size, *q = run->motion.y;
    double largest = 0;
    for (int i = 0; i < run->model->n; ++i)
        largest = lag_max(lag_max(fabs(q[i]), size[i]), largest);
    return DBL_EPSILON * largest;
}

static double measure(LagRun *run, double h)
{
    const LagMotion *m = &run->motion;
    const int n = m->n;
    double *a = run->probe, *changed = a + n, *q = changed + n, *normal = q + n, *way = normal + 2 * n;
    if (!change(run, m->y, NULL, a))
        return INFINITY;
    const double size = along(m, h, a, way);
    if (size <= rounding(run)) /* what rests meets no singular position, whatever time does to it */
        return 0;
    if (!isfinite(size) || !across(run, size, q, normal))
        return INFINITY;
    for (int i = 0; i < n; ++i)
        q[i] = m->y[i] + way[i];
    if (!change(run, q, a, changed))
        return INFINITY;
    const double by_motion = largest_held(changed, normal, size, n);
    for (int i = 0; i < n; ++i)
        q[i] = m->y[i] + normal[i];
    return change(run, q, a, changed) ? largest_held(changed, normal, size, n) / by_motion : INFINITY;
}

double lag_singularity(LagRun *run, double h)
{
    const int was_careful = run->careful;
    run->careful = 0;
    const double ratio = measure(run, h);
    run->careful = was_careful;
    return ratio;
}
