/* G.H. Golub, C.F. Van Loan, Matrix Computations, 4th ed., 3.4: outer products, column by column. */
#include "numbers/dense_lu.h"

#include <math.h>

#include "numbers/extremes.h"

static const double SMALLEST = 1e-300, LARGEST = 1e300; /* whose inverses are numbers */

void lag_dense_lu_layout(LagDenseLu *lu, int size, int is_complex, LagArena *arena)
{
    const size_t n = (size_t)size;
    lu->size = size;
    lu->dependent = LAG_DEPENDENT;
    lu->early = 1;
    lu->apart = 0;
    lu->re = lag_take(arena, n * n);
    lu->im = is_complex ? lag_take(arena, n * n) : NULL;
    lu->scale = lag_take(arena, n);
    lu->pivot = lag_take_ints(arena, n);
}

static double length(const LagDenseLu *lu, int place)
{
    return fabs(lu->re[place]) + (lu->im ? fabs(lu->im[place]) : 0);
}

static void scale_rows(LagDenseLu *lu)
{
    const int n = lu->size;
    for (int i = 0; i < n; ++i)
        lu->scale[i] = 0;
    for (int k = 0; k < n * n; ++k)
        lu->scale[k % n] = lag_max(length(lu, k), lu->scale[k % n]);
    for (int i = 0; i < n; ++i)
        lu->scale[i] = lu->scale[i] > 0 ? 1 / lu->scale[i] : 0;
}

/* Relative to its row. */
static double size_of(const LagDenseLu *lu, int i, int k) { return length(lu, i + k * lu->size) * lu->scale[i]; }

/* The first row of pivots of column k that are good enough, among rows `first` and below, and its size relative to its row. */
static int best_pivot(const LagDenseLu *lu, int first, int k, double *size)
{
    const int end = k < lu->apart ? lu->apart : lu->size;
    double largest = 0;
    int best = first;
    for (int i = first; i < end; ++i)
        largest = lag_max(size_of(lu, i, k), largest);
    while (best < end - 1 && !(size_of(lu, best, k) >= lu->early * largest))
        ++best;
    *size = best < end ? size_of(lu, best, k) : -1;
    return best;
}

static double largest_of_column(const LagDenseLu *lu, int k)
{
    double largest = 0;
    for (int i = 0; i < lu->size; ++i)
        largest = lag_max(size_of(lu, i, k), largest);
    return largest;
}

static void swap(double *a, double *b)
{
    const double c = *a;
    *a = *b;
    *b = c;
}

static void swap_rows(LagDenseLu *lu, int a, int b)
{
    const int n = lu->size;
    swap(&lu->scale[a], &lu->scale[b]);
    for (int j = 0; j < n; ++j) {
        swap(&lu->re[a + j * n], &lu->re[b + j * n]);
        if (lu->im)
            swap(&lu->im[a + j * n], &lu->im[b + j * n]);
    }
}

/* (re, im) -= (fr, fi) times column `l`, rows first .. n-1; real when im is NULL. */
static void subtract(int first, int n, const double *l_re, const double *l_im, double fr, double fi, double *re, double *im)
{
    if (!im) {
        for (int i = first; i < n; ++i)
            re[i] -= fr * l_re[i];
        return;
    }
    for (int i = first; i < n; ++i) {
        re[i] -= fr * l_re[i] - fi * l_im[i];
        im[i] -= fr * l_im[i] + fi * l_re[i];
    }
}

static void multiply(double *re, double *im, double fr, double fi)
{
    const double x = *re;
    *re = x * fr - *im * fi;
    *im = x * fi + *im * fr;
}

/* 1/(re + i im) without overflow. */
static void invert(double *re, double *im)
{
    const double scale = lag_max(fabs(*re), fabs(*im)), x = *re / scale, y = *im / scale, square = (x * x + y * y) * scale;
    *re = x / square;
    *im = -y / square;
}

/* Divides column k below row r by its pivot, and leaves 1/pivot in row r. */
static void divide_column(LagDenseLu *lu, int r, int k)
{
    const int n = lu->size;
    double *re = lu->re + k * n, *im = lu->im ? lu->im + k * n : NULL;
    if (!im) {
        re[r] = 1 / re[r];
        for (int i = r + 1; i < n; ++i)
            re[i] *= re[r];
        return;
    }
    invert(&re[r], &im[r]);
    for (int i = r + 1; i < n; ++i)
        multiply(&re[i], &im[i], re[r], im[r]);
}

static void eliminate(LagDenseLu *lu, int r, int k)
{
    const int n = lu->size;
    double *re = lu->re, *im = lu->im;
    divide_column(lu, r, k);
    for (int j = k + 1; j < n; ++j) {
        const double fr = re[r + j * n], fi = im ? im[r + j * n] : 0;
        if (fr != 0 || fi != 0)
            subtract(r + 1, n, re + k * n, im ? im + k * n : NULL, fr, fi, re + j * n, im ? im + j * n : NULL);
    }
}

/* One real number, with its digits as they are among others. Returns 0 where it may be dependent. */
static int invert_one(LagDenseLu *lu)
{
    const double size = fabs(lu->re[0]);
    if (lu->size != 1 || lu->im || lu->apart > 0 || !(size > SMALLEST && size < LARGEST))
        return 0;
    lu->scale[0] = 1 / size;
    lu->re[0] = 1 / lu->re[0];
    lu->pivot[0] = 0;
    return 1;
}

void lag_dense_lu_factor(LagDenseLu *lu)
{
    int r = 0;
    if (invert_one(lu))
        return;
    scale_rows(lu);
    for (int k = 0; k < lu->size; ++k) {
        double size;
        const int best = best_pivot(lu, r, k, &size);
        lu->pivot[k] = size > lu->dependent * largest_of_column(lu, k) ? best : -1;
        if (lu->pivot[k] < 0)
            continue;
        if (best != r)
            swap_rows(lu, r, best);
        eliminate(lu, r, k);
        ++r;
    }
}

void lag_dense_lu_solve(const LagDenseLu *lu, double *re, double *im)
{
    const int n = lu->size;
    int r = 0;
    if (n == 1 && !im) {
        re[0] = lu->pivot[0] < 0 ? 0 : re[0] * lu->re[0];
        return;
    }
    for (int k = 0; k < n; ++k) {
        if (lu->pivot[k] < 0)
            continue;
        swap(&re[r], &re[lu->pivot[k]]);
        if (im)
            swap(&im[r], &im[lu->pivot[k]]);
        ++r;
    }
    r = 0;
    for (int k = 0; k < n; ++k)
        if (lu->pivot[k] >= 0) {
            subtract(r + 1, n, lu->re + k * n, im ? lu->im + k * n : NULL, re[r], im ? im[r] : 0, re, im);
            ++r;
        }
    for (int k = n - 1; k >= 0; --k) { /* the pivot of column k stands in row r <= k */
        const int has_pivot = lu->pivot[k] >= 0;
        double x = 0, y = 0;
        if (has_pivot) {
            --r;
            x = re[r];
            y = im ? im[r] : 0;
            multiply(&x, &y, lu->re[r + k * n], im ? lu->im[r + k * n] : 0);
            subtract(0, r, lu->re + k * n, im ? lu->im + k * n : NULL, x, y, re, im);
        }
        re[k] = x;
        if (im)
            im[k] = y;
    }
}
