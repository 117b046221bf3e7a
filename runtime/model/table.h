/* Tables of one variable: polynomials between knots, which are exact in time: each piece is a segment of a run of its own. */
#ifndef LAG_TABLE_H
#define LAG_TABLE_H

#include "model/model.h"

/* What a table says beyond its ends: nothing is LAG_BEYOND_ERROR. */
enum { LAG_BEYOND_HOLD, LAG_BEYOND_LINEAR, LAG_BEYOND_PERIODIC, LAG_BEYOND_ERROR };

/* Where the slopes at the knots come from: of the spline with two continuous derivatives ("not-a-knot" at its ends; periodic where
 * the table is), or of its neighbours so that nothing overshoots (F.N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5, 1984). */
enum { LAG_SMOOTH_CUBIC, LAG_SMOOTH_MONOTONE };

struct LagTable {
    int n;                /* knots, 2 or more */
    int degree;           /* of the pieces: 0, 1 or 3 */
    int beyond;           /* LAG_BEYOND_... */
    double start, pitch;  /* knots are start + k pitch where x is not given */
    const double *x;      /* n, rising */
    const double *y;      /* n */
    const double *slopes; /* n: dy/dx at the knots, of degree 3 */
};

/* The first knot beyond x in the direction 1 or -1, or infinity that way. What is not farther than `near` counts as passed. */
double lag_table_next(const LagTable *table, double x, int direction, double near);

/* The place x0 and the coefficients of the polynomial in x - x0 that holds at x: 1 + degree of them, the constant first. Returns 0
 * where the table says nothing, and its end for it. */
int lag_table_piece(const LagTable *table, double x, double *piece);

/* Modes of all tables in time, at a time that is no knot; -1, or the number of the table that says nothing there. */
int lag_tables_read(const LagModel *model, const double *a, const double *b, double t, double *d);

/* Slopes at n knots, into `slopes`: LAG_SMOOTH_...; `work` has 4 n. Knots as in LagTable. */
LAG_API void lag_table_slopes(const LagTable *table, int smoothness, double *slopes, double *work);

#endif
