/* The stages of a step are known to half the digits of its end, as errors of Gauss collocation cancel only there. Evaluations at twice
 * as many nodes along it, integrated, are nearer by a factor of a hundred, and so on: the same iteration as that of the step, from where
 * it has come to. Degrees 0 and 1 are kept as they are: they alone tell where the step ends.
 */
#include "methods/pirk_dense.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "methods/pirk.h"
#include "methods/pirk_attitudes.h"
#include "methods/pirk_tableau.h"

enum { DEGREES = LAG_PIRK_DENSE, KEPT = 2, MOST_ROUNDS = 6, TAIL = 4 };
/* Units of error that may be left: a unit is a twentieth of the tolerance, and errors inside steps do not add up. The factor by which a
 * round comes nearer, mostly; one that comes less near than SLOW is the last. */
static const double NEAR = 1, GAIN = 0.05, SLOW = 0.5;
static const double ROUGH = 10; /* units: of what is no rounding */

void lag_pirk_dense_layout(LagPirkDense *dense, const LagMotion *m, LagArena *arena)
{
    const size_t all = (size_t)(m->size - m->n + lag_pirk_detours(m));
    dense->a = lag_take(arena, LAG_PIRK_DENSE * all);
    dense->coefficient = lag_take(arena, DEGREES * all);
}

/* -------- Legendre's polynomials, of x = 2 share - 1 */

typedef struct {
    double value[DEGREES + 2], rate[DEGREES + 1], place[DEGREES];
} Legendre;

/* The polynomials, their integrals from 0 to `share`, and the integrals of these: those of degree k from values of k + 1 and k - 1.
 * Written out, quotients are constants. */
static void legendre(double share, Legendre *p)
{
    const double x = 2 * share - 1;
    p->value[0] = 1;
    p->value[1] = x;
    LAG_UNROLL_ALL
    for (int k = 1; k <= DEGREES; ++k)
        p->value[k + 1] = ((2 * k + 1.0) / (k + 1)) * x * p->value[k] - (k / (k + 1.0)) * p->value[k - 1];
    p->rate[0] = share;
    LAG_UNROLL_ALL
    for (int k = 1; k <= DEGREES; ++k)
        p->rate[k] = (p->value[k + 1] - p->value[k - 1]) * (1.0 / (4 * k + 2));
    p->place[0] = 0.5 * share * share;
    LAG_UNROLL_ALL
    for (int k = 1; k < DEGREES; ++k)
        p->place[k] = (p->rate[k + 1] - p->rate[k - 1]) * (1.0 / (4 * k + 2));
}

static void tabulate(LagPirkDense *dense)
{
    Legendre p;
    for (int j = 0; j < LAG_ABREAST; ++j) {
        legendre(lag_pirk_node[j], &p);
        for (int k = 0; k < LAG_ABREAST; ++k)
            dense->coarse[j][k] = (2 * k + 1) * lag_pirk_end[j][1] * p.value[k];
    }
    for (int j = 0; j < LAG_PIRK_DENSE; ++j) {
        legendre(lag_pirk_dense_node[j], &p);
        for (int k = 0; k < DEGREES; ++k) {
            dense->fine[j][k] = (2 * k + 1) * lag_pirk_dense_weight[j] * p.value[k];
            dense->rate[k][j] = p.rate[k];
            dense->place[k][j] = p.place[k];
        }
    }
    dense->has_tables = 1;
}

static void need_tables(LagPirkDense *dense)
{
    if (!dense->has_tables)
        tabulate(dense);
}

/* -------- coefficients */

/* Those of the step's own polynomial. */
static void begin(LagPirkDense *dense, const double *known, int all)
{
    memset(dense->coefficient, 0, (size_t)(all * DEGREES) * sizeof *dense->coefficient);
    for (int c = 0; c < all; ++c)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
            lag_wide_write(dense->coefficient + c * DEGREES + lane,
                           lag_wide_weighed(known + c * LAG_ABREAST, &dense->coarse[0][0], LAG_ABREAST, LAG_ABREAST, lane));
}

/* Positions of attitudes at eight nodes, by their detours as the coefficients tell them, and these anew. */
static void turn(LagPirk *s, const LagMotion *m, int first)
{
    LagPirkDense *dense = &s->dense;
    const int all = m->size - m->n;
    const double h = s->length;
    for (int k = 0; k < lag_pirk_detours(m); ++k)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
            double *q = s->q + lag_pirk_detour_of(m, k) * LAG_ABREAST + lane;
            const double *sum = dense->coefficient + (all + k) * DEGREES;
            const LagWide way = lag_wide_weighed(sum, &dense->rate[0][0], DEGREES, LAG_PIRK_DENSE, first + lane);
            lag_wide_write(q, lag_wide_read(q) + h * way);
        }
    lag_pirk_find_detours(m, s->q, s->v, dense->a + all * LAG_PIRK_DENSE + first, LAG_PIRK_DENSE);
}

/* Accelerations at all nodes along the motion from y that the coefficients tell. */
static int evaluate(LagPirk *s, LagMotion *m, const double *y)
{
    LagPirkDense *dense = &s->dense;
    const int n = m->n, all = m->size - n;
    const double h = s->length;
    for (int first = 0; first < LAG_PIRK_DENSE; first += LAG_ABREAST) {
        for (int c = 0; c < n; ++c)
            for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
                const double *sum = dense->coefficient + c * DEGREES;
                const LagWide share = lag_wide_read(lag_pirk_dense_node + first + lane);
                const LagWide rate = lag_wide_weighed(sum, &dense->rate[0][0], DEGREES, LAG_PIRK_DENSE, first + lane);
                const LagWide place = lag_wide_weighed(sum, &dense->place[0][0], DEGREES, LAG_PIRK_DENSE, first + lane);
                lag_wide_write(s->v + c * LAG_ABREAST + lane, y[n + c] + h * rate);
                lag_wide_write(s->q + c * LAG_ABREAST + lane, y[c] + h * (share * y[n + c] + h * place));
            }
        turn(s, m, first);
        lag_pirk_set_times(s, m, s->begin, h, lag_pirk_dense_node + first);
        if (!lag_pirk_evaluate(s, m))
            return 0;
        for (int c = 0; c < all; ++c)
            memcpy(dense->a + c * LAG_PIRK_DENSE + first, s->a + c * LAG_ABREAST, LAG_ABREAST * sizeof *s->a);
    }
    return 1;
}

/* The coefficients of these. By how many units rates change: the integral of a polynomial of degree k is at most 1/(2 k) large. */
static double expand(LagPirk *s, const LagMotion *m)
{
    LagPirkDense *dense = &s->dense;
    double largest = 0;
    const int all = m->size - m->n;
    for (int c = 0; c < all + lag_pirk_detours(m); ++c) {
        double *sum = dense->coefficient + c * DEGREES, before[DEGREES];
        memcpy(before, sum, sizeof before);
        for (int lane = 0; lane < DEGREES; lane += LAG_WIDE)
            lag_wide_write(sum + lane, lag_wide_weighed(dense->a + c * LAG_PIRK_DENSE, &dense->fine[0][0], LAG_PIRK_DENSE, DEGREES, lane));
        memcpy(sum, before, KEPT * sizeof *sum);
        const double weight = c < m->n ? s->weight[c] : c >= all ? s->weight[m->n + c - all] : 0;
        for (int k = KEPT; k < DEGREES && weight > 0; ++k)
            largest = lag_max(fabs(sum[k] - before[k]) * weight / (2 * k), largest);
    }
    return largest;
}

/* Whether a jump is among the nodes: the last coefficients do not fall then. It may be beyond what ends the step, as the cut of an angle
 * is half a turn further on. */
static int is_rough(const LagPirk *s, const LagMotion *m)
{
    double last = 0, before = 0;
    for (int c = 0; c < m->n; ++c)
        for (int k = DEGREES - TAIL; k < DEGREES; ++k) {
            const double *sum = s->dense.coefficient + c * DEGREES;
            last = lag_max(fabs(sum[k]) * s->weight[c], last);
            before = lag_max(fabs(sum[k - TAIL]) * s->weight[c], before);
        }
    return last > ROUGH && last > SLOW * before;
}

/* The coefficients of the step from y whose own polynomial is `known`. */
static void refine(LagPirk *s, LagMotion *m, const double *y, const double *known)
{
    double before = INFINITY;
    need_tables(&s->dense);
    begin(&s->dense, known, m->size - m->n + lag_pirk_detours(m));
    for (int round = 0; round < MOST_ROUNDS && evaluate(s, m, y); ++round) {
        const double far = expand(s, m);
        if (!(GAIN * far > NEAR) || far > SLOW * before)
            break;
        before = far;
    }
    ++m->dense_outputs;
}

static void prepare(LagPirk *s, LagMotion *m)
{
    refine(s, m, m->other, s->known);
    s->dense.is_ready = 1;
    m->lacks_slopes = is_rough(s, m);
}

double lag_pirk_second_look(LagPirk *s, LagMotion *m, const double *y)
{
    LagPirkDense *dense = &s->dense;
    double most = 0;
    need_tables(dense);
    begin(dense, s->known, m->size - m->n + lag_pirk_detours(m));
    if (!evaluate(s, m, y))
        return INFINITY;
    for (int c = 0; c < m->n; ++c) {
        double found[KEPT] = {0};
        for (int j = 0; j < LAG_PIRK_DENSE; ++j)
            for (int k = 0; k < KEPT; ++k)
                found[k] += dense->a[c * LAG_PIRK_DENSE + j] * dense->fine[j][k];
        for (int k = 0; k < KEPT; ++k)
            most = lag_max(fabs(found[k] - dense->coefficient[c * DEGREES + k]) * s->weight[c], most);
    }
    return most;
}

/* sum of coefficients times values, in the same order whatever registers hold. */
static double dot(const double *coefficient, const double *value)
{
    double each[LAG_ABREAST];
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        lag_wide_write(each + lane, lag_wide_read(coefficient + lane) * lag_wide_read(value + lane)
                                        + lag_wide_read(coefficient + LAG_ABREAST + lane) * lag_wide_read(value + LAG_ABREAST + lane));
    return lag_wide_total(each);
}

/* Positions of the first n of `rows` components and rates of all, at a share of the step from `from`. */
static void read_rows(const double *from, const double *coefficient, int n, int rows, double h, double share, const Legendre *p, double *y)
{
    for (int c = 0; c < rows; ++c) {
        const double *sum = coefficient + c * DEGREES;
        if (c < n)
            y[c] = from[c] + h * (share * from[n + c] + h * dot(sum, p->place));
        y[n + c] = from[n + c] + h * dot(sum, p->rate);
    }
}

void lag_pirk_dense_read(LagPirk *s, LagMotion *m, double t, double *y)
{
    const int n = m->n;
    const double h = s->length, share = (t - s->begin) / h, *from = m->other;
    Legendre p;
    if (!s->dense.is_ready)
        prepare(s, m);
    legendre(share, &p);
    read_rows(from, s->dense.coefficient, n, m->size - n, h, share, &p, y);
    for (int k = 0; k < lag_pirk_detours(m); ++k)
        y[lag_pirk_detour_of(m, k)] += h * dot(s->dense.coefficient + (m->size - n + k) * DEGREES, p.rate);
}

/* -------- steps that are kept */

/* A record: whether it holds the coefficients or the step's own polynomial yet, the state that the step began from, what its
 * accelerations are worth, and these or those. */
typedef struct {
    double *is_ready, *from, *weight, *rows;
} Kept;

static Kept kept_at(double *place, int n) { return (Kept){place, place + 1, place + 1 + 2 * n, place + 1 + 3 * n}; }

static void keep(const void *self, const LagMotion *m, double *place)
{
    const LagPirk *s = self;
    const size_t n = (size_t)m->n;
    const Kept kept = kept_at(place, m->n);
    *kept.is_ready = 0;
    memcpy(kept.from, m->other, 2 * n * sizeof *kept.from);
    memcpy(kept.weight, s->weight, n * sizeof *kept.weight);
    memcpy(kept.rows, s->known, LAG_ABREAST * n * sizeof *kept.rows);
}

/* What the latest step is foreseen from stays. */
static void recall(void *self, LagMotion *m, double *place, double begins, double length, double t, double *y)
{
    LagPirk *s = self;
    const int n = m->n;
    const Kept kept = kept_at(place, n);
    Legendre p;
    if (*kept.is_ready == 0) {
        const double begin_now = s->begin, length_now = s->length;
        s->begin = begins;
        s->length = length;
        memcpy(s->weight, kept.weight, (size_t)n * sizeof *s->weight);
        refine(s, m, kept.from, kept.rows);
        memcpy(kept.rows, s->dense.coefficient, (size_t)(DEGREES * n) * sizeof *kept.rows);
        s->begin = begin_now;
        s->length = length_now;
        s->dense.is_ready = 0;
        *kept.is_ready = 1;
    }
    const double share = (t - begins) / length;
    legendre(share, &p);
    read_rows(kept.from, kept.rows, n, n, length, share, &p, y);
}

const LagRecord lag_pirk_record = {keep, recall};
