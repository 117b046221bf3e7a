#include "methods/linear_system.h"

#include <string.h>

#include "model/dd_tape.h"

static LagDD *take(LagArena *arena, size_t count) { return (LagDD *)lag_take(arena, 2 * count); }

static LagSparse sparse(LagRows rows) { return (LagSparse){rows.rows, rows.start, rows.column, NULL}; }

void lag_linear_system_layout(LagLinearSystem *s, const LagModel *model, LagArena *arena)
{
    const LagLinearPattern pattern = lag_linear_pattern(model);
    s->model = model;
    s->n = pattern.n;
    s->n_w = pattern.n_w;
    s->n_inputs = pattern.n_inputs;
    s->changes = pattern.changes;
    s->n_forms = pattern.n_forms;
    s->size = pattern.size;
    s->order = pattern.order;
    s->lower = sparse(pattern.lower);
    s->F = sparse(pattern.F);
    s->G = sparse(pattern.G);
    for (int i = 0; i < s->n_forms; ++i)
        s->form[i] = sparse(pattern.form[i]);
    const size_t n_work = model->linear.n_work > model->waves.n_work ? model->linear.n_work : model->waves.n_work;
    s->values = take(arena, (size_t)model->linear.out_size[0]);
    s->waves = take(arena, (size_t)s->n_w);
    s->work = take(arena, n_work);
    s->right = take(arena, (size_t)s->n);
    s->inverse = take(arena, (size_t)s->n);
    s->rough = lag_take(arena, (size_t)s->n);
    s->p = lag_take(arena, (size_t)model->n_parameters);
    s->d = lag_take(arena, (size_t)model->n_modes);
}

static void place_values(LagLinearSystem *s)
{
    LagSparse *matrices[] = {&s->lower, &s->F, &s->G, &s->form[0], &s->form[1]};
    LagDD *next = s->values + s->n;
    s->diagonal = s->values;
    for (int i = 0; i < 3 + s->n_forms; ++i) {
        matrices[i]->value = next;
        next += matrices[i]->start[matrices[i]->rows];
    }
}

/* M = L D L' row by row: the row of L D is solved for in `right`, whose places outside the row's pattern stay zero. */
static int factor(LagLinearSystem *s)
{
    const LagSparse *L = &s->lower;
    for (int k = 0; k < s->n; ++k) {
        LagDD pivot = s->diagonal[k];
        for (int e = L->start[k]; e < L->start[k + 1]; ++e)
            s->right[L->column[e]] = L->value[e];
        for (int e = L->start[k]; e < L->start[k + 1]; ++e) {
            const int j = L->column[e];
            for (int f = L->start[j]; f < L->start[j + 1]; ++f)
                s->right[j] = lag_dd_sub(s->right[j], lag_dd_mul(L->value[f], s->right[L->column[f]]));
            L->value[e] = lag_dd_div(s->right[j], s->diagonal[j]);
            pivot = lag_dd_sub(pivot, lag_dd_mul(L->value[e], s->right[j]));
        }
        for (int e = L->start[k]; e < L->start[k + 1]; ++e)
            s->right[L->column[e]] = lag_dd(0);
        s->diagonal[k] = pivot;
        if (!(pivot.hi > 0) || !isfinite(pivot.hi))
            return 0;
    }
    for (int k = 0; k < s->n; ++k)
        s->inverse[k] = lag_dd_div(lag_dd(1), s->diagonal[k]);
    return 1;
}

int lag_linear_system_build(LagLinearSystem *s, const double *p, const double *d, int *is_new)
{
    const size_t n_p = (size_t)s->model->n_parameters * sizeof *p, n_d = (size_t)s->model->n_modes * sizeof *d;
    *is_new = !s->is_built || memcmp(p, s->p, n_p) != 0 || (s->changes && memcmp(d, s->d, n_d) != 0);
    if (!*is_new)
        return 1;
    const double *in[] = {p, d};
    lag_dd_tape_run(s->model->linear.tape, in, &s->values, s->work);
    memcpy(s->p, p, n_p);
    memcpy(s->d, d, n_d);
    place_values(s);
    double probe = 0;
    for (int i = 0; i < s->model->linear.out_size[0]; ++i)
        probe += 0 * s->values[i].hi;
    s->is_built = probe == 0 && factor(s);
    return s->is_built;
}

void lag_linear_system_loads(LagLinearSystem *s, const LagInputs *inputs, double t, const double *d, double *u, LagDDs w)
{
    const double *in[] = {&t, s->p, d};
    lag_dd_tape_run(s->model->waves.tape, in, &s->waves, s->work);
    for (int i = 0; i < s->n_w; ++i)
        lag_dds_set(w, (size_t)i, s->waves[i]);
    if (s->n_inputs > 0) {
        lag_inputs_at(inputs, t, u);
        for (int i = 0; i < s->n_inputs; ++i)
            lag_dds_set(w, (size_t)i, lag_dd(u[i]));
        lag_inputs_slope(inputs, u);
        for (int i = 0; i < s->n_inputs; ++i)
            lag_dds_set(w, (size_t)(s->n_inputs + i), lag_dd(u[i]));
    }
}

static LagDD row_times(const LagSparse *matrix, int row, LagDDs x)
{
    LagDD sum = {0, 0};
    for (int e = matrix->start[row]; e < matrix->start[row + 1]; ++e)
        lag_dd_gather(&sum, matrix->value[e], x.hi[matrix->column[e]], x.lo[matrix->column[e]]);
    return lag_dd_sum(sum.hi, sum.lo);
}

/* Solves M a = right, both in the order of elimination. */
static void solve(LagLinearSystem *s)
{
    const LagSparse *L = &s->lower;
    LagDD *a = s->right;
    for (int k = 0; k < s->n; ++k)
        for (int e = L->start[k]; e < L->start[k + 1]; ++e)
            a[k] = lag_dd_sub(a[k], lag_dd_mul(L->value[e], a[L->column[e]]));
    for (int k = 0; k < s->n; ++k)
        a[k] = lag_dd_mul(a[k], s->inverse[k]);
    for (int k = s->n - 1; k >= 0; --k)
        for (int e = L->start[k]; e < L->start[k + 1]; ++e)
            a[L->column[e]] = lag_dd_sub(a[L->column[e]], lag_dd_mul(L->value[e], a[k]));
}

void lag_linear_system_slope(LagLinearSystem *s, LagDDs x, LagDDs dx)
{
    const size_t n = (size_t)s->n;
    lag_dds_copy(lag_dds_from(x, n), dx, n);
    for (int k = 0; k < s->n; ++k)
        s->right[k] = row_times(&s->F, s->order[k], x);
    solve(s);
    for (int k = 0; k < s->n; ++k) {
        lag_dds_set(dx, n + (size_t)s->order[k], s->right[k]);
        s->right[k] = lag_dd(0);
    }
    for (int i = 0; i < s->n_w; ++i)
        lag_dds_set(dx, 2 * n + (size_t)i, row_times(&s->G, i, lag_dds_from(x, 2 * n)));
}

static double rough_row_times(const LagSparse *matrix, int row, const double *x)
{
    double sum = 0;
    for (int e = matrix->start[row]; e < matrix->start[row + 1]; ++e)
        sum += matrix->value[e].hi * x[matrix->column[e]];
    return sum;
}

static void solve_roughly(const LagLinearSystem *s, double *a)
{
    const LagSparse *L = &s->lower;
    for (int k = 0; k < s->n; ++k)
        for (int e = L->start[k]; e < L->start[k + 1]; ++e)
            a[k] -= L->value[e].hi * a[L->column[e]];
    for (int k = 0; k < s->n; ++k)
        a[k] *= s->inverse[k].hi;
    for (int k = s->n - 1; k >= 0; --k)
        for (int e = L->start[k]; e < L->start[k + 1]; ++e)
            a[L->column[e]] -= L->value[e].hi * a[k];
}

void lag_linear_system_rough_slope(const LagLinearSystem *s, const double *x, double *dx)
{
    const size_t n = (size_t)s->n;
    memcpy(dx, x + n, n * sizeof *x);
    for (int k = 0; k < s->n; ++k)
        s->rough[k] = rough_row_times(&s->F, s->order[k], x);
    solve_roughly(s, s->rough);
    for (int k = 0; k < s->n; ++k)
        dx[n + (size_t)s->order[k]] = s->rough[k];
    for (int i = 0; i < s->n_w; ++i)
        dx[2 * n + (size_t)i] = rough_row_times(&s->G, i, x + 2 * n);
}
