/* Adams' methods, of variable order and step: the polynomial through the latest slopes is integrated, once for rates and twice for
 * positions. One evaluation, at the predicted state: the slope found there corrects the step, and is the next to predict from.
 * Dense output is the polynomial itself. L.F. Shampine, M.K. Gordon, Computer Solution of Ordinary Differential Equations (1975),
 * whose differences these are; F.T. Krogh, Changing Stepsize in the Integration of Differential Equations Using Modified Divided
 * Differences (1974), for the second integral.
 *
 * Half as many evaluations to an error as Runge-Kutta methods take, and more work beside each: for long equations. What begins
 * anew after events takes a dozen steps to come to its order.
 */
#include "methods/adams.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "numbers/lanes.h"
#include "numbers/rough_power.h"
#include "steps/step.h"
#include "steps/turns.h"

/* Chosen, like those of scale.c, for fewest evaluations to a given error, on chains, linkages and rows of springs. CAUTION multiplies
 * the error, so that a tolerance means about the same error by each method. Another order must be LOYAL times better. */
static const double CAUTION = 15, SAFETY = 0.75, GROW = 2, LOYAL = 0.95, TINY = 1e-60;
enum { GLANCE = 16 }; /* attempts from one look at what limits the steps to the next */
enum { PART = 4, PARTS = PART / LAG_LANES }; /* every fourth number has a sum, however many lanes there are: the same digits */

static size_t width_of(const LagMotion *m) { return (size_t)(m->size - m->n); }

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    LagAdams *s = self;
    const size_t width = width_of(m) + LAG_LANES, size = (size_t)m->size + LAG_LANES; /* the last lanes reach beyond */
    for (int i = 0; i < LAG_ADAMS_ROWS; ++i)
        s->difference[i] = lag_take(arena, width);
    s->slope = lag_take(arena, size);
    s->rates = lag_take(arena, width);
    s->places = lag_take(arena, width);
    s->missed = lag_take(arena, width);
    s->step = lag_take(arena, size);
    s->unit = lag_take(arena, size);
    s->end = lag_take(arena, size);
}

static void restart(void *self, LagMotion *m)
{
    LagAdams *s = self;
    memcpy(s->difference[0], m->slope + m->n, width_of(m) * sizeof(double));
    s->order = s->known = s->is_starting = 1;
    s->attempts = 0;
}

/* -------- the polynomial */

/* Of its terms over the step, by its length: of one after the other, and of their integrals. */
typedef struct {
    double once[LAG_ADAMS_ROWS], twice[LAG_ADAMS_ROWS];
} Integrals;

/* `share` of each slope's reach is the step. Written out: numbers stay where they are computed. */
LAG_UNROLLED void integrate_terms(const double *share, int count, Integrals *g)
{
    double w[LAG_ADAMS_ROWS + 1];
    LAG_UNROLL_ALL
    for (int i = 0; i <= count; ++i)
        w[i] = 1.0 / (i + 1);
    LAG_UNROLL_ALL
    for (int i = 0; i < count; ++i) {
        g->once[i] = w[0];
        g->twice[i] = w[1];
        LAG_UNROLL_ALL
        for (int j = 0; j < count - i; ++j)
            w[j] -= share[i] * w[j + 1];
    }
}

/* At least `count` terms. */
static void integrate(const double *share, int count, Integrals *g)
{
    switch ((count + 1) / 2) {
    case 1: integrate_terms(share, 2, g); break;
    case 2: integrate_terms(share, 4, g); break;
    case 3: integrate_terms(share, 6, g); break;
    case 4: integrate_terms(share, 8, g); break;
    case 5: integrate_terms(share, 10, g); break;
    case 6: integrate_terms(share, 12, g); break;
    default: integrate_terms(share, LAG_ADAMS_ROWS, g);
    }
}

/* The polynomial over a step of length h. */
static void extend(LagAdams *s, double h, Integrals *g)
{
    double share[LAG_ADAMS_ROWS] = {1};
    s->new_reach[0] = h;
    s->stretch[0] = 1;
    for (int i = 1; i < s->known; ++i) {
        s->new_reach[i] = h + s->reach[i - 1];
        s->stretch[i] = s->stretch[i - 1] * (s->new_reach[i - 1] / s->reach[i - 1]);
        share[i] = h / s->new_reach[i];
    }
    integrate(share, s->order + 1 + (s->known > s->order), g);
}

/* The slope that the polynomial foretells at the end of the step, and what it adds to rates and positions. */
static void predict(LagAdams *s, const LagMotion *m, double h, const Integrals *g)
{
    const int width = (int)width_of(m), order = s->order;
    double by_rate[LAG_ADAMS_ROWS], by_place[LAG_ADAMS_ROWS];
    for (int j = 0; j < order; ++j) {
        by_rate[j] = h * g->once[j] * s->stretch[j];
        by_place[j] = h * h * g->twice[j] * s->stretch[j];
    }
    for (int i = 0; i < width; i += LAG_LANES) {
        LagLanes rate = LAG_LANES_OF(0), place = LAG_LANES_OF(0), slope = LAG_LANES_OF(0), difference;
        for (int j = order - 1; j >= 0; --j) {
            memcpy(&difference, s->difference[j] + i, sizeof difference);
            rate += LAG_LANES_OF(by_rate[j]) * difference;
            place += LAG_LANES_OF(by_place[j]) * difference;
            slope += LAG_LANES_OF(s->stretch[j]) * difference;
        }
        memcpy(s->rates + i, &rate, sizeof rate);
        memcpy(s->places + i, &place, sizeof place);
        memcpy(s->missed + i, &slope, sizeof slope);
    }
    for (int i = 0; i < m->n; ++i) {
        s->places[i] += h * m->y[m->n + i];
        m->point[i] = m->y[i] + s->places[i];
        s->slope[i] = m->y[m->n + i] + s->rates[i];
    }
}

/* The step, with one term more: what the prediction has missed. */
static void correct(LagAdams *s, LagMotion *m, double h, const Integrals *g)
{
    const int n = m->n, width = (int)width_of(m);
    const double once = h * g->once[s->order], twice = h * h * g->twice[s->order], *found = s->slope + n;
    for (int i = 0; i < width; ++i) {
        s->missed[i] = found[i] - s->missed[i];
        s->step[n + i] = s->rates[i] + once * s->missed[i];
    }
    for (int i = 0; i < n; ++i)
        s->step[i] = s->places[i] + twice * s->missed[i];
    lag_motion_add(m, s->step);
}

/* -------- errors */

/* What is missed by this order, by one less and by one more: squares in units, summed over positions and over rates. */
enum { THIS, LESS, MORE, ORDERS };
typedef struct {
    double place[ORDERS], rate[ORDERS];
    double power[ORDERS]; /* the largest of the energy quadratures */
    double moving;        /* positions and rates that have units */
} Misses;

static double total(const LagLanes *parts)
{
    double each[PART];
    memcpy(each, parts, sizeof each);
    return (each[0] + each[1]) + (each[2] + each[3]);
}

/* 1 / unit; 0 where there is none. */
LAG_UNROLLED void invert(LagLanes *unit)
{
    *unit = LAG_LANES_SELECT(*unit > LAG_LANES_OF(0), LAG_LANES_OF(1) / *unit, LAG_LANES_OF(0));
}

static int largest_of(const double *misses, const double *unit, int n)
{
    int worst = 0;
    double largest = 0;
    for (int i = 0; i < n; ++i)
        if (fabs(misses[i]) > largest * unit[i]) {
            largest = fabs(misses[i]) / unit[i];
            worst = i;
        }
    return worst;
}

/* In the last lanes of positions there may be rates. */
static const double IS_PLACE[2 * PART] = {1, 1, 1, 1};

static void measure(const LagAdams *s, int n, Misses *found)
{
    const int k = s->order, is_more = k < s->known;
    const double *last = s->difference[k - 1], *further = s->difference[is_more ? k : k - 1];
    const LagLanes zero = LAG_LANES_OF(0), one = LAG_LANES_OF(1);
    const LagLanes less = LAG_LANES_OF(s->stretch[k - 1]), more = LAG_LANES_OF(is_more ? s->stretch[k] : 0);
    LagLanes place[ORDERS][PARTS] = {{zero}}, rate[ORDERS][PARTS] = {{zero}}, moving[PARTS] = {zero};
    for (int i = 0; i < n; i += LAG_LANES) {
        const int part = i / LAG_LANES % PARTS;
        LagLanes miss[ORDERS], by_place, by_rate, places;
        memcpy(&by_place, s->unit + i, sizeof by_place);
        memcpy(&by_rate, s->unit + n + i, sizeof by_rate);
        memcpy(&places, IS_PLACE + (n - i < LAG_LANES ? LAG_LANES - (n - i) : 0), sizeof places);
        by_place *= places;
        invert(&by_place);
        invert(&by_rate);
        moving[part] += LAG_LANES_SELECT(by_place > zero, one, zero) + LAG_LANES_SELECT(by_rate > zero, one, zero);
        by_place *= by_place;
        by_rate *= by_rate;
        memcpy(&miss[THIS], s->missed + i, sizeof miss[THIS]);
        memcpy(&miss[LESS], last + i, sizeof miss[LESS]);
        memcpy(&miss[MORE], further + i, sizeof miss[MORE]);
        miss[LESS] = miss[THIS] + less * miss[LESS];
        miss[MORE] = miss[THIS] - more * miss[MORE];
        LAG_UNROLL_ALL
        for (int order = 0; order < ORDERS; ++order) {
            miss[order] *= miss[order];
            place[order][part] += miss[order] * by_place;
            rate[order][part] += miss[order] * by_rate;
        }
    }
    for (int order = 0; order < ORDERS; ++order) {
        found->place[order] = total(place[order]);
        found->rate[order] = total(rate[order]);
    }
    found->moving = total(moving);
}

/* The same of the energy quadratures: the largest each, in units of the tolerance. */
static void measure_powers(const LagAdams *s, const LagMotion *m, double h, const LagScale *scale, Misses *found)
{
    const int n = m->n, k = s->order, is_more = k < s->known;
    const double energy = fmax(m->energy, h * h * m->strength);
    for (int order = 0; order < ORDERS; ++order)
        found->power[order] = 0;
    for (int i = n; i < (int)width_of(m) && m->energy > 0; ++i) {
        const double unit = scale->tolerance * fmax(fabs(m->other[n + i]), energy), miss = s->missed[i];
        const double more = is_more ? s->stretch[k] * s->difference[k][i] : 0;
        found->power[THIS] = lag_max(fabs(miss) / unit, found->power[THIS]);
        found->power[LESS] = lag_max(fabs(miss + s->stretch[k - 1] * s->difference[k - 1][i]) / unit, found->power[LESS]);
        found->power[MORE] = lag_max(fabs(miss - more) / unit, found->power[MORE]);
    }
}

/* The square of the error of a step predicted from so many slopes: one of the ORDERS. */
static double square_error(const Misses *found, int which, int order, double h, const Integrals *g)
{
    const double once = h * (g->once[order] - g->once[order - 1]), twice = h * h * (g->twice[order] - g->twice[order - 1]);
    const double squares = twice * twice * found->place[which] + once * once * found->rate[which], power = once * found->power[which];
    const double motion = found->moving > 0 ? CAUTION * CAUTION / found->moving * squares : 0;
    return power * power > motion ? power * power : motion;
}

static double factor_of(double square, int order) { return SAFETY * lag_rough_power(lag_max(square, TINY), -0.5 / (order + 1)); }

/* The order of the next step, or of another attempt at this one: that by which it gets longest, if it matters. */
static void choose(LagAdams *s, const Misses *found, double h, const Integrals *g, double square)
{
    const int k = s->order, is_good = square <= 1, may_rise = is_good && k < s->known && k < LAG_ADAMS_ORDER;
    const double more = may_rise ? square_error(found, MORE, k + 1, h, g) : INFINITY;
    s->is_starting = s->is_starting && is_good && k < LAG_ADAMS_ORDER && (k <= 2 || more < square);
    if (s->is_starting) {
        s->next_order = k + 1;
        return;
    }
    const double lower = k > 1 ? LOYAL * factor_of(square_error(found, LESS, k - 1, h, g), k - 1) : 0;
    const double higher = may_rise ? LOYAL * factor_of(more, k + 1) : 0;
    if (s->factor >= GROW || lag_max(lower, higher) <= s->factor)
        return;
    s->next_order = lower > higher ? k - 1 : k + 1;
    s->factor = lag_max(lower, higher);
}

/* Root mean square in units over positions and rates that move, as of the other methods. */
static double estimate(LagAdams *s, LagMotion *m, double h, const Integrals *g, const LagScale *scale)
{
    Misses found;
    if (scale->is_resting)
        lag_scale_foresee(scale, m->other);
    lag_scale_units(scale, m->y, m->other, s->unit);
    measure(s, m->n, &found);
    measure_powers(s, m, h, scale, &found);
    const double square = square_error(&found, THIS, s->order, h, g);
    if (!(square < INFINITY))
        return INFINITY;
    s->next_order = s->order;
    s->factor = factor_of(square, s->order);
    choose(s, &found, h, g, square);
    s->factor = lag_min(s->factor, GROW);
    return sqrt(square);
}

static double factor(const void *self) { return ((const LagAdams *)self)->factor; }

/* -------- steps */

static double attempt(void *self, LagMotion *m, double t_new, const LagScale *scale, int *worst)
{
    LagAdams *s = self;
    const double h = t_new - m->t;
    Integrals g;
    m->t_old = m->t;
    extend(s, h, &g);
    predict(s, m, h, &g);
    if (!lag_motion_slope(m, t_new, m->point, s->slope, s->slope)) {
        *worst = m->n + lag_first_not_finite(s->slope + m->n, m->n);
        return INFINITY;
    }
    correct(s, m, h, &g);
    const double error = estimate(s, m, h, &g, scale);
    if (!(error <= 1) || s->attempts++ % GLANCE == 0)
        s->worst = m->n + largest_of(s->missed, s->unit + m->n, m->n);
    if (error > 1 && error < INFINITY)
        s->order = s->next_order;
    *worst = s->worst;
    return error;
}

/* The slope at the predicted state is that of the step's end from now on. */
static int accept(void *self, LagMotion *m, double t_new)
{
    LagAdams *s = self;
    const int width = (int)width_of(m), rows = (s->known < s->order + 1 ? s->known : s->order + 1) + 1;
    for (int i = 0; i < width; i += LAG_LANES) {
        LagLanes latest, before;
        memcpy(&latest, s->slope + m->n + i, sizeof latest);
        for (int j = 0; j < rows - 1; ++j) {
            memcpy(&before, s->difference[j] + i, sizeof before);
            memcpy(s->difference[j] + i, &latest, sizeof latest);
            latest -= LAG_LANES_OF(s->stretch[j]) * before;
        }
        memcpy(s->difference[rows - 1] + i, &latest, sizeof latest);
    }
    memcpy(s->reach, s->new_reach, sizeof s->reach);
    s->terms = s->order + 1;
    s->has_end = 0;
    s->known = rows;
    s->order = s->next_order;
    lag_motion_take(m, t_new);
    return 1;
}

/* The polynomial that the step has integrated, backwards from its end. */
static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagAdams *s = self;
    const int n = m->n, width = (int)width_of(m);
    const double h = t - m->t_end;
    if (!s->has_end)
        memcpy(s->end, m->y, (size_t)m->size * sizeof *m->y);
    s->has_end = 1;
    double w[LAG_ADAMS_ROWS + 1], before = 0;
    for (int i = 0; i <= s->terms; ++i)
        w[i] = 1.0 / (i + 1);
    memset(s->rates, 0, (size_t)width * sizeof *s->rates);
    memset(s->places, 0, (size_t)width * sizeof *s->places);
    for (int j = 0; j < s->terms; ++j) {
        if (j > 0) {
            const double near = (h + before) / s->reach[j - 1], far = h / s->reach[j - 1];
            for (int i = 0; i <= s->terms - j; ++i)
                w[i] = near * w[i] - far * w[i + 1];
            before = s->reach[j - 1];
        }
        for (int i = 0; i < width; ++i) {
            s->rates[i] += w[0] * s->difference[j][i];
            s->places[i] += w[1] * s->difference[j][i];
        }
    }
    for (int i = 0; i < n; ++i)
        y[i] = s->end[i] + h * (s->end[n + i] + h * s->places[i]);
    for (int i = 0; i < width; ++i)
        y[n + i] = s->end[n + i] + h * s->rates[i];
}

/* Where conditions are not held through steps, slopes before tell little of those to come. */
static LagStatus step(LagRun *run)
{
    if ((run->switches.is_live || run->model->n_cones > 0) && lag_turn_pass(run))
        return run->methods.table->step(run);
    return lag_step_adaptive(run);
}

const LagMethod lag_adams = {
    .name = "adams", .order = 2, .layout = layout, .restart = restart, .step = step, .attempt = attempt, .accept = accept,
    .interpolate = interpolate, .holds_switches = 1, .stride = 4, .begins_low = 1, .weighs_work = 1, .leaves_trouble = 1,
    .factor = factor,
};
