/* At a dead point of a crank whose slide is moved, rates, accelerations and forces are quotients of what vanishes: rounding of positions is
 * magnified by the inverse of the distance, by its square, and by its fourth power. Positions are known to a rounding of constraints over
 * the singular value of their slopes J, along its singular vector: what changes over that much is not known of a row. Singular vectors by
 * rotations of pairs of rows (G.E. Forsythe, P. Henrici, Trans. Amer. Math. Soc. 94 (1960); M.R. Hestenes).
 */
#include "run/unsure.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "model/function.h"
#include "numbers/extremes.h"
#include "state/state.h"

static const double LEAST = 1e-6, MANY = 1000; /* of the sizes of outputs; tolerances: what need not be known */
static const double NEAR = 0.1, NOTHING = 1e-9; /* singular values: of what is nearly singular, of what repeats others */
static const double ROUNDINGS = 2; /* of constraints, in which positions are known */
static const double DOUBLE_ROOT = 1e-8; /* of sizes: to which they are known where a singular value vanishes */
static const double FAINT = 1e-12; /* of the largest multiplier, or coordinate, or rate: rounding of what is none */
static const double ORTHOGONAL = 1e-15;
enum { MOST_ROWS = 40, SWEEPS = 12, PLACES = 3, STEERS = 2 };

static int is_small(const LagModel *model)
{
    return model->n_multipliers > 0 && model->n_multipliers <= MOST_ROWS && model->n <= 2 * MOST_ROWS;
}

static int asks(const LagModel *model) { return is_small(model) && model->outputs_need_acceleration; }

void lag_unsure_layout(LagUnsure *s, const LagModel *model, LagArena *arena)
{
    const size_t m = is_small(model) ? (size_t)model->n_multipliers : 0, n = m > 0 ? (size_t)model->n : 0;
    double **const of_rows[] = {&s->reach, &s->rate, &s->still}, **const of_outputs[] = {&s->one, &s->other, &s->largest, &s->spread};
    s->J = lag_take(arena, m * n);
    s->state = lag_take(arena, 2 * n);
    s->place = lag_take(arena, n);
    for (size_t k = 0; k < sizeof of_rows / sizeof *of_rows; ++k)
        *of_rows[k] = lag_take(arena, m);
    for (size_t k = 0; k < sizeof of_outputs / sizeof *of_outputs; ++k)
        *of_outputs[k] = lag_take(arena, m > 0 ? (size_t)model->n_outputs : 0);
}

void lag_unsure_reset(LagRun *run)
{
    LagUnsure *s = &run->unsure;
    s->multipliers = 0;
    if (!is_small(run->model))
        return;
    memset(s->largest, 0, (size_t)run->model->n_outputs * sizeof *s->largest);
    memset(s->reach, 0, (size_t)run->model->n_multipliers * sizeof *s->reach);
    s->repeated = run->model->n_multipliers;
}

/* Of a coordinate, or of a rate from n on: the largest of its kind, an angle of 1. */
static double size_of(const LagRun *run, int i)
{
    const LagScale *scale = &run->scale;
    const int n = run->model->n;
    const double seen = scale->group[(i < n ? 0 : scale->kinds) + scale->kind[i % n]];
    return i < n && isfinite(scale->cap[i]) ? lag_max(seen, 1) : seen;
}

static double largest_of_all(const LagRun *run)
{
    double largest = run->unsure.multipliers;
    for (int i = 0; i < 2 * run->model->n; ++i)
        largest = lag_max(size_of(run, i), largest);
    return largest;
}

/* J v + dPhi/dt, where only coordinate i moves, or none (-1). */
static void rates_of(LagRun *run, double t, const double *q, int i, double *rate)
{
    LagUnsure *s = &run->unsure;
    const int n = run->model->n;
    double *v = s->state + n;
    memset(v, 0, (size_t)n * sizeof *v);
    if (i >= 0)
        v[i] = size_of(run, i);
    const double *in[] = {&t, q, v, run->u, run->d, run->c};
    double *out[] = {run->projection.measure.phi, rate};
    lag_call(&run->model->residual, in, out, run->work);
}

/* J at q, in natural displacements: its rows are no smaller than they have been. */
static void find_slopes(LagRun *run, double t, const double *q)
{
    LagUnsure *s = &run->unsure;
    const int n = run->model->n, m = run->model->n_multipliers;
    lag_inputs_at(&run->inputs, t, run->u);
    rates_of(run, t, q, -1, s->still);
    for (int i = 0; i < n; ++i) {
        rates_of(run, t, q, i, s->rate);
        for (int j = 0; j < m; ++j)
            s->J[j * n + i] = s->rate[j] - s->still[j];
    }
    for (int j = 0; j < m; ++j)
        s->reach[j] = lag_max(lag_largest(s->J + j * n, (size_t)n), s->reach[j]);
}

/* J at one of some places beside this one. */
static void look_beside(LagRun *run, double t, const double *q, int k)
{
    LagUnsure *s = &run->unsure;
    for (int i = 0; i < run->model->n; ++i)
        s->place[i] = q[i] + ((i >> k) & 1 ? -1 : 1) * size_of(run, i);
    find_slopes(run, t, s->place);
}

/* The usual sizes of rows, at places beside the first one. */
static void see_other_places(LagRun *run, double t, const double *q)
{
    for (int k = 0; k < PLACES && run->unsure.repeated == run->model->n_multipliers; ++k)
        look_beside(run, t, q, k);
}

static double product(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += a[i] * b[i];
    return sum;
}

/* Makes two rows orthogonal. Returns whether they were not. */
static int rotate(double *a, double *b, int n)
{
    const double aa = product(a, a, n), bb = product(b, b, n), ab = product(a, b, n);
    if (!(fabs(ab) > ORTHOGONAL * sqrt(aa * bb)))
        return 0;
    const double zeta = (bb - aa) / (2 * ab), tangent = (zeta < 0 ? -1 : 1) / (fabs(zeta) + sqrt(1 + zeta * zeta));
    const double cosine = 1 / sqrt(1 + tangent * tangent), sine = cosine * tangent;
    for (int i = 0; i < n; ++i) {
        const double first = a[i];
        a[i] = cosine * first - sine * b[i];
        b[i] = sine * first + cosine * b[i];
    }
    return 1;
}

/* The rows become singular vectors, as long as their values. */
static void decompose(double *J, int m, int n)
{
    for (int sweep = 0, turned = 1; sweep < SWEEPS && turned; ++sweep) {
        turned = 0;
        for (int j = 0; j < m; ++j)
            for (int k = j + 1; k < m; ++k)
                turned |= rotate(J + j * n, J + k * n, n);
    }
}

/* Of J as it was found, with rows by their usual size. Returns how many singular values are no more than `most`. */
static int take_values(LagRun *run, double most)
{
    LagUnsure *s = &run->unsure;
    const int n = run->model->n, m = run->model->n_multipliers;
    int none = 0;
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < n && s->reach[j] > 0; ++i)
            s->J[j * n + i] /= s->reach[j];
    decompose(s->J, m, n);
    for (int j = 0; j < m; ++j)
        none += !(sqrt(product(s->J + j * n, s->J + j * n, n)) > most);
    return none;
}

/* Of J at q. */
static int find_values(LagRun *run, double t, const double *q)
{
    see_other_places(run, t, q);
    find_slopes(run, t, q);
    return take_values(run, NOTHING);
}

/* How many rows repeat others here, that did not in a row before. */
static int find_lost(LagRun *run, double t, const double *y)
{
    LagUnsure *s = &run->unsure;
    const int none = find_values(run, t, y);
    s->repeated = none < s->repeated ? none : s->repeated;
    return none - s->repeated;
}

/* Outputs as if y had the accelerations and multipliers of a state away from it, whose rates keep the constraints there. */
static void displaced(LagRun *run, double t, const double *y, const double *way, double length, double *outputs)
{
    LagUnsure *s = &run->unsure;
    const int n = run->model->n;
    double *dv = run->acceleration;
    memcpy(s->state, y, 2 * (size_t)n * sizeof *y);
    for (int i = 0; i < n; ++i)
        s->state[i] += length * way[i] * size_of(run, i);
    for (int k = 0; k < STEERS; ++k) {
        const double *in[] = {&t, s->state, s->state + n, run->u, run->d, run->c};
        lag_call(&run->model->steer, in, &dv, run->work);
        for (int i = 0; i < n; ++i)
            s->state[n + i] += dv[i];
    }
    lag_outputs_beside(run, t, s->state, y, outputs);
}

/* What is not known of each output: into s->spread. Returns whether the position is nearly singular. */
static int find_spread(LagRun *run, double t, const double *y, const double *outputs)
{
    LagUnsure *s = &run->unsure;
    const int n = run->model->n, m = run->model->n_multipliers;
    int is_near = 0;
    memset(s->spread, 0, (size_t)run->model->n_outputs * sizeof *s->spread);
    const int is_lost = find_lost(run, t, y) > 0;
    for (int j = 0; j < m; ++j) {
        const double *way = s->J + j * n, value = sqrt(product(way, way, n));
        if (!(value < NEAR) || !(value > NOTHING || (is_lost && value > 0)))
            continue;
        const double length = (value > NOTHING ? ROUNDINGS * DBL_EPSILON / value : DOUBLE_ROOT) / value;
        is_near = 1;
        displaced(run, t, y, way, length, s->one);
        displaced(run, t, y, way, -length, s->other);
        for (int i = 0; i < run->model->n_outputs; ++i) {
            const double spread = fmax(fabs(s->one[i] - outputs[i]), fabs(s->other[i] - outputs[i]));
            if (!isnan(outputs[i]))
                s->spread[i] = isnan(spread) ? INFINITY : s->spread[i] + spread;
        }
    }
    return is_near;
}

/* What is not known by too much is not told. */
static void forget(LagRun *run, double t, double *outputs)
{
    LagUnsure *s = &run->unsure;
    LagStatistics *statistics = &run->statistics;
    const double most = lag_max(MANY * run->settings.tolerance, LEAST), faint = FAINT * largest_of_all(run);
    int unknown = 0;
    for (int i = 0; i < run->model->n_outputs; ++i) {
        const double size = lag_max(s->largest[i] > 0 ? 0 : fabs(outputs[i]), s->largest[i]);
        if (!(s->spread[i] > lag_max(most * size, faint)))
            continue;
        if (unknown++ == 0 && statistics->unsure == 0) {
            statistics->unsure_output = i;
            statistics->unsure_time = t;
        }
        outputs[i] = NAN;
    }
    statistics->unsure += unknown > 0;
}

static int is_quiet(const LagRun *run) { return run->sliding.count == 0 && !run->switches.is_live && !run->rests; }

void lag_unsure_row(LagRun *run, double t, const double *y, double *outputs)
{
    LagUnsure *s = &run->unsure;
    if (!asks(run->model) || !is_quiet(run))
        return;
    const double multipliers = lag_largest(run->multipliers, (size_t)run->model->n_multipliers);
    const int is_near = find_spread(run, t, y, outputs);
    if (!is_near || s->multipliers == 0)
        s->multipliers = lag_max(multipliers, s->multipliers);
    if (is_near)
        forget(run, t, outputs);
    for (int i = 0; i < run->model->n_outputs && !is_near; ++i)
        s->largest[i] = lag_max(fabs(outputs[i]), s->largest[i]);
}

int lag_unsure_is_singular(LagRun *run, double most)
{
    const LagMotion *m = &run->motion;
    int beside = run->model->n_multipliers;
    if (!is_small(run->model))
        return 0;
    for (int k = 0; k < PLACES; ++k) /* the first time for the sizes of rows */
        look_beside(run, m->t, m->y, k);
    for (int k = 0; k < PLACES; ++k) {
        look_beside(run, m->t, m->y, k);
        const int none = take_values(run, most);
        beside = none < beside ? none : beside;
    }
    find_slopes(run, m->t, m->y);
    return take_values(run, most) > beside;
}
