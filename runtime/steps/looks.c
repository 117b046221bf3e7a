#include "steps/looks.h"

#include <math.h>
#include <string.h>

#include "events/narrow.h"
#include "numbers/extremes.h"
#include "state/inside.h"
#include "state/project.h"
#include "state/scale.h"
#include "state/state.h"
#include "state/stepper.h"
#include "steps/roots.h"
#include "steps/step.h"
#include "steps/turns.h"

/* Widths in a step that its stages see. A place is as wide as g needs to change by 1, or by 1 about where it turns. */
static const double SEEN = 4;
static const double FAINT = -36;  /* g of exponentials that are rounding */
static const double QUIET = 1.5;  /* g that changes less in a step has nothing narrow in it */
static const double FINE = 0.1, NARROWER = 0.7;  /* change of g; share of a width that is tried next */
static const double APART = 1.5, OUTSIDE = 6, SHORTER = 0.9; /* widths, but for the last one: a share */
static const double FADED = 4;    /* change of g */
static const double BESIDE = 0.1, ROUND = 2; /* share of a width; change of g within one, at the sides of a square */
static const double UNIT = 1; /* of error that may be passed over */
enum { MOST_TRIES = 60, MOST_HALVINGS = 40, AROUND = 4 };

void lag_looks_layout(LagLooks *s, const LagModel *model, int size, LagArena *arena)
{
    const size_t count = (size_t)model->n_looks, of_state = count > 0 ? (size_t)size : 0;
    s->g = lag_take(arena, (LAG_LOOKS + 2) * count);
    s->pace = lag_take(arena, (LAG_LOOKS + 2) * count);
    s->ahead = lag_take(arena, count);
    s->state = lag_take(arena, of_state);
    s->slope = lag_take(arena, of_state);
    s->seen = lag_take(arena, LAG_SIGHTS * of_state);
}

/* The state at a share of the latest step by the cubics of its ends: near enough to see what lies on the way. Steps of series are so long
 * that it is not; they tell it at no cost. */
static double place(LagRun *run, double x)
{
    const LagMotion *m = &run->motion;
    double *y = run->looks.state;
    const double h = m->t - m->t_old;
    if (run->methods.solver == LAG_SOLVER_TAYLOR) {
        lag_state_inside(run, m->t_old + x * h, y);
        return m->t_old + x * h;
    }
    for (int i = 0; i < m->n; ++i) {
        const double a = m->other[i], way = m->y[i] - a, ra = h * m->other[m->n + i], rb = h * m->y[m->n + i];
        const double c2 = 3 * way - 2 * ra - rb, c3 = ra + rb - 2 * way;
        y[i] = a + x * (ra + x * (c2 + x * c3));
        y[m->n + i] = (ra + x * (2 * c2 + x * 3 * c3)) / h;
    }
    return m->t_old + x * h;
}

/* Switches that are live are those of the latest accelerations. */
static const double *state_at(LagRun *run, double x)
{
    const double t = place(run, x), *y = run->looks.state;
    if (run->switches.is_live)
        lag_motion_slope(&run->motion, t, y, y + run->model->n, run->looks.slope);
    return y;
}

static const LagNarrowView VIEW = {state_at, 1e-6};

typedef struct {
    double x, width; /* shares of the step; no width: there is none */
    double flank;    /* the width of its sides, where these are steeper */
} Narrow;

/* How far from x on both sides g of place i is another by 1, at most what all stages see: flat tops have no curvature. */
static double width_about(LagRun *run, int i, double x)
{
    LagLooks *s = &run->looks;
    double width = 1 / SEEN;
    lag_narrow_ask(run, &VIEW, x, s->ahead);
    const double middle = s->ahead[i];
    for (int round = 0; round < MOST_HALVINGS; ++round) {
        lag_narrow_ask(run, &VIEW, x - width, s->ahead);
        const double before = fabs(s->ahead[i] - middle);
        lag_narrow_ask(run, &VIEW, x + width, s->ahead);
        if (lag_max(before, fabs(s->ahead[i] - middle)) <= 1)
            break;
        width *= NARROWER;
    }
    return width;
}

/* The least way at x + width or x - width over which g of place i changes by as much as that of a square does: flat tops have steep
 * sides. */
static double flank_about(LagRun *run, int i, double x, double width)
{
    LagLooks *s = &run->looks;
    double rise = 0;
    for (int side = -1; side <= 1; side += 2) {
        lag_narrow_ask(run, &VIEW, x + side * width, s->ahead);
        const double here = s->ahead[i];
        lag_narrow_ask(run, &VIEW, x + side * (1 + BESIDE) * width, s->ahead);
        rise = lag_max(fabs(s->ahead[i] - here) / (BESIDE * width), rise);
    }
    return lag_min(ROUND / rise, width);
}

/* Where g of place i is 0 (or turns, if `turns`) after look k. */
static Narrow close_in(LagRun *run, int i, int k, int turns)
{
    LagLooks *s = &run->looks;
    const int count = run->model->n_looks;
    double *g = s->g + (size_t)((LAG_LOOKS + 1) * count);
    const double *all = (turns ? s->pace : s->g) + (size_t)(k * count + i);
    LagNarrowPart part = {(double)k / LAG_LOOKS, (k + 1.0) / LAG_LOOKS, all[0], all[count]};
    lag_narrow_close_in(run, &VIEW, i, turns, FINE, &part);
    const double length = part.high - part.low, x = part.low + length / 2;
    lag_narrow_ask(run, &VIEW, x, g);
    const double width = !turns ? length / fabs(part.after - part.before) : g[i] < FAINT ? 0 : width_about(run, i, x);
    return (Narrow){x, width, turns && width > 0 ? flank_about(run, i, x, width) : width};
}

/* Accelerations and powers, of which there are so many. */
static int seen_of(const LagMotion *m) { return m->size - m->n; }

/* These at a place of the step, into a row of `seen`. */
static int see(LagRun *run, double x, int row)
{
    LagMotion *m = &run->motion;
    LagLooks *s = &run->looks;
    const double t = place(run, x);
    const int count = seen_of(m);
    if (!lag_motion_slope(m, t, s->state, s->state + m->n, s->slope))
        return 0;
    memcpy(s->seen + (size_t)(row * count), s->slope + m->n, (size_t)count * sizeof *s->seen);
    return 1;
}

/* The largest that was seen of accelerations of the kind of i, or of powers. */
static double largest_seen(const LagRun *run, int i)
{
    const int n = run->motion.n, count = seen_of(&run->motion), *kind = run->scale.kind;
    double largest = 0;
    for (int row = 0; row < LAG_SIGHTS; ++row)
        for (int k = i < n ? 0 : n; k < (i < n ? n : count); ++k)
            if (i >= n || kind[k] == kind[i])
                largest = lag_max(fabs(run->looks.seen[row * count + k]), largest);
    return largest;
}

/* By how many units of error a step errs that misses so much of what i accelerates, or gives, for so long; where nothing of its kind has
 * moved yet, in units of what was seen of it. */
static double weigh(const LagRun *run, int i, double missed, double moment)
{
    const LagMotion *m = &run->motion;
    const LagScale *scale = &run->scale;
    const double h = m->t - m->t_old, change = fabs(missed) * moment;
    const double known = i < m->n ? lag_scale_unit(scale, m->n + i, m->other, m->y) : scale->tolerance * m->energy;
    const double way = i < m->n ? lag_scale_unit(scale, i, m->other, m->y) : 0;
    const double unit = known > 0 ? known : scale->tolerance * moment * largest_seen(run, i);
    return lag_max(unit > 0 ? change / unit : 0, way > 0 ? change * h / way : 0);
}

/* What a cubic through accelerations three and six widths away on both sides does not tell, in the middle and beside it. */
static double bump(LagRun *run, Narrow at)
{
    static const double AT[LAG_SIGHTS] = {-6, -3, 3, 6, 0, -0.8, 0.8};
    const LagLooks *s = &run->looks;
    const int count = seen_of(&run->motion);
    const double h = run->motion.t - run->motion.t_old;
    double most = 0;
    for (int k = 0; k < LAG_SIGHTS; ++k)
        if (!see(run, at.x + AT[k] * at.width, k))
            return 0;
    for (int k = AROUND; k < LAG_SIGHTS; ++k)
        for (int i = 0; i < count; ++i) {
            double told = 0;
            for (int j = 0; j < AROUND; ++j) {
                double share = 1;
                for (int l = 0; l < AROUND; ++l)
                    share *= l == j ? 1 : (AT[k] - AT[l]) / (AT[j] - AT[l]);
                told += share * s->seen[j * count + i];
            }
            most = lag_max(weigh(run, i, s->seen[k * count + i] - told, at.width * h), most);
        }
    return most;
}

/* The same at an end of the step, by the sixth differences of accelerations before or after it: there it fades. */
static double edge(LagRun *run, Narrow at)
{
    static const double WEIGHT[LAG_SIGHTS] = {1, -6, 15, -20, 15, -6, 1};
    const LagLooks *s = &run->looks;
    const int count = seen_of(&run->motion);
    const double way = (at.x > 0 ? -APART : APART) * at.width, h = run->motion.t - run->motion.t_old;
    double most = 0;
    for (int k = 0; k < LAG_SIGHTS; ++k)
        if (!see(run, at.x + k * way, k))
            return 0;
    for (int i = 0; i < count; ++i) {
        double missed = 0;
        for (int k = 0; k < LAG_SIGHTS; ++k)
            missed += WEIGHT[k] * s->seen[k * count + i];
        most = lag_max(weigh(run, i, missed, at.width * h), most);
    }
    return most;
}

static int is_passed_over(LagRun *run, Narrow at)
{
    if (!(at.width > 0 && SEEN * at.flank < 1))
        return 0;
    return (at.x > 0 && at.x < 1 ? bump(run, at) : edge(run, at)) > UNIT;
}

/* A narrow place at an end, which is left behind within the first look from there. */
static Narrow at_end(const LagRun *run, int i, int is_end)
{
    const LagLooks *s = &run->looks;
    const int count = run->model->n_looks, k = (is_end ? LAG_LOOKS * count : 0) + i;
    const double g = fabs(s->g[k]), beside = fabs(s->g[is_end ? k - count : k + count]);
    const double width = g < -FAINT && beside > g + FADED ? 1 / fabs(s->pace[k]) : 0;
    return (Narrow){is_end, width, width};
}

/* The first place that the latest step passed over, of those of function i; no width: it did not. */
static Narrow find(LagRun *run, int i)
{
    const LagLooks *s = &run->looks;
    const int count = run->model->n_looks;
    Narrow at = at_end(run, i, 0);
    const Narrow end = at_end(run, i, 1);
    if (is_passed_over(run, at))
        return at;
    for (int k = 0; k < LAG_LOOKS; ++k)
        for (int turns = 0; turns < 2; ++turns) {
            const double *all = (turns ? s->pace : s->g) + (size_t)(k * count + i);
            if ((all[0] < 0) == (all[count] < 0)) /* which may be 0 at a look itself, as in the middle of a run */
                continue;
            at = close_in(run, i, k, turns);
            if (is_passed_over(run, at))
                return at;
        }
    return is_passed_over(run, end) ? end : (Narrow){0, 0, 0};
}

/* Whether g of some place changes so much that something may lie between: at both ends of a swing it may stand still. */
static int is_suspect(LagRun *run)
{
    static const double AT[] = {0.29, 0.62, 1}; /* at no even distance, by which waves would look like none */
    LagLooks *s = &run->looks;
    const size_t count = (size_t)run->model->n_looks;
    double *change = s->pace;
    memset(change, 0, count * sizeof *change);
    lag_narrow_ask(run, &VIEW, 0, s->g);
    for (size_t k = 0; k < sizeof AT / sizeof *AT; ++k) {
        lag_narrow_ask(run, &VIEW, AT[k], s->ahead);
        for (size_t i = 0; i < count; ++i)
            change[i] += fabs(s->ahead[i] - s->g[i]);
        memcpy(s->g, s->ahead, count * sizeof *change);
    }
    return lag_largest(change, count) > QUIET;
}

static Narrow passed_over(LagRun *run)
{
    LagLooks *s = &run->looks;
    const int count = run->model->n_looks;
    Narrow first = {0, 0, 0};
    if (!is_suspect(run))
        return first;
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k <= LAG_LOOKS; ++k) /* closing in overwrites them */
            lag_narrow_look(run, &VIEW, (double)k / LAG_LOOKS, s->g + (size_t)(k * count), s->pace + (size_t)(k * count));
        const Narrow found = find(run, i);
        if (found.width > 0 && !(first.width > 0 && first.x < found.x))
            first = found;
    }
    return first;
}

/* When it is behind. */
static double end_of(const LagRun *run, Narrow at)
{
    return run->motion.t_old + (at.x + OUTSIDE * at.width) * (run->motion.t - run->motion.t_old);
}

/* To a few widths before it, or, from there, so short that stages see it. */
static double shorter_step(const LagRun *run, Narrow at)
{
    const double h = run->motion.t - run->motion.t_old;
    const double share = at.x > 2 * OUTSIDE * at.width ? at.x - OUTSIDE * at.width : SHORTER * SEEN * at.flank;
    return lag_min(share, SHORTER) * h;
}

static int begin_anew(LagRun *run)
{
    LagMotion *m = &run->motion;
    m->t_old = m->t;
    if (!lag_motion_slope(m, m->t, m->y, m->y + m->n, m->slope))
        return 0;
    run->methods.table->restart(run->methods.self, m);
    return 1;
}

static LagStatus again(LagRun *run, double step)
{
    const LagMethod *method = run->methods.table;
    lag_roots_take_back(run, step);
    const int is_ready = method->step != lag_step_adaptive && !method->take_back ? lag_turn_pass(run) : begin_anew(run);
    return is_ready ? run->methods.table->step(run) : lag_step_give_up(run, 0);
}

/* Steps of sweeps past another point, which their stages may not see: what they miss tells. */
static LagStatus watch_passes(LagRun *run)
{
    for (int k = 0; k < MOST_TRIES && run->methods.table->miss && lag_roots_pass(run); ++k) {
        const double step = SHORTER * (run->motion.t - run->motion.t_old) / 2;
        if (!(step > 2 * lag_step_smallest(run->motion.t_old)) || !(run->methods.table->miss(run->methods.self, &run->motion) > UNIT))
            return LAG_OK;
        const LagStatus status = again(run, step);
        if (status != LAG_OK)
            return status;
    }
    return LAG_OK;
}

LagStatus lag_looks_watch(LagRun *run)
{
    const LagStatus passed = watch_passes(run);
    if (passed != LAG_OK)
        return passed;
    if (run->model->n_looks == 0 || run->methods.table->is_exact)
        return LAG_OK;
    for (int k = 0; k < MOST_TRIES; ++k) {
        const Narrow at = passed_over(run);
        if (!(at.width > 0))
            return LAG_OK;
        const double step = shorter_step(run, at);
        if (!(step > 2 * lag_step_smallest(run->motion.t_old)))
            break;
        run->looks.until = end_of(run, at);
        run->looks.width = at.width * (run->motion.t - run->motion.t_old);
        if (run->methods.solver == LAG_SOLVER_CONSERVATIVE) {
            lag_roots_take_back(run, step);
            return lag_roots_leave(run);
        }
        const LagStatus status = again(run, step);
        if (status != LAG_OK)
            return status;
    }
    ++run->statistics.tolerance_missed;
    return LAG_OK;
}
