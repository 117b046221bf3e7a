/* Householder QR with column pivoting: P. Businger, G.H. Golub, Numer. Math. 7 (1965); G.H. Golub, C.F. Van Loan,
 * Matrix Computations, 4th ed., 5.2 and 5.4.
 *
 * Column j keeps its reflector u in rows j and below (I - 2 u u' / u'u), R above; the diagonal of R is kept apart. Norms of
 * the remaining columns are computed anew, not updated: sizes are small, and safe is better.
 */
#include "numbers/qr.h"

#include <math.h>
#include <string.h>

/* In four independent chains, which processors run side by side. */
static double dot(const double *a, const double *b, int n)
{
    double sum[4] = {0, 0, 0, 0};
    int i = 0;
    for (; i + 3 < n; i += 4)
        for (int k = 0; k < 4; ++k)
            sum[k] += a[i + k] * b[i + k];
    for (; i < n; ++i)
        sum[0] += a[i] * b[i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* x = (I - 2 u u' / u'u) x */
static void reflect(const double *u, double length2, double *x, int n)
{
    const double factor = 2 * dot(u, x, n) / length2;
    if (factor == 0) /* as of gradients that have no value in common */
        return;
    for (int i = 0; i < n; ++i)
        x[i] -= factor * u[i];
}

static int longest_column(const double *a, int rows, int cols, int first, double *norm)
{
    int longest = first;
    *norm = -1;
    for (int j = first; j < cols; ++j) {
        const double *column = a + j * rows + first, length = sqrt(dot(column, column, rows - first));
        if (length > *norm) {
            *norm = length;
            longest = j;
        }
    }
    return longest;
}

static void swap_columns(double *a, int rows, int *pivot, int i, int j)
{
    const int column = pivot[i];
    pivot[i] = pivot[j];
    pivot[j] = column;
    for (int r = 0; r < rows; ++r) {
        const double x = a[i * rows + r];
        a[i * rows + r] = a[j * rows + r];
        a[j * rows + r] = x;
    }
}

int lag_qr(double *a, int rows, int cols, double *diagonal, int *pivot, double tolerance)
{
    const int most = rows < cols ? rows : cols;
    double first = 0;
    for (int j = 0; j < cols; ++j)
        pivot[j] = j;
    for (int j = 0; j < most; ++j) {
        double norm;
        swap_columns(a, rows, pivot, j, longest_column(a, rows, cols, j, &norm));
        first = j == 0 ? norm : first;
        if (!(norm > tolerance * first))
            return j;
        double *u = a + j * rows + j;
        diagonal[j] = u[0] > 0 ? -norm : norm;
        u[0] -= diagonal[j];
        const double length2 = dot(u, u, rows - j);
        for (int c = j + 1; c < cols; ++c)
            reflect(u, length2, a + c * rows + j, rows - j);
    }
    return most;
}

/* y of R' y = b in the sense of least squares, R having more columns than rows: by the QR factors of R'. */
static void solve_transposed(const double *qr, int rows, int cols, int rank, const double *diagonal, const int *pivot,
                             const double *b, const double *weight, LagLeastSquares *s)
{
    for (int k = 0; k < rank; ++k)
        for (int i = 0; i < cols; ++i)
            s->a[i + k * cols] = weight[pivot[i]] * (i > k ? qr[i * rows + k] : i == k ? diagonal[k] : 0);
    for (int i = 0; i < cols; ++i)
        s->b[i] = weight[pivot[i]] * b[pivot[i]];
    lag_qr(s->a, cols, rank, s->diagonal, s->pivot, 0);
    for (int j = 0; j < rank; ++j) {
        const double *u = s->a + j * cols + j;
        reflect(u, dot(u, u, cols - j), s->b + j, cols - j);
    }
    for (int j = rank - 1; j >= 0; --j) {
        double rest = s->b[j];
        for (int k = j + 1; k < rank; ++k)
            rest -= s->a[k * cols + j] * s->y[s->pivot[k]];
        s->y[s->pivot[j]] = rest / s->diagonal[j];
    }
}

void lag_qr_nearest(const double *qr, int rows, int cols, int rank, const double *diagonal, const int *pivot, const double *b,
                    const double *weight, LagLeastSquares *scratch, double *x)
{
    for (int j = 0; j < rank; ++j) { /* Q' x: its last entries stay, */
        const double *u = qr + j * rows + j;
        reflect(u, dot(u, u, rows - j), x + j, rows - j);
    }
    if (rank < cols) { /* its first ones are told by R' y = b */
        solve_transposed(qr, rows, cols, rank, diagonal, pivot, b, weight, scratch);
        memcpy(x, scratch->y, (size_t)rank * sizeof *x);
    }
    for (int j = 0; rank == cols && j < rank; ++j)
        x[j] = (b[pivot[j]] - dot(qr + j * rows, x, j)) / diagonal[j];
    for (int j = rank - 1; j >= 0; --j) { /* x = Q y */
        const double *u = qr + j * rows + j;
        reflect(u, dot(u, u, rows - j), x + j, rows - j);
    }
}
