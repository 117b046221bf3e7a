/* Householder QR with column pivoting as in qr.c, of columns that are 0 in most rows.
 *
 * Nothing is moved: a column keeps its place, and its diagonal is in the row where it is largest. So a reflector touches the rows of
 * its column alone, and the columns that are there, which take these rows over: those of one loop come to its neighbours in a row
 * of loops only. Of columns of which nearly as much is left as of the longest, that with the fewest rows is next, as most of the
 * zeros stay so (as in H.M. Markowitz, Management Science 3, 1957). What is left of a column is computed anew where it changes.
 */
#include "numbers/sparse_qr.h"

#include <limits.h>
#include <math.h>
#include <string.h>

static const double MUCH = 0.1; /* of the longest column */
enum { DEPENDENT = INT_MAX };   /* step of a column of which nothing is left */

void lag_sparse_qr_layout(LagSparseQr *s, size_t rows, size_t cols, LagArena *arena)
{
    s->a = lag_take(arena, rows * cols);
    s->left2 = lag_take(arena, cols);
    s->diagonal = lag_take(arena, cols);
    s->length2 = lag_take(arena, cols);
    s->pivot = lag_take_ints(arena, cols);
    s->pivot_row = lag_take_ints(arena, cols);
    s->column_step = lag_take_ints(arena, cols);
    s->row_step = lag_take_ints(arena, rows);
    s->entries = lag_take_ints(arena, rows * cols);
    s->n_entries = lag_take_ints(arena, cols);
    s->n_above = lag_take_ints(arena, cols);
    s->columns = lag_take_ints(arena, rows * cols);
    s->n_columns = lag_take_ints(arena, rows);
    s->changed = lag_take_ints(arena, cols);
    s->column_mark = lag_take_ints(arena, cols);
    s->row_mark = lag_take_ints(arena, rows);
}

static double *column_of(const LagSparseQr *s, int j) { return s->a + (size_t)j * (size_t)s->rows; }
static int *entries_of(const LagSparseQr *s, int j) { return s->entries + (size_t)j * (size_t)s->rows; }
static int *columns_of(const LagSparseQr *s, int i) { return s->columns + (size_t)i * (size_t)s->cols; }

static void add_entry(LagSparseQr *s, int i, int j)
{
    entries_of(s, j)[s->n_entries[j]++] = i;
    columns_of(s, i)[s->n_columns[i]++] = j;
}

/* The square of what is left of a column. */
static double left2_of(const LagSparseQr *s, int j)
{
    const double *column = column_of(s, j);
    const int *entries = entries_of(s, j);
    double sum = 0;
    for (int e = s->n_above[j]; e < s->n_entries[j]; ++e)
        sum += column[entries[e]] * column[entries[e]];
    return sum;
}

static void begin(LagSparseQr *s, int rows, int cols)
{
    s->rows = rows;
    s->cols = cols;
    for (int i = 0; i < rows; ++i) {
        s->row_step[i] = cols;
        s->n_columns[i] = 0;
        s->row_mark[i] = -1;
    }
    for (int j = 0; j < cols; ++j) {
        s->pivot[j] = j;
        s->column_step[j] = cols;
        s->n_above[j] = s->n_entries[j] = 0;
        s->column_mark[j] = -1;
        for (int i = 0; i < rows; ++i)
            if (column_of(s, j)[i] != 0)
                add_entry(s, i, j);
        s->left2[j] = left2_of(s, j);
    }
}

static int n_left(const LagSparseQr *s, int j) { return s->n_entries[j] - s->n_above[j]; }

/* Gives step k the column with the fewest rows of those of which much is left. Returns the length of the longest. */
static double choose_column(LagSparseQr *s, int k)
{
    double longest2 = 0;
    int best = k;
    for (int c = k; c < s->cols; ++c)
        longest2 = s->left2[s->pivot[c]] > longest2 ? s->left2[s->pivot[c]] : longest2;
    for (int c = k; c < s->cols; ++c)
        if (s->left2[s->pivot[c]] >= MUCH * MUCH * longest2
            && (s->left2[s->pivot[best]] < MUCH * MUCH * longest2 || n_left(s, s->pivot[c]) < n_left(s, s->pivot[best])))
            best = c;
    const int j = s->pivot[best];
    s->pivot[best] = s->pivot[k];
    s->pivot[k] = j;
    return sqrt(longest2);
}

/* Makes the reflector of step k: of its column it leaves the diagonal alone. */
static void make_reflector(LagSparseQr *s, int k)
{
    const int j = s->pivot[k], *entries = entries_of(s, j);
    const double norm = sqrt(s->left2[j]);
    double *u = column_of(s, j), largest = -1;
    int top = 0;
    for (int e = s->n_above[j]; e < s->n_entries[j]; ++e) {
        if (!(fabs(u[entries[e]]) > largest))
            continue;
        top = entries[e];
        largest = fabs(u[top]);
    }
    s->column_step[j] = s->row_step[top] = k;
    s->pivot_row[k] = top;
    s->diagonal[k] = u[top] > 0 ? -norm : norm;
    u[top] -= s->diagonal[k];
    s->length2[k] = left2_of(s, j);
}

/* x = (I - 2 u u' / u'u) x, of step k. */
static void reflect(const LagSparseQr *s, int k, double *x)
{
    const int j = s->pivot[k], *entries = entries_of(s, j);
    const double *u = column_of(s, j);
    double sum = 0;
    for (int e = s->n_above[j]; e < s->n_entries[j]; ++e)
        sum += u[entries[e]] * x[entries[e]];
    const double factor = 2 * sum / s->length2[k];
    for (int e = s->n_above[j]; e < s->n_entries[j]; ++e)
        x[entries[e]] -= factor * u[entries[e]];
}

/* Fills `changed` with the columns without a step that meet the reflector of step k; rows forget the others. Returns their number. */
static int find_changed(LagSparseQr *s, int k)
{
    const int j = s->pivot[k];
    int count = 0;
    for (int e = s->n_above[j]; e < s->n_entries[j]; ++e) {
        const int i = entries_of(s, j)[e];
        int *columns = columns_of(s, i), kept = 0;
        for (int n = 0; n < s->n_columns[i]; ++n) {
            const int c = columns[n];
            if (s->column_step[c] != s->cols)
                continue;
            columns[kept++] = c;
            if (s->column_mark[c] != k)
                s->changed[count++] = c;
            s->column_mark[c] = k;
        }
        s->n_columns[i] = kept;
    }
    return count;
}

/* The rows of the reflector of step k become those of column c, too. */
static void take_over(LagSparseQr *s, int k, int c)
{
    const int j = s->pivot[k], *entries = entries_of(s, j);
    for (int e = s->n_above[c]; e < s->n_entries[c]; ++e)
        s->row_mark[entries_of(s, c)[e]] = c;
    for (int e = s->n_above[j]; e < s->n_entries[j]; ++e)
        if (s->row_mark[entries[e]] != c)
            add_entry(s, entries[e], c);
}

/* The row of step k is no longer left of column c; nothing is, and nothing comes to it, where it is not longer than `least`. */
static void leave(LagSparseQr *s, int k, int c, double least)
{
    int *entries = entries_of(s, c), e = s->n_above[c];
    while (entries[e] != s->pivot_row[k])
        ++e;
    entries[e] = entries[s->n_above[c]];
    entries[s->n_above[c]++] = s->pivot_row[k];
    s->left2[c] = left2_of(s, c);
    if (s->left2[c] > least * least)
        return;
    s->left2[c] = 0;
    s->column_step[c] = DEPENDENT;
}

void lag_sparse_qr(LagSparseQr *s, int rows, int cols, double tolerance)
{
    const int most = rows < cols ? rows : cols;
    double first = 0;
    begin(s, rows, cols);
    for (s->rank = 0; s->rank < most; ++s->rank) {
        const int k = s->rank;
        const double longest = choose_column(s, k);
        first = k == 0 ? longest : first;
        if (!(longest > tolerance * first))
            return;
        make_reflector(s, k);
        for (int n = find_changed(s, k) - 1; n >= 0; --n) {
            const int c = s->changed[n];
            take_over(s, k, c);
            reflect(s, k, column_of(s, c));
            leave(s, k, c, tolerance * first);
        }
    }
}

/* Fills y, step by step, with what R' y = b says, as many columns as steps. */
static void solve_transposed(const LagSparseQr *s, const double *b, double *y)
{
    for (int k = 0; k < s->rank; ++k) {
        const int j = s->pivot[k], *entries = entries_of(s, j);
        double rest = b[j];
        for (int e = 0; e < s->n_above[j]; ++e)
            rest -= column_of(s, j)[entries[e]] * y[s->row_step[entries[e]]];
        y[k] = rest / s->diagonal[k];
    }
}

/* Fills y[columns] with the least squares of A y = z, A's columns independent; z is overwritten. */
static void solve_least_squares(const LagSparseQr *s, double *z, double *y)
{
    for (int k = 0; k < s->rank; ++k)
        reflect(s, k, z);
    for (int k = s->rank - 1; k >= 0; --k) {
        const int j = s->pivot[k], *entries = entries_of(s, j);
        const double *column = column_of(s, j);
        y[j] = z[s->pivot_row[k]] / s->diagonal[k];
        for (int e = 0; e < s->n_above[j]; ++e)
            z[entries[e]] -= column[entries[e]] * y[j];
    }
}

/* The same in the sense of weighted least squares, of more columns than steps. */
static void solve_dependent(const LagSparseQr *s, const double *b, const double *weight, LagSparseQr *dependent, double *z,
                            double *y)
{
    memset(dependent->a, 0, (size_t)s->cols * (size_t)s->rank * sizeof *dependent->a);
    for (int j = 0; j < s->cols; ++j) {
        const int *entries = entries_of(s, j);
        for (int e = 0; e < s->n_above[j]; ++e)
            dependent->a[j + s->row_step[entries[e]] * s->cols] = weight[j] * column_of(s, j)[entries[e]];
        if (s->column_step[j] < s->rank)
            dependent->a[j + s->column_step[j] * s->cols] = weight[j] * s->diagonal[s->column_step[j]];
        z[j] = weight[j] * b[j];
    }
    memset(y, 0, (size_t)s->rank * sizeof *y);
    lag_sparse_qr(dependent, s->cols, s->rank, 0);
    solve_least_squares(dependent, z, y);
}

void lag_sparse_qr_nearest(const LagSparseQr *s, const double *b, const double *weight, LagSparseQr *dependent, double *y,
                           double *z, double *x)
{
    for (int k = 0; k < s->rank; ++k)
        reflect(s, k, x); /* Q' x: where no diagonal is it stays, */
    if (s->rank < s->cols)
        solve_dependent(s, b, weight, dependent, z, y);
    else
        solve_transposed(s, b, y);
    for (int k = 0; k < s->rank; ++k)
        x[s->pivot_row[k]] = y[k]; /* elsewhere R' y = b tells it */
    for (int k = s->rank - 1; k >= 0; --k)
        reflect(s, k, x);
}
