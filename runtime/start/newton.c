/* Gauss-Newton with shortest corrections: P. Deuflhard, Newton Methods for Nonlinear Problems (2004), 4.4.
 *
 * Values are measured by their natural sizes, equations by the length of their gradient in those, so that a residual is the
 * distance to the solution set and units do not matter. A correction is the shortest in the mass metric (metric.c) that solves
 * the linearised equations, by the QR factors of the transposed Jacobian; dependent ones (redundant constraints) as well as they
 * can be. Long corrections of positions are cut, so that a mechanism near a dead centre is not thrown to a far solution: less where
 * the equations have changed as foretold, by lengths that are far apart. All are halved until the sum of squares falls.
 *
 * Where that leads nowhere, steepest descent does, unless the gradient vanishes: then a small push, always the same one,
 * leaves the critical point. The iteration ends when nothing falls any more.
 *
 * Where both sides of a quotient vanish, its gradient grows without bound, and any residual is near to the solution set by that
 * measure: such an equation has no value there, and does not hold.
 */
#include "start/newton.h"

#include <math.h>
#include <string.h>

#include "model/function.h"
#include "numbers/qr.h"

static const double SATISFIED = 1e-10, DEPENDENT = 1e-10, SHORTEST_STEP = 1e-4, LONGEST_STEP = 0.5, FAITHFUL = 0.9,
                    STEEPEST = 1e9;
static const double CRITICAL = 1e-6, PUSH = 1e-2, GOLDEN_RATIO = 0.6180339887498949;

void lag_newton_layout(LagNewton *s, const LagModel *model, LagArena *arena)
{
    const size_t equations = (size_t)model->n_initial, unknowns = equations > 0 ? 2 * (size_t)lag_start_size(model) : 0;
    s->model = s->positions.model = s->rates.model = model;
    s->g = lag_take(arena, equations);
    s->jacobian = lag_take(arena, equations * unknowns);
    s->transposed = lag_take(arena, equations * unknowns);
    s->length = lag_take(arena, equations);
    s->general = lag_take(arena, equations * unknowns);
    s->general_length = lag_take(arena, equations);
    s->longest = lag_take(arena, equations);
    s->weight = lag_take(arena, equations);
    s->share = lag_take(arena, equations);
    s->right = lag_take(arena, equations);
    s->diagonal = lag_take(arena, equations);
    s->scale = lag_take(arena, unknowns);
    s->step = lag_take(arena, unknowns);
    s->trial = lag_take(arena, unknowns);
    s->z = lag_take(arena, unknowns);
    s->gradient = lag_take(arena, unknowns);
    s->pivot = (int *)lag_take(arena, equations);
    s->active = (int *)lag_take(arena, equations);
    s->scratch.a = lag_take(arena, equations * equations);
    s->scratch.b = lag_take(arena, equations);
    s->scratch.y = lag_take(arena, equations);
    s->scratch.diagonal = lag_take(arena, equations);
    s->scratch.pivot = (int *)lag_take(arena, equations);
    lag_metric_layout(&s->positions, arena);
    lag_metric_layout(&s->rates, arena);
}

int lag_newton_evaluate(LagNewton *s, const double *p, const double *x, double *work)
{
    const double *in[] = {x, x + lag_start_size(s->model), p, s->u};
    double *out[] = {s->g, s->jacobian};
    return lag_call(&s->model->initial, in, out, work);
}

void lag_newton_survey(LagNewton *s, const double *reach)
{
    const int equations = s->model->n_initial, unknowns = 2 * lag_start_size(s->model);
    memcpy(s->general, s->jacobian, (size_t)(equations * unknowns) * sizeof *s->general);
    for (int i = 0; i < equations; ++i) {
        double length2 = 0;
        for (int j = 0; j < unknowns; ++j)
            length2 += s->general[i + j * equations] * reach[j] * s->general[i + j * equations] * reach[j];
        s->general_length[i] = isfinite(length2) ? sqrt(length2) : 0;
        const double longest = STEEPEST * (s->general_length[i] + fabs(s->g[i]));
        s->longest[i] = longest > 0 ? longest : INFINITY;
    }
}

/* So many values may move: in the metrics, vectors have an entry for each, positions first. */
static int moving(const LagNewton *s) { return s->positions.count + s->rates.count; }

/* The gradient of an equation in the metrics. Returns its length. */
static double measure_gradient(LagNewton *s, const double *jacobian, int i, double *measured)
{
    const int equations = s->model->n_initial, n = lag_start_size(s->model);
    double length2 = 0;
    for (int j = 0; j < 2 * n; ++j)
        s->gradient[j] = jacobian[i + j * equations];
    lag_metric_of_gradient(&s->positions, s->gradient, measured);
    lag_metric_of_gradient(&s->rates, s->gradient + n, measured + s->positions.count);
    for (int j = 0; j < moving(s); ++j)
        length2 += measured[j] * measured[j];
    return sqrt(length2);
}

void lag_newton_measure(LagNewton *s, const double *p, const int *fixed, const double *x, int way, double *work)
{
    const int n = lag_start_size(s->model);
    lag_metric_set(&s->positions, x, p, fixed, s->scale, way, work);
    lag_metric_set(&s->rates, x, p, fixed + n, s->scale + n, way, work);
    for (int i = 0; i < s->model->n_initial; ++i) {
        const double length = measure_gradient(s, s->general, i, s->step);
        s->weight[i] = isfinite(length) ? length : 0;
    }
}

/* Fills `transposed` and `length` from the Jacobian. */
static void scale_equations(LagNewton *s)
{
    const int equations = s->model->n_initial, unknowns = 2 * lag_start_size(s->model);
    for (int i = 0; i < equations; ++i) {
        double *row = s->transposed + i * unknowns, length2 = 0;
        for (int j = 0; j < unknowns; ++j) {
            row[j] = s->jacobian[i + j * equations] * s->scale[j];
            length2 += row[j] * row[j];
        }
        s->length[i] = !s->active[i] ? INFINITY : fmax(sqrt(length2), s->general_length[i]);
        if (!(s->length[i] > 0))
            s->length[i] = 1;
        for (int j = 0; j < unknowns; ++j)
            row[j] /= s->length[i];
    }
}

/* The largest scaled residual; infinity when not all are finite. */
static double residual(const LagNewton *s, int *worst)
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

/* Whether an equation has no value at the place evaluated last. */
static int is_void(const LagNewton *s, int i)
{
    const int equations = s->model->n_initial, unknowns = 2 * lag_start_size(s->model);
    double length2 = 0;
    for (int j = 0; j < unknowns; ++j)
        length2 += s->jacobian[i + j * equations] * s->scale[j] * s->jacobian[i + j * equations] * s->scale[j];
    return !(length2 <= s->longest[i] * s->longest[i]);
}

/* -1, or an equation that does not hold at the place evaluated last, where the largest scaled residual, of `worst`, is
 * `size`; g is NAN of one that has no value there. */
static int unsatisfied(LagNewton *s, double size, int worst)
{
    if (!(size <= SATISFIED))
        return worst;
    for (int i = 0; i < s->model->n_initial; ++i) {
        if (s->active[i] && is_void(s, i)) {
            s->g[i] = NAN;
            return i;
        }
    }
    return -1;
}

/* Sum of the squares of the scaled residuals. */
static double sum_of_squares(const LagNewton *s)
{
    double sum = 0;
    for (int i = 0; i < s->model->n_initial; ++i)
        sum += (s->g[i] / s->length[i]) * (s->g[i] / s->length[i]);
    return sum;
}

/* Fills `transposed` with the gradients of the linearised equations in the metrics, of unit size at most, `right`, and what a
 * unit is worth in the sum of squares. Returns their number: equations that do not change with what may move, or beyond all measure, are left out. */
static int measure_equations(LagNewton *s)
{
    const int rows = moving(s);
    int count = 0;
    for (int i = 0; i < s->model->n_initial; ++i) {
        double *column = s->transposed + count * rows;
        if (!s->active[i])
            continue;
        const double length = measure_gradient(s, s->jacobian, i, column), unit = fmax(length, s->weight[i]);
        if (!(length > 0 && isfinite(unit)))
            continue;
        s->right[count] = -s->g[i] / unit;
        s->share[count++] = unit / s->length[i];
        for (int j = 0; j < rows; ++j)
            column[j] /= unit;
    }
    return count;
}

/* Cuts the step: rates go all the way, angles LONGEST_STEP at once, other positions as far as they are trusted. Returns its
 * length before. */
static double cut(LagNewton *s)
{
    const int n = lag_start_size(s->model);
    double longest = 0, excess = 1;
    for (int j = 0; j < 2 * n; ++j) {
        const double size = s->scale[j] > 0 ? fabs(s->step[j]) / s->scale[j] : 0;
        longest = fmax(longest, size);
        if (j < n)
            excess = fmax(excess, size / (s->model->coordinate_kind[j] == LAG_KIND_ANGLE ? LONGEST_STEP : s->trusted));
    }
    s->part = 1 / excess;
    for (int j = 0; s->part < 1 && j < 2 * n; ++j)
        s->step[j] *= s->part;
    return longest;
}

/* `step` from the wish `z`, so changed that the linearised equations hold. Returns its length. */
static double correct(LagNewton *s)
{
    const int n = lag_start_size(s->model), rows = moving(s), count = measure_equations(s);
    const int rank = lag_qr(s->transposed, rows, count, s->diagonal, s->pivot, DEPENDENT);
    lag_qr_nearest(s->transposed, rows, count, rank, s->diagonal, s->pivot, s->right, s->share, &s->scratch, s->z);
    lag_metric_to_step(&s->positions, s->z, s->step);
    lag_metric_to_step(&s->rates, s->z + s->positions.count, s->step + n);
    return cut(s);
}

/* From a to b in the metrics. */
static void fill_wish(LagNewton *s, const double *a, const double *b)
{
    const int n = lag_start_size(s->model);
    for (int j = 0; j < 2 * n; ++j)
        s->gradient[j] = b[j] - a[j];
    lag_metric_from_step(&s->positions, s->gradient, s->z);
    lag_metric_from_step(&s->rates, s->gradient + n, s->z + s->positions.count);
}

double lag_newton_lean(LagNewton *s, const double *guess, const double *x)
{
    fill_wish(s, x, guess);
    s->trusted = LONGEST_STEP;
    return correct(s);
}

double lag_newton_distance2(LagNewton *s, const double *a, const double *b)
{
    double sum = 0;
    fill_wish(s, a, b);
    for (int j = 0; j < moving(s); ++j)
        sum += s->z[j] * s->z[j];
    return sum;
}

/* The step down the gradient to the minimum of the linearised sum of squares. Returns 0 at a critical point. */
static int steepest(LagNewton *s)
{
    const int equations = s->model->n_initial, unknowns = 2 * lag_start_size(s->model);
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
        s->step[j] *= s->scale[j] * length2 / change2;
    return 1;
}

/* Goes along the step as far as the sum of squares falls. Returns 0 when it does not fall at all. */
static int descend(LagNewton *s, const double *p, double *x, double *work)
{
    const double before = sum_of_squares(s);
    for (double part = 1; part > SHORTEST_STEP; part /= 2) {
        for (int j = 0; j < 2 * lag_start_size(s->model); ++j)
            s->trial[j] = x[j] + part * s->step[j];
        if (lag_newton_evaluate(s, p, s->trial, work) == 0 && sum_of_squares(s) < before) {
            memcpy(x, s->trial, 2 * (size_t)lag_start_size(s->model) * sizeof *x);
            return 1;
        }
    }
    lag_newton_evaluate(s, p, x, work);
    return 0;
}

/* Moves every free position by a different amount, of either sign. Rates are a linear matter: they are never stuck. */
static void push(LagNewton *s, const double *p, double *x, double *work)
{
    for (int j = 0; j < lag_start_size(s->model); ++j)
        x[j] += PUSH * s->scale[j] * (fmod((j + 1) * GOLDEN_RATIO, 1) - 0.5);
    lag_newton_evaluate(s, p, x, work);
}

/* One step nearer to a solution. Returns 0 where none is found. */
static int improve(LagNewton *s, const double *p, double size, double *x, double *work)
{
    const double before = sum_of_squares(s);
    memset(s->z, 0, 2 * (size_t)lag_start_size(s->model) * sizeof *s->z);
    correct(s);
    if (descend(s, p, x, work)) {
        const double foretold = 1 - FAITHFUL * s->part;
        s->trusted *= s->part < 1 && sum_of_squares(s) <= foretold * foretold * before ? 2 : 1;
        return 1;
    }
    scale_equations(s);
    return size > SATISFIED && steepest(s) && descend(s, p, x, work);
}

int lag_newton_solve(LagNewton *s, const double *p, int most_iterations, int most_pushes, double *x, double *work)
{
    int worst = 0, pushes = 0;
    double size = INFINITY;
    s->trusted = LONGEST_STEP;
    if (lag_newton_evaluate(s, p, x, work) != 0)
        return 0;
    for (int i = 0; i < most_iterations; ++i) {
        scale_equations(s);
        size = residual(s, &worst);
        if (!(size > 0 && size < INFINITY))
            break;
        if (improve(s, p, size, x, work))
            continue;
        if (size <= SATISFIED || pushes++ == most_pushes)
            break;
        push(s, p, x, work);
    }
    return unsatisfied(s, size, worst);
}
