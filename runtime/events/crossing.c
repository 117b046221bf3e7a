/* The conditions are looked at at the end of a step, and the first place where one has changed is found in its dense output. One that
 * changes to and fro within a step is found by its rates at both ends (L.F. Shampine, S. Thompson, Event location for ordinary
 * differential equations, Comput. Math. Appl. 39 (2000)).
 */
#include "events/crossing.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "events/hiding.h"
#include "events/standing.h"
#include "numbers/extremes.h"
#include "state/inside.h"
#include "model/schedule.h"

/* Of what it could move in a step at the pace of one of its ends: a length that is more at both does not reach 0 in between. */
static const double FAR = 0.6;
/* By what a condition has to go farther at the pace of an end of a step than it is from its change, to be looked at in between. */
static const double STRAYS = 4;
/* A dip to less than this share of what the condition is at the ends is looked at. */
static const double SHALLOW = LAG_CROSSING_SHALLOW, ROUNDING = 4 * DBL_EPSILON, NOISE = 1e-3, SHARE = 32 * DBL_EPSILON, CHORD = 64,
                    STRIDE = 4, SLOW = 0.5, OF_RATE = 1.0 / 64;
/* Where a part of a step is looked at to see whether a cubic describes conditions in it, and how far it may be off (distances have
 * corners: two balls may pass through each other); parts that are not made smaller; the least share of a step that the next one may
 * take for one part. */
static const double EARLY = LAG_CROSSING_EARLY, LATE = LAG_CROSSING_LATE, ROUGH = LAG_CROSSING_ROUGH, NARROWEST = 1.0 / 512, MOST_PARTS = 0.25;
/* Steps are looked at so when they have become so much longer, or so many were not; after one where that was in vain, when they are
 * much longer, or after a pause. */
static const double LONGER = 1.2, MUCH_LONGER = 16;
enum { LOOK_AGAIN = 8, PAUSE = 256, HALVINGS = 12, MOST_HALVINGS = 40, MOST_ITERATIONS = 300, PATIENCE = 5 };
enum { DIP_ITERATIONS = 6, MOST_DIP_ITERATIONS = 48, NEWTON_ITERATIONS = 16 };

double lag_crossing_time(const LagRun *run, double share)
{
    const LagMotion *m = &run->motion;
    return share < 1 ? m->t_old + share * (m->t - m->t_old) : m->t;
}

/* Those before this one may change: behind them are gaps, and what does not rest, which are said to be far where nothing is held. */
static inline int watched_end(const LagRun *run) { return run->sliding.count > 0 ? run->model->n_switches : lag_gap(run->model, 0); }

/* Whether a condition has changed for sure. What rests at the corner of a spring is on both its sides by rounding, again and again;
 * what rests at a contact is held. */
static int is_beyond(const LagRun *run, int i, double depth)
{
    return depth < (lag_is_event(run->model, i) ? 0 : -run->switches.unknown[i]);
}

/* How far condition i is from changing; negative: it has. Events have some slack, what stands has rounding, and shares of what slides, so that
 * what is torn off has more than rounding to move by. */
static double depth_of(const LagRun *run, int i, const double *g)
{
    const LagSwitches *s = &run->switches;
    const double share = s->slides[i] ? SHARE : s->stands[i] && s->held[i] == 0.5 ? s->unknown[i] : 0;
    const double slack = lag_is_event(run->model, i) ? lag_slack(run->model, &run->impacts, i) : share;
    return lag_depth(&run->switches, i, g) + slack;
}

/* The state there, into s->state; what stands is held to its level by what slides, as at the ends of steps. */
static void find_state(LagRun *run, double t)
{
    if (lag_standing_is_held(run))
        lag_held_state_inside(run, t, run->switches.state);
    else
        lag_state_inside(run, t, run->switches.state);
}

/* s->state and s->g_inside there. */
static void look_at(LagRun *run, double x)
{
    LagSwitches *s = &run->switches;
    const double t = lag_crossing_time(run, x);
    find_state(run, t);
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
    if (!(meet > 0 && meet < 1 && a + ra * meet < SHALLOW * lag_max(a, b)))
        return -1;
    const double lowest = -ra / (c2 + sqrt(lag_max(c2 * c2 - 3 * c3 * ra, 0)));
    return lowest > 0 && lowest < 1 ? lowest : meet;
}

/* Whether one of the conditions comes nearer to its change at the beginning of a part of the step, of that width in s, and goes away from it
 * at the end; or is as quick as if it did, as what swings is. */
static int turns(const LagRun *run, double width)
{
    const LagSwitches *s = &run->switches;
    const int end = watched_end(run);
    for (int i = 0; i < end; ++i) {
        const double size = lag_max(fabs(s->g_begin[i]), fabs(s->g[i])) + s->unknown[i];
        const double way = width * lag_max(fabs(s->rate_begin[i]), fabs(s->rate[i]));
        if ((lag_depth(s, i, s->rate_begin) < 0 && lag_depth(s, i, s->rate) > 0) || way > STRAYS * size)
            return 1;
    }
    return 0;
}

/* Of contacts, whose gaps are rounding where they are closed, how much of them cannot be told from none. */
static double closeness(const LagRun *run, int i)
{
    const int k = i - lag_when(run->model, 0);
    return lag_is_event(run->model, i) && run->impacts.has_contact[k] ? run->sliding.error[lag_gap(run->model, k)] : 0;
}

/* How well cubics describe conditions in a part of a step: some are off; as far as parts need; as well as conditions are known. */
typedef enum { UNLIKE, ROUGHLY, TO_ROUNDING } Likeness;

/* The likeness at the share x of the part. */
static Likeness look_for_cubics(LagRun *run, Part part, double x)
{
    const LagSwitches *s = &run->switches;
    const int end = watched_end(run);
    const double width = (part.high - part.low) * (run->motion.t - run->motion.t_old);
    Likeness found = TO_ROUNDING;
    look_at(run, part.low + x * (part.high - part.low));
    for (int i = 0; i < end; ++i) {
        const double a = s->g_begin[i], b = s->g[i], ra = width * s->rate_begin[i], rb = width * s->rate[i];
        const double size = lag_max(lag_max(fabs(a), fabs(b)), fabs(s->g_inside[i]));
        const double miss = fabs(cubic(a, b, ra, rb, x) - s->g_inside[i]);
        if (!(miss <= s->unknown[i])) {
            if (!(miss <= ROUGH * size + s->unknown[i] + closeness(run, i)))
                return UNLIKE;
            found = ROUGHLY;
        }
    }
    return found;
}

static Likeness resolve(LagRun *run, Part part)
{
    const Likeness early = look_for_cubics(run, part, EARLY), late = early ? look_for_cubics(run, part, LATE) : UNLIKE;
    return early < late ? early : late;
}

/* A place where a condition that holds at both ends does not; -1: none was found. Where it has a corner, as |x - a| < d, no cubic leads
 * there, and the part is halved. One so near the beginning that times cannot be told apart is none: what begins at its change with a force
 * from nothing, whose length counts as 1e-150, goes down by that. */
static double find_dip(LagRun *run, int i, Part part)
{
    const LagSwitches *s = &run->switches;
    const double h = run->motion.t - run->motion.t_old;
    double low = part.low, high = part.high, a = depth_of(run, i, s->g_begin), b = depth_of(run, i, s->g);
    double ra = h * lag_depth(s, i, s->rate_begin), rb = h * lag_depth(s, i, s->rate);
    for (int k = 0; k < MOST_DIP_ITERATIONS; ++k) {
        const double lowest = dip(a, b, ra * (high - low), rb * (high - low)), share = k < DIP_ITERATIONS ? lowest : 0.5;
        const double x = low + share * (high - low);
        if (lowest < 0 || x - part.low <= ROUNDING)
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

/* A place in the step, how far a condition is from its change there, its pace in a step and, where it was foreseen, how that changes. */
typedef struct {
    double x, depth, pace, bend;
} Sight;

/* Where the cubic of a part's ends changes between two places of it; whatever it does besides, a place between them. */
static Sight foresee(const LagRun *run, int i, Part part, double low, double high)
{
    const LagSwitches *s = &run->switches;
    const double width = part.high - part.low, h = width * (run->motion.t - run->motion.t_old);
    const double a = depth_of(run, i, s->g_begin), b = depth_of(run, i, s->g);
    const double ra = h * lag_depth(s, i, s->rate_begin), rb = h * lag_depth(s, i, s->rate);
    const double c2 = 3 * (b - a) - 2 * ra - rb, c3 = ra + rb - 2 * (b - a);
    double left = (low - part.low) / width, right = (high - part.low) / width, x = left + (right - left) / 2, pace = 0;
    for (int k = 0; k < NEWTON_ITERATIONS; ++k) {
        const double depth = cubic(a, b, ra, rb, x);
        pace = ra + x * (2 * c2 + x * 3 * c3);
        *(depth < 0 ? &right : &left) = x;
        const double next = x - depth / pace;
        if (fabs(next - x) <= DBL_EPSILON)
            break;
        x = next > left && next < right ? next : left + (right - left) / 2;
    }
    return (Sight){part.low + x * width, 0, pace / width, (2 * c2 + 6 * c3 * x) / (width * width)};
}

/* Conditions inside become those on that side of the place that is looked for. */
static Sight look_beside(LagRun *run, int i, double x)
{
    LagSwitches *s = &run->switches;
    const Sight here = {x, depth_at(run, i, x), 0, 0};
    lag_swap(&s->g_inside, here.depth < 0 ? &s->g_after : &s->g_before);
    return here;
}

/* A moment beyond the place where the condition changes by its pace, so that it comes to lie between here and there. */
static double beyond(Sight here, double moment)
{
    const double way = -here.depth / here.pace, sense = here.depth < 0 ? -1 : 1;
    return here.x + (sense * way > 0 ? way : 0) + sense * moment;
}

/* What rounding makes of the condition of an event. */
static double rounding_of(const LagRun *run, int i)
{
    const double rounding = lag_conditions_error(run, run->switches.unknown[i]) * DBL_EPSILON / run->scale.tolerance;
    return lag_is_event(run->model, i) ? rounding : 0;
}

/* How late contact i may close: as much as its place is rounding, where its rate changes by less than can be told of it. */
static double lateness_of(const LagRun *run, int i, double stair, double bend)
{
    const int k = i - lag_when(run->model, 0);
    if (!lag_is_event(run->model, i) || run->impacts.has_contact[k] != LAG_CONTACT)
        return 0;
    const double h = run->motion.t - run->motion.t_old, known = run->sliding.error[lag_contact(run->model, k)];
    return lag_min(OF_RATE * known * h / fabs(bend), stair);
}

/* The place between low and high where condition i changes, to `enough`, or to rounding of a share: by the cubic and by chords, over stairs
 * by ever longer ways and then by halving, and halving where chords are slow. Conditions at both are known, and are then those on both sides
 * of it. Places of events are not left to rounding of their conditions: one in a hundred runs of a ball that comes to rest on a shaken
 * table met events without end so. Contacts may be late by as much as nobody can tell: a ball's last bounces were halvings of one stair. */
static double close_in(LagRun *run, int i, Part part, Sight low, Sight high, double enough)
{
    const double noise = run->switches.slides[i] ? SHARE : 0;
    Sight last = foresee(run, i, part, low.x, high.x); /* a chord from there to itself has the pace of the cubic */
    const double part_of_all = NOISE * (high.x - low.x), least = lag_max(enough, lag_min(fabs(noise / last.pace), part_of_all)) / 2;
    const double rounding = rounding_of(run, i), stair = lag_min(fabs(rounding / last.pace), part_of_all); /* its breadth */
    double x = last.x, moment = lag_max(least, stair), near = lag_max(enough, lateness_of(run, i, stair, last.bend));
    for (int k = 1, slow = 0, is_stair = 0; k <= MOST_ITERATIONS && high.x - low.x > near && -high.depth > noise; ++k) {
        const double width = high.x - low.x;
        const int halves = is_stair || slow >= PATIENCE || !(x > low.x && x < high.x);
        Sight here = look_beside(run, i, halves ? low.x + width / 2 : x);
        *(here.depth < 0 ? &high : &low) = here;
        near = k > 1 || fabs(here.depth) <= STRIDE * rounding ? near : enough; /* the cubic is the condition itself, or not */
        here.pace = fabs(here.x - last.x) > CHORD * enough ? (here.depth - last.depth) / (here.x - last.x) : last.pace;
        x = beyond(here, moment);
        const int stays = (here.depth < 0) == (last.depth < 0), is_again = k > 1 && stays && fabs(x - here.x) < 2 * moment;
        is_stair |= k > 1 && !stays && moment > least && high.x - low.x <= 2 * STRIDE * moment;
        slow = is_again || high.x - low.x < SLOW * width ? 0 : slow + 1;
        if (k > 1)
            moment = is_again ? STRIDE * moment : least; /* by rounding the place may seem to be here again */
        last = here;
    }
    if (high.x - low.x > CHORD * enough) /* before it others may have changed that have not at the other side */
        memcpy(run->switches.g_before, run->switches.g_after, (size_t)run->model->n_switches * sizeof *run->switches.g_after);
    return high.x;
}

/* The place up to `high`, where conditions are g_after, from which on condition i has changed. What has just changed may begin beyond
 * its place by rounding. */
static double find_root(LagRun *run, int i, Part part, double high)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    const size_t size = (size_t)run->model->n_switches * sizeof *s->g;
    const int is_event = lag_is_event(run->model, i);
    const double enough = lag_max(ROUNDING, lag_time_resolution(m->t) / (m->t - m->t_old));
    Sight low = {part.low, depth_of(run, i, s->g_begin), 0, 0}, end = {high, depth_of(run, i, s->g_after), 0, 0};
    memcpy(s->g_before, s->g_begin, size);
    for (int k = 1; low.depth < 0 && k <= (is_event ? MOST_HALVINGS : HALVINGS); ++k) {
        const Sight here = look_beside(run, i, part.low + ldexp((is_event ? high : end.x) - part.low, -k));
        *(here.depth < 0 ? &end : &low) = here;
    }
    if (low.depth >= 0)
        return close_in(run, i, part, low, end, enough);
    if (is_event) /* it comes a moment later, where what has just left is back */
        return end.x;
    memcpy(s->g_after, s->g_begin, size);
    return part.low;
}

static void evaluate_end(LagRun *run, double x)
{
    LagSwitches *s = &run->switches;
    const double t = lag_crossing_time(run, x);
    find_state(run, t);
    lag_conditions_with_rates(run, t, s->state, s->g, s->rate);
}

/* Whether a condition is another one behind the place that was found than at both ends: it goes to and fro around it, as |v| > 1e-6 does
 * where v passes 0. */
static int is_passed(const LagRun *run)
{
    const LagSwitches *s = &run->switches;
    const int end = watched_end(run);
    for (int i = 0; i < end; ++i)
        if (is_beyond(run, i, depth_of(run, i, s->g_after)) && !is_beyond(run, i, depth_of(run, i, s->g)))
            return 1;
    return 0;
}

/* The first place in a part of the step where a condition changes; LAG_NOWHERE: there is none. */
static double find_in_part(LagRun *run, Part part)
{
    LagSwitches *s = &run->switches;
    const int end = watched_end(run);
    double first = LAG_NOWHERE;
    for (int i = 0; i < end; ++i) {
        const int has_changed = is_beyond(run, i, depth_of(run, i, s->g));
        const double high = has_changed ? part.high : find_dip(run, i, part);
        if (high < 0)
            continue;
        if (first < high) {
            if (depth_of(run, i, s->g_after) >= 0 || depth_of(run, i, s->g_before) >= 0) /* it changes later, or there */
                continue;
        } else if (has_changed)
            memcpy(s->g_after, s->g, (size_t)run->model->n_switches * sizeof *s->g);
        else
            look_beside(run, i, high);
        first = find_root(run, i, part, lag_min(first, high));
    }
    if (!(first < part.high) || !is_passed(run))
        return first;
    evaluate_end(run, first);
    return lag_min(first, find_in_part(run, (Part){part.low, first}));
}

/* Whether no other condition can have gone to and fro before a place that was found: up to there, cubics describe them. */
static int is_first(LagRun *run, Part part, double found)
{
    const Part before = {part.low, found};
    if (!(found > part.low))
        return 1;
    evaluate_end(run, found);
    return resolve(run, before) != UNLIKE;
}

/* The next step is no longer than some such parts of the latest one. */
static void shorten_step(LagRun *run, double narrowest)
{
    if (narrowest < MOST_PARTS)
        run->step = lag_min(run->step, narrowest / MOST_PARTS * (run->motion.t - run->motion.t_old));
}

/* A place that was found; stairs may go by ever faster, in the end several in the narrowest part of a step. */
static double take_place(LagRun *run, double found, double narrowest)
{
    if (run->model->conditions_may_hide)
        shorten_step(run, narrowest);
    return found;
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
    } else
        shorten_step(run, narrowest);
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
        if (!(lag_min(a, b) > FAR * h * lag_max(fabs(s->rate_begin[i]), fabs(s->rate[i]))))
            return 0;
    }
    return 1;
}

/* The end of a part: at the next of the hidden places, or of the step, or as it was thought. */
static double first_end(double low, double high, const double *hidden, int n_hidden)
{
    int k = 0;
    while (k < n_hidden && hidden[k] <= low)
        ++k;
    return lag_min(lag_min(k < n_hidden ? hidden[k] : 1, high), 1);
}

/* The same in the latest step. Where conditions go up and down in it (a cam that turns freely, sin(w t)) it is looked at in parts, and
 * the next one is not longer than a few of them. */
double lag_crossing_find(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const double h = run->motion.t - run->motion.t_old;
    const int may_graze = run->model->n_whens > 0 && run->methods.solver == LAG_SOLVER_TAYLOR; /* a ball that does goes to and fro */
    const int is_long = may_graze || run->model->conditions_may_hide;
    const int may_pause = !run->model->conditions_may_hide && h <= MUCH_LONGER * s->resolved;
    const int is_paused = ++s->unlooked < 0 && may_pause;
    const int is_due = !is_paused && (is_long || h > LONGER * s->resolved || s->unlooked > LOOK_AGAIN);
    double width = 1, narrowest = 1, hidden[LAG_HIDDEN];
    if (are_far(run))
        return LAG_NOWHERE;
    const int n_hidden = lag_hiding_places(run, hidden);
    for (double low = 0; low < 1;) {
        const Part part = {low, first_end(low, low + width, hidden, n_hidden)};
        evaluate_end(run, part.high);
        const int is_looked_at = is_due || (!is_paused && turns(run, (part.high - part.low) * h));
        const Likeness like = is_looked_at ? resolve(run, part) : ROUGHLY;
        if (like == UNLIKE && width > NARROWEST) {
            width /= 2;
            narrowest = lag_min(width, narrowest);
            continue;
        }
        const double found = find_in_part(run, part);
        if (found < LAG_NOWHERE && (is_paused || width <= NARROWEST || like == TO_ROUNDING || is_first(run, part, found)))
            return take_place(run, found, narrowest);
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
