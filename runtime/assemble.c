/* Gauss-Newton with shortest corrections: P. Deuflhard, Newton Methods for Nonlinear Problems (2004), 4.4.
 *
 * Unknowns are measured by their guesses (1 where the guess is 0), equations by the length of their gradient in those
 * units, so that a residual is the distance to the solution set and units do not matter. Each correction solves the
 * linearised equations by the QR factors of the transposed Jacobian: the shortest one, and dependent equations (redundant
 * constraints) drop out by pivoting; they are satisfied along with the others or reported. Corrections are halved until the
 * residual falls; the iteration ends when it falls no more.
 */
#include "assemble.h"

#include <math.h>
#include <string.h>

#include "function.h"
#include "linear.h"

static const double SATISFIED = 1e-10, DEPENDENT = 1e-10, SHORTEST_STEP = 1e-4;
enum { MOST_ITERATIONS = 100 };

void lag_assembly_layout(LagAssembly *s, LagArena *arena)
{
    const size_t equations = (size_t)s->model->n_initial, unknowns = 2 * (size_t)s->model->n;
    s->g = lag_take(arena, equations);
    s->jacobian = lag_take(arena, equations * unknowns);
    s->transposed = lag_take(arena, equations * unknowns);
    s->length = lag_take(arena, equations);
    s->right = lag_take(arena, equations);
    s->diagonal = lag_take(arena, equations);
    s->scale = lag_take(arena, unknowns);
    s->step = lag_take(arena, unknowns);
    s->trial = lag_take(arena, unknowns);
    s->pivot = (int *)lag_take(arena, equations);
}

static int evaluate(LagAssembly *s, const double *p, const double *x, double *work)
{
    const double *in[] = {x, x + s->model->n, p};
    double *out[] = {s->g, s->jacobian};
    return lag_call(&s->model->initial, in, out, work);
}

/* Fills `transposed` and `length` from the Jacobian. */
static void scale_equations(LagAssembly *s)
{
    const int equations = s->model->n_initial, unknowns = 2 * s->model->n;
    for (int i = 0; i < equations; ++i) {
        double *row = s->transposed + i * unknowns, length2 = 0;
        for (int j = 0; j < unknowns; ++j) {
            row[j] = s->jacobian[i + j * equations] * s->scale[j];
            length2 += row[j] * row[j];
        }
        s->length[i] = length2 > 0 ? sqrt(length2) : 1;
        for (int j = 0; j < unknowns; ++j)
            row[j] /= s->length[i];
    }
}

/* The largest scaled residual; infinity when not all are finite. */
static double residual(const LagAssembly *s, int *worst)
{
    double largest = 0;
    for (int i = 0; i < s->model->n_initial; ++i) {
        const double size = fabs(s->g[i]) / s->length[i];
        if (size > largest || isnan(size)) {
            largest = isnan(size) ? INFINITY : size;
            *worst = i;
        }
    }
    return largest;
}

static void correction(LagAssembly *s)
{
    const int equations = s->model->n_initial, unknowns = 2 * s->model->n;
    for (int i = 0; i < equations; ++i)
        s->right[i] = -s->g[i] / s->length[i];
    const int rank = lag_qr(s->transposed, unknowns, equations, s->diagonal, s->pivot, DEPENDENT);
    lag_qr_shortest(s->transposed, unknowns, rank, s->diagonal, s->pivot, s->right, s->step);
}

/* Goes along the correction as far as the residual falls. Returns 0 when it does not fall at all. */
static int descend(LagAssembly *s, const double *p, double before, double *x, double *work)
{
    int worst;
    for (double part = 1; part > SHORTEST_STEP; part /= 2) {
        for (int j = 0; j < 2 * s->model->n; ++j)
            s->trial[j] = x[j] + part * s->scale[j] * s->step[j];
        if (evaluate(s, p, s->trial, work) == 0 && residual(s, &worst) < before) {
            memcpy(x, s->trial, 2 * (size_t)s->model->n * sizeof *x);
            return 1;
        }
    }
    evaluate(s, p, x, work);
    return 0;
}

int lag_assemble(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    int worst = 0, falling = 1;
    double size = INFINITY;
    for (int j = 0; j < 2 * s->model->n; ++j)
        s->scale[j] = fixed[j] ? 0 : x[j] != 0 ? fabs(x[j]) : 1;
    if (s->model->n_initial == 0)
        return -1;
    if (evaluate(s, p, x, work) != 0)
        return 0;
    for (int i = 0; i < MOST_ITERATIONS && falling; ++i) {
        scale_equations(s);
        size = residual(s, &worst);
        if (!(size > 0 && size < INFINITY))
            break;
        correction(s);
        falling = descend(s, p, size, x, work);
    }
    return size <= SATISFIED ? -1 : worst;
}
