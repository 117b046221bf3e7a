/* Explicit Runge-Kutta pairs, each a table of coefficients: Dormand-Prince 8(5,3), for loose tolerances Tsitouras 5(4), and for tight
 * ones Verner 9(8), which has no dense output: its steps end at rows, and what is inside one is stepped to.
 * E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), II.5, II.6.
 *
 * State y = (q, v, e): e are energy quadratures, whose errors count where they are large (account.c). A stage's velocity is
 * written where the slope of its position belongs, so q' = v costs nothing. The slope at the end of a step is the first of
 * the next. Further slopes of the dense output are evaluated only when someone looks inside a step.
 */
#include "methods/explicit.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "methods/dop853_tableau.h"
#include "numbers/extremes.h"
#include "numbers/lanes.h"
#include "state/account.h"
#include "state/attitudes.h"
#include "steps/step.h"
#include "methods/tsit5_tableau.h"
#include "methods/verner9_tableau.h"

const LagTableau lag_dop853_tableau = {LAG_DOP853_STAGES, LAG_DOP853_ALL_STAGES, LAG_DOP853_DENSE_ROWS, lag_dop853_node,
                                        lag_dop853_stage, &lag_dop853_error5, &lag_dop853_error3, lag_dop853_dense, 0, 1};
const LagTableau lag_tsit5_tableau = {LAG_TSIT5_STAGES, LAG_TSIT5_STAGES + 1, LAG_TSIT5_DENSE_ROWS, lag_tsit5_node,
                                       lag_tsit5_stage, &lag_tsit5_error, NULL, lag_tsit5_dense, 1, 2};
const LagTableau lag_verner9_tableau = {LAG_VERNER9_STAGES, LAG_VERNER9_STAGES + 1, 0, lag_verner9_node,
                                   lag_verner9_stage, &lag_verner9_error, NULL, NULL, 0, 0.6};
enum { LONG = 16 }; /* coordinates from which on lanes pay, where numbers were written a moment ago */

static void layout(LagExplicit *s, const LagTableau *tableau, const LagMotion *m, LagArena *arena)
{
    s->tableau = tableau;
    for (int i = 0; i < tableau->all_stages; ++i)
        s->k[i] = lag_take(arena, (size_t)m->size);
    for (int i = 0; i < LAG_HERMITE_ROWS + tableau->dense_rows; ++i)
        s->dense[i] = lag_take(arena, (size_t)m->size);
    s->unit = lag_take(arena, 2 * (size_t)m->n);
}

static void layout_dop853(void *self, const LagMotion *m, LagArena *arena) { layout(self, &lag_dop853_tableau, m, arena); }

static void layout_tsit5(void *self, const LagMotion *m, LagArena *arena) { layout(self, &lag_tsit5_tableau, m, arena); }

static void layout_verner9(void *self, const LagMotion *m, LagArena *arena) { layout(self, &lag_verner9_tableau, m, arena); }

/* sum = weights of the row times slopes but the last one, for the first `size` components and what lies behind them in its lanes.
 * The last slope is the latest, written number by number a moment ago, and callers add it number by number: reading several at
 * once would wait until all of them are in the cache (a fifth of the time in scenes of one or two coordinates). */
LAG_UNROLLED void combine_earlier(const LagExplicit *s, const LagTableauRow *row, int size, double *sum)
{
    for (int i = 0; i < size; i += LAG_LANES) {
        LagLanes total = LAG_LANES_OF(0), k;
        LAG_UNROLL_ALL
        for (int j = 0; j < row->count - 1; ++j) {
            memcpy(&k, s->k[row->column[j]] + i, sizeof k);
            total += k * LAG_LANES_OF(row->weight[j]);
        }
        memcpy(sum + i, &total, sizeof total);
    }
}

LAG_UNROLLED void combine(const LagExplicit *s, const LagTableauRow *row, int size, double h, double *sum)
{
    const double w = row->weight[row->count - 1], *last = s->k[row->column[row->count - 1]];
    combine_earlier(s, row, size, sum);
    for (int i = 0; i < size; ++i)
        sum[i] = h * (sum[i] + w * last[i]);
}

/* to = y + h (sum + w last), as long as there are LAG_LANES. Returns how far it came. */
static int advance_many(const double *y, const double *sum, const double *last, double w, double h, int n, double *to)
{
    const LagLanes weight = LAG_LANES_OF(w), length = LAG_LANES_OF(h);
    int i = 0;
    for (; i + LAG_LANES <= n; i += LAG_LANES) {
        LagLanes base, earlier, latest;
        memcpy(&base, y + i, sizeof base);
        memcpy(&earlier, sum + i, sizeof earlier);
        memcpy(&latest, last + i, sizeof latest);
        base += length * (earlier + weight * latest);
        memcpy(to + i, &base, sizeof base);
    }
    return i;
}

/* Slope i of the step of length h from (t, y). */
LAG_UNROLLED int stage(LagExplicit *s, LagMotion *m, const LagTableau *tableau, int i, double t, const double *y, double h)
{
    const int n = m->n;
    const LagTableauRow *row = &tableau->stage[i];
    const double w = row->weight[row->count - 1], *last = s->k[row->column[row->count - 1]], *sum = m->sum;
    double *k = s->k[i], *point = m->point;
    int j = 0;
    combine_earlier(s, row, 2 * n, m->sum);
    if (n >= LONG) {
        advance_many(y, sum, last, w, h, n, point);
        j = advance_many(y + n, sum + n, last + n, w, h, n, k);
    }
    for (; j < n; ++j) {
        point[j] = y[j] + h * (sum[j] + w * last[j]);
        k[j] = y[n + j] + h * (sum[n + j] + w * last[n + j]);
    }
    return lag_motion_slope(m, t + tableau->node[i] * h, point, k, k);
}

/* Errors in units instead of errors, and 0 for what never moved. Returns how many components move. */
static int in_units(const LagMotion *m, const LagScale *scale, double *fine, double *coarse)
{
    int moving = 0;
    for (int i = 0; i < 2 * m->n; ++i) {
        const double unit = lag_scale_unit(scale, i, m->y, m->other), inverse = unit > 0 ? 1 / unit : 0;
        moving += unit > 0;
        fine[i] = unit > 0 ? fabs(fine[i] * inverse) : 0;
        if (coarse)
            coarse[i] = unit > 0 ? coarse[i] * inverse : 0;
    }
    return moving;
}

/* The same for a long state. */
static int many_in_units(const LagExplicit *s, const LagMotion *m, const LagScale *scale, double *fine, double *coarse)
{
    const LagLanes zero = LAG_LANES_OF(0), one = LAG_LANES_OF(1);
    int moving = 0;
    lag_scale_units(scale, m->y, m->other, s->unit);
    for (int i = 0; i < 2 * m->n; i += LAG_LANES) { /* the padding of units is 0 */
        LagLanes unit, inverse, error;
        memcpy(&unit, s->unit + i, sizeof unit);
        inverse = one / unit;
        memcpy(&error, fine + i, sizeof error);
        error *= inverse;
        error = LAG_LANES_SELECT(unit > zero, LAG_LANES_ABS(error), zero);
        memcpy(fine + i, &error, sizeof error);
        if (coarse) {
            memcpy(&error, coarse + i, sizeof error);
            error = LAG_LANES_SELECT(unit > zero, error * inverse, zero);
            memcpy(coarse + i, &error, sizeof error);
        }
    }
    for (int i = 0; i < 2 * m->n; ++i)
        moving += s->unit[i] > 0;
    return moving;
}

/* The error of a step, root mean square in units over positions and rates that move, and Hairer's combination where there are
 * two embedded errors; *worst: where it is largest. 0 when nothing moves. */
LAG_UNROLLED double estimate(const LagExplicit *s, LagMotion *m, const LagTableau *tableau, double h, const LagScale *scale,
                                int *worst)
{
    const int size = 2 * m->n;
    double *fine = m->sum, *coarse = tableau->coarse_error ? m->point : NULL;
    if (scale->is_resting)
        lag_scale_foresee(scale, m->other);
    combine(s, tableau->error, size, h, fine);
    if (coarse)
        combine(s, tableau->coarse_error, size, h, coarse);
    const int moving = m->n >= LONG ? many_in_units(s, m, scale, fine, coarse) : in_units(m, scale, fine, coarse);
    double fine_squares = 0, coarse_squares = 0, largest = 0;
    for (int i = 0; i < size; ++i) { /* one after another: the same digits with and without vectors */
        fine_squares += fine[i] * fine[i];
        coarse_squares += coarse ? coarse[i] * coarse[i] : 0;
        if (fine[i] > largest) {
            largest = fine[i];
            *worst = i;
        }
    }
    if (!(fine_squares > 0))
        return fine_squares;
    const double share = coarse ? sqrt(fine_squares / (fine_squares + 0.01 * coarse_squares)) : 1;
    return tableau->caution * share * sqrt(fine_squares / moving);
}

static double combine_one(const LagExplicit *s, const LagTableauRow *row, double h, int i)
{
    double sum = 0;
    for (int j = 0; j < row->count; ++j)
        sum += row->weight[j] * s->k[row->column[j]][i];
    return fabs(h * sum);
}

/* The error of one of the energy quadratures: Hairer's combination, as that of the state; but that of what holds the motion, whose forces
 * are known to fewer digits, is the larger one. */
static double quadrature_error(const LagExplicit *s, const LagMotion *m, const LagTableau *tableau, double h, int i)
{
    const double fine = combine_one(s, tableau->error, h, i);
    const double coarse = tableau->coarse_error && m->strength == 0 ? combine_one(s, tableau->coarse_error, h, i) : 0;
    return coarse > 0 && fine > 0 ? fine * fine / sqrt(fine * fine + 0.01 * coarse * coarse) : fine;
}

/* The largest of them, in units of the tolerance. */
static double energy_error(const LagExplicit *s, const LagMotion *m, const LagTableau *tableau, double h, const LagScale *scale)
{
    const double energy = lag_max(m->energy, h * h * m->strength);
    double largest = 0;
    for (int i = 2 * m->n; i < m->size; ++i)
        largest = lag_max(quadrature_error(s, m, tableau, h, i) / (scale->tolerance * lag_max(fabs(m->other[i]), energy)), largest);
    return largest;
}

static void restart(void *self, LagMotion *m)
{
    LagExplicit *s = self;
    memcpy(s->k[0], m->slope, (size_t)m->size * sizeof *m->slope);
    s->first_slope_is_last = 0;
}

/* Where the error estimate needs the slope at the end, it is that of the state before its projection. */
static int end_slope(LagExplicit *s, LagMotion *m, double t_new)
{
    return lag_motion_slope(m, t_new, m->other, m->other + m->n, s->k[s->tableau->stages]);
}

/* Copied for each method: stages and weights are in the code, not in tables, which saves a tenth of the time of small scenes. */
LAG_UNROLLED double attempt(LagExplicit *s, LagMotion *m, const LagTableau *tableau, double t_new, const LagScale *scale,
                               int *worst)
{
    const double h = t_new - m->t;
    m->t_old = m->t;
    if (s->first_slope_is_last)
        lag_swap(&s->k[0], &s->k[tableau->stages]);
    s->first_slope_is_last = 0;
    LAG_UNROLL_ALL
    for (int i = 1; i < tableau->stages; ++i)
        if (!stage(s, m, tableau, i, m->t, m->y, h)) {
            *worst = m->n + lag_first_not_finite(s->k[i] + m->n, m->n);
            return INFINITY;
        }
    combine(s, &tableau->stage[tableau->stages], m->size, h, m->sum);
    lag_motion_add(m, m->sum);
    if (tableau->error_at_end && !end_slope(s, m, t_new)) {
        *worst = m->n + lag_first_not_finite(s->k[tableau->stages] + m->n, m->n);
        return INFINITY;
    }
    double error = estimate(s, m, tableau, h, scale, worst);
    if (m->energy > 0) {
        const double work = energy_error(s, m, tableau, h, scale);
        error = lag_max(m->strength > 0 ? work : lag_account_count(m, h, work), error);
    }
    return error >= 0 ? error : INFINITY;
}

static double attempt_dop853(void *self, LagMotion *m, double t_new, const LagScale *scale, int *worst)
{
    return attempt(self, m, &lag_dop853_tableau, t_new, scale, worst);
}

static double attempt_tsit5(void *self, LagMotion *m, double t_new, const LagScale *scale, int *worst)
{
    return attempt(self, m, &lag_tsit5_tableau, t_new, scale, worst);
}

static double attempt_verner9(void *self, LagMotion *m, double t_new, const LagScale *scale, int *worst)
{
    return attempt(self, m, &lag_verner9_tableau, t_new, scale, worst);
}

/* Rates of the state, which may have been projected, as slopes of its positions at the end. */
static void take_rates(LagExplicit *s, const LagMotion *m)
{
    double *k = s->k[s->tableau->stages];
    memcpy(k, m->other + m->n, (size_t)m->n * sizeof *k);
    if (m->n_attitudes > 0)
        lag_attitudes_turn_slope(m, m->other, k);
}

static double *slope(void *self)
{
    LagExplicit *s = self;
    return s->k[s->first_slope_is_last ? s->tableau->stages : 0];
}

static int accept(void *self, LagMotion *m, double t_new)
{
    LagExplicit *s = self;
    if (s->tableau->error_at_end) /* the projection's correction of the accelerations is below their error */
        take_rates(s, m);
    else if (!end_slope(s, m, t_new))
        return 0;
    for (int i = 2 * m->n; i < m->size; ++i)
        m->doubt += quadrature_error(s, m, s->tableau, t_new - m->t, i);
    lag_motion_take(m, t_new);
    s->first_slope_is_last = 1;
    s->dense_ready = s->has_other_stages = 0;
    return 1;
}

static void take_back(LagRun *run)
{
    LagExplicit *s = run->methods.self;
    s->first_slope_is_last = s->dense_ready = 0;
    lag_motion_take_back(&run->motion);
    --run->statistics.steps;
    ++run->statistics.rejected;
}

static int rows_of(const LagExplicit *s) { return LAG_HERMITE_ROWS + s->tableau->dense_rows; }

/* Coefficients of the polynomial of the step from y_old to y_new, whose slopes are in s->k. */
static void prepare_dense(LagExplicit *s, LagMotion *m, double t_old, double h, const double *y_old, const double *y_new)
{
    const double *k_old = s->k[0], *k_new = s->k[s->tableau->stages];
    m->lacks_slopes = 0;
    for (int i = s->tableau->stages + 1; i < s->tableau->all_stages; ++i)
        m->lacks_slopes |= !stage(s, m, s->tableau, i, t_old, y_old, h);
    for (int i = 0; i < m->size; ++i) {
        const double step = y_new[i] - y_old[i];
        s->dense[0][i] = step;
        s->dense[1][i] = h * k_old[i] - step;
        s->dense[2][i] = 2 * step - h * (k_new[i] + k_old[i]);
    }
    for (int r = 0; r < s->tableau->dense_rows; ++r) {
        double *coefficient = s->dense[LAG_HERMITE_ROWS + r];
        combine(s, &s->tableau->dense[r], m->size, h, coefficient);
        if (m->lacks_slopes)
            memset(coefficient, 0, (size_t)m->size * sizeof *coefficient);
    }
    ++m->dense_outputs;
}

/* Horner's scheme in x and 1 - x alternately, of as many components as there are LAG_LANES. Returns how far it came. */
static int interpolate_many(const LagExplicit *s, const LagMotion *m, double x, double *y)
{
    const LagLanes factor[] = {LAG_LANES_OF(x), LAG_LANES_OF(1 - x)};
    int i = 0;
    for (; i + LAG_LANES <= m->size; i += LAG_LANES) {
        LagLanes sum = LAG_LANES_OF(0), term;
        for (int j = LAG_HERMITE_ROWS + s->tableau->dense_rows - 1; j >= 0; --j) {
            memcpy(&term, s->dense[j] + i, sizeof term);
            sum = (sum + term) * factor[j % 2];
        }
        memcpy(&term, m->other + i, sizeof term);
        sum = term + sum;
        memcpy(y + i, &sum, sizeof sum);
    }
    return i;
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagExplicit *s = self;
    if (!s->dense_ready)
        prepare_dense(s, m, m->t_old, m->t_end - m->t_old, m->other, m->y);
    s->dense_ready = 1;
    const double x = (t - m->t_old) / (m->t_end - m->t_old), factor[] = {x, 1 - x};
    for (int i = interpolate_many(s, m, x, y); i < m->size; ++i) {
        double sum = 0;
        for (int j = LAG_HERMITE_ROWS + s->tableau->dense_rows - 1; j >= 0; --j)
            sum = (sum + s->dense[j][i]) * factor[j % 2];
        y[i] = m->other[i] + sum;
    }
}

/* By a step to there from where the latest step began. */
static void interpolate_verner9(void *self, LagMotion *m, double t, double *y)
{
    LagExplicit *s = self;
    const double h = t - m->t_old;
    if (h == 0) {
        memcpy(y, m->other, (size_t)m->size * sizeof *y);
        return;
    }
    for (int i = 1; i < lag_verner9_tableau.stages; ++i)
        stage(s, m, &lag_verner9_tableau, i, m->t_old, m->other, h);
    s->has_other_stages = 1;
    combine(s, &lag_verner9_tableau.stage[lag_verner9_tableau.stages], m->size, h, m->sum);
    for (int i = 0; i < m->size; ++i)
        y[i] = m->other[i] + m->sum[i];
    ++m->dense_outputs;
}

/* By cubics of the step's ends. An error of 16 x^2 (1 - x)^2 e has slopes up to 3.1 e: from those of the stages follows by how much more
 * than e it may be, also where all is at rest at both ends. */
static int glimpse(const void *self, const LagMotion *m, double x, double *y, double *error)
{
    const LagExplicit *s = self;
    const double h = m->t_end - m->t_old, *node = s->tableau->node, *k_old = s->k[0], *k_new = s->k[s->tableau->stages];
    for (int i = 0; i < 2 * m->n; ++i) {
        const double way = m->y[i] - m->other[i], bend = h * k_old[i] - way, twist = 2 * way - h * (k_new[i] + k_old[i]);
        double most = 0;
        y[i] = m->other[i] + x * (way + (1 - x) * (bend + x * twist));
        for (int j = 1; error && j < s->tableau->stages; ++j) {
            const double at = node[j], slope = way + (1 - 2 * at) * bend + at * (2 - 3 * at) * twist;
            most = fmax(fabs(h * s->k[j][i] - slope), most);
        }
        if (error)
            error[i] = most / 2;
    }
    return !s->has_other_stages;
}

/* -------- steps that are kept */

/* The head of a record tells whether it holds coefficients behind the state at its beginning, or the state at its end and slopes. */

static void keep(const void *self, const LagMotion *m, double *place)
{
    const LagExplicit *s = self;
    const size_t states = 2 * (size_t)m->n;
    double *const row = place + LAG_RECORD_HEAD;
    place[0] = 0;
    memcpy(row, m->other, states * sizeof *row);
    memcpy(row + states, m->y, states * sizeof *row);
    for (int j = 0; j <= s->tableau->stages; ++j)
        memcpy(row + (size_t)(j + 2) * states, s->k[j], states * sizeof *row);
}

/* Slopes become coefficients when somebody looks. */
static void prepare_record(LagExplicit *s, LagMotion *m, double *place, double begin, double length)
{
    const size_t states = 2 * (size_t)m->n;
    double *const row = place + LAG_RECORD_HEAD;
    for (int j = 0; j <= s->tableau->stages; ++j)
        memcpy(s->k[j], row + (size_t)(j + 2) * states, states * sizeof *row);
    prepare_dense(s, m, begin, length, row, row + states);
    for (int j = 0; j < rows_of(s); ++j)
        memcpy(row + (size_t)(j + 1) * states, s->dense[j], states * sizeof *row);
    place[0] = 1;
    s->dense_ready = 0;
}

static void recall(void *self, LagMotion *m, double *place, double begin, double length, double t, double *y)
{
    LagExplicit *s = self;
    const double x = (t - begin) / length, factor[] = {x, 1 - x}, *row = place + LAG_RECORD_HEAD;
    const size_t states = 2 * (size_t)m->n;
    if (place[0] == 0)
        prepare_record(s, m, place, begin, length);
    for (size_t i = 0; i < states; ++i) {
        double sum = 0;
        for (int j = rows_of(s); j > 0; --j)
            sum = (sum + row[(size_t)j * states + i]) * factor[(j - 1) % 2];
        y[i] = row[i] + sum;
    }
}

static const LagRecord RECORD = {keep, recall};

const LagMethod lag_dop853 = {
    .name = "erk", .order = 8, .layout = layout_dop853, .restart = restart, .step = lag_step_adaptive, .attempt = attempt_dop853,
    .accept = accept, .slope = slope, .interpolate = interpolate, .glimpse = glimpse, .take_back = take_back, .is_good_inside = 1,
    .holds_switches = 1, .most_sliding = INT_MAX, .stride = 1, .record = &RECORD,
};
const LagMethod lag_verner9 = {
    .name = "erk9", .order = 9, .layout = layout_verner9, .restart = restart, .step = lag_step_adaptive,
    .attempt = attempt_verner9, .accept = accept, .slope = slope, .interpolate = interpolate_verner9, .glimpse = glimpse,
    .holds_switches = 1, .most_sliding = INT_MAX, .stride = 1, .ends_at_rows = 1, .dreads_rows = 1,
};
const LagMethod lag_tsit5 = {
    .name = "erk5", .order = 5, .layout = layout_tsit5, .restart = restart, .step = lag_step_adaptive, .attempt = attempt_tsit5,
    .accept = accept, .slope = slope, .interpolate = interpolate, .take_back = take_back, .is_good_inside = 1, .holds_switches = 1,
    .most_sliding = INT_MAX, .stride = 1, .record = &RECORD,
};
