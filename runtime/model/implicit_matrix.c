#include "model/implicit_matrix.h"

#include <string.h>

#include "model/function.h"

void lag_implicit_matrix_layout(LagImplicitMatrix *m, const LagModel *model, int pairs, LagArena *arena)
{
    const size_t size = (size_t)(model->n + model->n_multipliers), entries = (size_t)model->n_entries;
    m->n = model->n;
    if (model->jacobian_waits)
        return;
    m->size = (int)size;
    m->entries = model->n_entries;
    m->is_sparse = model->n_lower > 0;
    m->start = model->jacobian_pattern;
    m->row = m->start + size + 1;
    m->order = m->row + entries;
    m->colour = m->order + size;
    m->along = lag_take(arena, (size_t)m->n);
    m->still = lag_take(arena, (size_t)m->n);
    for (int i = 0; i < 3; ++i)
        m->part[i] = lag_take(arena, entries);
    m->re = lag_take(arena, entries);
    m->im = lag_take(arena, entries);
    m->right_re = lag_take(arena, size);
    m->right_im = lag_take(arena, size);
    for (int i = 0; i < 1 + pairs; ++i)
        if (m->is_sparse)
            lag_sparse_lu_layout(&m->sparse[i], m->size, model->n_lower, model->n_upper, arena);
        else
            lag_dense_lu_layout(&m->dense[i], m->size, i > 0, arena);
}

/* Entries of the columns of one colour, from the product with their sum. */
static void pick(const LagImplicitMatrix *m, int colour, const double *product, double *part)
{
    for (int j = 0; j < m->n; ++j)
        if (m->colour[j] == colour)
            for (int i = m->start[j]; i < m->start[j + 1]; ++i)
                part[i] = product[m->row[i]];
}

/* J^T of S1 from J of S0. */
static void turn_constraints(const LagImplicitMatrix *m)
{
    for (int j = 0; j < m->n; ++j)
        for (int i = m->start[j]; i < m->start[j + 1]; ++i) {
            const int row = m->row[i];
            if (row < m->n)
                continue;
            for (int k = m->start[row]; k < m->start[row + 1]; ++k)
                if (m->row[k] == j)
                    m->part[1][k] = m->part[0][i];
        }
}

/* By products with directions, all columns of a colour at once. */
static void evaluate_along(LagImplicitMatrix *m, const LagModel *model, const double *const *in, double *work)
{
    const double *all[10];
    double *out[] = {m->right_im, m->right_re};
    for (int i = 0; i < 8; ++i)
        all[i] = in[i];
    for (int colour = 0; colour < model->n_colours; ++colour) {
        for (int j = 0; j < m->n; ++j)
            m->along[j] = m->colour[j] == colour;
        all[8] = m->along;
        all[9] = m->still;
        lag_call(&model->tangent, all, out, work);
        pick(m, colour, m->right_re, m->part[2]);
        all[8] = m->still;
        all[9] = m->along;
        lag_call(&model->tangent, all, out, work);
        pick(m, colour, m->right_im, m->part[0]);
        pick(m, colour, m->right_re, m->part[1]);
    }
    turn_constraints(m);
}

void lag_implicit_matrix_evaluate(LagImplicitMatrix *m, const LagModel *model, const double *const *in, double *work)
{
    if (lag_present(&model->jacobian))
        lag_call(&model->jacobian, in, m->part, work);
    else
        evaluate_along(m, model, in, work);
}

/* The entries of mu S0 + S1 + S2/mu. */
static void assemble(LagImplicitMatrix *m, double mu_re, double mu_im)
{
    const double square = mu_re * mu_re + mu_im * mu_im, by_re = mu_re / square, by_im = -mu_im / square;
    for (int i = 0; i < m->entries; ++i) {
        m->re[i] = mu_re * m->part[0][i] + m->part[1][i] + by_re * m->part[2][i];
        m->im[i] = mu_im * m->part[0][i] + by_im * m->part[2][i];
    }
}

static void fill(const LagImplicitMatrix *m, const double *values, double *full)
{
    const size_t size = (size_t)m->size;
    memset(full, 0, size * size * sizeof *full);
    for (int j = 0; j < m->size; ++j)
        for (int i = m->start[j]; i < m->start[j + 1]; ++i)
            full[m->row[i] + j * m->size] = values[i];
}

void lag_implicit_matrix_factor(LagImplicitMatrix *m, int which, double mu_re, double mu_im)
{
    assemble(m, mu_re, mu_im);
    if (m->is_sparse) {
        const LagSparseMatrix matrix = {m->start, m->row, m->order, m->re, m->im};
        lag_sparse_lu_factor(&m->sparse[which], &matrix);
        return;
    }
    fill(m, m->re, m->dense[which].re);
    if (which > 0)
        fill(m, m->im, m->dense[which].im);
    lag_dense_lu_factor(&m->dense[which]);
}

/* y += factor part (x, 0) */
static void add_product(const LagImplicitMatrix *m, const double *part, double factor, const double *x, double *y)
{
    for (int j = 0; j < m->n; ++j)
        for (int i = m->start[j]; i < m->start[j + 1]; ++i)
            y[m->row[i]] += factor * part[i] * x[j];
}

void lag_implicit_matrix_solve(LagImplicitMatrix *m, int which, const double *re, const double *im, const double *s,
                               double *x_re, double *x_im)
{
    const size_t bytes = (size_t)m->size * sizeof *m->right_re;
    memset(m->right_re, 0, bytes);
    memset(m->right_im, 0, bytes);
    add_product(m, m->part[0], 1, re, m->right_re);
    if (s)
        add_product(m, m->part[2], -1, s, m->right_re);
    if (im)
        add_product(m, m->part[0], 1, im, m->right_im);
    if (m->is_sparse)
        lag_sparse_lu_solve(&m->sparse[which], m->order, m->right_re, m->right_im);
    else
        lag_dense_lu_solve(&m->dense[which], m->right_re, which > 0 ? m->right_im : NULL);
    memcpy(x_re, m->right_re, (size_t)m->n * sizeof *x_re);
    if (x_im)
        memcpy(x_im, m->right_im, (size_t)m->n * sizeof *x_im);
}
