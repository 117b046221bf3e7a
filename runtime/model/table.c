/* A knot is found by a guess of proportion and steps from there that double, then by halving: at once where knots lie evenly, in
 * O(log n) wherever they lie. Nothing is kept from one call to the next.
 */
#include "model/table.h"

#include <math.h>

static double knot(const LagTable *table, int k) { return table->x ? table->x[k] : table->start + k * table->pitch; }

/* The last piece that begins at or before x, from 0 to n - 2. */
static int find(const LagTable *table, double x)
{
    const int last = table->n - 2;
    const double first = knot(table, 0), span = knot(table, last + 1) - first, guess = floor((x - first) / span * (last + 1));
    int low = guess > 0 ? guess < last ? (int)guess : last : 0, high = low, step = 1;
    while (low > 0 && knot(table, low) > x) {
        high = low;
        low = low > step ? low - step : 0;
        step *= 2;
    }
    for (step = 1; high < last && knot(table, high + 1) <= x; step *= 2) {
        low = high + 1;
        high = high < last - step ? high + step : last;
    }
    while (low < high) {
        const int middle = low + (high - low + 1) / 2;
        if (knot(table, middle) <= x)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

static double period(const LagTable *table) { return knot(table, table->n - 1) - knot(table, 0); }

/* So many whole periods lie before x. */
static double turns(const LagTable *table, double x)
{
    return table->beyond == LAG_BEYOND_PERIODIC ? floor((x - knot(table, 0)) / period(table)) : 0;
}

double lag_table_next(const LagTable *table, double x, int direction, double near)
{
    const int last = table->n - 1;
    const double moved = turns(table, x) * period(table), here = x - moved;
    if (table->beyond != LAG_BEYOND_PERIODIC && (direction > 0 ? here + near < knot(table, 0) : here - near > knot(table, last)))
        return knot(table, direction > 0 ? 0 : last);
    int k = find(table, here);
    if (direction > 0)
        while (k <= last && knot(table, k) <= here + near)
            ++k;
    else
        for (k += 2; k >= 0 && (k > last || knot(table, k) >= here - near);)
            --k;
    if (k >= 0 && k <= last)
        return knot(table, k) + moved;
    if (table->beyond != LAG_BEYOND_PERIODIC)
        return direction > 0 ? INFINITY : -INFINITY;
    return moved + direction * period(table) + knot(table, direction > 0 ? 1 : last - 1);
}

static void cubic(const LagTable *table, int k, double *c)
{
    const double h = knot(table, k + 1) - knot(table, k), rise = (table->y[k + 1] - table->y[k]) / h;
    const double a = table->slopes[k], b = table->slopes[k + 1];
    c[0] = table->y[k];
    c[1] = a;
    c[2] = (3 * rise - 2 * a - b) / h;
    c[3] = (a + b - 2 * rise) / (h * h);
}

/* The slope at an end, of the piece beside it. */
static double end_slope(const LagTable *table, int is_last)
{
    if (table->degree == 3)
        return table->slopes[is_last ? table->n - 1 : 0];
    const int k = is_last ? table->n - 2 : 0;
    return (table->y[k + 1] - table->y[k]) / (knot(table, k + 1) - knot(table, k));
}

int lag_table_piece(const LagTable *table, double x, double *piece)
{
    const int last = table->n - 1;
    const double moved = turns(table, x) * period(table), here = x - moved;
    double *c = piece + 1;
    const int is_before = here < knot(table, 0), is_outside = is_before || here >= knot(table, last);
    for (int i = 0; i <= table->degree; ++i)
        c[i] = 0;
    if (is_outside && table->beyond != LAG_BEYOND_PERIODIC) {
        const int end = is_before ? 0 : last;
        piece[0] = knot(table, end);
        c[0] = table->y[end];
        if (table->beyond == LAG_BEYOND_LINEAR && table->degree > 0)
            c[1] = end_slope(table, !is_before);
        return table->beyond != LAG_BEYOND_ERROR;
    }
    const int k = find(table, here);
    piece[0] = knot(table, k) + moved;
    c[0] = table->y[k];
    if (table->degree == 1)
        c[1] = (table->y[k + 1] - table->y[k]) / (knot(table, k + 1) - knot(table, k));
    if (table->degree == 3)
        cubic(table, k, c);
    return 1;
}

int lag_tables_read(const LagModel *model, const double *a, const double *b, double t, double *d)
{
    int silent = -1;
    for (int i = 0; i < model->n_lookups; ++i) {
        const int event = model->lookups[2 * i], number = model->event_kind[event] - LAG_EVENT_TABLE;
        if (!lag_table_piece(model->tables + number, a[event] + b[event] * t, d + model->lookups[2 * i + 1]))
            silent = number;
    }
    return silent;
}

/* ---------------------------------------------------------------- slopes */

static double width(const LagTable *table, int k) { return knot(table, k + 1) - knot(table, k); }

static double rise(const LagTable *table, int k) { return (table->y[k + 1] - table->y[k]) / width(table, k); }

/* Rows a s[k-1] + b s[k] + c s[k+1] = r of the slopes, in place: r becomes s. Diagonally dominant but for the first and the last
 * row, which are those of the ends. `u`, where it is there, is another r. */
static void solve(int n, const double *a, double *b, const double *c, double *r, double *u)
{
    for (int k = 1; k < n; ++k) {
        const double factor = a[k] / b[k - 1];
        b[k] -= factor * c[k - 1];
        r[k] -= factor * r[k - 1];
        if (u)
            u[k] -= factor * u[k - 1];
    }
    for (int k = n - 1; k >= 0; --k) {
        r[k] = (r[k] - (k < n - 1 ? c[k] * r[k + 1] : 0)) / b[k];
        if (u)
            u[k] = (u[k] - (k < n - 1 ? c[k] * u[k + 1] : 0)) / b[k];
    }
}

/* The second derivative goes on at inner knots. */
static void inner_rows(const LagTable *table, double *a, double *b, double *c, double *r)
{
    for (int k = 1; k < table->n - 1; ++k) {
        const double left = width(table, k - 1), right = width(table, k);
        a[k] = right;
        b[k] = 2 * (left + right);
        c[k] = left;
        r[k] = 3 * (right * rise(table, k - 1) + left * rise(table, k));
    }
}

/* At the ends the third derivative goes on at the second knot and the last but one; of three knots it is a parabola. */
static void end_rows(const LagTable *table, double *a, double *b, double *c, double *r)
{
    const int last = table->n - 1;
    if (last < 3) {
        b[0] = c[0] = a[last] = b[last] = 1;
        r[0] = 2 * rise(table, 0);
        r[last] = 2 * rise(table, last - 1);
        return;
    }
    const double h = width(table, 0), h1 = width(table, 1), g = width(table, last - 1), g1 = width(table, last - 2);
    b[0] = h1;
    c[0] = h + h1;
    r[0] = ((h + 2 * c[0]) * h1 * rise(table, 0) + h * h * rise(table, 1)) / c[0];
    b[last] = g1;
    a[last] = g + g1;
    r[last] = ((g + 2 * a[last]) * g1 * rise(table, last - 1) + g * g * rise(table, last - 2)) / a[last];
}

/* Two unknowns of a ring are each other's neighbours on both sides. */
static void solve_two(const double *a, const double *b, const double *c, double *s)
{
    const double p = a[0] + c[0], q = a[1] + c[1], det = b[0] * b[1] - p * q, r = s[0];
    s[0] = (b[1] * r - p * s[1]) / det;
    s[1] = (b[0] * s[1] - q * r) / det;
}

/* Slopes of the spline that comes again: the last knot is the first one. The rows are those of a ring, which is cut by a correction
 * of rank one (J. Sherman, W. Morrison, 1950). */
static void solve_ring(const LagTable *table, double *s, double *work)
{
    const int n = table->n - 1; /* unknowns */
    double *a = work, *b = work + n, *c = work + 2 * n, *u = work + 3 * n;
    inner_rows(table, a, b, c, s);
    const double left = width(table, n - 1), right = width(table, 0);
    a[0] = right;
    b[0] = 2 * (left + right);
    c[0] = left;
    s[0] = 3 * (right * rise(table, n - 1) + left * rise(table, 0));
    if (n == 2) {
        solve_two(a, b, c, s);
    } else {
        const double corner = a[0], end = c[n - 1], gamma = -b[0];
        for (int k = 0; k < n; ++k)
            u[k] = k == 0 ? gamma : k == n - 1 ? end : 0;
        b[0] -= gamma;
        b[n - 1] -= corner * end / gamma;
        solve(n, a, b, c, s, u);
        const double factor = (s[0] + corner * s[n - 1] / gamma) / (1 + u[0] + corner * u[n - 1] / gamma);
        for (int k = 0; k < n; ++k)
            s[k] -= factor * u[k];
    }
    s[n] = s[0];
}

static double between(double h, double d, double h1, double d1)
{
    return d * d1 > 0 ? 3 * (h + h1) / ((2 * h1 + h) / d + (h1 + 2 * h) / d1) : 0;
}

/* Of the three points at an end, unless it would overshoot (C. Moler, Numerical Computing with MATLAB, 3.6). */
static double at_end(double h, double d, double h1, double d1)
{
    const double s = ((2 * h + h1) * d - h * d1) / (h + h1);
    return s * d <= 0 ? 0 : d * d1 <= 0 && fabs(s) > 3 * fabs(d) ? 3 * d : s;
}

static void monotone(const LagTable *table, double *s)
{
    const int last = table->n - 1;
    for (int k = 1; k < last; ++k)
        s[k] = between(width(table, k - 1), rise(table, k - 1), width(table, k), rise(table, k));
    if (table->beyond == LAG_BEYOND_PERIODIC) {
        s[0] = s[last] = between(width(table, last - 1), rise(table, last - 1), width(table, 0), rise(table, 0));
    } else {
        s[0] = at_end(width(table, 0), rise(table, 0), width(table, 1), rise(table, 1));
        s[last] = at_end(width(table, last - 1), rise(table, last - 1), width(table, last - 2), rise(table, last - 2));
    }
}

void lag_table_slopes(const LagTable *table, int smoothness, double *slopes, double *work)
{
    const int n = table->n;
    if (n == 2) {
        slopes[0] = slopes[1] = rise(table, 0);
    } else if (smoothness == LAG_SMOOTH_MONOTONE) {
        monotone(table, slopes);
    } else if (table->beyond == LAG_BEYOND_PERIODIC) {
        solve_ring(table, slopes, work);
    } else {
        inner_rows(table, work, work + n, work + 2 * n, slopes);
        end_rows(table, work, work + n, work + 2 * n, slopes);
        solve(n, work, work + n, work + 2 * n, slopes, NULL);
    }
}
