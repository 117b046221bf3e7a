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
 * A few equations of many cost what they do alone: theirs are the instructions, rows and values that are gone through.
 *
 * Where both sides of a quotient vanish, its gradient grows without bound, and any residual is near to the solution set by that
 * measure: such an equation has no value there, and does not hold.
 */
#include "start/newton.h"

#include <math.h>
#include <string.h>

#include "model/function.h"
#include "numbers/qr.h"

static const double SATISFIED = 1e-10, DEPENDENT = 1e-10, ROUNDING = 1e-10, SHORTEST_STEP = 1e-4, LONGEST_STEP = 0.5,
                    FAITHFUL = 0.9, STEEPEST = 1e9, ROUNDED = 1e-14;
enum { FULL = 8 }; /* matrices with an entry of so many that is not 0, or more, gain nothing by account of zeros */
static const double CRITICAL = 1e-6, PUSH = 1e-2, GOLDEN_RATIO = 0.6180339887498949;

static int is_long(const LagNewton *s) { return lag_is_long_start(s->model); }

static void lay_factors(LagNewton *s, size_t equations, size_t unknowns, LagArena *arena)
{
    s->scratch.b = lag_take(arena, equations);
    s->scratch.y = lag_take(arena, equations);
    s->scratch.diagonal = lag_take(arena, equations);
    s->scratch.pivot = (int *)lag_take(arena, equations);
    if (is_long(s)) {
        lag_sparse_qr_layout(&s->sparse, unknowns, equations, arena);
        lag_sparse_qr_layout(&s->dependent, equations, equations, arena);
    }
    s->transposed = is_long(s) ? s->sparse.a : lag_take(arena, equations * unknowns);
    s->scratch.a = is_long(s) ? s->dependent.a : lag_take(arena, equations * equations);
}

void lag_newton_layout(LagNewton *s, const LagModel *model, LagArena *arena)
{
    const size_t equations = (size_t)model->n_initial, unknowns = equations > 0 ? 2 * (size_t)lag_start_size(model) : 0;
    const size_t slopes = equations > 0 ? (size_t)model->initial_pattern[equations] : 0;
    s->model = s->positions.model = s->rates.model = model;
    s->is_read = s->n_rows = s->positions.offset = 0;
    s->rates.offset = lag_start_size(model);
    s->g = lag_take(arena, equations);
    s->first = model->initial_pattern;
    s->values = equations > 0 ? model->initial_pattern + equations + 1 : NULL;
    s->jacobian = lag_take(arena, slopes);
    s->length = lag_take(arena, equations);
    s->general = lag_take(arena, slopes);
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
    s->places = lag_take_ints(arena, unknowns);
    s->pivot = (int *)lag_take(arena, equations);
    s->active = (int *)lag_take(arena, equations);
    s->rows = lag_take_ints(arena, equations);
    lag_slicer_layout(&s->slicer, &model->initial, arena);
    lag_slice_layout(&s->residuals, &model->initial, arena);
    lag_slice_layout(&s->slopes, &model->initial, arena);
    lay_factors(s, equations, unknowns, arena);
    lag_metric_layout(&s->positions, arena);
    lag_metric_layout(&s->rates, arena);
}

int lag_newton_evaluate(LagNewton *s, const double *p, const double *x, double *work)
{
    const double *in[] = {x, x + lag_start_size(s->model), p, s->u};
    double *out[] = {s->g, s->jacobian};
    return lag_call(&s->model->initial, in, out, work);
}

/* What a slice has of the rows that are looked at: residuals, or gradients with them; all where there are no slices. */
static int evaluate(LagNewton *s, const LagSlice *slice, const double *p, const double *x, double *work)
{
    const double *in[] = {x, x + lag_start_size(s->model), p, s->u};
    double *out[] = {s->g, s->jacobian};
    if (!lag_has_slices(&s->model->initial))
        return lag_newton_evaluate(s, p, x, work);
    lag_tape_run(&slice->tape, in, out, work);
    return 0;
}

void lag_newton_survey(LagNewton *s, const double *reach)
{
    memcpy(s->general, s->jacobian, (size_t)s->first[s->model->n_initial] * sizeof *s->general);
    memset(s->gradient, 0, 2 * (size_t)lag_start_size(s->model) * sizeof *s->gradient);
    if (lag_has_slices(&s->model->initial) && !s->is_read)
        lag_slicer_begin(&s->slicer);
    s->is_read = 1;
    for (int i = 0; i < s->model->n_initial; ++i) {
        double length2 = 0;
        for (int k = s->first[i]; k < s->first[i + 1]; ++k) {
            const double slope = s->general[k] * reach[s->values[k]];
            length2 += slope * slope;
        }
        s->general_length[i] = isfinite(length2) ? sqrt(length2) : 0;
        const double longest = STEEPEST * (s->general_length[i] + fabs(s->g[i]));
        s->longest[i] = longest > 0 ? longest : INFINITY;
    }
}

/* So many values may move: in the metrics, vectors have an entry for each, positions first. */
static int moving(const LagNewton *s) { return s->positions.count + s->rates.count; }

/* The gradient of an equation in the metrics, where `places` says, so many of them. Returns its length. */
static double measure_gradient(LagNewton *s, const double *jacobian, int i, double *measured, int *count)
{
    const int n = lag_start_size(s->model), begin = s->first[i], end = s->first[i + 1];
    int middle = begin, first = 0; /* from here on rates */
    double length2 = 0;
    for (int k = begin; k < end; ++k) {
        s->gradient[s->values[k]] = jacobian[k];
        middle += s->values[k] < n;
    }
    first = lag_metric_of_gradient(&s->positions, s->gradient, s->values + begin, middle - begin, measured, s->places);
    *count = first + lag_metric_of_gradient(&s->rates, s->gradient + n, s->values + middle, end - middle,
                                            measured + s->positions.count, s->places + first);
    for (int e = first; e < *count; ++e)
        s->places[e] += s->positions.count;
    for (int e = 0; e < *count; ++e)
        length2 += measured[s->places[e]] * measured[s->places[e]];
    for (int k = begin; k < end; ++k)
        s->gradient[s->values[k]] = 0;
    return sqrt(length2);
}

/* Lists the equations that are looked at. Returns whether they are others than before. */
static int list_rows(LagNewton *s)
{
    const int before = s->n_rows;
    int others = 0;
    s->n_rows = 0;
    for (int i = 0; i < s->model->n_initial; ++i) {
        if (!s->active[i])
            continue;
        others |= s->n_rows >= before || s->rows[s->n_rows] != i;
        s->rows[s->n_rows++] = i;
    }
    return others || s->n_rows != before;
}

/* The equations that are looked at, and what computes them. */
static void choose_rows(LagNewton *s)
{
    if (!list_rows(s) || !lag_has_slices(&s->model->initial))
        return;
    lag_slice_begin(&s->slicer, &s->residuals);
    for (int r = 0; r < s->n_rows; ++r)
        lag_slice_add(&s->slicer, &s->residuals, 0, s->rows[r]);
    lag_slice_end(&s->slicer, &s->residuals);
    lag_slice_begin(&s->slicer, &s->slopes);
    for (int r = 0; r < s->n_rows; ++r) {
        const int i = s->rows[r];
        lag_slice_add(&s->slicer, &s->slopes, 0, i);
        for (int k = s->first[i]; k < s->first[i + 1]; ++k)
            lag_slice_add(&s->slicer, &s->slopes, 1, k);
    }
    lag_slice_end(&s->slicer, &s->slopes);
}

void lag_newton_measure(LagNewton *s, const double *p, const int *fixed, const double *x, int way, double *work)
{
    const int n = lag_start_size(s->model);
    lag_metric_set(&s->positions, x, p, fixed, s->scale, way, work);
    lag_metric_set(&s->rates, x, p, fixed + n, s->scale + n, way, work);
    choose_rows(s);
    for (int r = 0; r < s->n_rows; ++r) {
        const int i = s->rows[r];
        int entries = 0;
        const double length = measure_gradient(s, s->general, i, s->step, &entries);
        s->weight[i] = isfinite(length) ? length : 0;
    }
}

/* A slope, along a value in its natural size. */
static double slope(const LagNewton *s, int k) { return s->jacobian[k] * s->scale[s->values[k]]; }

static double squared_length(const LagNewton *s, int i)
{
    double length2 = 0;
    for (int k = s->first[i]; k < s->first[i + 1]; ++k)
        length2 += slope(s, k) * slope(s, k);
    return length2;
}

/* Fills `length` from the Jacobian. */
static void measure_lengths(LagNewton *s)
{
    for (int r = 0; r < s->n_rows; ++r) {
        const int i = s->rows[r];
        s->length[i] = fmax(sqrt(squared_length(s, i)), s->general_length[i]);
        if (!(s->length[i] > 0))
            s->length[i] = 1;
    }
}

/* The largest scaled residual; infinity when not all are finite. */
static double residual(const LagNewton *s, int *worst)
{
    double largest = 0;
    for (int r = 0; r < s->n_rows; ++r) {
        const int i = s->rows[r];
        const double size = fabs(s->g[i]) / s->length[i];
        if (size > largest || isnan(size)) {
            largest = isnan(size) ? INFINITY : size;
            *worst = i;
        }
    }
    return largest;
}

/* Whether an equation has no value at the place evaluated last. */
static int is_void(const LagNewton *s, int i) { return !(squared_length(s, i) <= s->longest[i] * s->longest[i]); }

/* -1, or an equation that does not hold at the place evaluated last, where the largest scaled residual, of `worst`, is
 * `size`; g is NAN of one that has no value there. */
static int unsatisfied(LagNewton *s, double size, int worst)
{
    if (!(size <= SATISFIED))
        return worst;
    for (int r = 0; r < s->n_rows; ++r) {
        if (is_void(s, s->rows[r])) {
            s->g[s->rows[r]] = NAN;
            return s->rows[r];
        }
    }
    return -1;
}

/* Sum of the squares of the scaled residuals. */
static double sum_of_squares(const LagNewton *s)
{
    double sum = 0;
    for (int r = 0; r < s->n_rows; ++r) {
        const double size = s->g[s->rows[r]] / s->length[s->rows[r]];
        sum += size * size;
    }
    return sum;
}

/* Fills `transposed` with the gradients of the linearised equations in the metrics, of unit size at most, `right`, and what a
 * unit is worth in the sum of squares. Returns their number: equations that do not change with what may move, but
 * for rounding, or beyond all measure, are left out. */
static int measure_equations(LagNewton *s)
{
    int count = 0;
    lag_newton_begin_matrix(s, moving(s), s->n_rows);
    for (int r = 0; r < s->n_rows; ++r) {
        const int i = s->rows[r];
        int entries = 0;
        const double length = measure_gradient(s, s->jacobian, i, s->trial, &entries), unit = fmax(length, s->weight[i]);
        if (!(length > ROUNDING * unit && isfinite(unit)))
            continue;
        for (int e = 0; e < entries; ++e)
            lag_newton_put(s, s->places[e], count, s->trial[s->places[e]] / unit);
        s->right[count] = -s->g[i] / unit;
        s->share[count++] = unit / s->length[i];
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

void lag_newton_begin_matrix(LagNewton *s, int rows, int most_columns)
{
    s->n_matrix_rows = rows;
    if (is_long(s))
        lag_sparse_qr_begin(&s->sparse, rows, most_columns);
    else
        memset(s->transposed, 0, (size_t)rows * (size_t)most_columns * sizeof *s->transposed);
}

void lag_newton_put(LagNewton *s, int i, int column, double value)
{
    if (is_long(s))
        lag_sparse_qr_add(&s->sparse, i, column, value);
    else
        s->transposed[i + column * s->n_matrix_rows] = value;
}

int lag_newton_factor(LagNewton *s, int count, double tolerance)
{
    const size_t size = (size_t)s->n_matrix_rows * (size_t)count;
    s->is_sparse = is_long(s) && lag_sparse_qr_entries(&s->sparse, count) * FULL < size;
    if (s->is_sparse) {
        lag_sparse_qr(&s->sparse, count, tolerance);
        return s->sparse.rank;
    }
    if (is_long(s))
        lag_sparse_qr_fill(&s->sparse, count);
    return lag_qr(s->transposed, s->n_matrix_rows, count, s->diagonal, s->pivot, tolerance);
}

/* `step` from the wish `z`, so changed that the linearised equations hold. Returns its length. */
static double correct(LagNewton *s)
{
    const int n = lag_start_size(s->model), count = measure_equations(s);
    const int rank = lag_newton_factor(s, count, DEPENDENT);
    if (s->is_sparse)
        lag_sparse_qr_nearest(&s->sparse, s->right, s->share, &s->dependent, s->scratch.y, s->scratch.b, s->z);
    else
        lag_qr_nearest(s->transposed, s->n_matrix_rows, count, rank, s->diagonal, s->pivot, s->right, s->share, &s->scratch, s->z);
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
    memset(s->gradient, 0, 2 * (size_t)n * sizeof *s->gradient);
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

/* Moves `step` down the gradient of the sum of squares. */
static void step_down(LagNewton *s)
{
    memset(s->step, 0, 2 * (size_t)lag_start_size(s->model) * sizeof *s->step);
    for (int r = 0; r < s->n_rows; ++r) {
        const int i = s->rows[r];
        for (int k = s->first[i]; k < s->first[i + 1]; ++k)
            s->step[s->values[k]] -= slope(s, k) / s->length[i] * s->g[i] / s->length[i];
    }
}

/* By how much the scaled residuals change along `step`, squared. */
static double squared_change(const LagNewton *s)
{
    double change2 = 0;
    for (int r = 0; r < s->n_rows; ++r) {
        const int i = s->rows[r];
        double change = 0;
        for (int k = s->first[i]; k < s->first[i + 1]; ++k)
            change += slope(s, k) / s->length[i] * s->step[s->values[k]];
        change2 += change * change;
    }
    return change2;
}

/* The step down the gradient to the minimum of the linearised sum of squares. Returns 0 at a critical point. */
static int steepest(LagNewton *s)
{
    const int unknowns = 2 * lag_start_size(s->model);
    double length2 = 0;
    step_down(s);
    for (int j = 0; j < unknowns; ++j)
        length2 += s->step[j] * s->step[j];
    const double change2 = squared_change(s);
    if (!(length2 > CRITICAL * CRITICAL * sum_of_squares(s)))
        return 0;
    for (int j = 0; j < unknowns; ++j)
        s->step[j] *= s->scale[j] * length2 / change2;
    return 1;
}

/* By how much the sum of squares falls along all of the step, as its slope foretells. */
static double foretell_fall(const LagNewton *s)
{
    double fall = 0;
    for (int r = 0; r < s->n_rows; ++r) {
        const int i = s->rows[r];
        double change = 0;
        for (int k = s->first[i]; k < s->first[i + 1]; ++k)
            change += s->jacobian[k] * s->step[s->values[k]];
        fall -= 2 * change / s->length[i] * s->g[i] / s->length[i];
    }
    return fall;
}

/* Goes along the step as far as the sum of squares falls: all the way or not at all where it, or what it is to fall by, is but
 * rounding, as where what may move leads no nearer. Returns 0 when it does not fall at all. */
static int descend(LagNewton *s, const double *p, double *x, double *work)
{
    const double before = sum_of_squares(s);
    const int is_rounding = before < ROUNDED * ROUNDED || fabs(foretell_fall(s)) < ROUNDED * before;
    const double shortest = is_rounding ? 1 : SHORTEST_STEP;
    for (double part = 1; part >= shortest; part /= 2) {
        for (int j = 0; j < 2 * lag_start_size(s->model); ++j)
            s->trial[j] = x[j] + part * s->step[j];
        if (evaluate(s, &s->residuals, p, s->trial, work) == 0 && sum_of_squares(s) < before) {
            memcpy(x, s->trial, 2 * (size_t)lag_start_size(s->model) * sizeof *x);
            return !lag_has_slices(&s->model->initial) || evaluate(s, &s->slopes, p, x, work) == 0;
        }
    }
    evaluate(s, &s->slopes, p, x, work);
    return 0;
}

/* Moves every free position by a different amount, of either sign. Rates are a linear matter: they are never stuck. */
static void push(LagNewton *s, const double *p, double *x, double *work)
{
    for (int j = 0; j < lag_start_size(s->model); ++j)
        x[j] += PUSH * s->scale[j] * (fmod((j + 1) * GOLDEN_RATIO, 1) - 0.5);
    evaluate(s, &s->slopes, p, x, work);
}

/* One step nearer to a solution. Returns 0 where none is found. */
static int improve(LagNewton *s, const double *p, double size, double *x, double *work)
{
    const double before = sum_of_squares(s);
    memset(s->z, 0, 2 * (size_t)lag_start_size(s->model) * sizeof *s->z);
    if (correct(s) > 0 && descend(s, p, x, work)) {
        const double foretold = 1 - FAITHFUL * s->part;
        s->trusted *= s->part < 1 && sum_of_squares(s) <= foretold * foretold * before ? 2 : 1;
        return 1;
    }
    measure_lengths(s);
    return size > SATISFIED && steepest(s) && descend(s, p, x, work);
}

int lag_newton_solve(LagNewton *s, const double *p, int most_iterations, int most_pushes, double *x, double *work)
{
    int worst = 0, pushes = 0;
    double size = INFINITY;
    s->trusted = LONGEST_STEP;
    if (evaluate(s, &s->slopes, p, x, work) != 0)
        return 0;
    for (int i = 0; i < most_iterations; ++i) {
        measure_lengths(s);
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
