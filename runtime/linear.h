/* Small dense linear algebra. */
#ifndef LAG_LINEAR_H
#define LAG_LINEAR_H

/* A = Q R P', A rows x cols, column-major, overwritten; diagonal[cols] is that of R, pivot[cols] the order of columns.
 * Returns the rank: columns that are shorter than `tolerance` times the first pivot count as dependent. */
int lag_qr(double *a, int rows, int cols, double *diagonal, int *pivot, double tolerance);

/* The shortest x[rows] with A' x = b for the `rank` independent columns of A; qr as left by lag_qr. */
void lag_qr_shortest(const double *qr, int rows, int rank, const double *diagonal, const int *pivot, const double *b,
                     double *x);

#endif
