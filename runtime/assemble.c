/* Gauss-Newton with shortest corrections: P. Deuflhard, Newton Methods for Nonlinear Problems (2004), 4.4.
 *
 * Unknowns are measured by the guesses of their kind, equations by the length of their gradient in those
 * units, so that a residual is the distance to the solution set and units do not matter. Each correction solves the
 * linearised equations by the QR factors of the transposed Jacobian: the shortest one, and dependent equations (redundant
 * constraints) drop out by pivoting; they are satisfied along with the others or reported. Long corrections are cut, so that
 * a mechanism near a dead centre is not thrown to a far solution, and halved until the sum of squares falls.
 *
 * Where that leads nowhere, steepest descent does, unless the gradient vanishes: then a small push, always the same one,
 * leaves the critical point. The iteration ends when nothing falls any more.
 */
#include "assemble.h"

#include <math.h>
#include <string.h>

#include "function.h"
#include "linear.h"

static const double SATISFIED = 1e-10, DEPENDENT = 1e-10, SHORTEST_STEP = 1e-4, LONGEST_STEP = 0.5;
static const double FREE = 10, CRITICAL = 1e-6, PUSH = 1e-2, GOLDEN_RATIO = 0.6180339887498949;
enum { MOST_ITERATIONS = 100, MOST_PUSHES = 3 };

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
    s->reach = lag_take(arena, unknowns);
    s->step = lag_take(arena, unknowns);
    s->kept = lag_take(arena, unknowns);
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
        s->length[i] = i >= s->active ? INFINITY : length2 > 0 ? sqrt(length2) : 1;
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

/* Sum of the squares of the scaled residuals. */
static double sum_of_squares(const LagAssembly *s)
{
    double sum = 0;
    for (int i = 0; i < s->model->n_initial; ++i)
        sum += (s->g[i] / s->length[i]) * (s->g[i] / s->length[i]);
    return sum;
}

static void correction(LagAssembly *s)
{
    const int equations = s->model->n_initial, unknowns = 2 * s->model->n;
    for (int i = 0; i < equations; ++i)
        s->right[i] = -s->g[i] / s->length[i];
    const int rank = lag_qr(s->transposed, unknowns, equations, s->diagonal, s->pivot, DEPENDENT);
    lag_qr_shortest(s->transposed, unknowns, rank, s->diagonal, s->pivot, s->right, s->step);
    double longest = 0;
    for (int j = 0; j < unknowns; ++j)
        longest = fmax(longest, fabs(s->step[j]) * s->scale[j] / s->reach[j]);
    for (int j = 0; longest > LONGEST_STEP && j < unknowns; ++j)
        s->step[j] *= LONGEST_STEP / longest;
}

/* The step down the gradient to the minimum of the linearised sum of squares. Returns 0 at a critical point. */
static int steepest(LagAssembly *s)
{
    const int equations = s->model->n_initial, unknowns = 2 * s->model->n;
    double length2 = 0, change2 = 0;
    memset(s->step, 0, (size_t)unknowns * sizeof *s->step);
    for (int i = 0; i < equations; ++i)
        for (int j = 0; j < unknowns; ++j)
            s->step[j] -= s->transposed[i * unknowns + j] * s->g[i] / s->length[i];
    for (int j = 0; j < unknowns; ++j)
        length2 += s->step[j] * s->step[j];
    for (int i = 0; i < equations; ++i) {
        double change = 0;
        for (int j = 0; j < unknowns; ++j)
            change += s->transposed[i * unknowns + j] * s->step[j];
        change2 += change * change;
    }
    if (!(length2 > CRITICAL * CRITICAL * sum_of_squares(s)))
        return 0;
    for (int j = 0; j < unknowns; ++j)
        s->step[j] *= length2 / change2;
    return 1;
}

/* Goes along the step as far as the sum of squares falls. Returns 0 when it does not fall at all. */
static int descend(LagAssembly *s, const double *p, double *x, double *work)
{
    const double before = sum_of_squares(s);
    for (double part = 1; part > SHORTEST_STEP; part /= 2) {
        for (int j = 0; j < 2 * s->model->n; ++j)
            s->trial[j] = x[j] + part * s->scale[j] * s->step[j];
        if (evaluate(s, p, s->trial, work) == 0 && sum_of_squares(s) < before) {
            memcpy(x, s->trial, 2 * (size_t)s->model->n * sizeof *x);
            return 1;
        }
    }
    evaluate(s, p, x, work);
    return 0;
}

/* Moves every free position by a different amount, of either sign. Rates are a linear matter: they are never stuck. */
static void push(LagAssembly *s, const double *p, double *x, double *work)
{
    for (int j = 0; j < s->model->n; ++j)
        x[j] += PUSH * (s->scale[j] > 0 ? s->reach[j] : 0) * (fmod((j + 1) * GOLDEN_RATIO, 1) - 0.5);
    evaluate(s, p, x, work);
}

/* One step nearer to a solution. Returns 0 where none is found. */
static int improve(LagAssembly *s, const double *p, double size, double *x, double *work)
{
    correction(s);
    if (descend(s, p, x, work))
        return 1;
    scale_equations(s);
    return size > SATISFIED && steepest(s) && descend(s, p, x, work);
}

/* An angle is measured by 1, another value by the largest of its kind; what nobody guessed moves FREE times as easily. */
static void set_scales(LagAssembly *s, const int *fixed, const double *x)
{
    const int n = s->model->n, *kind = s->model->coordinate_kind;
    for (int j = 0; j < 2 * n; ++j) {
        const int first = j < n ? 0 : n;
        double largest = 0;
        for (int i = first; i < first + n; ++i)
            if (kind[i - first] == kind[j - first])
                largest = fmax(largest, fabs(x[i]));
        s->reach[j] = kind[j - first] == LAG_KIND_ANGLE || largest == 0 ? 1 : largest;
        s->scale[j] = fixed[j] == LAG_START_FIXED ? 0 : fixed[j] == LAG_START_FREE ? FREE * s->reach[j] : s->reach[j];
    }
}

/* Satisfies the first `active` equations by moving the unknowns first .. last-1. Returns -1, or the worst equation. */
static int solve(LagAssembly *s, const double *p, const int *fixed, int active, int first, int last, double *x, double *work)
{
    int worst = 0, pushes = 0;
    double size = INFINITY;
    s->active = active;
    set_scales(s, fixed, x);
    for (int j = 0; j < 2 * s->model->n; ++j)
        if (j < first || j >= last)
            s->scale[j] = 0;
    if (evaluate(s, p, x, work) != 0)
        return 0;
    for (int i = 0; i < MOST_ITERATIONS; ++i) {
        scale_equations(s);
        size = residual(s, &worst);
        if (!(size > 0 && size < INFINITY))
            break;
        if (improve(s, p, size, x, work))
            continue;
        if (size <= SATISFIED || pushes++ == MOST_PUSHES)
            break;
        push(s, p, x, work);
    }
    return size <= SATISFIED ? -1 : worst;
}

/* Positions first, by what is said of positions; then rates where they are, which is a linear matter; all together only when
 * that does not do: an equation that ties rates to positions. */
int lag_assemble(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    const int n = s->model->n, all = s->model->n_initial, positions = s->model->n_initial_positions;
    if (all == 0)
        return -1;
    if (positions > 0) {
        const int worst = solve(s, p, fixed, positions, 0, n, x, work);
        if (worst >= 0 || positions == all)
            return worst;
        memcpy(s->kept, x, 2 * (size_t)n * sizeof *x);
        if (solve(s, p, fixed, all, n, 2 * n, x, work) < 0)
            return -1;
        memcpy(x, s->kept, 2 * (size_t)n * sizeof *x);
    }
    return solve(s, p, fixed, all, 0, 2 * n, x, work);
}
