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
    lag_heap_layout(&s->longest, cols, arena);
    lag_heap_layout(&s->shortest, cols, arena);
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
static int *columns_of(const LagSparseQr *s, int i) { return s->columns + (size_t)i * (size_t)s->room; }

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

void lag_sparse_qr_begin(LagSparseQr *s, int rows, int cols)
{
    s->rows = rows;
    s->room = cols;
    memset(s->n_columns, 0, (size_t)rows * sizeof *s->n_columns);
    memset(s->n_entries, 0, (size_t)cols * sizeof *s->n_entries);
}

void lag_sparse_qr_add(LagSparseQr *s, int i, int j, double value)
{
    if (value == 0)
        return;
    column_of(s, j)[i] = value;
    add_entry(s, i, j);
}

size_t lag_sparse_qr_entries(const LagSparseQr *s, int cols)
{
    size_t sum = 0;
    for (int j = 0; j < cols; ++j)
        sum += (size_t)s->n_entries[j];
    return sum;
}

void lag_sparse_qr_fill(LagSparseQr *s, int cols)
{
    for (int i = 0; i < s->rows; ++i)
        s->row_mark[i] = -1;
    for (int j = 0; j < cols; ++j) {
        for (int e = 0; e < s->n_entries[j]; ++e)
            s->row_mark[entries_of(s, j)[e]] = j;
        for (int i = 0; i < s->rows; ++i)
            if (s->row_mark[i] != j)
                column_of(s, j)[i] = 0;
    }
}

/* What is left of a column, and in how many rows. */
static void measure(LagSparseQr *s, int j)
{
    s->longest.key[j] = -left2_of(s, j);
    s->shortest.key[j] = s->n_entries[j] - s->n_above[j];
}

static double left2(const LagSparseQr *s, int j) { return -s->longest.key[j]; }

static void begin(LagSparseQr *s)
{
    for (int i = 0; i < s->rows; ++i) {
        s->row_step[i] = s->cols;
        s->row_mark[i] = -1;
    }
    for (int j = 0; j < s->cols; ++j) {
        s->column_step[j] = s->cols;
        s->n_above[j] = 0;
        s->column_mark[j] = -1;
        measure(s, j);
    }
    lag_heap_fill(&s->longest, s->cols);
    lag_heap_fill(&s->shortest, s->cols);
}

/* Takes a column out of those without a step. */
static void take_column(LagSparseQr *s, int j)
{
    lag_heap_take(&s->longest, j);
    lag_heap_take(&s->shortest, j);
}

/* Gives step k the column with the fewest rows of those of which much is left. Returns the length of the longest; 0: there is none. */
static double choose_column(LagSparseQr *s, int k)
{
    const double most = s->longest.size > 0 ? -s->longest.key[s->longest.item[0]] : 0;
    int passed = 0;
    while (most > 0 && left2(s, s->shortest.item[0]) < MUCH * MUCH * most) {
        s->changed[passed++] = s->shortest.item[0];
        lag_heap_take(&s->shortest, s->shortest.item[0]);
    }
    if (most > 0)
        s->pivot[k] = s->shortest.item[0];
    while (passed > 0)
        lag_heap_put(&s->shortest, s->changed[--passed]);
    return sqrt(most);
}

/* Makes the reflector of step k: of its column it leaves the diagonal alone. */
static void make_reflector(LagSparseQr *s, int k)
{
    const int j = s->pivot[k], *entries = entries_of(s, j);
    const double norm = sqrt(left2(s, j));
    double *u = column_of(s, j), largest = -1;
    int top = 0;
    for (int e = s->n_above[j]; e < s->n_entries[j]; ++e) {
        if (!(fabs(u[entries[e]]) > largest))
            continue;
        top = entries[e];
        largest = fabs(u[top]);
    }
    take_column(s, j);
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
    for (int e = s->n_above[j]; e < s->n_entries[j]; ++e) {
        if (s->row_mark[entries[e]] == c)
            continue;
        column_of(s, c)[entries[e]] = 0;
        add_entry(s, entries[e], c);
    }
}

/* The row of step k is no longer left of column c; nothing is, and nothing comes to it, where it is not longer than `least`. */
static void leave(LagSparseQr *s, int k, int c, double least)
{
    int *entries = entries_of(s, c), e = s->n_above[c];
    while (entries[e] != s->pivot_row[k])
        ++e;
    entries[e] = entries[s->n_above[c]];
    entries[s->n_above[c]++] = s->pivot_row[k];
    measure(s, c);
    if (left2(s, c) > least * least) {
        lag_heap_update(&s->longest, c);
        lag_heap_update(&s->shortest, c);
        return;
    }
    take_column(s, c);
    s->column_step[c] = DEPENDENT;
}

void lag_sparse_qr(LagSparseQr *s, int cols, double tolerance)
{
    const int most = s->rows < cols ? s->rows : cols;
    double first = 0;
    s->cols = cols;
    begin(s);
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
    lag_sparse_qr_begin(dependent, s->cols, s->rank);
    for (int j = 0; j < s->cols; ++j) {
        const int *entries = entries_of(s, j);
        for (int e = 0; e < s->n_above[j]; ++e)
            lag_sparse_qr_add(dependent, j, s->row_step[entries[e]], weight[j] * column_of(s, j)[entries[e]]);
        if (s->column_step[j] < s->rank)
            lag_sparse_qr_add(dependent, j, s->column_step[j], weight[j] * s->diagonal[s->column_step[j]]);
        z[j] = weight[j] * b[j];
    }
    memset(y, 0, (size_t)s->rank * sizeof *y);
    lag_sparse_qr(dependent, s->rank, 0);
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
