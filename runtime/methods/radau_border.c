/* Shares s keep dg/dt = 0 (sliding.c), and accelerations are a = f + W s with the ways W = da/ds. So the system of a step,
 *
 *     mu x - a' = r,   a' = J_v x + J_q x/mu - W c,   g_a a' + g_v x + g_q x/mu = 0,
 *
 * where ' is change and g_a, g_v, g_q are derivatives of dg/dt, has a border: with X0 and Y, which the matrix without it makes of r and
 * W, x = X0 - Y c and (mu g_a + g_v + g_q/mu) (X0 - Y c) = g_a r.
 */
#include "methods/radau_border.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "state/state.h"

static const double DIFFERENCE = 1e-6; /* of what counts as the size of a component */

void lag_border_layout(LagBorder *b, const LagMotion *motion, int pairs, LagArena *arena)
{
    const int possible = lag_sliding_most(((const LagRun *)motion->context)->model);
    b->n = motion->n;
    b->most = possible < LAG_MOST_BORDER ? possible : LAG_MOST_BORDER;
    const size_t most = (size_t)b->most, all = most * (size_t)b->n, size = most > 0 ? (size_t)motion->size : 0;
    double **const vectors[] = {&b->way, &b->by_place, &b->by_rate, &b->by_acceleration};
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
        *vectors[i] = lag_take(arena, all);
    b->probe = lag_take(arena, size);
    b->slope = lag_take(arena, size);
    b->slope_without = lag_take(arena, size);
    for (int i = 0; i < 1 + pairs; ++i) {
        b->factor[i].solved.re = lag_take(arena, all);
        b->factor[i].solved.im = i > 0 ? lag_take(arena, all) : NULL;
        lag_dense_lu_layout(&b->factor[i].lu, b->most, i > 0, arena);
    }
    b->change.re = lag_take(arena, most);
    b->change.im = lag_take(arena, most);
}

/* -------- derivatives */

/* Accelerations are linear in shares. */
static void find_ways(LagBorder *b, LagRun *run, double t, const double *y)
{
    const LagSliding *s = &run->sliding;
    const int n = b->n;
    run->sliding.count = 0; /* accelerations as the shares say */
    lag_motion_slope(&run->motion, t, y, y + n, b->slope_without);
    for (int k = 0; k < b->count; ++k) {
        double *share = lag_share(run, s->which[k]), *way = b->way + k * n;
        const double here = *share, change = lag_share_step(run, k);
        *share = here + change;
        lag_motion_slope(&run->motion, t, y, y + n, b->slope);
        *share = here;
        for (int i = 0; i < n; ++i)
            way[i] = (b->slope[n + i] - b->slope_without[n + i]) / change;
    }
    run->sliding.count = b->count;
}

/* Into entry i of each row: how much dg/dt at the state b->probe with accelerations a differs from that of the latest one, by
 * `change`. */
static void difference(LagBorder *b, LagRun *run, double t, const double *a, double change, int i, double *rows)
{
    LagSwitches *switches = &run->switches;
    lag_conditions_by(run, t, b->probe, b->probe + b->n, a, switches->g_inside, run->sliding.rate);
    for (int k = 0; k < b->count; ++k) {
        const int which = run->sliding.which[k];
        rows[i + k * b->n] = (run->sliding.rate[which] - switches->rate_inside[which]) / change;
    }
}

static double change_of(double value, double size, double share)
{
    const double whole = lag_max(fabs(value), size);
    return share * (whole > 0 ? whole : 1);
}

int lag_border_find(LagBorder *b, LagRun *run, double t, const double *y)
{
    LagSwitches *switches = &run->switches;
    const int n = b->n;
    double *a = b->slope_without + n;
    b->count = run->sliding.count;
    if (b->count == 0)
        return 1;
    find_ways(b, run, t, y);
    memcpy(b->probe, y, 2 * (size_t)n * sizeof *y);
    lag_conditions_by(run, t, b->probe, b->probe + n, a, switches->g_inside, switches->rate_inside);
    const double largest = lag_largest(a, (size_t)n);
    for (int i = 0; i < n; ++i) {
        const double before = a[i], change = change_of(before, largest, 1);
        a[i] = before + change;
        difference(b, run, t, a, change, i, b->by_acceleration);
        a[i] = before;
    }
    for (int i = 0; i < 2 * n; ++i) {
        const double change = change_of(y[i], run->scale.floor[i], DIFFERENCE);
        b->probe[i] = y[i] + change;
        difference(b, run, t, a, change, i < n ? i : i - n, i < n ? b->by_place : b->by_rate);
        b->probe[i] = y[i];
    }
    return lag_all_finite(b->way, b->count * n) && lag_all_finite(b->by_place, b->count * n)
        && lag_all_finite(b->by_rate, b->count * n) && lag_all_finite(b->by_acceleration, b->count * n);
}

/* -------- systems */

/* Row k of the border times x: into entry k of `change`. */
static void multiply(LagBorder *b, int which, int k, const double *x_re, const double *x_im, double *re, double *im)
{
    const double mu_re = b->factor[which].mu_re, mu_im = b->factor[which].mu_im, square = mu_re * mu_re + mu_im * mu_im;
    *re = *im = 0;
    for (int i = 0; i < b->n; ++i) {
        const int at = i + k * b->n;
        const double row_re = mu_re * b->by_acceleration[at] + b->by_rate[at] + mu_re / square * b->by_place[at];
        const double row_im = mu_im * b->by_acceleration[at] - mu_im / square * b->by_place[at];
        *re += row_re * x_re[i] - (x_im ? row_im * x_im[i] : 0);
        *im += row_im * x_re[i] + (x_im ? row_re * x_im[i] : 0);
    }
}

void lag_border_factor(LagBorder *b, LagImplicitMatrix *matrix, int which, double mu_re, double mu_im)
{
    const LagNumbers solved = b->factor[which].solved;
    LagDenseLu *lu = &b->factor[which].lu;
    b->factor[which].mu_re = mu_re;
    b->factor[which].mu_im = mu_im;
    lu->size = b->count;
    for (int j = 0; j < b->count; ++j) {
        double *y_re = solved.re + j * b->n, *y_im = which > 0 ? solved.im + j * b->n : NULL, im;
        lag_implicit_matrix_solve(matrix, which, b->way + j * b->n, NULL, NULL, y_re, y_im);
        for (int k = 0; k < b->count; ++k)
            multiply(b, which, k, y_re, y_im, &lu->re[k + j * b->count], which > 0 ? &lu->im[k + j * b->count] : &im);
    }
    lag_dense_lu_factor(lu);
}

static double product(const double *x, const double *y, int n)
{
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += x[i] * y[i];
    return sum;
}

void lag_border_solve(LagBorder *b, LagImplicitMatrix *matrix, int which, const double *re, const double *im, const double *s,
                      double *x_re, double *x_im)
{
    const LagNumbers c = b->change, solved = b->factor[which].solved;
    const int n = b->n;
    for (int k = 0; k < b->count; ++k) {
        c.re[k] = product(b->by_acceleration + k * n, re, n) - (s ? product(b->by_place + k * n, s, n) : 0);
        c.im[k] = im ? product(b->by_acceleration + k * n, im, n) : 0;
    }
    lag_implicit_matrix_solve(matrix, which, re, im, s, x_re, x_im);
    for (int k = 0; k < b->count; ++k) {
        double made_re, made_im;
        multiply(b, which, k, x_re, x_im, &made_re, &made_im);
        c.re[k] = made_re - c.re[k];
        c.im[k] = made_im - c.im[k];
    }
    lag_dense_lu_solve(&b->factor[which].lu, c.re, which > 0 ? c.im : NULL);
    for (int k = 0; k < b->count; ++k)
        for (int i = 0; i < n; ++i) {
            const double y_re = solved.re[i + k * n], y_im = which > 0 ? solved.im[i + k * n] : 0;
            x_re[i] -= y_re * c.re[k] - (which > 0 ? y_im * c.im[k] : 0);
            if (x_im)
                x_im[i] -= y_re * c.im[k] + y_im * c.re[k];
        }
}
