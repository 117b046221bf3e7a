/* The distance is dx' W dx with W from M = L L' (A. L. Cholesky), the values that nobody guessed taken first: their columns of L
 * are divided by FREE. So the others are measured by the least kinetic energy that leaves these free to follow (a Schur
 * complement), and these by the little that remains. Without `momentum` L is diagonal.
 *
 * M v = momentum(q, v); values are taken in units, and M relative to its largest entry there. Where M is singular, a pivot that
 * vanishes is raised: such a value moves next to freely.
 */
#include "start/metric.h"

#include <math.h>
#include <string.h>

#include "model/function.h"

static const double FREE = 100, LEAST_PIVOT = 1e-10, NO_MASS = 1e-30;

void lag_metric_layout(LagMetric *s, LagArena *arena)
{
    const size_t n = s->model->n_initial > 0 ? (size_t)lag_start_size(s->model) : 0;
    s->factor = lag_take(arena, n * n);
    s->unit = lag_take(arena, n);
    s->column = lag_take(arena, n);
    s->rates = lag_take(arena, n);
    s->order = (int *)lag_take(arena, n);
    s->first = (int *)lag_take(arena, n);
}

static void choose_order(LagMetric *s, const int *fixed, const double *unit, int way)
{
    s->count = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int j = 0; j < lag_start_size(s->model); ++j)
            if (unit[j] > 0 && (fixed[j] >= LAG_START_FREE && way != LAG_METRIC_EVEN) == (pass == 0))
                s->order[s->count++] = j;
        if (pass == 0)
            s->n_free = s->count;
    }
}

/* Fills the lower triangle with D M D, or with the identity. Returns its largest entry; 0: there is no mass, or no number. */
static double fill(LagMetric *s, const double *q, const double *p, double *work)
{
    const int n = lag_start_size(s->model), count = s->count;
    const double *in[] = {q, s->rates, p};
    double largest = 0, probe = 0;
    for (int i = 0; i < count; ++i)
        memset(s->factor + i * n, 0, (size_t)count * sizeof *s->factor);
    memset(s->rates, 0, (size_t)n * sizeof *s->rates);
    for (int k = 0; k < count && lag_present(&s->model->momentum); ++k) {
        const int j = s->order[k];
        s->rates[j] = s->unit[j];
        lag_call(&s->model->momentum, in, &s->column, work);
        s->rates[j] = 0;
        for (int i = k; i < count; ++i) {
            s->factor[i * n + k] = s->column[s->order[i]] * s->unit[s->order[i]];
            probe += 0 * s->factor[i * n + k];
        }
        largest = fmax(largest, s->factor[k * n + k]);
    }
    return probe == 0 ? largest : 0;
}

static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += a[i] * b[i];
    return sum;
}

static int max_int(int a, int b) { return a > b ? a : b; }

/* Row by row; a pivot is compared with what the value had before. A row of L begins where that of M does. */
static void factorise(LagMetric *s, double largest)
{
    const int n = lag_start_size(s->model);
    for (int i = 0; i < s->count; ++i) {
        double *row = s->factor + i * n;
        int first = 0;
        while (first < i && row[first] == 0)
            ++first;
        s->first[i] = first;
        for (int k = first; k < i; ++k) {
            const double *other = s->factor + k * n;
            const int begin = max_int(first, s->first[k]);
            row[k] = (row[k] / largest - dot(row + begin, other + begin, max_int(k - begin, 0))) / other[k];
        }
        const double own = row[i] / largest, floor = LEAST_PIVOT * (own > NO_MASS ? own : 1);
        row[i] = sqrt(fmax(own - dot(row + first, row + first, i - first), floor));
    }
    for (int i = 0; i < s->count; ++i)
        for (int k = s->first[i]; k <= i && k < s->n_free; ++k)
            s->factor[i * n + k] /= FREE;
}

void lag_metric_set(LagMetric *s, const double *q, const double *p, const int *fixed, const double *unit, int way,
                    double *work)
{
    const int n = lag_start_size(s->model);
    memcpy(s->unit, unit, (size_t)n * sizeof *unit);
    choose_order(s, fixed, unit, way);
    double largest = way == LAG_METRIC_MASS ? fill(s, q, p, work) : 0;
    for (int i = 0; i < s->count && largest == 0; ++i) {
        memset(s->factor + i * n, 0, (size_t)s->count * sizeof *s->factor);
        s->factor[i * n + i] = 1;
    }
    factorise(s, largest == 0 ? 1 : largest);
}

/* z = L^-1 D g */
void lag_metric_of_gradient(const LagMetric *s, const double *g, double *z)
{
    const int n = lag_start_size(s->model);
    int first = 0; /* before it all is 0 */
    while (first < s->count && g[s->order[first]] == 0)
        z[first++] = 0;
    for (int i = first; i < s->count; ++i) {
        const double *row = s->factor + i * n;
        const int begin = max_int(first, s->first[i]);
        z[i] = (g[s->order[i]] * s->unit[s->order[i]] - dot(row + begin, z + begin, i - begin)) / row[i];
    }
}

/* dx = D L'^-1 z */
void lag_metric_to_step(const LagMetric *s, const double *z, double *dx)
{
    const int n = lag_start_size(s->model);
    double *rest = s->column;
    memcpy(rest, z, (size_t)s->count * sizeof *z);
    memset(dx, 0, (size_t)n * sizeof *dx);
    for (int i = s->count - 1; i >= 0; --i) {
        const double *row = s->factor + i * n, x = rest[i] / row[i];
        dx[s->order[i]] = x * s->unit[s->order[i]];
        for (int k = s->first[i]; k < i; ++k)
            rest[k] -= row[k] * x;
    }
}

/* z = L' D^-1 dx */
void lag_metric_from_step(const LagMetric *s, const double *dx, double *z)
{
    const int n = lag_start_size(s->model);
    memset(z, 0, (size_t)s->count * sizeof *z);
    for (int i = 0; i < s->count; ++i) {
        const double *row = s->factor + i * n, x = dx[s->order[i]] / s->unit[s->order[i]];
        for (int k = s->first[i]; k <= i; ++k)
            z[k] += row[k] * x;
    }
}
