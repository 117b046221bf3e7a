#include "steps/roots.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "state/evaluate.h"
#include "model/function.h"
#include "state/inside.h"
#include "state/project.h"
#include "steps/segment.h"
#include "state/state.h"
#include "steps/step.h"
#include "state/stepper.h"
#include "steps/turns.h"

/* Of the larger one at the ends of a step, what lies under a root comes near to 0 within it: there the distance is a tenth. */
static const double NEAR = 0.01, HALF = 0.5, SUSPECT = LAG_ROOTS_SUSPECT;
enum { LOOKS = 5 };
/* Steps until something under a root is 0, and what they are of the longest of all, where they lead there. */
static const double FEW = 32, SHORT = 1e-3;

void lag_roots_layout(LagRoots *s, const LagModel *model, int size, LagArena *arena)
{
    const size_t count = (size_t)model->n_roots;
    double **const vectors[] = {&s->g, &s->rate, &s->g_old, &s->rate_old, &s->g_in, &s->rate_in, &s->g_ahead};
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
        *vectors[i] = lag_take(arena, count);
    s->state = lag_take(arena, count > 0 ? (size_t)size : 0);
}

/* Those that estimate errors from forces all over a step see it. */
static int may_miss(const LagRun *run)
{
    const int32_t solver = run->methods.solver;
    return run->model->n_roots > 0
        && (solver == LAG_SOLVER_TAYLOR || solver == LAG_SOLVER_PIRK || solver == LAG_SOLVER_ADAMS || solver == LAG_SOLVER_ERK9);
}

static void look_at(LagRun *run, double t, const double *y, double *g, double *rate)
{
    const double *in[] = {&t, y, y + run->model->n, run->u, run->d, run->c};
    double *out[] = {g, rate};
    lag_inputs_at(&run->inputs, t, run->u);
    lag_call(&run->model->roots, in, out, run->work);
}

/* The share of the step at which g of root i is least, by its parabola, and at most NEAR there; 0: it stays away from 0. The parabola
 * is made better by looking at its place. */
static double nearest(LagRun *run, int i)
{
    const LagMotion *m = &run->motion;
    LagRoots *s = &run->roots;
    const double h = m->t - m->t_old, near = NEAR * fmax(s->g_old[i], s->g[i]);
    double low = 0, high = 1, a = s->rate_old[i], b = s->rate[i];
    if (!(a < 0 && b > 0))
        return 0;
    for (int k = 0; k < LOOKS; ++k) {
        const double part = a / (a - b), x = low + (high - low) * fmin(fmax(part, 0.05), 0.95);
        lag_state_inside(run, m->t_old + x * h, s->state);
        look_at(run, m->t_old + x * h, s->state, s->g_in, s->rate_in);
        if (s->g_in[i] <= near)
            return x;
        if (s->rate_in[i] < 0) {
            low = x;
            a = s->rate_in[i];
        } else {
            high = x;
            b = s->rate_in[i];
        }
    }
    return 0;
}

/* Whether a parabola through both ends comes so near to 0 that it is worth a look. */
static int is_suspect(const LagRun *run, int i)
{
    const LagRoots *s = &run->roots;
    const double h = run->motion.t - run->motion.t_old, a = s->g_old[i], b = s->g[i], ra = h * s->rate_old[i], rb = h * s->rate[i];
    if (!(ra < 0 && rb > 0))
        return 0;
    return fmin(a + ra / 2 * (ra / (ra - rb)), b - rb / 2 * (rb / (rb - ra))) < SUSPECT * fmax(a, b);
}

/* g a few steps of length h ahead, if rates stay as they are. */
static void look_beyond(LagRun *run, double h)
{
    LagRoots *s = &run->roots;
    const LagMotion *m = &run->motion;
    memcpy(s->state, m->y, 2 * (size_t)m->n * sizeof *s->state);
    for (int i = 0; i < m->n; ++i)
        s->state[i] += h * m->y[m->n + i];
    look_at(run, m->t + h, s->state, s->g_ahead, s->rate_in);
}

int lag_roots_are_close(LagRun *run, double h)
{
    LagRoots *s = &run->roots;
    const int count = run->model->n_roots;
    if (count == 0 || !(h < SHORT * run->statistics.largest_step))
        return 0;
    look_at(run, run->motion.t, run->motion.y, s->g_in, s->rate_in);
    for (int i = 0; i < count; ++i)
        if (s->g_in[i] < FEW * h * fabs(s->rate_in[i]))
            return 1;
    look_beyond(run, FEW * h);
    for (int i = 0; i < count; ++i) /* where it is least it has no rate */
        if (s->g_in[i] < s->g_ahead[i] / 2)
            return 1;
    return 0;
}

void lag_roots_look(LagRun *run)
{
    LagRoots *s = &run->roots;
    look_at(run, run->motion.t, run->motion.y, s->g, s->rate);
    s->known = run->statistics.steps;
    s->events = run->statistics.events;
}

/* The beginning is mostly the end of the step before. */
static void look_at_ends(LagRun *run)
{
    const LagMotion *m = &run->motion;
    const LagStatistics *statistics = &run->statistics;
    LagRoots *s = &run->roots;
    const int is_known = s->known == statistics->steps - 1 && s->events == statistics->events && s->known > 0;
    lag_swap(&s->g, &s->g_old);
    lag_swap(&s->rate, &s->rate_old);
    if (!is_known)
        look_at(run, m->t_old, m->other, s->g_old, s->rate_old);
    lag_roots_look(run);
}

/* The share of the latest step at which it came near; 0: it did not. */
static double approach(LagRun *run)
{
    double x = 0;
    if (run->model->n_roots > 0)
        look_at_ends(run);
    for (int i = 0; i < run->model->n_roots && x == 0; ++i)
        x = is_suspect(run, i) ? nearest(run, i) : 0;
    return x;
}

int lag_roots_pass(LagRun *run)
{
    const LagRoots *s = &run->roots;
    if (run->model->n_roots > 0 && !(s->known == run->statistics.steps && s->events == run->statistics.events))
        look_at_ends(run);
    for (int i = 0; i < run->model->n_roots; ++i)
        if (fmin(s->g_old[i], s->g[i]) < SUSPECT * fmax(s->g_old[i], s->g[i]) || is_suspect(run, i))
            return 1;
    return 0;
}

int lag_roots_cross(LagRun *run)
{
    const LagMotion *m = &run->motion;
    LagSwitches *s = &run->switches;
    const int n = m->n, count = run->model->n_switches;
    if (count > 0) {
        lag_conditions_by(run, m->t_old, m->other, m->other + n, s->slope + n, s->g_begin, s->rate_begin);
        lag_conditions_by(run, m->t, m->y, m->y + n, s->slope + n, s->g, s->rate);
    }
    for (int i = 0; i < count; ++i)
        if (s->g_begin[i] * s->g[i] < 0)
            return 1;
    return approach(run) > 0;
}

void lag_roots_forget(LagRun *run) { run->roots.known = 0; }

void lag_roots_take_back(LagRun *run, double step)
{
    run->step = step;
    lag_motion_take_back(&run->motion);
    lag_project_forget(run);
    lag_roots_forget(run);
    --run->statistics.steps;
    ++run->statistics.rejected;
    run->segment_over = 0;
}

static void take_back(LagRun *run, double share)
{
    lag_roots_take_back(run, HALF * share * (run->motion.t - run->motion.t_old));
}

LagStatus lag_roots_leave(LagRun *run)
{
    lag_stepper_choose(run, run->choice.trouble(run, LAG_TROUBLE_CROSSED));
    run->choice.reset(run);
    const LagStatus status = lag_segment_evaluate(run);
    return status == LAG_OK ? run->methods.table->step(run) : status;
}

LagStatus lag_roots_watch(LagRun *run)
{
    const int is_equal = run->methods.solver == LAG_SOLVER_CONSERVATIVE;
    if (is_equal && lag_roots_cross(run)) {
        take_back(run, 1);
        return lag_roots_leave(run);
    }
    const double x = may_miss(run) ? approach(run) : 0;
    if (x == 0)
        return LAG_OK;
    take_back(run, x);
    return lag_turn_pass(run) ? run->methods.table->step(run) : lag_step_give_up(run, 0);
}
