/* A step is looked at in parts, each at five places, unless cubics through its ends tell that all guards are far. A part is halved where
 * positions do not follow there from the rates at these places (exact solvers go over many periods in one step; in a step of another
 * that went wrong they may do so nowhere), and where five values of a guard do not tell what it is between them.
 */
#include "run/guards.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "events/conditions.h"
#include "model/function.h"
#include "model/schedule.h"
#include "numbers/extremes.h"
#include "run/guard_values.h"
#include "state/attitudes.h"
#include "state/inside.h"
#include "state/state.h"

enum { PLACES = LAG_GUARD_VALUES, MOST_ITERATIONS = 100, PATIENCE = 5, ROUNDINGS = 256 };
static const double LEAST = 1.0 / (1 << 24), NARROWEST = 1.0 / 1024; /* of a step that is exact; of others, and of what motions ask for */
static const double SMOOTH = 0.01;
static const double DOUBT = 4; /* errors of a glimpse into a step */
static const double SHARE = 1; /* of a tolerance, by which states may be off: what is no farther beyond is not so for sure */

typedef struct {
    double low, high; /* shares of the step */
} Part;

typedef enum { INSIDE, BEYOND, SURELY_BEYOND } Side;

void lag_guards_layout(LagGuards *s, const LagModel *model, int size, LagArena *arena)
{
    const size_t count = (size_t)model->n_guards, state = count > 0 ? (size_t)size : 0;
    s->found = lag_take(arena, count + (size_t)model->n_seen);
    s->other = lag_take(arena, count + (size_t)model->n_seen);
    s->places = lag_take(arena, PLACES * count);
    s->states = lag_take(arena, count > 0 ? PLACES * 2 * (size_t)model->n : 0);
    s->told = lag_take(arena, count);
    s->passed = lag_take(arena, count);
    s->is_armed = lag_take_ints(arena, count);
    s->is_news = lag_take_ints(arena, count);
    s->state = lag_take(arena, state);
    s->beside = lag_take(arena, state);
    s->error = lag_take(arena, state);
}

static int kind_of(const LagModel *model, int i) { return model->guard_kinds[i] & (LAG_GUARD_OF_PARAMETERS - 1); }
static int is_of_parameters(const LagModel *model, int i) { return (model->guard_kinds[i] & LAG_GUARD_OF_PARAMETERS) != 0; }
/* The event that tells whether guard i ends the run; -1: its own number does. */
static int event_of(const LagModel *model, int i) { return model->guard_kinds[i] / LAG_GUARD_EVENTS - 1; }
static int ends(const LagModel *model, int i) { return kind_of(model, i) != LAG_GUARD_WARNING; }

/* What has no value does not hold; and does not come true. */
static int is_beyond(const LagModel *model, int i, double g) { return kind_of(model, i) == LAG_GUARD_END ? g < 0 : !(g >= 0); }

static int may_break(const LagRun *run, int i)
{
    const LagGuards *s = &run->guards;
    return kind_of(run->model, i) == LAG_GUARD_END ? s->is_armed[i] || event_of(run->model, i) >= 0 : ends(run->model, i) || isnan(s->told[i]);
}

/* Guards and what they compare, of the state y. */
static void look_at(LagRun *run, double t, const double *y, double *found)
{
    lag_guards_at(run, t, y, found);
    for (int i = 0; i < run->model->n_guards; ++i)
        if (event_of(run->model, i) >= 0)
            found[i] = t >= run->impacts.came[event_of(run->model, i)] ? -1 : 1;
}

static void look_inside(LagRun *run, double t)
{
    LagGuards *s = &run->guards;
    lag_held_state_inside(run, t, s->state);
    look_at(run, t, s->state, s->found);
}

/* By how much errors of the state that was looked at may change guard i. */
static double change_by(LagRun *run, double t, int i, const double *error)
{
    LagGuards *s = &run->guards;
    double most = 0;
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * run->model->n); ++pattern) {
        lag_conditions_disturb(run, s->state, error, pattern, s->beside);
        look_at(run, t, s->beside, s->other);
        most = lag_max(fabs(s->other[i] - s->found[i]), most);
    }
    return most;
}

/* By how much guard i may be off at the state that was looked at. */
static double unsure(LagRun *run, double t, int i)
{
    const double share = fmax(SHARE, ROUNDINGS * DBL_EPSILON / run->scale.tolerance);
    if (is_of_parameters(run->model, i))
        return 0;
    lag_conditions_units(run, run->guards.state, share, run->guards.error);
    return change_by(run, t, i, run->guards.error);
}

/* Whether resets have just set the rates of guard i, at the state that was looked at, to what it compares them with: only numbers that
 * do not come from the motion are known so well. */
static int is_on_level(LagRun *run, double t, int i)
{
    const int has_rule = run->model->guard_kinds[i] & (LAG_GUARD_HOLDS_ON_LEVEL | LAG_GUARD_BREAKS_ON_LEVEL);
    return has_rule && run->model->n_resets > 0 && t == run->impacts.struck &&
           fabs(run->guards.found[i]) < change_by(run, t, i, run->impacts.rounding);
}

/* Whether guard i is beyond at the state that was looked at, and for sure. */
static Side side_of(LagRun *run, double t, int i)
{
    const double g = run->guards.found[i];
    if (is_on_level(run, t, i))
        return run->model->guard_kinds[i] & LAG_GUARD_BREAKS_ON_LEVEL ? SURELY_BEYOND : INSIDE;
    if (!is_beyond(run->model, i, g))
        return INSIDE;
    return may_break(run, i) && (isnan(g) || -g > unsure(run, t, i)) ? SURELY_BEYOND : BEYOND;
}

static void warn(LagGuards *s, int i, double t)
{
    s->told[i] = t;
    s->is_news[i] = 1;
}

LagStatus lag_guards_tell(LagRun *run)
{
    const int i = run->guards.broken - 1;
    if (i < 0)
        return LAG_OK;
    lag_fail(run, kind_of(run->model, i) == LAG_GUARD_END ? LAG_ENDED : LAG_ASSERTED, i, 0, 0);
    run->failure.time = run->guards.end;
    return (LagStatus)run->failure.status;
}

static LagStatus end_at(LagRun *run, int i, double t)
{
    run->guards.broken = 1 + i;
    run->guards.end = t;
    return lag_guards_tell(run);
}

LagStatus lag_guards_of_parameters(LagRun *run)
{
    LagGuards *s = &run->guards;
    const LagModel *model = run->model;
    const double t = run->motion.t, *y = run->motion.y;
    const double *in[] = {&t, y, y + model->n, run->acceleration, run->multipliers, run->u, run->d, run->c};
    if (model->n_guards == 0)
        return LAG_OK;
    lag_call(&model->guards, in, &s->found, run->work);
    for (int i = 0; i < model->n_guards; ++i) {
        if (!is_of_parameters(model, i) || !may_break(run, i) || !is_beyond(model, i, s->found[i]))
            continue;
        if (ends(model, i))
            return end_at(run, i, t);
        warn(s, i, t);
    }
    return LAG_OK;
}

LagStatus lag_guards_reset(LagRun *run)
{
    LagGuards *s = &run->guards;
    s->broken = 0;
    s->end = INFINITY;
    s->row = NAN;
    for (int k = 0; k < run->model->n_whens; ++k)
        run->impacts.came[k] = NAN;
    for (int i = 0; i < run->model->n_guards; ++i) {
        s->told[i] = s->passed[i] = NAN;
        s->is_armed[i] = s->is_news[i] = 0;
    }
    return lag_guards_of_parameters(run);
}

static void arm(LagGuards *s, int i, Side side) { s->is_armed[i] |= side == INSIDE && !isnan(s->found[i]); }

LagStatus lag_guards_meet(LagRun *run, double t, const double *y)
{
    LagGuards *s = &run->guards;
    const LagModel *model = run->model;
    if (model->n_guards == 0 || s->broken)
        return lag_guards_tell(run);
    memcpy(s->state, y, 2 * (size_t)model->n * sizeof *y);
    look_at(run, t, s->state, s->found);
    for (int i = 0; i < model->n_guards; ++i) {
        const Side side = side_of(run, t, i);
        if (may_break(run, i) && side == SURELY_BEYOND) {
            if (ends(model, i))
                return end_at(run, i, t);
            warn(s, i, t);
        }
        arm(s, i, side);
    }
    return LAG_OK;
}

/* ---------------------------------------------------------------- within a step */

static double time_at(const LagRun *run, double share)
{
    const LagMotion *m = &run->motion;
    return share < 1 ? m->t_old + share * (m->t - m->t_old) : m->t;
}

static double share_of(Part part, int place) { return part.low + (part.high - part.low) * place / (PLACES - 1); }

static double *place(const LagRun *run, int k) { return run->guards.places + (size_t)k * (size_t)run->model->n_guards; }

static double *state(const LagRun *run, int k) { return run->guards.states + (size_t)k * 2 * (size_t)run->model->n; }

static void sample(LagRun *run, Part part, int k)
{
    look_inside(run, time_at(run, share_of(part, k)));
    memcpy(place(run, k), run->guards.found, (size_t)run->model->n_guards * sizeof(double));
    memcpy(state(run, k), run->guards.state, 2 * (size_t)run->model->n * sizeof(double));
    lag_attitudes_turn_slope(&run->motion, state(run, k), state(run, k) + run->model->n);
}

/* Whether a glimpse may tell of guards in the latest step: they are of the state alone, and nothing jumps or is held. */
static int is_plain(const LagRun *run)
{
    const LagMotion *m = &run->motion;
    const int is_struck = m->t == run->impacts.struck || m->t_old == run->impacts.struck;
    return run->methods.table->glimpse && !run->model->guards_need_acceleration && run->model->n_delays == 0 && !run->switches.is_live
        && run->sliding.count == 0 && !run->rests && !run->segment_over && !is_struck && m->t == m->t_end;
}

/* Guards at five places of a glimpse, and how far states may be off; 0: it cannot be had. */
static int glimpse(LagRun *run)
{
    LagGuards *s = &run->guards;
    for (int k = 0; k < PLACES; ++k) {
        const double x = share_of((Part){0, 1}, k);
        if (!run->methods.table->glimpse(run->methods.self, &run->motion, x, s->state, k < PLACES - 1 ? NULL : s->error))
            return 0;
        look_at(run, time_at(run, x), s->state, s->found);
        if (!lag_all_finite(s->found, run->model->n_guards))
            return 0;
        memcpy(place(run, k), s->found, (size_t)run->model->n_guards * sizeof(double));
    }
    for (int i = 0; i < 2 * run->model->n; ++i)
        s->error[i] *= DOUBT;
    return 1;
}

/* Guard i at the five places. */
static void values_of(const LagRun *run, int i, double *g)
{
    for (int k = 0; k < PLACES; ++k)
        g[k] = place(run, k)[i];
}

/* Whether guard i is farther off than it changes between five places, and by errors of the states; or asks for nothing more. */
static int is_far(const LagRun *run, int i, double change)
{
    double g[PLACES];
    values_of(run, i, g);
    return lag_guard_values_are_far(g, change) || is_of_parameters(run->model, i) || !(may_break(run, i) || kind_of(run->model, i) == LAG_GUARD_END);
}

/* Whether no guard is met in the latest step by far, as its ends and stages tell without further evaluations. */
static int are_far(LagRun *run)
{
    LagGuards *s = &run->guards;
    if (!is_plain(run) || !glimpse(run))
        return 0;
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * run->model->n); ++pattern) {
        lag_conditions_disturb(run, s->state, s->error, pattern, s->beside);
        look_at(run, run->motion.t, s->beside, s->other);
        for (int i = 0; i < run->model->n_guards; ++i)
            if (!is_far(run, i, fabs(s->other[i] - s->found[i])))
                return 0;
    }
    for (int i = 0; i < run->model->n_guards; ++i) {
        s->passed[i] = NAN;
        arm(s, i, INSIDE);
    }
    return 1;
}

/* The next part begins where this one ends. */
static void go_on(LagRun *run)
{
    memcpy(place(run, 0), place(run, PLACES - 1), (size_t)run->model->n_guards * sizeof(double));
    memcpy(state(run, 0), state(run, PLACES - 1), 2 * (size_t)run->model->n * sizeof(double));
}

/* Whether positions follow from rates, by Boole's rule. */
static int is_motion_told(const LagRun *run, Part part)
{
    static const double WEIGHTS[PLACES] = {7.0 / 90, 32.0 / 90, 12.0 / 90, 32.0 / 90, 7.0 / 90};
    const int n = run->model->n;
    const double h = (part.high - part.low) * (run->motion.t - run->motion.t_old);
    const double *first = state(run, 0), *last = state(run, PLACES - 1);
    for (int i = 0; i < n; ++i) {
        double sum = 0, size = 0;
        for (int k = 0; k < PLACES; ++k) {
            const double rate = h * WEIGHTS[k] * state(run, k)[n + i];
            sum += rate;
            size += fabs(rate);
        }
        if (!(fabs(last[i] - first[i] - sum) <= SMOOTH * size + lag_scale_unit(&run->scale, i, first, last)))
            return 0;
    }
    return 1;
}

/* Whether five places of a part tell of guard i between them. */
static int is_told(LagRun *run, Part part, int i)
{
    double g[PLACES];
    values_of(run, i, g);
    if (!may_break(run, i) || lag_guard_values_are_far(g, 0) || lag_guard_values_are_smooth(g))
        return 1;
    return lag_guard_values_change(g) <= unsure(run, time_at(run, part.high), i); /* rounding */
}

static int are_told(LagRun *run, Part part)
{
    for (int i = 0; i < run->model->n_guards; ++i)
        if (!is_told(run, part, i))
            return 0;
    return 1;
}

/* The place between two from which on guard i is beyond: by the regula falsi (Illinois), and halving where that is slow. */
static double find_root(LagRun *run, int i, double low, double high, double a, double b)
{
    const LagMotion *m = &run->motion;
    const double enough = fmax(4 * DBL_EPSILON, lag_time_resolution(m->t) / (m->t - m->t_old));
    int side = 0; /* that moved last: the value at the other one counts half when it stays again */
    for (int k = 1; k <= MOST_ITERATIONS && high - low > enough; ++k) {
        const double half = low + (high - low) / 2, guess = high - (high - low) * (b / (b - a));
        const double x = k % PATIENCE != 0 && guess > low && guess < high ? guess : half;
        look_inside(run, time_at(run, x));
        const double here = run->guards.found[i];
        const int now = is_beyond(run->model, i, here) ? 1 : -1;
        *(now > 0 ? &high : &low) = x;
        *(now > 0 ? &b : &a) = here;
        if (now == side)
            *(now > 0 ? &a : &b) *= 0.5;
        side = now;
    }
    return high;
}

/* From when on guard i is beyond, as it is at place k of a part, and was not at the one before; its number may say otherwise where
 * resets have put it on its level. */
static double passed_at(LagRun *run, Part part, int i, int k)
{
    if (k == 0 || !is_beyond(run->model, i, place(run, k)[i]))
        return time_at(run, share_of(part, k));
    if (is_beyond(run->model, i, place(run, k - 1)[i]))
        return time_at(run, share_of(part, k - 1));
    return time_at(run, find_root(run, i, share_of(part, k - 1), share_of(part, k), place(run, k - 1)[i], place(run, k)[i]));
}

/* When guard i breaks in a part, in the latest step; INFINITY: it does not. */
static double when_broken(LagRun *run, Part part, int i)
{
    LagGuards *s = &run->guards;
    for (int k = 0; k < PLACES; ++k) {
        const double t = time_at(run, share_of(part, k));
        if (is_beyond(run->model, i, place(run, k)[i]) || t == run->impacts.struck)
            look_inside(run, t);
        else
            s->found[i] = place(run, k)[i];
        const Side side = side_of(run, t, i);
        if (side == INSIDE)
            s->passed[i] = NAN;
        else if (may_break(run, i)) {
            if (isnan(s->passed[i]))
                s->passed[i] = passed_at(run, part, i, k);
            if (side == SURELY_BEYOND)
                return fmax(s->passed[i], run->motion.t_old);
        }
        arm(s, i, side);
    }
    return INFINITY;
}

/* What breaks first in a part ends the run, and warnings come until then. */
static void judge(LagRun *run, Part part)
{
    LagGuards *s = &run->guards;
    for (int i = 0; i < run->model->n_guards; ++i) {
        const double when = ends(run->model, i) ? when_broken(run, part, i) : INFINITY;
        if (when < s->end) {
            s->broken = 1 + i;
            s->end = when;
        }
    }
    for (int i = 0; i < run->model->n_guards; ++i) {
        const double when = ends(run->model, i) ? INFINITY : when_broken(run, part, i);
        if (when < INFINITY && when <= s->end)
            warn(s, i, when);
    }
}

int lag_guards_watch_motion(const LagModel *model)
{
    for (int i = 0; i < model->n_guards; ++i)
        if (!is_of_parameters(model, i))
            return 1;
    return 0;
}

void lag_guards_watch(LagRun *run)
{
    LagGuards *s = &run->guards;
    const double least = run->methods.table->attempt ? NARROWEST : LEAST;
    double width = 1, fine = 1;
    if (s->is_idle || !lag_guards_watch_motion(run->model))
        return;
    s->end = INFINITY;
    if (are_far(run))
        return;
    sample(run, (Part){0, 1}, 0);
    for (double low = 0; low < 1 && !s->broken;) {
        const Part part = {low, low + width < 1 ? low + width : 1};
        for (int k = 1; k < PLACES; ++k)
            sample(run, part, k);
        const int is_motion = width <= least || is_motion_told(run, part);
        if (!is_motion || (width > NARROWEST * fine && !are_told(run, part))) {
            width /= 2;
            fine = is_motion ? fine : width;
            continue;
        }
        judge(run, part);
        go_on(run);
        low = part.high;
        width *= 2;
    }
    if (s->broken)
        look_inside(run, s->end);
}

double lag_guards_pending(const LagRun *run)
{
    const LagGuards *s = &run->guards;
    double first = INFINITY;
    for (int i = 0; i < run->model->n_guards && !s->broken; ++i)
        if (ends(run->model, i) && may_break(run, i) && s->passed[i] > run->motion.t_old && s->passed[i] < run->motion.t)
            first = fmin(s->passed[i], first);
    return first;
}

double lag_guards_limit(const LagRun *run) { return run->guards.broken ? run->guards.end : run->motion.t; }

void lag_guards_forget(LagRun *run, double t)
{
    LagGuards *s = &run->guards;
    if (s->broken && s->end > t)
        s->broken = 0;
    if (s->row > t)
        s->row = NAN;
    for (int i = 0; i < run->model->n_guards; ++i) {
        if (s->passed[i] > t)
            s->passed[i] = NAN;
        if (event_of(run->model, i) >= 0 && run->impacts.came[event_of(run->model, i)] > t)
            run->impacts.came[event_of(run->model, i)] = NAN;
        if (s->told[i] > t) {
            s->told[i] = NAN;
            s->is_news[i] = 0;
        }
    }
}

int lag_run_warning(LagRun *run, double *t)
{
    LagGuards *s = &run->guards;
    for (int i = 0; i < run->model->n_guards; ++i)
        if (s->is_news[i]) {
            s->is_news[i] = 0;
            *t = s->told[i];
            return 1 + i;
        }
    return 0;
}

const double *lag_run_seen(const LagRun *run) { return run->guards.found + run->model->n_guards; }
