/* The conditions are looked at at the end of a step, and the first place where one has changed is found in its dense output. One that
 * changes to and fro within a step is found by its rates at both ends (L.F. Shampine, S. Thompson, Event location for ordinary
 * differential equations, Comput. Math. Appl. 39 (2000)).
 */
#include "events/crossing.h"

#include <float.h>
#include <math.h>

#include "events/conditions.h"
#include "state/inside.h"
#include "model/schedule.h"

/* Of what it could move in a step at the pace of one of its ends: a length that is more at both does not reach 0 in between. */
static const double FAR = 0.6;
/* A dip to less than this share of what the condition is at the ends is looked at. */
static const double SHALLOW = 0.05, ROUNDING = 4 * DBL_EPSILON;
/* Where a part of a step is looked at to see whether a cubic describes conditions in it, and how far it may be off (distances have
 * corners: two balls may pass through each other); parts that are not made smaller; the least share of a step that the next one may
 * take for one part. */
static const double EARLY = 0.38, LATE = 0.73, ROUGH = 0.02, NARROWEST = 1.0 / 512, MOST_PARTS = 0.25;
/* Steps are looked at so when they have become so much longer, or so many were not; after one where that was in vain, when they are
 * much longer, or after a pause. */
static const double LONGER = 1.2, MUCH_LONGER = 16;
enum { LOOK_AGAIN = 8, PAUSE = 256, HALVINGS = 12, MOST_HALVINGS = 40, MOST_ITERATIONS = 100, DIP_ITERATIONS = 6, PATIENCE = 5 };

double lag_crossing_time(const LagRun *run, double share)
{
    const LagMotion *m = &run->motion;
    return share < 1 ? m->t_old + share * (m->t - m->t_old) : m->t;
}

/* Whether a condition has changed for sure. What rests at the corner of a spring is on both its sides by rounding, again and again;
 * what rests at a contact is held. */
static int is_beyond(const LagRun *run, int i, double depth)
{
    return depth < (lag_is_event(run->model, i) ? 0 : -run->switches.unknown[i]);
}

/* How far condition i is from changing; negative: it has. Events have some slack. */
static double depth_of(const LagRun *run, int i, const double *g)
{
    const double slack = lag_is_event(run->model, i) ? lag_slack(run->model, &run->impacts, i) : 0;
    return lag_depth(&run->switches, i, g) + slack;
}

/* s->state and s->g_inside there. */
static void look_at(LagRun *run, double x)
{
    LagSwitches *s = &run->switches;
    const double t = lag_crossing_time(run, x);
    lag_state_inside(run, t, s->state);
    lag_conditions(run, t, s->state, s->g_inside, s->rate_inside);
}

static double depth_at(LagRun *run, int i, double x)
{
    look_at(run, x);
    return depth_of(run, i, run->switches.g_inside);
}

static double pace_at(LagRun *run, int i, double x)
{
    LagSwitches *s = &run->switches;
    lag_conditions_with_rates(run, lag_crossing_time(run, x), s->state, s->g_inside, s->rate_inside);
    return lag_depth(s, i, s->rate_inside);
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

/* Its lowest place, where it goes down and up again in one bow, so far that it matters: where the tangents at its ends meet, which lies
 * below the bow. -1: it does not. */
static double dip(double a, double b, double ra, double rb)
{
    if (!(ra < 0 && rb > 0))
        return -1;
    const double meet = (a - b + rb) / (rb - ra), c2 = 3 * (b - a) - 2 * ra - rb, c3 = ra + rb - 2 * (b - a);
    if (!(meet > 0 && meet < 1 && a + ra * meet < SHALLOW * fmax(a, b)))
        return -1;
    const double lowest = -ra / (c2 + sqrt(fmax(c2 * c2 - 3 * c3 * ra, 0)));
    return lowest > 0 && lowest < 1 ? lowest : meet;
}

/* Whether one of the conditions comes nearer to its change at the beginning of a part of the step, and goes away from it at the end. */
static int turns(const LagRun *run)
{
    const LagSwitches *s = &run->switches;
    for (int i = 0; i < run->model->n_switches; ++i)
        if (lag_depth(s, i, s->rate_begin) < 0 && lag_depth(s, i, s->rate) > 0)
            return 1;
    return 0;
}

/* Of contacts, whose gaps are rounding where they are closed, how much of them cannot be told from none. */
static double closeness(const LagRun *run, int i)
{
    const int k = i - lag_when(run->model, 0);
    return lag_is_event(run->model, i) && run->impacts.has_contact[k] ? run->sliding.error[lag_gap(run->model, k)] : 0;
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
        if (!(fabs(cubic(a, b, ra, rb, x) - s->g_inside[i]) <= ROUGH * size + s->unknown[i] + closeness(run, i)))
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
    double low = part.low, high = part.high, a = depth_of(run, i, s->g_begin), b = depth_of(run, i, s->g);
    double ra = h * lag_depth(s, i, s->rate_begin), rb = h * lag_depth(s, i, s->rate);
    for (int k = 0; k < DIP_ITERATIONS; ++k) {
        const double share = dip(a, b, ra * (high - low), rb * (high - low)), x = low + share * (high - low);
        if (share < 0)
            return -1;
        const double here = depth_at(run, i, x);
        if (is_beyond(run, i, here))
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
    const int is_event = lag_is_event(run->model, i);
    const double enough = fmax(ROUNDING, lag_time_resolution(m->t) / (m->t - m->t_old)), begin = low;
    double a = depth_of(run, i, s->g_begin), b = depth_at(run, i, high);
    const double end = high;
    for (int k = 1; a < 0 && k <= (is_event ? MOST_HALVINGS : HALVINGS); ++k) {
        const double x = begin + ldexp((is_event ? end : high) - begin, -k), here = depth_at(run, i, x);
        *(here >= 0 ? &low : &high) = x;
        *(here >= 0 ? &a : &b) = here;
    }
    if (a < 0) /* an event comes a moment later, where what has just left is back */
        return is_event ? high : begin;
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

/* The first place in a part of the step where a condition changes; LAG_NOWHERE: there is none. */
static double find_in_part(LagRun *run, Part part)
{
    const LagSwitches *s = &run->switches;
    double first = LAG_NOWHERE;
    for (int i = 0; i < run->model->n_switches; ++i) {
        const double high = is_beyond(run, i, depth_of(run, i, s->g)) ? part.high : find_dip(run, i, part);
        if (high < 0 || (first < high && depth_at(run, i, first) >= 0))
            continue;
        first = find_root(run, i, part.low, fmin(first, high));
    }
    return first;
}

static void evaluate_end(LagRun *run, double x)
{
    LagSwitches *s = &run->switches;
    const double t = lag_crossing_time(run, x);
    lag_state_inside(run, t, s->state);
    lag_conditions_with_rates(run, t, s->state, s->g, s->rate);
}

/* Whether no other condition can have gone to and fro before a place that was found: up to there, cubics describe them. */
static int is_first(LagRun *run, Part part, double found)
{
    const Part before = {part.low, found};
    if (!(found > part.low))
        return 1;
    evaluate_end(run, found);
    return is_resolved(run, before);
}

/* How long steps may be for their conditions to be simple, after one that was looked at in parts. */
static void note_parts(LagRun *run, int was_due, double narrowest)
{
    LagSwitches *s = &run->switches;
    const double h = run->motion.t - run->motion.t_old;
    if (was_due) {
        s->resolved = narrowest * h;
        s->unlooked = 0;
    }
    if (narrowest <= NARROWEST) { /* in vain */
        s->resolved = h;
        s->unlooked = -PAUSE;
    } else if (narrowest < MOST_PARTS)
        run->step = fmin(run->step, narrowest / MOST_PARTS * h);
}

/* Whether all conditions are those of lengths, and none can have been 0 in the latest step, by its paces at both ends. */
static int are_far(LagRun *run)
{
    const LagSwitches *s = &run->switches;
    const double h = run->motion.t - run->motion.t_old;
    if (run->model->n_switches > run->model->n_lengths)
        return 0;
    evaluate_end(run, 1);
    for (int i = 0; i < run->model->n_lengths; ++i) {
        const double a = lag_depth(s, i, s->g_begin), b = lag_depth(s, i, s->g);
        if (!(fmin(a, b) > FAR * h * fmax(fabs(s->rate_begin[i]), fabs(s->rate[i]))))
            return 0;
    }
    return 1;
}

/* The same in the latest step. Where conditions go up and down in it (a cam that turns freely, sin(w t)) it is looked at in parts, and
 * the next one is not longer than a few of them. */
double lag_crossing_find(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const double h = run->motion.t - run->motion.t_old;
    const int may_hide = run->methods.solver == LAG_SOLVER_TAYLOR || run->model->conditions_know_time;
    const int is_long = run->model->n_whens > 0 && may_hide; /* a ball that grazes goes to and fro */
    const int is_paused = ++s->unlooked < 0 && h <= MUCH_LONGER * s->resolved;
    const int is_due = !is_paused && (is_long || h > LONGER * s->resolved || s->unlooked > LOOK_AGAIN);
    double width = 1, narrowest = 1;
    if (are_far(run))
        return LAG_NOWHERE;
    for (double low = 0; low < 1;) {
        const Part part = {low, low + width < 1 ? low + width : 1};
        evaluate_end(run, part.high);
        if ((is_due || (!is_paused && turns(run))) && !is_resolved(run, part) && width > NARROWEST) {
            width /= 2;
            narrowest = fmin(width, narrowest);
            continue;
        }
        const double found = find_in_part(run, part);
        if (found < LAG_NOWHERE && (is_paused || width <= NARROWEST || is_first(run, part, found)))
            return found;
        if (found < LAG_NOWHERE) {
            width /= 2;
            continue;
        }
        low = part.high;
        width *= 2;
        lag_swap(&s->g, &s->g_begin);
        lag_swap(&s->rate, &s->rate_begin);
    }
    lag_swap(&s->g, &s->g_begin); /* those of the end */
    lag_swap(&s->rate, &s->rate_begin);
    note_parts(run, is_due, narrowest);
    return LAG_NOWHERE;
}
