/* Symplectic, symmetric Runge-Kutta-Nystrom splitting of order 6 with 11 stages: S. Blanes, P.C. Moan, Practical symplectic
 * partitioned Runge-Kutta and Runge-Kutta-Nystrom methods, J. Comput. Appl. Math. 142 (2002), SRKN 11 of order 6. Where M is
 * constant and forces follow from positions, kicks v += b h a(q) and drifts q += c h v are Hamilton's motion with one part of
 * the energy at a time: nothing has to be solved.
 *
 * Steps are equal, or the energy error would grow. Their length is chosen once, by the energy error of steps of several lengths
 * over the span of a trial run. A row inside a step is a shorter step of its own, which the run does not feel.
 */
#include "methods/nystrom.h"

#include <math.h>
#include <string.h>

#include "methods/equal_steps.h"
#include "state/evaluate.h"
#include "state/state.h"
#include "steps/step.h"

enum { STAGES = 11, MOST_LENGTHS = 24, MOST_STEPS = 5000 };
static const double KICK[STAGES + 1] = {
    0.0414649985182624, 0.198128671918067, -0.0400061921041533, 0.0752539843015807, -0.0115113874206879, 0.2366699247869311,
    0.2366699247869311, -0.0115113874206879, 0.0752539843015807, -0.0400061921041533, 0.198128671918067, 0.0414649985182624,
};
static const double DRIFT[STAGES] = {
    0.123229775946271, 0.290553797799558, -0.127049212625417, -0.246331761062075, 0.357208872795928, 0.20477705429147008,
    0.357208872795928, -0.246331761062075, -0.127049212625417, 0.290553797799558, 0.123229775946271,
};
/* The longest step that is tried, by the shortest of the trial's; the next one by the one before. */
static const double LONGEST = 6, SHORTER = 0.8;

static void layout(void *self, const LagMotion *motion, LagArena *arena)
{
    LagNystrom *s = self;
    s->a = lag_take(arena, (size_t)motion->n);
    s->taken = lag_take(arena, (size_t)motion->n);
}

static void restart(void *self, LagMotion *m)
{
    LagNystrom *s = self;
    (void)m;
    s->h = 0;
    s->is_known = 0;
}

static int accelerations(LagMotion *m, double t, double *y, double *a)
{
    double power[2];
    ++m->evaluations;
    return m->rhs(m->context, t, y, y + m->n, a, power);
}

/* y += weight x, compensated. */
static void add(int n, double weight, const double *x, double *y, double *carry)
{
    for (int i = 0; i < n; ++i) {
        const double step = weight * x[i] + carry[i], sum = y[i] + step, taken = sum - y[i];
        carry[i] = (y[i] - (sum - taken)) + (step - taken);
        y[i] = sum;
    }
}

/* Moves the state y on by h; `a` holds its accelerations, and then those of the new one. Returns 0 when one is not finite. */
static int move(LagMotion *m, double t, double h, double *y, double *carry, double *a)
{
    const int n = m->n;
    double *v = y + n, *carry_v = carry + n;
    for (int i = 0; i < STAGES; ++i) {
        add(n, KICK[i] * h, a, v, carry_v);
        add(n, DRIFT[i] * h, v, y, carry);
        if (!accelerations(m, t, y, a))
            return 0;
    }
    add(n, KICK[STAGES] * h, a, v, carry_v);
    return 1;
}

/* The energy of the state y; *scale is raised to that of its parts. */
static double energy(LagRun *run, const double *y, double *scale)
{
    double energies[3];
    lag_energies(run, run->motion.t, y, energies);
    for (int i = 0; i < 3; ++i)
        *scale = fmax(*scale, fabs(energies[i]));
    return energies[2];
}

/* The largest change of energy in steps of length h over the trial's span, or its first MOST_STEPS, by the largest part. */
static double energy_error(LagRun *run, LagNystrom *s, double h, double span)
{
    LagMotion *m = &run->motion;
    const size_t size = (size_t)m->size * sizeof *m->y;
    double scale = 0, largest = 0;
    const double begin = energy(run, m->y, &scale);
    memcpy(m->other, m->y, size);
    memset(m->other_carry, 0, size);
    if (!accelerations(m, m->t, m->other, s->a))
        return INFINITY;
    for (int i = 0; i < MOST_STEPS && i * h < span && largest < INFINITY; ++i) {
        const int is_finite = move(m, m->t, h, m->other, m->other_carry, s->a);
        largest = is_finite ? fmax(largest, fabs(energy(run, m->other, &scale) - begin)) : INFINITY;
    }
    return scale > 0 ? largest / scale : largest;
}

/* The longest steps whose energy error is below the tolerance. */
static LagTrial choose(LagRun *run, LagNystrom *s)
{
    const LagTrial trial = lag_trial(run);
    if (trial.bends)
        return trial;
    s->h = LONGEST * trial.shortest;
    for (int i = 0; i < MOST_LENGTHS && !(energy_error(run, s, s->h, trial.span) <= run->settings.tolerance); ++i)
        s->h *= SHORTER;
    s->h = lag_equal_length(run, s->h);
    s->is_known = 0;
    return trial;
}

static int attempt(LagRun *run, double h, int is_cut)
{
    LagNystrom *s = &run->methods.nystrom;
    LagMotion *m = &run->motion;
    const size_t size = (size_t)m->size * sizeof *m->y;
    double *const taken = s->taken;
    (void)is_cut;
    if (!s->is_known && !accelerations(m, m->t, m->y, taken))
        return 0;
    s->is_known = 1;
    memcpy(m->other, m->y, size);
    memcpy(m->other_carry, m->carry, size);
    memcpy(s->a, taken, (size_t)m->n * sizeof *taken);
    if (!move(m, m->t, h, m->other, m->other_carry, s->a))
        return 0;
    s->taken = s->a;
    s->a = taken;
    return 1;
}

static LagStatus step(LagRun *run)
{
    LagNystrom *s = &run->methods.nystrom;
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

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagNystrom *s = self;
    const size_t size = (size_t)m->size * sizeof *y;
    memcpy(y, m->other, size);
    memcpy(m->sum, m->other_carry, size);
    accelerations(m, m->t_old, y, s->a);
    move(m, m->t_old, t - m->t_old, y, m->sum, s->a);
    ++m->dense_outputs;
}

const LagMethod lag_nystrom = {
    .name = "conservative", .order = 6, .layout = layout, .restart = restart, .step = step, .interpolate = interpolate,
    .stride = 1,
};
