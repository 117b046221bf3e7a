/* The equations are smooth in each step, whatever conditions say in it: the force of a stop goes on as if there were no stop. At
 * its end the conditions are looked at, and where one has changed, the first such place in the step is found in its dense output.
 * One that changes to and fro within a step is found by its rates at both ends (L.F. Shampine, S. Thompson, Event location for
 * ordinary differential equations, Comput. Math. Appl. 39 (2000)).
 *
 * Where a condition changes back at once, again and again (a mass at rest at the corner of its spring, where rounding decides), steps
 * are taken for a while with conditions as they are at every evaluation, and step control makes the best of it.
 */
#include "switches.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "advance.h"
#include "extremes.h"
#include "function.h"
#include "schedule.h"
#include "state.h"

/* A dip to less than this share of what the condition is at the ends is looked at. */
static const double SHALLOW = 0.05, ROUNDING = 4 * DBL_EPSILON, NOWHERE = 2;
/* Where a part of a step is looked at to see whether a cubic describes conditions in it, and how far it may be off (distances have
 * corners: two balls may pass through each other); parts that are not made smaller; the least share of a step that the next one may
 * take for one part. */
static const double EARLY = 0.38, LATE = 0.73, ROUGH = 0.02, NARROWEST = 1.0 / 512, MOST_PARTS = 0.25;
/* Steps are looked at so when they have become so much longer, or so many were not. */
static const double LONGER = 1.2;
/* A switch that changes in every step changes to and fro when these are so short, by the longest of the run. */
static const double SOON = 1e-3;
enum { LOOK_AGAIN = 8, PAUSE = 256, PATTERNS = 3, ROUNDINGS = 256, HURRY = 5, FIRST_SPELL = 32, MOST_SPELL = 4096 };
enum { HALVINGS = 12, MOST_ITERATIONS = 100, DIP_ITERATIONS = 6, PATIENCE = 5 };

void lag_switches_layout(LagSwitches *s, const LagModel *model, int size, LagArena *arena)
{
    double **const vectors[] = {&s->held, &s->g, &s->rate, &s->g_begin, &s->rate_begin, &s->g_inside, &s->rate_inside,
                                &s->unknown};
    const size_t count = (size_t)model->n_switches;
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
        *vectors[i] = lag_take(arena, count);
    s->turned = lag_take_ints(arena, count);
    s->state = lag_take(arena, count > 0 ? (size_t)size : 0);
    s->slope = lag_take(arena, count > 0 ? (size_t)size : 0);
}

void lag_switches_forget(LagRun *run) { memset(run->switches.turned, 0, (size_t)run->model->n_switches * sizeof(int)); }

void lag_switches_reset(LagRun *run)
{
    LagSwitches *s = &run->switches;
    s->is_live = s->live_steps = s->hurried = 0;
    s->resolved = 0;
    s->unlooked = 0;
    s->spell = FIRST_SPELL;
    s->last = -1;
    memset(s->held, 0, (size_t)run->model->n_switches * sizeof *s->held);
    lag_switches_forget(run);
}

/* -------- what conditions are */

static void evaluate(LagRun *run, double t, const double *q, const double *v, double *g, double *rate)
{
    const double *in[] = {&t, q, v, run->switches.slope + run->model->n, run->u, run->d, run->c};
    double *out[] = {g, rate};
    lag_inputs_at(&run->inputs, t, run->u);
    lag_call(&run->model->switches, in, out, run->work);
}

/* With the rates. */
static void evaluate_whole(LagRun *run, double t, const double *y, double *g, double *rate)
{
    const int n = run->model->n;
    if (run->model->switches_need_acceleration)
        lag_motion_slope(&run->motion, t, y, y + n, run->switches.slope);
    evaluate(run, t, y, y + n, g, rate);
}

static double sign_of(double g) { return g > 0 ? 1 : g < 0 ? 0 : 0.5; }

void lag_switches_set(LagRun *run, double t, const double *q, const double *v)
{
    LagSwitches *s = &run->switches;
    double *d = run->d + run->model->n_modes;
    evaluate(run, t, q, v, s->g_inside, s->rate_inside);
    for (int i = 0; i < run->model->n_switches; ++i)
        d[i] = sign_of(s->g_inside[i]);
}

void lag_switches_recall(LagRun *run)
{
    memcpy(run->d + run->model->n_modes, run->switches.held, (size_t)run->model->n_switches * sizeof *run->d);
}

/* How much rounding of the state, as it adds up in steps, changes conditions: for some patterns of its signs. */
static void find_unknown(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const int n = run->model->n;
    const double *y = run->motion.y, share = ROUNDINGS * DBL_EPSILON / run->scale.tolerance;
    memset(s->unknown, 0, (size_t)run->model->n_switches * sizeof *s->unknown);
    for (int pattern = 0; pattern < PATTERNS; ++pattern) {
        for (int i = 0; i < 2 * n; ++i) {
            const double sign = (i >> pattern) % 2 == 0 ? 1 : -1;
            s->state[i] = y[i] + sign * share * lag_scale_unit(&run->scale, i, y, y);
        }
        evaluate(run, run->motion.t, s->state, s->state + n, s->g_inside, s->rate_inside);
        for (int i = 0; i < run->model->n_switches; ++i)
            s->unknown[i] = lag_max(fabs(s->g_inside[i] - s->g[i]), s->unknown[i]);
    }
}

/* What changes now, and what is neither, goes the way that it is going. */
int lag_switches_enter(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const int count = run->model->n_switches;
    const double *y = run->motion.y;
    int undecided = 0, turned = 0;
    if (count == 0)
        return 0;
    s->is_live = s->for_good || s->live_steps > 0 || !run->methods.table->holds_switches;
    evaluate(run, run->motion.t, y, y + run->model->n, s->g, s->rate);
    for (int i = 0; i < count; ++i) {
        s->held[i] = s->turned[i] ? 1 - s->held[i] : sign_of(s->g[i]);
        turned |= s->turned[i];
        undecided |= s->held[i] == 0.5;
    }
    lag_switches_recall(run);
    evaluate_whole(run, run->motion.t, y, s->g, s->rate);
    for (int i = 0; i < count; ++i)
        if (s->held[i] == 0.5)
            s->held[i] = s->rate[i] > 0;
    lag_switches_recall(run);
    if (undecided)
        evaluate_whole(run, run->motion.t, y, s->g, s->rate);
    find_unknown(run);
    lag_switches_forget(run);
    return turned;
}

int lag_switches_release(LagRun *run)
{
    LagSwitches *s = &run->switches;
    if (run->model->n_switches == 0 || s->is_live)
        return 0;
    s->is_live = s->live_steps = 1;
    return 1;
}

/* -------- where they change. x is the share of the latest step. */

/* How far a condition is from changing; negative: it has. */
static double depth(const LagSwitches *s, int i, const double *g) { return s->held[i] > 0 ? g[i] : -g[i]; }

/* Whether it has for sure. What rests at the corner of a spring is on both its sides by rounding, again and again. */
static int is_beyond(const LagSwitches *s, int i, double depth) { return depth < -s->unknown[i]; }

static double time_at(const LagRun *run, double x)
{
    const LagMotion *m = &run->motion;
    return x < 1 ? m->t_old + x * (m->t - m->t_old) : m->t;
}

/* s->state and s->g_inside there. */
static void look_at(LagRun *run, double x)
{
    LagSwitches *s = &run->switches;
    const double t = time_at(run, x);
    lag_state_inside(run, t, s->state);
    evaluate(run, t, s->state, s->state + run->model->n, s->g_inside, s->rate_inside);
}

static double depth_at(LagRun *run, int i, double x)
{
    look_at(run, x);
    return depth(&run->switches, i, run->switches.g_inside);
}

static double pace_at(LagRun *run, int i, double x)
{
    LagSwitches *s = &run->switches;
    evaluate_whole(run, time_at(run, x), s->state, s->g_inside, s->rate_inside);
    return depth(s, i, s->rate_inside);
}

/* A part of the step, from low to high: s->g_begin and s->rate_begin belong to its beginning, s->g and s->rate to its end. */
typedef struct {
    double low, high;
} Part;

/* The cubic with depths a, b and paces ra, rb (over its length 1) at its ends. */
static double cubic(double a, double b, double ra, double rb, double x)
{
    const double c2 = 3 * (b - a) - 2 * ra - rb, c3 = ra + rb - 2 * (b - a);
    return a + x * (ra + x * (c2 + x * c3));
}

/* Where the tangents at its ends meet, which lies below it if it goes down and up again in one bow; -1 where it does not, or not so
 * far that it matters. */
static double dip_of_tangents(double a, double b, double ra, double rb)
{
    if (!(ra < 0 && rb > 0))
        return -1;
    const double x = (a - b + rb) / (rb - ra);
    return x > 0 && x < 1 && a + ra * x < SHALLOW * fmax(a, b) ? x : -1;
}

/* Whether one of the conditions comes nearer to its change at the beginning of a part of the step, and goes away from it at the end. */
static int turns(const LagRun *run)
{
    const LagSwitches *s = &run->switches;
    for (int i = 0; i < run->model->n_switches; ++i)
        if (depth(s, i, s->rate_begin) < 0 && depth(s, i, s->rate) > 0)
            return 1;
    return 0;
}

/* Whether conditions at the share x of a part of the step are what cubics say. */
static int are_cubic(LagRun *run, Part part, double x)
{
    const LagSwitches *s = &run->switches;
    const double width = (part.high - part.low) * (run->motion.t - run->motion.t_old);
    look_at(run, part.low + x * (part.high - part.low));
    for (int i = 0; i < run->model->n_switches; ++i) {
        const double a = s->g_begin[i], b = s->g[i], ra = width * s->rate_begin[i], rb = width * s->rate[i];
        const double size = fmax(fmax(fabs(a), fabs(b)), fabs(s->g_inside[i]));
        if (!(fabs(cubic(a, b, ra, rb, x) - s->g_inside[i]) <= ROUGH * size + s->unknown[i]))
            return 0;
    }
    return 1;
}

static int is_resolved(LagRun *run, Part part) { return are_cubic(run, part, EARLY) && are_cubic(run, part, LATE); }

/* A place where a condition that holds at both ends does not; -1: none was found. */
static double find_dip(LagRun *run, int i, Part part)
{
    const LagSwitches *s = &run->switches;
    const double h = run->motion.t - run->motion.t_old;
    double low = part.low, high = part.high, a = depth(s, i, s->g_begin), b = depth(s, i, s->g);
    double ra = h * depth(s, i, s->rate_begin), rb = h * depth(s, i, s->rate);
    for (int k = 0; k < DIP_ITERATIONS; ++k) {
        const double share = dip_of_tangents(a, b, ra * (high - low), rb * (high - low)), x = low + share * (high - low);
        if (share < 0)
            return -1;
        const double here = depth_at(run, i, x);
        if (is_beyond(s, i, here))
            return x;
        const double pace = h * pace_at(run, i, x);
        if (pace < 0) {
            low = x;
            a = here;
            ra = pace;
        } else {
            high = x;
            b = here;
            rb = pace;
        }
    }
    return -1;
}

/* The place up to `high` from which on condition i has changed: by the regula falsi (Illinois), and halving where that is slow. What
 * has just changed may begin beyond its place by rounding. */
static double find_root(LagRun *run, int i, double low, double high)
{
    const LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    const double enough = fmax(ROUNDING, lag_time_resolution(m->t) / (m->t - m->t_old)), begin = low;
    double a = depth(s, i, s->g_begin), b = depth_at(run, i, high);
    for (int k = 1; a < 0 && k <= HALVINGS; ++k) {
        const double x = begin + ldexp(high - begin, -k), here = depth_at(run, i, x);
        *(here >= 0 ? &low : &high) = x;
        *(here >= 0 ? &a : &b) = here;
    }
    if (a < 0)
        return begin;
    int side = 0; /* that moved last: the value at the other one counts half when it stays again */
    for (int k = 1; k <= MOST_ITERATIONS && high - low > enough; ++k) {
        const double half = low + (high - low) / 2, guess = high - (high - low) * (b / (b - a));
        const double x = k % PATIENCE != 0 && guess > low && guess < high ? guess : half, here = depth_at(run, i, x);
        const int now = here < 0 ? 1 : -1;
        *(here < 0 ? &high : &low) = x;
        *(here < 0 ? &b : &a) = here;
        if (now == side)
            *(here < 0 ? &a : &b) *= 0.5;
        side = now;
    }
    return high;
}

/* The first place in a part of the step where a condition changes; NOWHERE: there is none. */
static double find_in_part(LagRun *run, Part part)
{
    const LagSwitches *s = &run->switches;
    double first = NOWHERE;
    for (int i = 0; i < run->model->n_switches; ++i) {
        const double high = is_beyond(s, i, depth(s, i, s->g)) ? part.high : find_dip(run, i, part);
        if (high < 0 || (first < high && depth_at(run, i, first) >= 0))
            continue;
        first = find_root(run, i, part.low, fmin(first, high));
    }
    return first;
}

static void evaluate_end(LagRun *run, double x)
{
    LagSwitches *s = &run->switches;
    const double t = time_at(run, x);
    lag_state_inside(run, t, s->state);
    evaluate_whole(run, t, s->state, s->g, s->rate);
}

/* The same in the latest step. Where conditions go up and down in it (a cam that turns freely, sin(w t)) it is looked at in parts, and
 * the next one is not longer than a few of them. */
static double find_first(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const double h = run->motion.t - run->motion.t_old;
    const int is_paused = ++s->unlooked < 0, is_due = !is_paused && (h > LONGER * s->resolved || s->unlooked > LOOK_AGAIN);
    double width = 1, narrowest = 1;
    for (double low = 0; low < 1;) {
        const Part part = {low, low + width < 1 ? low + width : 1};
        evaluate_end(run, part.high);
        if ((is_due || (!is_paused && turns(run))) && !is_resolved(run, part) && width > NARROWEST) {
            width /= 2;
            narrowest = fmin(width, narrowest);
            continue;
        }
        const double found = find_in_part(run, part);
        if (found < NOWHERE)
            return found;
        low = part.high;
        width *= 2;
        lag_swap(&s->g, &s->g_begin);
        lag_swap(&s->rate, &s->rate_begin);
    }
    lag_swap(&s->g, &s->g_begin); /* those of the end */
    lag_swap(&s->rate, &s->rate_begin);
    if (is_due) {
        s->resolved = narrowest * h;
        s->unlooked = 0;
    }
    if (narrowest <= NARROWEST) { /* in vain */
        s->resolved = h;
        s->unlooked = -PAUSE;
    } else if (narrowest < MOST_PARTS)
        run->step = fmin(run->step, narrowest / MOST_PARTS * h);
    return NOWHERE;
}

/* -------- what is done about it */

/* Notes which change at the present time. One that does so in step after short step is left to step control for a while. */
static void turn(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const double *y = run->motion.y;
    int first = -1;
    evaluate(run, run->motion.t, y, y + run->model->n, s->g, s->rate);
    for (int i = 0; i < run->model->n_switches; ++i) {
        s->turned[i] = depth(s, i, s->g) <= 0;
        first = first < 0 && s->turned[i] ? i : first;
    }
    const double since = run->motion.t - run->motion.t_old;
    const int stands = since <= lag_time_resolution(run->motion.t), is_soon = since < SOON * run->statistics.largest_step;
    s->hurried = stands || (first == s->last && is_soon) ? s->hurried + 1 : 0;
    s->last = first;
    if (s->hurried < HURRY)
        return;
    s->live_steps = s->spell;
    s->spell = s->spell < MOST_SPELL ? 2 * s->spell : s->spell;
    s->hurried = 0;
    s->last = -1;
}

static void watch_live(LagRun *run)
{
    LagSwitches *s = &run->switches;
    if (s->live_steps == 0 || --s->live_steps > 0)
        return;
    lag_switches_enter(run);
}

static void watch_held(LagRun *run)
{
    LagSwitches *s = &run->switches;
    lag_swap(&s->g, &s->g_begin);
    lag_swap(&s->rate, &s->rate_begin);
    const double x = find_first(run);
    if (x == NOWHERE) {
        s->hurried = 0;
        return;
    }
    if (x < 1)
        lag_go_back(run, time_at(run, x));
    turn(run);
    run->segment_over = 1;
}

void lag_switches_watch(LagRun *run)
{
    if (run->switches.is_live)
        watch_live(run);
    else
        watch_held(run);
}
