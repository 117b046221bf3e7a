/* Small dense linear algebra. */
#ifndef LAG_QR_H
#define LAG_QR_H

/* A = Q R P', A rows x cols, column-major, overwritten; diagonal[cols] is that of R, pivot[cols] the order of columns.
 * Returns the rank: columns that are shorter than `tolerance` times the first pivot count as dependent. */
int lag_qr(double *a, int rows, int cols, double *diagonal, int *pivot, double tolerance);

/* Scratch for dependent columns: a[cols * cols], the others [cols]. */
typedef struct {
    double *a, *b, *y, *diagonal;
    int *pivot;
} LagLeastSquares;

/* Moves x[rows] to the nearest place with A' x = b, in the sense of weighted least squares where columns of A are dependent;
 * qr as left by lag_qr. */
void lag_qr_nearest(const double *qr, int rows, int cols, int rank, const double *diagonal, const int *pivot, const double *b,
                    const double *weight, LagLeastSquares *scratch, double *x);

#endif
