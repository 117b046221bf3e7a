/* The equations of a collocation step: with the rates' increments Z_i, positions q + h c_i v + h sum a_ij Z_j,
 *
 *     1/h sum (A^-1)_ij Z_j = a(t_i, q_i, v_i),
 *
 * by simplified Newton iterations. The eigenvectors of A^-1 take them apart into one real and some complex systems
 * (mu - J_v - J_q/mu) w = r with mu = eigenvalue/h, each of the size of the coordinates: E. Hairer, G. Wanner, Solving Ordinary
 * Differential Equations II (1996), IV.8, with the rates eliminated. The positions follow from the rates exactly.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "events/conditions.h"
#include "events/cones.h"
#include "methods/radau.h"
#include "steps/step.h"

/* Changes of the stages left undone, in units of error; in multiples of rounding. A contraction that shows nothing but rounding
 * any more, and the largest change it may leave. */
static const double GOAL = 0.001, ROUNDING = 2 * DBL_EPSILON, TIME_ROUNDING = 4 * DBL_EPSILON, STALLED = 0.9, STALLED_CHANGE = 0.5;
/* The change up to which the contraction of the step before is believed to hold: a ball that meets the floor in this step must not
 * pass because its flight was easy. */
static const double UNSEEN = 1;
static const double DIVERGED = 0.99, SLOWER = 0.8, FEWEST_UNITS = 1e-4, MOST_UNITS = 20;
static const double MOST_LEFT = 1; /* units of error, of what accelerations lack */
static const double UNCERTAIN = 10; /* of what stages may be off, in the powers at one place */
enum { BASE_ITERATIONS = 7, FEWEST_STAGES = 3 };

int lag_radau_most_iterations(const LagRadauTableau *tableau)
{
    return BASE_ITERATIONS + 2 * (tableau->stages - FEWEST_STAGES);
}

double lag_radau_unit(const LagRadau *s, const LagMotion *m, const LagScale *scale, int i, const double *y_new)
{
    const double change = fabs(y_new[i] - m->y[i]);
    const double resolution = change > LAG_SCALE_NOTHING ? TIME_ROUNDING * fabs(m->t) / s->trial.h * change : 0;
    return fmax(lag_scale_unit(scale, i, m->y, y_new), resolution);
}

static void factor(LagRadau *s, int which, double mu_re, double mu_im)
{
    lag_implicit_matrix_factor(&s->matrix, which, mu_re, mu_im);
    lag_border_factor(&s->border, &s->matrix, which, mu_re, mu_im);
}

int lag_radau_prepare(LagRadau *s, LagRun *run, double h)
{
    const double *mu = s->tableau->eigenvalue;
    if (!s->jacobian_is_known) {
        if (!lag_jacobian(run, run->motion.t, run->motion.y, &s->matrix)
            || !lag_border_find(&s->border, run, run->motion.t, run->motion.y))
            return 0;
        s->jacobian_is_known = s->jacobian_is_fresh = 1;
        s->factored = 0;
    }
    if (fabs(s->factored - h) <= 1e-9 * h && s->factored_tableau == s->tableau)
        return 1;
    factor(s, 0, mu[0] / h, 0);
    for (int k = 1; k <= s->tableau->pairs; ++k)
        factor(s, k, mu[2 * k - 1] / h, mu[2 * k] / h);
    s->factored = h;
    s->factored_tableau = s->tableau;
    run->statistics.factorisations += 1 + s->tableau->pairs;
    return 1;
}

/* h times row i of A times the rates of the stages. */
static void place_stages(LagRadau *s, const LagMotion *m, double h)
{
    const int n = m->n, stages = s->tableau->stages;
    for (int i = 0; i < stages; ++i) {
        const double *a = s->tableau->a + i * stages, c = s->tableau->node[i];
        for (int k = 0; k < n; ++k) {
            double sum = c * m->y[n + k];
            for (int j = 0; j < stages; ++j)
                sum += a[j] * s->trial.rate[j * n + k];
            s->place[i * n + k] = h * sum;
        }
    }
    if (m->n_attitudes > 0)
        lag_collocation_turn(&s->trial, m, h, s->place);
}

/* Accelerations and powers of the stages. Returns 0 when they are not finite. */
static int evaluate_stages(LagRadau *s, LagMotion *m, double h, int *worst)
{
    const int n = m->n, n_power = m->size - 2 * n;
    double *k = m->sum;
    s->evaluations += s->tableau->stages;
    for (int i = 0; i < s->tableau->stages; ++i) {
        for (int j = 0; j < n; ++j) {
            m->point[j] = m->y[j] + s->place[i * n + j];
            m->point[n + j] = m->y[n + j] + s->trial.rate[i * n + j];
        }
        if (!lag_motion_slope(m, m->t + s->tableau->node[i] * h, m->point, m->point + n, k)) {
            *worst = n + lag_first_not_finite(k + n, n);
            return 0;
        }
        memcpy(s->force + i * n, k + n, (size_t)n * sizeof *k);
        for (int j = 0; j < n_power; ++j)
            s->trial.power[i * n_power + j] = k[2 * n + j] - s->slope[2 * n + j];
    }
    return 1;
}

/* force becomes the residual: force - A^-1 Z/h. */
static void subtract_slopes(LagRadau *s, int n, double h)
{
    const int stages = s->tableau->stages;
    for (int i = 0; i < stages; ++i)
        for (int k = 0; k < n; ++k) {
            double sum = 0;
            for (int j = 0; j < stages; ++j)
                sum += s->tableau->inverse[i * stages + j] * s->trial.rate[j * n + k];
            s->force[i * n + k] -= sum / h;
        }
}

/* Row `row` of the left eigenvectors times the residuals. */
static void transform(const LagRadau *s, int row, int n, double *w)
{
    const int stages = s->tableau->stages;
    const double *to = s->tableau->to + row * stages;
    for (int k = 0; k < n; ++k) {
        w[k] = 0;
        for (int i = 0; i < stages; ++i)
            w[k] += to[i] * s->force[i * n + k];
    }
}

static void transform_back(LagRadau *s, int column, int n, const double *w)
{
    const int stages = s->tableau->stages;
    for (int i = 0; i < stages; ++i)
        for (int k = 0; k < n; ++k)
            s->change[i * n + k] += s->tableau->from[i * stages + column] * w[k];
}

/* The change of the rates from the residuals. */
static void solve_systems(LagRadau *s, int n)
{
    memset(s->change, 0, (size_t)(s->tableau->stages * n) * sizeof *s->change);
    transform(s, 0, n, s->w_re);
    lag_border_solve(&s->border, &s->matrix, 0, s->w_re, NULL, NULL, s->w_re, NULL);
    transform_back(s, 0, n, s->w_re);
    for (int k = 1; k <= s->tableau->pairs; ++k) {
        transform(s, 2 * k - 1, n, s->w_re);
        transform(s, 2 * k, n, s->w_im);
        lag_border_solve(&s->border, &s->matrix, k, s->w_re, s->w_im, NULL, s->w_re, s->w_im);
        transform_back(s, 2 * k - 1, n, s->w_re);
        transform_back(s, 2 * k, n, s->w_im);
    }
}

/* Units of error, by the present state and the end of the step as it is known now. */
static void weigh(LagRadau *s, const LagMotion *m, const LagScale *scale)
{
    const int n = m->n, last = (s->tableau->stages - 1) * n;
    for (int k = 0; k < n; ++k) {
        m->point[k] = m->y[k] + s->place[last + k];
        m->point[n + k] = m->y[n + k] + s->trial.rate[last + k];
    }
    if (scale->is_resting)
        lag_scale_foresee(scale, m->point);
    for (int k = 0; k < 2 * n; ++k) {
        const double unit = lag_radau_unit(s, m, scale, k, m->point);
        s->weight[k] = unit > 0 ? 1 / unit : 0;
    }
}

/* Applies the change; its root mean square over stages, positions and rates, in units of error. */
static double apply_change(LagRadau *s, LagRun *run, double h)
{
    LagMotion *m = &run->motion;
    const int n = m->n, stages = s->tableau->stages;
    double sum = 0;
    for (int k = 0; k < stages * n; ++k)
        s->trial.rate[k] += s->change[k];
    memcpy(s->force, s->place, (size_t)(stages * n) * sizeof *s->force);
    place_stages(s, m, h);
    weigh(s, m, &run->scale);
    for (int i = 0; i < stages; ++i)
        for (int k = 0; k < n; ++k) {
            const double rate = s->change[i * n + k] * s->weight[n + k];
            const double place = (s->place[i * n + k] - s->force[i * n + k]) * s->weight[k];
            sum += rate * rate + place * place;
        }
    return sqrt(sum / (2 * stages * n));
}

/* First guesses: as the step before foresees them, or a parabola. */
static void guess(LagRadau *s, const LagMotion *m, double h)
{
    const int n = m->n;
    if (s->has_last)
        lag_collocation_foresee(&s->last, n, s->tableau, h, s->trial.rate);
    else
        for (int i = 0; i < s->tableau->stages; ++i)
            for (int k = 0; k < n; ++k)
                s->trial.rate[i * n + k] = s->tableau->node[i] * h * s->slope[n + k];
    place_stages(s, m, h);
}

/* How the iterations go on: CONVERGED means that they may. `change` is the latest one in multiples of the goal. */
static LagConvergence judge(LagRadau *s, double ratio, double contraction, double change, double *shorter)
{
    const int left = lag_radau_most_iterations(s->tableau) - s->iterations;
    if (ratio >= STALLED && change < STALLED_CHANGE / GOAL)
        return LAG_STAGES_CONVERGED;
    s->contraction = contraction;
    if (!(contraction < DIVERGED))
        return LAG_STAGES_DIVERGED;
    s->patience = contraction / (1 - contraction);
    const double expected = s->patience * change * pow(contraction, left - 1);
    if (left == 0 || expected < 1)
        return LAG_STAGES_CONVERGED;
    *shorter = SLOWER * pow(fmin(MOST_UNITS, fmax(FEWEST_UNITS, expected)), -1.0 / (3 + left));
    return LAG_STAGES_SLOW;
}

/* Of changes of the stages, in units of error. */
static double goal_of(const LagRun *run) { return fmax(GOAL, ROUNDING / run->scale.tolerance); }

LagConvergence lag_radau_solve(LagRadau *s, LagRun *run, double h, double *shorter, int *worst)
{
    LagMotion *m = &run->motion;
    const int most = lag_radau_most_iterations(s->tableau);
    const double goal = goal_of(run);
    double last = 0, last_ratio = 0;
    s->trial.tableau = s->tableau;
    s->trial.h = h;
    s->patience = pow(fmax(s->patience, DBL_EPSILON), SLOWER);
    guess(s, m, h);
    for (int i = 1; i <= most; ++i) {
        if (!evaluate_stages(s, m, h, worst))
            return LAG_STAGES_NOT_FINITE;
        subtract_slopes(s, m->n, h);
        solve_systems(s, m->n);
        const double change = apply_change(s, run, h);
        if (!isfinite(change))
            return LAG_STAGES_NOT_FINITE;
        s->iterations = i;
        if (i > 1) {
            const double ratio = change / last;
            const LagConvergence verdict = judge(s, ratio, i == 2 ? ratio : sqrt(ratio * last_ratio), change / goal, shorter);
            if (verdict != LAG_STAGES_CONVERGED || (ratio >= STALLED && change < STALLED_CHANGE))
                return verdict;
            last_ratio = ratio;
        }
        if (s->patience * change <= goal && (i > 1 || change < UNSEEN))
            return LAG_STAGES_CONVERGED;
        last = change;
    }
    *shorter = SLOWER / 2;
    return LAG_STAGES_SLOW;
}

/* Whether accelerations at the stages are those of the step, in units of error. Friction in the plane changes its direction with slips of
 * next to nothing: iterations with derivatives by slow ones hardly change others, and converge where they are; and there are solutions
 * with stages beyond the place where a slip turns round. Leaves residuals. */
static int are_solved(LagRadau *s, LagRun *run, double h)
{
    LagMotion *m = &run->motion;
    const int n = m->n;
    subtract_slopes(s, n, h);
    for (int i = 0; i < s->tableau->stages; ++i) {
        for (int k = 0; k < n; ++k) {
            m->point[k] = m->y[k] + s->place[i * n + k];
            m->point[n + k] = m->y[n + k] + s->trial.rate[i * n + k];
            if (!(fabs(h * s->force[i * n + k]) * s->weight[n + k] <= MOST_LEFT))
                return 0;
        }
        if (lag_cones_have_turned(run, m->t + s->tableau->node[i] * h, m->point))
            return 0;
    }
    return 1;
}

/* Integrals of the powers, and their errors. */
static void integrate_powers(LagRadau *s, LagMotion *m, double h, double tolerance)
{
    const int n = m->n, n_power = m->size - 2 * n, stages = s->tableau->stages;
    const double least = fmax(m->energy, h * h * m->strength);
    s->doubt = s->missed = 0;
    for (int k = 0; k < n_power; ++k) {
        double sum = s->slope[2 * n + k], error = 0;
        for (int i = 0; i < stages; ++i) {
            sum += s->tableau->a[(stages - 1) * stages + i] * s->trial.power[i * n_power + k];
            error += s->tableau->error_place[i] * s->trial.power[i * n_power + k];
        }
        error = fabs(h / s->tableau->eigenvalue[0] * error);
        m->sum[2 * n + k] = h * sum;
        s->doubt += error;
        if (least > 0)
            s->missed = fmax(s->missed, error / (tolerance * fmax(least, fabs(m->y[2 * n + k] + h * sum))));
    }
}

int lag_radau_finish(LagRadau *s, LagRun *run, double h)
{
    LagMotion *m = &run->motion;
    const int n = m->n, last = s->tableau->stages - 1, slips = run->sliding.known_error < INFINITY;
    int worst;
    if ((m->size > 2 * n || slips) && !evaluate_stages(s, m, h, &worst)) /* the powers of the last iteration, not of the one before */
        return 0;
    if (slips && !are_solved(s, run, h))
        return 0;
    memcpy(m->sum, s->place + last * n, (size_t)n * sizeof *m->sum);
    memcpy(m->sum + n, s->trial.rate + last * n, (size_t)n * sizeof *m->sum);
    integrate_powers(s, m, h, run->scale.tolerance);
    lag_motion_add(m, m->sum);
    return 1;
}

int lag_radau_knows_powers(LagRadau *s, LagRun *run, double h)
{
    LagMotion *m = &run->motion;
    const int n = m->n, n_power = m->size - 2 * n;
    const double *at_end = s->trial.power + (s->tableau->stages - 1) * n_power, least = fmax(m->energy, h * h * m->strength);
    for (int k = 0; k < 2 * n; ++k)
        s->filtered[k] = s->weight[k] > 0 ? goal_of(run) / s->weight[k] : 0;
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * n); ++pattern) {
        lag_conditions_disturb(run, m->other, s->filtered, pattern, m->point);
        if (!lag_motion_slope(m, m->t + h, m->point, m->point + n, m->sum))
            return 0;
        for (int k = 0; k < n_power; ++k)
            if (s->missed < UNCERTAIN * h * fabs(m->sum[2 * n + k] - s->slope[2 * n + k] - at_end[k]) / (run->scale.tolerance * least))
                return 0;
    }
    return 1;
}
