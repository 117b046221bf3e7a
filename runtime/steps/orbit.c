#include "steps/orbit.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "numbers/jets.h"
#include "steps/step.h"
#include "state/stepper.h"

/* At a turn all rates are 0 but for their errors; where they are not, only one coordinate has turned, and others go on: each by the
 * measure of its own rates, as one may be slow where another is quick. Below NOTHING of all rates it hardly moves. */
static const double RESTS = 100, RESTS_AT_LEAST = 1e-8, RESTS_AT_MOST = 0.02, NOTHING = 1e-10;
enum { ROOT_ITERATIONS = 60 };

static int can_swing(const LagModel *model, const LagSettings *settings)
{
    return model->is_swing && settings->solver == LAG_SOLVER_AUTO && model->solver == LAG_SOLVER_AUTO && model->n_switches == model->n_lengths;
}

void lag_orbit_layout(LagOrbit *s, const LagModel *model, const LagSettings *settings, LagArena *arena)
{
    const size_t states = 2 * (size_t)model->n, steps = can_swing(model, settings) ? LAG_ORBIT_STEPS : 0;
    s->room = model->n_jets > 0 ? states * LAG_JET_STRIDE : LAG_RECORD_HEAD + states * LAG_RECORD_ROWS;
    s->begin = lag_take(arena, steps + 1);
    s->kept = lag_take(arena, steps * s->room);
    s->y = lag_take(arena, states);
}

void lag_orbit_restart(LagRun *run)
{
    LagOrbit *s = &run->orbit;
    const LagMotion *m = &run->motion;
    s->is_open = can_swing(run->model, &run->settings) && run->methods.table->record;
    s->solver = run->methods.solver;
    s->count = 0;
    s->has_turned = m->n > 0 && lag_largest(m->y + m->n, (size_t)m->n) == 0;
    s->first = m->t;
}

/* ---------------------------------------------------------------- steps that are kept */

static void keep(LagRun *run)
{
    LagOrbit *s = &run->orbit;
    const LagMotion *m = &run->motion;
    if (!s->has_turned)
        s->count = 0;
    s->begin[s->count] = m->t_old;
    s->begin[s->count + 1] = m->t;
    run->methods.table->record->keep(run->methods.self, &run->motion, s->kept + (size_t)s->count * s->room);
    ++s->count;
}

/* The state at t, inside step k. */
static void recall(LagRun *run, int k, double t, double *y)
{
    const LagOrbit *s = &run->orbit;
    const LagStepper base = lag_stepper_of(run, s->solver);
    const double begin = s->begin[k], length = s->begin[k + 1] - begin;
    const int was_careful = run->careful;
    run->careful = run->model->n_multipliers > 0; /* as in lag_state_inside */
    base.table->record->recall(base.self, &run->motion, s->kept + (size_t)k * s->room, begin, length, t, y);
    run->careful = was_careful;
}

/* ---------------------------------------------------------------- turns */

/* The rate that is largest at the end of the latest step, in units of its kind. */
static int leading(const LagRun *run)
{
    const LagMotion *m = &run->motion;
    const double *size = run->scale.group + run->scale.kinds;
    double most = 0;
    int leader = 0;
    for (int i = 0; i < m->n; ++i) {
        const double share = fabs(m->y[m->n + i]) / size[run->scale.kind[i]];
        if (share > most) {
            most = share;
            leader = i;
        }
    }
    return leader;
}

/* Where a rate passes 0 in the latest step: regula falsi, weighed as by M. Dowell, P. Jarratt, BIT 11 (1971). */
static double root(LagRun *run, int i)
{
    LagOrbit *s = &run->orbit;
    const LagMotion *m = &run->motion;
    double a = m->t_old, b = m->t, at_a = m->other[m->n + i], at_b = m->y[m->n + i], t = b;
    for (int k = 0; k < ROOT_ITERATIONS; ++k) {
        t = b - at_b * (b - a) / (at_b - at_a);
        if (!(t > fmin(a, b) && t < fmax(a, b)))
            break;
        recall(run, s->count - 1, t, s->y);
        const double rate = s->y[m->n + i];
        if (rate == 0)
            break;
        if ((rate < 0) != (at_b < 0)) {
            a = b;
            at_a = at_b;
        } else {
            at_a /= 2;
        }
        b = t;
        at_b = rate;
    }
    return t;
}

/* Whether all rests in orbit.y. */
static int rests(const LagRun *run)
{
    const int n = run->motion.n;
    const double *size = run->scale.group + run->scale.kinds;
    const double share = fmin(fmax(RESTS * run->scale.tolerance, RESTS_AT_LEAST), RESTS_AT_MOST);
    for (int i = 0; i < n; ++i)
        if (!(fabs(run->orbit.y[n + i]) <= lag_max(share * run->scale.largest[n + i], NOTHING * size[run->scale.kind[i]])))
            return 0;
    return 1;
}

static void turn(LagRun *run, double t)
{
    LagOrbit *s = &run->orbit;
    if (!s->has_turned) {
        s->has_turned = 1;
        s->first = t;
        return;
    }
    s->span = t - s->first;
    s->is_open = 0;
    if (s->span > 0) {
        lag_stepper_choose(run, run->choice.trouble(run, LAG_TROUBLE_SWING));
        run->stiffness.is_watching = 0;
    }
}

void lag_orbit_follow(LagRun *run)
{
    LagOrbit *s = &run->orbit;
    const LagMotion *m = &run->motion;
    if (run->methods.solver != s->solver || s->count == LAG_ORBIT_STEPS) {
        s->is_open = 0;
        return;
    }
    const int i = leading(run), is_reversed = m->y[m->n + i] * m->other[m->n + i] < 0;
    if (is_reversed || s->has_turned)
        keep(run);
    if (is_reversed) {
        const double t = root(run, i);
        recall(run, s->count - 1, t, s->y);
        if (rests(run))
            turn(run, t);
    }
}

/* ---------------------------------------------------------------- steps that are read */

/* The step that t falls into; the first or the last where it lies outside by rounding. */
static int find(const LagOrbit *s, double t)
{
    int low = 0, high = s->count - 1;
    while (low < high) {
        const int middle = (low + high + 1) / 2;
        if (s->begin[middle] <= t)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

static void read_state(LagRun *run, double t, double *y)
{
    const LagOrbit *s = &run->orbit;
    const double whole = 2 * s->span, u = fmod(t - s->first, whole), ahead = u < 0 ? u + whole : u;
    const int is_back = ahead > s->span;
    const double inside = s->first + (is_back ? whole - ahead : ahead);
    recall(run, find(s, inside), inside, y);
    for (int i = run->motion.n; is_back && i < 2 * run->motion.n; ++i)
        y[i] = -y[i];
}

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    (void)self, (void)m, (void)arena;
}

/* What changes the state or the equations goes on by steps. */
static void restart(void *self, LagMotion *m)
{
    (void)self, (void)m;
}

/* Where nobody watches the motion, rows are read from a step as long as there are any to come: half a swing without events is followed
 * by others without. */
static double end_of_step(const LagRun *run)
{
    const LagSettings *settings = &run->settings;
    const double end = lag_min(run->segment_end, settings->t_stop);
    return isinf(end) || settings->max_step > 0 || run->model->n_guards > 0 ? lag_step_aim(run) : end;
}

static LagStatus step(LagRun *run)
{
    LagMotion *m = &run->motion;
    const double t = m->t, t_new = end_of_step(run);
    read_state(run, t_new, m->other);
    memset(m->other_carry, 0, 2 * (size_t)m->n * sizeof *m->other_carry);
    lag_project_forget(run);
    lag_motion_take(m, t_new);
    lag_step_record(run, t_new - t);
    return LAG_OK;
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    (void)self;
    read_state(m->context, t, y);
    ++m->dense_outputs;
}

const LagMethod lag_orbit = {
    .name = "orbit", .order = 8, .layout = layout, .restart = restart, .step = step, .interpolate = interpolate, .stride = 1,
    .is_exact = 1,
};
