/* J.R. Gilbert, T. Peierls, Sparse partial pivoting in time proportional to arithmetic operations, SIAM J. Sci. Stat. Comput. 9
 * (1988); T.A. Davis, Direct Methods for Sparse Linear Systems (2006), 6.2. Column k of L U = P A Q is the solution of a
 * triangular system whose nonzeros are found by a search through the columns of L so far. Rows keep their numbers throughout.
 */
#include "numbers/sparse_lu.h"

#include <math.h>
#include <string.h>

#include "numbers/dense_lu.h"

/* The row that stands on the diagonal of A is kept as long as it is this good: less fill, and the pattern lasts. Pivots of a
 * matrix with other values may fall this far behind the best. */
static const double DIAGONAL = 0.1, STILL_GOOD = 1e-3;

void lag_sparse_lu_layout(LagSparseLu *lu, int size, int n_lower, int n_upper, LagArena *arena)
{
    const size_t n = (size_t)size, lower = (size_t)n_lower, upper = (size_t)n_upper;
    lu->size = size;
    lu->is_known = 0;
    lu->l_start = lag_take_ints(arena, n + 1);
    lu->l_row = lag_take_ints(arena, lower);
    lu->u_start = lag_take_ints(arena, n + 1);
    lu->u_column = lag_take_ints(arena, upper);
    lu->pivot = lag_take_ints(arena, n);
    lu->column = lag_take_ints(arena, n);
    lu->stack = lag_take_ints(arena, n);
    lu->next = lag_take_ints(arena, n);
    lu->seen = lag_take_ints(arena, n);
    lu->l_re = lag_take(arena, lower);
    lu->l_im = lag_take(arena, lower);
    lu->u_re = lag_take(arena, upper);
    lu->u_im = lag_take(arena, upper);
    lu->d_re = lag_take(arena, n);
    lu->d_im = lag_take(arena, n);
    lu->x_re = lag_take(arena, n);
    lu->x_im = lag_take(arena, n);
    lu->scale = lag_take(arena, n);
}

static double length(double re, double im) { return fabs(re) + fabs(im); }

static void scale_rows(LagSparseLu *lu, const LagSparseMatrix *a)
{
    memset(lu->scale, 0, (size_t)lu->size * sizeof *lu->scale);
    for (int i = 0; i < a->start[lu->size]; ++i)
        lu->scale[a->row[i]] = fmax(lu->scale[a->row[i]], length(a->re[i], a->im[i]));
    for (int i = 0; i < lu->size; ++i)
        lu->scale[i] = lu->scale[i] > 0 ? 1 / lu->scale[i] : 0;
}

/* Depth-first from a row through the columns of L that it leads to. Rows come out last to first: `top` is the new top of the
 * list at the end of `stack`. Row numbers of the path grow from the bottom of the same stack. */
static int search(LagSparseLu *lu, int row, int mark, int top)
{
    int head = 0;
    lu->stack[0] = row;
    while (head >= 0) {
        const int here = lu->stack[head], column = lu->column[here];
        if (lu->seen[here] != mark) {
            lu->seen[here] = mark;
            lu->next[head] = column < 0 ? 0 : lu->l_start[column];
        }
        const int end = column < 0 ? 0 : lu->l_start[column + 1];
        int place = lu->next[head];
        while (place < end && lu->seen[lu->l_row[place]] == mark)
            ++place;
        lu->next[head] = place + 1;
        if (place < end)
            lu->stack[++head] = lu->l_row[place];
        else {
            --head;
            lu->stack[--top] = here;
        }
    }
    return top;
}

/* The column of A into x. */
static void scatter(LagSparseLu *lu, const LagSparseMatrix *a, int column)
{
    for (int i = a->start[column]; i < a->start[column + 1]; ++i) {
        lu->x_re[a->row[i]] = a->re[i];
        lu->x_im[a->row[i]] = a->im[i];
    }
}

/* x -= (re, im) times column j of L. */
static void subtract(LagSparseLu *lu, int j, double re, double im, double *x_re, double *x_im)
{
    for (int i = lu->l_start[j]; i < lu->l_start[j + 1]; ++i) {
        const int row = lu->l_row[i];
        x_re[row] -= lu->l_re[i] * re - lu->l_im[i] * im;
        x_im[row] -= lu->l_re[i] * im + lu->l_im[i] * re;
    }
}

/* Moves x at the pivots of U's column k into U, eliminating. */
static void eliminate(LagSparseLu *lu, int k)
{
    for (int i = lu->u_start[k]; i < lu->u_start[k + 1]; ++i) {
        const int j = lu->u_column[i], row = lu->pivot[j];
        const double re = lu->x_re[row], im = lu->x_im[row];
        lu->u_re[i] = re;
        lu->u_im[i] = im;
        lu->x_re[row] = lu->x_im[row] = 0;
        if (re != 0 || im != 0)
            subtract(lu, j, re, im, lu->x_re, lu->x_im);
    }
}

/* Moves x at the rows of L's column k into L, divided by the pivot x holds in the row `pivot` (-1: none). */
static void divide(LagSparseLu *lu, int k, int pivot)
{
    double re = 0, im = 0;
    if (pivot >= 0) {
        const double size = length(lu->x_re[pivot], lu->x_im[pivot]), x = lu->x_re[pivot] / size, y = lu->x_im[pivot] / size;
        const double square = (x * x + y * y) * size;
        re = x / square;
        im = -y / square;
        lu->x_re[pivot] = lu->x_im[pivot] = 0;
    }
    lu->d_re[k] = re;
    lu->d_im[k] = im;
    for (int i = lu->l_start[k]; i < lu->l_start[k + 1]; ++i) {
        const int row = lu->l_row[i];
        const double x = lu->x_re[row], y = lu->x_im[row];
        lu->l_re[i] = x * re - y * im;
        lu->l_im[i] = x * im + y * re;
        lu->x_re[row] = lu->x_im[row] = 0;
    }
}

static double column_size(const LagSparseLu *lu, const LagSparseMatrix *a, int column)
{
    double largest = 0;
    for (int i = a->start[column]; i < a->start[column + 1]; ++i)
        largest = fmax(largest, length(a->re[i], a->im[i]) * lu->scale[a->row[i]]);
    return largest;
}

/* The best pivot among the rows stack[first ..]; one on the diagonal, or which was there before, is kept if it is good. */
static int choose(const LagSparseLu *lu, const LagSparseMatrix *a, int column, int first)
{
    double largest = LAG_DEPENDENT * column_size(lu, a, column);
    int best = -1;
    for (int i = first; i < lu->size; ++i) {
        const int row = lu->stack[i];
        const double size = length(lu->x_re[row], lu->x_im[row]) * lu->scale[row];
        if (lu->column[row] < 0 && size > largest) {
            largest = size;
            best = row;
        }
    }
    const double own = length(lu->x_re[column], lu->x_im[column]) * lu->scale[column];
    return best >= 0 && lu->column[column] < 0 && own >= DIAGONAL * largest ? column : best;
}

static void factor_column(LagSparseLu *lu, const LagSparseMatrix *a, int k)
{
    const int column = a->order[k];
    int top = lu->size, u = lu->u_start[k], l = lu->l_start[k];
    for (int i = a->start[column]; i < a->start[column + 1]; ++i)
        if (lu->seen[a->row[i]] != k + 1)
            top = search(lu, a->row[i], k + 1, top);
    for (int i = top; i < lu->size; ++i)
        if (lu->column[lu->stack[i]] >= 0)
            lu->u_column[u++] = lu->column[lu->stack[i]];
    lu->u_start[k + 1] = u;
    scatter(lu, a, column);
    eliminate(lu, k);
    const int pivot = choose(lu, a, column, top);
    for (int i = top; i < lu->size; ++i)
        if (lu->column[lu->stack[i]] < 0 && lu->stack[i] != pivot)
            lu->l_row[l++] = lu->stack[i];
    lu->l_start[k + 1] = l;
    lu->pivot[k] = pivot;
    divide(lu, k, pivot);
    if (pivot >= 0)
        lu->column[pivot] = k;
}

static void factor_anew(LagSparseLu *lu, const LagSparseMatrix *a)
{
    lu->l_start[0] = lu->u_start[0] = 0;
    for (int i = 0; i < lu->size; ++i) {
        lu->column[i] = -1;
        lu->seen[i] = 0;
    }
    for (int k = 0; k < lu->size; ++k)
        factor_column(lu, a, k);
    lu->is_known = 1;
}

/* Whether the pivot of column k is still good enough among its rows. */
static int is_still_good(const LagSparseLu *lu, const LagSparseMatrix *a, int k)
{
    const int pivot = lu->pivot[k];
    double largest = 0;
    if (pivot < 0)
        return 0;
    for (int i = lu->l_start[k]; i < lu->l_start[k + 1]; ++i)
        largest = fmax(largest, length(lu->x_re[lu->l_row[i]], lu->x_im[lu->l_row[i]]) * lu->scale[lu->l_row[i]]);
    const double own = length(lu->x_re[pivot], lu->x_im[pivot]) * lu->scale[pivot];
    return own >= STILL_GOOD * largest && own > LAG_DEPENDENT * column_size(lu, a, a->order[k]);
}

/* On the pattern of an earlier matrix; 0 when that is no longer good. */
static int factor_again(LagSparseLu *lu, const LagSparseMatrix *a)
{
    for (int k = 0; k < lu->size; ++k) {
        scatter(lu, a, a->order[k]);
        eliminate(lu, k);
        const int good = is_still_good(lu, a, k);
        divide(lu, k, lu->pivot[k]);
        if (!good)
            return 0;
    }
    return 1;
}

void lag_sparse_lu_factor(LagSparseLu *lu, const LagSparseMatrix *a)
{
    scale_rows(lu, a);
    if (!lu->is_known || !factor_again(lu, a))
        factor_anew(lu, a);
}

void lag_sparse_lu_solve(LagSparseLu *lu, const int *order, double *re, double *im)
{
    double *y_re = lu->x_re, *y_im = lu->x_im;
    for (int k = 0; k < lu->size; ++k) {
        const int row = lu->pivot[k];
        y_re[k] = row >= 0 ? re[row] : 0;
        y_im[k] = row >= 0 ? im[row] : 0;
        subtract(lu, k, y_re[k], y_im[k], re, im);
    }
    for (int k = lu->size - 1; k >= 0; --k) {
        const double x = y_re[k] * lu->d_re[k] - y_im[k] * lu->d_im[k], y = y_re[k] * lu->d_im[k] + y_im[k] * lu->d_re[k];
        for (int i = lu->u_start[k]; i < lu->u_start[k + 1]; ++i) {
            const int j = lu->u_column[i];
            y_re[j] -= lu->u_re[i] * x - lu->u_im[i] * y;
            y_im[j] -= lu->u_re[i] * y + lu->u_im[i] * x;
        }
        re[order[k]] = x;
        im[order[k]] = y;
        y_re[k] = y_im[k] = 0;
    }
}
