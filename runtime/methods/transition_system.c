/* A and the loads of a linear scene of few states, in doubles: what linear_system.c does for large ones in double-doubles. */
#include <math.h>
#include <string.h>

#include "model/tape.h"
#include "methods/transition_matrices.h"

/* The numbers of some rows, from `value` on, to their places; returns what follows them. */
static const double *unpack(const LagTransitionMatrices *s, LagRows rows, size_t first, const double *value, double *to)
{
    for (int i = 0; i < rows.rows; ++i)
        for (int e = rows.start[i]; e < rows.start[i + 1]; ++e)
            to[(size_t)rows.column[e] * s->stride + first + (size_t)i] = *value++;
    return value;
}

/* M = L D L' in its own place, row by row; in the order of elimination. Returns 0 when it is not positive definite. */
static int factor(LagTransitionMatrices *s)
{
    const int n = s->pattern.n;
    double *M = s->mass;
    for (int k = 0; k < n; ++k) {
        for (int j = 0; j < k; ++j) {
            double rest = M[k * n + j];
            for (int i = 0; i < j; ++i)
                rest -= M[k * n + i] * M[j * n + i] * M[i * n + i];
            M[k * n + j] = rest / M[j * n + j];
        }
        for (int i = 0; i < k; ++i)
            M[k * n + k] -= M[k * n + i] * M[k * n + i] * M[i * n + i];
        if (!(M[k * n + k] > 0) || !isfinite(M[k * n + k]))
            return 0;
    }
    return 1;
}

/* The rates of rates in a column of A, which holds forces, as the accelerations M^-1 F. */
static void solve(const LagTransitionMatrices *s, double *column)
{
    const int n = s->pattern.n;
    const double *L = s->mass;
    double a[LAG_TRANSITION_MOST_STATES];
    for (int k = 0; k < n; ++k) {
        a[k] = column[n + s->pattern.order[k]];
        for (int i = 0; i < k; ++i)
            a[k] -= L[k * n + i] * a[i];
    }
    for (int k = n - 1; k >= 0; --k) {
        a[k] /= L[k * n + k];
        for (int i = k + 1; i < n; ++i)
            a[k] -= L[i * n + k] * a[i];
    }
    for (int k = 0; k < n; ++k)
        column[n + s->pattern.order[k]] = a[k];
}

/* The largest sum of a row from `first` on over `count` columns, its columns and rows in units of the root of the masses. */
static double row_norm(const LagTransitionMatrices *s, size_t row, size_t column, size_t count, const double *unit)
{
    double largest = 0;
    for (size_t i = 0; i < count; ++i) {
        double sum = 0;
        for (size_t j = 0; j < count; ++j)
            sum += fabs(s->A[(column + j) * s->stride + row + i]) * (unit ? unit[i] / unit[j] : 1);
        largest = sum <= largest ? largest : sum; /* keeps a NaN */
    }
    return largest;
}

/* In units of time and of each coordinate in which the rates of positions, and rates by positions, are alike. Loads drive alone. */
static double norm_of(const LagTransitionMatrices *s, const double *unit)
{
    const size_t n = (size_t)s->pattern.n;
    const double stiffness = row_norm(s, n, 0, n, unit), damping = row_norm(s, n, n, n, unit);
    return fmax(sqrt(stiffness) + damping, row_norm(s, 2 * n, 2 * n, s->size - 2 * n, NULL));
}

static int build(LagTransitionMatrices *s)
{
    const LagLinearPattern *pattern = &s->pattern;
    const size_t n = (size_t)pattern->n;
    const double *next = s->values + n;
    double unit[LAG_TRANSITION_MOST_STATES], probe = 0;
    for (size_t k = 0; k < n; ++k) {
        memset(s->mass + k * n, 0, n * sizeof *s->mass);
        s->mass[k * n + k] = s->values[k];
        unit[pattern->order[k]] = sqrt(s->values[k]);
        for (int e = pattern->lower.start[k]; e < pattern->lower.start[k + 1]; ++e)
            s->mass[k * n + (size_t)pattern->lower.column[e]] = *next++;
    }
    memset(s->A, 0, lag_transition_entries(s) * sizeof *s->A);
    next = unpack(s, pattern->F, n, next, s->A);
    next = unpack(s, pattern->G, 2 * n, next, s->A + 2 * n * s->stride);
    for (int f = 0; f < s->n_forms; ++f) {
        memset(s->form[f], 0, lag_transition_entries(s) * sizeof *s->form[f]);
        next = unpack(s, pattern->form[s->place[f]], 0, next, s->form[f]);
    }
    if (!factor(s))
        return 0;
    for (size_t j = 0; j < s->size; ++j)
        solve(s, s->A + j * s->stride);
    for (size_t k = 0; k < n; ++k)
        s->A[(n + k) * s->stride + k] = 1;
    for (size_t i = 0; i < lag_transition_entries(s); ++i)
        probe += 0 * s->A[i];
    s->norm = norm_of(s, unit);
    return probe == 0 && isfinite(s->norm);
}

int lag_transition_build(LagTransitionMatrices *s, const double *p, const double *d)
{
    const size_t bytes = (size_t)s->model->n_parameters * sizeof *p;
    if (s->is_known && memcmp(p, s->p, bytes) == 0)
        return 1;
    const double *in[] = {p, d};
    lag_tape_run(s->model->linear.tape, in, &s->values, s->work);
    memcpy(s->p, p, bytes);
    s->length[0] = 0;
    s->is_planned = 0;
    s->is_known = build(s);
    return s->is_known;
}

void lag_transition_loads(LagTransitionMatrices *s, const LagInputs *inputs, double t, const double *d, double *u, double *w)
{
    const double *in[] = {&t, s->p, d};
    const int n_inputs = s->pattern.n_inputs;
    lag_tape_run(s->model->waves.tape, in, &w, s->work);
    if (n_inputs == 0)
        return;
    lag_inputs_at(inputs, t, u);
    memcpy(w, u, (size_t)n_inputs * sizeof *u);
    lag_inputs_slope(inputs, u);
    memcpy(w + n_inputs, u, (size_t)n_inputs * sizeof *u);
}
