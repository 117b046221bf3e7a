/* Gauss collocation, symplectic and symmetric, of order 2 s: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
 * Integration, 2nd ed. (2006), II.1.3, VI.4, VIII.6. Steps are taken in (q, p = dT/dv), where the motion is Hamilton's: so
 * the energy error does not grow, as long as all steps are equal. They are chosen once, from a trial run.
 *
 * The stages are iterated until only rounding is left, and sums are compensated (E. Hairer, R.I. McLachlan, A. Razakarivony,
 * BIT 48 (2008)): what is left of the energy error then walks at random. A row inside a step is a shorter step of its own,
 * which the run does not feel.
 */
#include "methods/gauss.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "methods/equal_steps.h"
#include "state/state.h"
#include "steps/step.h"

enum { MOST_ITERATIONS = 60 };
/* Iterations have converged when corrections fall below rounding, or below this and no longer shrink. */
static const double ROUNDING = 1e-16, NEARLY = 1e-11;

/* Fewest evaluations to an energy error like the tolerance, on pendulums, double pendulums, Kepler orbits and chains of
 * springs: stages, and the length of a step by the shortest one that Dormand-Prince 8(5,3) takes. */
static const struct {
    double tolerance;
    int tableau;
    double length;
} CHOICE[] = {{1e-3, 1, 1.2}, {1e-6, 2, 1.5}, {1e-10, 3, 2.4}, {0, 4, 3.0}};

static void take_stages(LagGaussStages *stages, size_t n, LagArena *arena)
{
    for (int i = 0; i < LAG_GAUSS_MOST_STAGES; ++i) {
        stages->v[i] = lag_take(arena, n);
        stages->force[i] = lag_take(arena, n);
    }
}

static void layout(void *self, const LagMotion *motion, LagArena *arena)
{
    LagGauss *s = self;
    const size_t n = (size_t)motion->n;
    s->p = lag_take(arena, n);
    s->carry = lag_take(arena, n);
    s->other = lag_take(arena, n);
    s->other_carry = lag_take(arena, n);
    s->q_stage = lag_take(arena, n);
    s->p_stage = lag_take(arena, n);
    s->v_new = lag_take(arena, n);
    s->force_new = lag_take(arena, n);
    take_stages(&s->step, n, arena);
    take_stages(&s->inside, n, arena);
}

static void restart(void *self, LagMotion *m)
{
    LagGauss *s = self;
    s->h = 0;
    s->stages_known = 0;
    memset(s->carry, 0, (size_t)m->n * sizeof *s->carry);
    m->flow(m->context, LAG_MOMENTUM, m->y, m->y + m->n, s->p);
}

static int velocity(LagMotion *m, const double *q, const double *p, double *v)
{
    return m->flow(m->context, LAG_VELOCITY, q, p, v);
}

static int force(LagMotion *m, const double *q, const double *v, double *result)
{
    ++m->evaluations;
    return m->flow(m->context, LAG_FORCE, q, v, result);
}

/* sum_j weight_j k_j for one component. */
static double weighed(const double *weight, double *const *k, int stages, int component)
{
    double sum = 0;
    for (int j = 0; j < stages; ++j)
        sum += weight[j] * k[j][component];
    return sum;
}

/* The slopes of stage i, from those of all others as they are known by now: momentum, velocity, position, force, in this
 * order, so that a sweep over the stages is worth two where M is constant. Returns the largest change of a position that
 * follows, by its magnitude; infinity where there is no value. */
static double improve(LagGauss *s, LagMotion *m, const LagScale *scale, const double *q, const double *p, double h, int i,
                      LagGaussStages *k)
{
    const LagGaussTableau *tableau = s->tableau;
    double largest = 0;
    for (int c = 0; c < m->n; ++c) {
        s->q_stage[c] = q[c] + h * weighed(tableau->a[i], k->v, tableau->stages, c);
        s->p_stage[c] = p[c] + h * weighed(tableau->a[i], k->force, tableau->stages, c);
    }
    if (!velocity(m, s->q_stage, s->p_stage, s->v_new))
        return INFINITY;
    for (int c = 0; c < m->n; ++c) {
        const double size = scale->floor[c], more = s->v_new[c] - k->v[i][c], change = fabs(h * more);
        if (change > 0)
            largest = fmax(largest, size > 0 ? change / size : 1);
        k->v[i][c] = s->v_new[c];
        s->q_stage[c] += h * tableau->a[i][i] * more;
    }
    return force(m, s->q_stage, k->v[i], k->force[i]) ? largest : INFINITY;
}

/* Solves for the stages of a step of length h from (q, p). Returns 0 when they cannot be found. */
static int solve(LagGauss *s, LagMotion *m, const LagScale *scale, const double *q, const double *p, double h,
                 LagGaussStages *k)
{
    double before = INFINITY;
    for (int iteration = 0; iteration < MOST_ITERATIONS; ++iteration) {
        double change = 0;
        for (int i = 0; i < s->tableau->stages; ++i)
            change = fmax(change, improve(s, m, scale, q, p, h, i, k));
        if (change <= ROUNDING || (change <= NEARLY && change >= before))
            return 1;
        if (!isfinite(change))
            return 0;
        before = change;
    }
    return 0;
}

/* First guesses: the collocation polynomial of the step before, continued; without one, the slopes at the beginning. */
static int guess(LagGauss *s, LagMotion *m, const double *q, const double *p)
{
    const int stages = s->tableau->stages;
    double row[LAG_GAUSS_MOST_STAGES];
    if (!s->stages_known) {
        if (!velocity(m, q, p, s->v_new) || !force(m, q, s->v_new, s->force_new))
            return 0;
        for (int i = 0; i < stages; ++i) {
            memcpy(s->step.v[i], s->v_new, (size_t)m->n * sizeof *row);
            memcpy(s->step.force[i], s->force_new, (size_t)m->n * sizeof *row);
        }
        return 1;
    }
    for (int c = 0; c < m->n; ++c)
        for (int which = 0; which < 2; ++which) {
            double **k = which ? s->step.force : s->step.v;
            for (int i = 0; i < stages; ++i)
                row[i] = weighed(s->tableau->start[i], k, stages, c);
            for (int i = 0; i < stages; ++i)
                k[i][c] = row[i];
        }
    return 1;
}

/* to = from + h b k, compensated. */
static void add(const LagGauss *s, double h, double *const *k, int n, const double *from, const double *from_carry, double *to,
                double *to_carry)
{
    const LagGaussTableau *tableau = s->tableau;
    for (int c = 0; c < n; ++c) {
        const double low = weighed(tableau->low, k, tableau->stages, c);
        const double step = h * weighed(tableau->b, k, tableau->stages, c) + (h * low + from_carry[c]);
        const double sum = from[c] + step, taken = sum - from[c];
        to[c] = sum;
        to_carry[c] = (from[c] - (sum - taken)) + (step - taken);
    }
}

static void swap(double **a, double **b)
{
    double *c = *a;
    *a = *b;
    *b = c;
}

/* Stages by the tolerance, and equal steps that end where the run does. */
static LagTrial choose(LagRun *run, LagGauss *s)
{
    const LagTrial trial = lag_trial(run);
    const double tolerance = run->settings.tolerance;
    size_t k = 0;
    while (tolerance < CHOICE[k].tolerance)
        ++k;
    s->tableau = &LAG_GAUSS[CHOICE[k].tableau];
    s->h = lag_equal_length(run, CHOICE[k].length * trial.shortest);
    return trial;
}

/* The new momenta are left in s->p. */
static int attempt(LagRun *run, double h, int is_cut)
{
    LagGauss *s = &run->methods.gauss;
    LagMotion *m = &run->motion;
    const int n = m->n;
    s->stages_known = s->stages_known && !is_cut;
    if (!guess(s, m, m->y, s->p) || !solve(s, m, &run->scale, m->y, s->p, h, &s->step)) {
        s->stages_known = 0;
        return 0;
    }
    add(s, h, s->step.v, n, m->y, m->carry, m->other, m->other_carry);
    add(s, h, s->step.force, n, s->p, s->carry, s->other, s->other_carry);
    if (!velocity(m, m->other, s->other, m->other + n))
        return 0;
    swap(&s->p, &s->other);
    swap(&s->carry, &s->other_carry);
    s->stages_known = !is_cut;
    return 1;
}

static LagStatus step(LagRun *run)
{
    LagGauss *s = &run->methods.gauss;
    double steps;
    if (s->h == 0) {
        const LagTrial trial = choose(run, s);
        if (trial.bends)
            return lag_roots_leave(run);
        if (lag_equal_never_ends(run, &trial, s->h, &steps))
            return lag_step_no_progress(run, -1, steps);
    }
    return lag_equal_step(run, &s->h, attempt);
}

/* Lagrange's polynomials through the stages, at x by the length of the step. */
static void cardinal(const LagGaussTableau *tableau, double x, double *row)
{
    for (int j = 0; j < tableau->stages; ++j) {
        row[j] = 1;
        for (int k = 0; k < tableau->stages; ++k)
            if (k != j)
                row[j] *= (x - tableau->c[k]) / (tableau->c[j] - tableau->c[k]);
    }
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagGauss *s = self;
    const int n = m->n, stages = s->tableau->stages;
    const double part = (t - m->t_old) / (m->t - m->t_old);
    const LagScale any = {.n = n, .floor = m->sum};
    double row[LAG_GAUSS_MOST_STAGES];
    for (int c = 0; c < n; ++c)
        m->sum[c] = fmax(fabs(m->y[c]), fabs(m->other[c]));
    for (int i = 0; i < stages; ++i) {
        cardinal(s->tableau, part * s->tableau->c[i], row);
        for (int c = 0; c < n; ++c) {
            s->inside.v[i][c] = weighed(row, s->step.v, stages, c);
            s->inside.force[i][c] = weighed(row, s->step.force, stages, c);
        }
    }
    solve(s, m, &any, m->other, s->other, t - m->t_old, &s->inside);
    add(s, t - m->t_old, s->inside.v, n, m->other, m->other_carry, y, m->point);
    add(s, t - m->t_old, s->inside.force, n, s->other, s->other_carry, s->p_stage, m->point);
    velocity(m, y, s->p_stage, y + n);
    ++m->dense_outputs;
}

const LagMethod lag_gauss = {
    .name = "conservative", .order = 8, .layout = layout, .restart = restart, .step = step, .interpolate = interpolate,
    .stride = 1,
};
