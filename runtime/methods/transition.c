/* A step leads to the next row, event or corner of the inputs. Times that are meant to be equally far apart are so but for rounding:
 * the state then moves by equal steps and lags behind its time by no more than the time's own rounding.
 *
 * Entries of exp(A h) that are wrong by eps change the slowest motions most: a free one by up to eps (norm t)^2 / 2 at the time t. In
 * 1 200 random scenes, stiff ones among them, it was at most 1/80 of eps (norm t)^2; their energy accounts asked for LOST. Where
 * doubles do not suffice, the run goes on by the method that it would have begun with otherwise.
 */
#include "methods/transition.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "state/evaluate.h"
#include "steps/segment.h"
#include "steps/step.h"
#include "state/stepper.h"

static const double SAME = 1e-9, IGNORED = 4 * DBL_EPSILON, LOST = 1.0 / 40; /* of eps (norm t)^2: allowed for */
enum { OFTEN = 4 }; /* steps of one length, after which it gets a rung of its own */

int lag_transition_fits(const LagModel *model, const LagSettings *settings)
{
    const int is_meant = model->solver == LAG_SOLVER_AUTO || model->solver == LAG_SOLVER_LINEAR;
    return settings->solver == LAG_SOLVER_AUTO && is_meant && isfinite(settings->t_stop) && lag_transition_possible(model);
}

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    LagTransition *s = self;
    lag_transition_layout(&s->matrices, ((const LagRun *)m->context)->model, arena);
    s->x = lag_take(arena, s->matrices.stride);
    s->sum = lag_take(arena, s->matrices.stride);
    s->loads = lag_take(arena, (size_t)s->matrices.pattern.n_w);
    s->loads_old = lag_take(arena, (size_t)s->matrices.pattern.n_w);
}

static void restart(void *self, LagMotion *m)
{
    LagTransition *s = self;
    (void)m;
    s->is_fresh = 1;
}

int lag_transition_serves(LagRun *run)
{
    LagTransition *s = &run->methods.transition;
    const LagSettings *settings = &run->settings;
    const double tolerance = fmax(settings->tolerance, LAG_SMALLEST_TOLERANCE);
    if (!lag_transition_build(&s->matrices, run->p, run->d))
        return 0;
    s->until = settings->t_start + sqrt(tolerance / (LOST * DBL_EPSILON)) / s->matrices.norm;
    return settings->t_stop <= s->until;
}

/* Equations and loads of the segment that begins. Returns 0 when this is not the method for them. */
static int begin(LagTransition *s, LagRun *run)
{
    s->is_fresh = 0;
    if (run->statistics.steps == 0) { /* a run does not depend on those before it */
        s->lag = s->usual = 0;
        s->times = s->matrices.is_planned = 0;
    }
    if (!lag_transition_serves(run))
        return 0;
    lag_transition_loads(&s->matrices, &run->inputs, run->motion.t, run->d, run->u, s->loads);
    return 1;
}

/* After a step of length h, of which some was no rung's. */
static void note_length(LagTransition *s, double h)
{
    s->times = fabs(h - s->usual) <= SAME * h ? s->times + 1 : 1;
    s->usual = h;
    if (s->times == OFTEN)
        lag_transition_plan(&s->matrices, h);
}

/* That state and its loads, moved on by h but for a rest of at most `ignored`. */
static LagMoving move(LagTransition *s, const LagMotion *m, const double *y, const double *loads, double h, double ignored)
{
    const size_t states = 2 * (size_t)m->n;
    LagMoving moving = {s->x, s->sum, {0, 0}, 0, 0};
    memcpy(s->x, y, states * sizeof *y);
    memcpy(s->x + states, loads, (size_t)s->matrices.pattern.n_w * sizeof *loads);
    if (!s->matrices.is_planned && !lag_transition_is_short(&s->matrices, h))
        lag_transition_plan(&s->matrices, h);
    lag_transition_move(&s->matrices, h, ignored, &moving);
    return moving;
}

/* Goes on by the method that comes next. */
static LagStatus leave(LagRun *run)
{
    lag_stepper_choose(run, run->choice.trouble(run, LAG_TROUBLE_HORIZON));
    run->choice.reset(run);
    const LagStatus status = lag_segment_evaluate(run);
    return status == LAG_OK ? run->methods.table->step(run) : status;
}

static LagStatus step(LagRun *run)
{
    LagTransition *s = run->methods.self;
    LagMotion *m = &run->motion;
    const double t = m->t, t_new = lag_step_aim(run), ignored = t_new == run->segment_end ? 0 : IGNORED * fabs(t_new);
    const size_t states = 2 * (size_t)m->n;
    if ((s->is_fresh && !begin(s, run)) || t_new > s->until)
        return leave(run);
    const LagMoving moving = move(s, m, m->y, s->loads, (t_new - t) + s->lag, ignored);
    if (moving.has_rest)
        note_length(s, t_new - t);
    memcpy(m->sum, moving.sum, states * sizeof *m->sum);
    memcpy(m->sum + states, moving.gain, (size_t)(m->size - 2 * m->n) * sizeof *m->sum);
    lag_motion_add(m, m->sum);
    if (!lag_all_finite(m->other, m->size))
        return lag_step_give_up(run, lag_first_not_finite(m->other, 2 * m->n));
    memcpy(s->loads_old, moving.x + states, (size_t)s->matrices.pattern.n_w * sizeof *s->loads);
    lag_swap(&s->loads, &s->loads_old);
    s->lag_old = s->lag;
    s->lag = moving.lag;
    lag_motion_take(m, t_new);
    lag_step_record(run, t_new - t);
    return LAG_OK;
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagTransition *s = self;
    const LagMoving moving = move(s, m, m->other, s->loads_old, (t - m->t_old) + s->lag_old, 0);
    for (int i = 0; i < 2 * m->n; ++i)
        y[i] = m->other[i] + moving.sum[i];
    for (int i = 2 * m->n; i < m->size; ++i)
        y[i] = m->other[i] + moving.gain[i - 2 * m->n];
    ++m->dense_outputs;
}

const LagMethod lag_transition = {
    .name = "linear", .order = 8, .layout = layout, .restart = restart, .step = step, .interpolate = interpolate, .stride = 1,
    .is_exact = 1,
};
