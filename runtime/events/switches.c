/* The equations are smooth in each step, whatever conditions say in it: the force of a stop goes on as if there were no stop. Where a
 * condition has changed (crossing.c) the run goes back to the place.
 *
 * Where a condition changes back at once, again and again (a mass at rest at the corner of its spring, where rounding decides), steps
 * are taken for a while with conditions as they are at every evaluation, and step control makes the best of it.
 */
#include "events/switches.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/changes.h"
#include "events/conditions.h"
#include "events/cones.h"
#include "events/contacts.h"
#include "events/crossing.h"
#include "events/levels.h"
#include "events/loaded.h"
#include "events/standing.h"
#include "state/ends.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "state/inside.h"
#include "model/schedule.h"
#include "state/stepper.h"

/* A switch that changes in every step changes to and fro when these are so short, by the longest of the run, unless it goes by so many
 * tolerances. */
static const double SOON = 1e-3, PASSED = 10, WRONG_SIDE = 16;
static const double AT_END = 1e-3; /* of a step: near enough to one of its ends */
static const double LOST = 1e-4; /* of a tolerance: rounding of the end of a step, to which is known what is inside it */
static const double EARLY = 1e-3, AMPLE = 4; /* share of a step that says little of its beginning; of what it had to be, the next one */
static const double HALF = 0.5; /* of a step that has passed a stop */
enum { MOST_JAMS = 4, MOST_PASSES = 4, MOST_AGAIN = 10, HURRY = 5, FIRST_SPELL = 32, MOST_SPELL = 4096 };

void lag_switches_layout(LagSwitches *s, const LagModel *model, int size, LagArena *arena)
{
    double **const vectors[] = {&s->held, &s->g, &s->rate, &s->g_begin, &s->rate_begin, &s->g_inside, &s->rate_inside,
                                &s->g_before, &s->g_after, &s->unknown, &s->rounding};
    const size_t count = (size_t)model->n_switches;
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
        *vectors[i] = lag_take(arena, count);
    s->turned = lag_take_ints(arena, count);
    s->slides = lag_take_ints(arena, count);
    s->is_idle = lag_take_ints(arena, count);
    s->stands = lag_take_ints(arena, count);
    s->noise = lag_take(arena, count > 0 ? (size_t)model->n : 0);
    s->state = lag_take(arena, count > 0 ? (size_t)size : 0);
    s->slope = lag_take(arena, count > 0 ? (size_t)size : 0);
    s->error = lag_take(arena, count > 0 ? (size_t)size : 0);
}

void lag_switches_forget(LagRun *run) { memset(run->switches.turned, 0, (size_t)run->model->n_switches * sizeof(int)); }

void lag_switches_start_anew(LagRun *run)
{
    LagSwitches *s = &run->switches;
    s->is_live = s->live_steps = s->hurried = s->again = s->calms = 0;
    s->resolved = 0;
    s->unlooked = 0;
    s->spell = FIRST_SPELL;
    s->last = -1;
    lag_switches_forget(run);
}

void lag_switches_reset(LagRun *run)
{
    LagSwitches *s = &run->switches;
    lag_switches_start_anew(run);
    memset(s->held, 0, (size_t)run->model->n_switches * sizeof *s->held);
    memset(s->stands, 0, (size_t)run->model->n_switches * sizeof *s->stands);
    lag_sliding_reset(run);
    lag_impacts_reset(run);
}

/* -------- what is held */

static double sign_of(double g) { return g > 0 ? 1 : g < 0 ? 0 : 0.5; }

void lag_switches_set(LagRun *run, double t, const double *q, const double *v)
{
    LagSwitches *s = &run->switches;
    double *d = run->d + run->model->n_modes;
    for (int pass = 0; pass < (run->model->shares_bend ? MOST_PASSES : 1); ++pass) {
        lag_conditions_of_motion(run, t, q, v, s->slope + run->model->n, s->g_inside, s->rate_inside);
        for (int i = 0; i < lag_when(run->model, 0); ++i)
            d[i] = lag_standing_alone(run->model, i, s->g_inside[i]);
    }
}

void lag_switches_look(LagRun *run, double t, const double *y)
{
    if (run->model->n_whens > 0)
        lag_switches_set(run, t, y, y + run->model->n);
    if (run->model->switches_need_acceleration)
        lag_motion_slope(&run->motion, t, y, y + run->model->n, run->switches.slope);
}

void lag_switches_settle(LagRun *run, double t, const double *y)
{
    LagSwitches *s = &run->switches;
    s->is_live = 0;
    lag_switches_set(run, t, y, y + run->model->n);
    if (!run->model->switches_need_acceleration)
        return;
    memcpy(s->held, run->d + run->model->n_modes, (size_t)run->model->n_switches * sizeof *s->held);
    memcpy(s->g, s->g_inside, (size_t)run->model->n_switches * sizeof *s->g);
    lag_conditions_find_unknown(run, t, y);
    for (int i = 0; i < run->model->n_switches; ++i)
        s->turned[i] = i < lag_when(run->model, 0) ? fabs(s->g[i]) <= lag_conditions_error(run, s->unknown[i]) : s->slides[i];
    lag_sliding_settle(run, t, y, s->turned);
    lag_switches_forget(run);
}

void lag_switches_set_free(LagRun *run, double t, const double *y)
{
    LagSwitches *s = &run->switches;
    s->is_live = 1;
    for (int i = 0; i < run->model->n_switches; ++i)
        s->turned[i] = i >= lag_when(run->model, 0) && s->slides[i];
    lag_sliding_settle(run, t, y, s->turned);
    lag_switches_forget(run);
}

void lag_switches_recall(LagRun *run)
{
    memcpy(run->d + run->model->n_modes, run->switches.held, (size_t)run->model->n_switches * sizeof *run->d);
}

/* Returns whether accelerations were found with it. */
static int find_unknown(LagRun *run)
{
    LagSwitches *s = &run->switches;
    lag_conditions_find_unknown(run, run->motion.t, run->motion.y);
    for (int i = 0; i < run->model->n_switches && run->model->switches_need_acceleration; ++i)
        run->sliding.error[i] = lag_conditions_error(run, s->unknown[i]);
    return lag_contacts_find_errors(run);
}

/* Forces that feel reactions ask for their signs, which follow from what all forces do: those that have come out otherwise than they
 * are held are held so. Returns whether there are some. */
static int turn_over(LagRun *run)
{
    LagSwitches *s = &run->switches;
    int some = 0;
    if (!run->model->shares_bend || s->is_live)
        return 0;
    lag_conditions(run, run->motion.t, run->motion.y, s->g_inside, s->rate_inside);
    for (int i = 0; i < lag_when(run->model, 0); ++i)
        if (!s->slides[i] && !s->turned[i] && fabs(s->g_inside[i]) > s->unknown[i] && s->held[i] != sign_of(s->g_inside[i])) {
            s->held[i] = sign_of(s->g_inside[i]);
            some = 1;
        }
    if (some)
        lag_switches_recall(run);
    return some;
}

/* What changes now, and what is neither, goes the way that it is going, or stands: but for events, which are to come where they are
 * neither. `is_seen`: the latest accelerations are those of the present. Returns whether something changes. */
static int choose(LagRun *run, int is_seen)
{
    LagSwitches *s = &run->switches;
    const int count = run->model->n_switches, first = lag_when(run->model, 0);
    const double *y = run->motion.y;
    const double *was = run->d + run->model->n_modes;
    int turned = 0, undecided = 0, stays = is_seen && !s->is_live && !run->model->shares_bend; /* conditions, too, then */
    lag_conditions(run, run->motion.t, y, s->g, s->rate);
    for (int i = 0; i < count; ++i) {
        const double held = s->held[i];
        lag_conditions_note_kick(run, i);
        if (s->turned[i] && !(s->stands[i] && s->held[i] == 0.5))
            s->held[i] = s->turned[i] == LAG_CHANGES ? 1 - s->held[i] : s->turned[i] == LAG_TO_1;
        else if (i < first)
            s->held[i] = s->stands[i] && fabs(s->g[i]) <= s->unknown[i] ? 0.5 : sign_of(s->g[i]);
        else if (!s->slides[i])
            s->held[i] = lag_contacts_is_inside(run, i, s->g[i]);
        turned |= s->turned[i];
        stays = stays && s->held[i] == held && was[i] == held;
        undecided |= i < first && s->held[i] == 0.5;
    }
    lag_switches_recall(run);
    for (int pass = 0; pass < MOST_PASSES && turn_over(run); ++pass)
        ;
    if (!stays)
        lag_conditions_with_rates(run, run->motion.t, y, s->g, s->rate);
    for (int i = 0; i < first; ++i)
        if (s->held[i] == 0.5)
            s->held[i] = s->rate[i] != 0 || run->model->at_level[i] == LAG_LEVEL_EITHER ? s->rate[i] > 0 : lag_standing_value(run->model, i);
    lag_switches_recall(run);
    if (undecided)
        lag_conditions_with_rates(run, run->motion.t, y, s->g, s->rate);
    return turned;
}

/* Of the conditions that are 0 now, those whose forces hold them there slide: but not what has just gone away. Returns whether one
 * could. */
static int let_slide(LagRun *run)
{
    LagSwitches *s = &run->switches;
    LagSliding *sliding = &run->sliding;
    const int first = lag_when(run->model, 0);
    int candidates = 0;
    lag_cones_note_torn(run);
    for (int i = 0; i < first && !s->is_live; ++i) {
        const int has_gone = s->turned[i] == LAG_TO_0 || s->turned[i] == LAG_TO_1;
        if (!has_gone && fabs(s->g[i]) <= lag_max(lag_sliding_held(run, i), s->unknown[i]))
            s->turned[i] = LAG_CHANGES;
        candidates |= s->turned[i] == LAG_CHANGES;
    }
    candidates |= lag_contacts_find_rest(run);
    sliding->is_lenient = run->model->n_cones > 0; /* what slips in the plane stops before it is known whether it is held */
    for (int turn = sliding->is_lenient ? 0 : 1; turn < 2; ++turn) {
        lag_sliding_settle(run, run->motion.t, run->motion.y, s->turned);
        if (sliding->count > 0)
            lag_sliding_stop(run);
        lag_cones_note_left(run);
        sliding->is_lenient = 0;
    }
    return candidates;
}

/* Chooses what is held at the present state. Returns whether something has changed. */
static int settle(LagRun *run)
{
    LagSwitches *s = &run->switches;
    s->is_live = s->live_steps > 0 || !run->methods.table->holds_switches;
    if (run->sliding.count > 0) /* what is torn off begins to move from rest */
        lag_sliding_stop(run);
    run->sliding.count = s->calms = 0;
    const int turned = choose(run, find_unknown(run));
    if (s->is_live)
        lag_sliding_end(run);
    const int may_slide = (!s->is_live || run->model->n_whens > 0) && run->model->switches_need_acceleration;
    for (int pass = 0; pass < MOST_PASSES && may_slide && let_slide(run); ++pass) {
        lag_conditions_with_rates(run, run->motion.t, run->motion.y, s->g, s->rate);
        if (!turn_over(run))
            break;
    }
    if (lag_standing_find(run) && may_slide)
        let_slide(run);
    lag_standing_rest(run);
    return turned;
}

/* Whether a slip was let go to one side, and what stopped others at the same time has thrown it to the other one: friction is against it. */
static int is_thrown(LagRun *run, int i)
{
    LagSwitches *s = &run->switches;
    if (!run->model->switches_need_acceleration || s->is_idle[i] || !(fabs(s->g[i]) > lag_sliding_drift(run, i)))
        return 0;
    s->held[i] = sign_of(s->g[i]);
    *lag_share(run, i) = s->held[i];
    return 1;
}

/* Rates as they were found, or stated, are others now by more than they are known to: the first time is told. */
static void note_jam(LagRun *run)
{
    LagStatistics *s = &run->statistics;
    if (s->jammed || !run->impacts.is_felt)
        return;
    s->jammed = lag_impacts_striking(run);
    s->jam_time = run->motion.t;
}

int lag_switches_enter(LagRun *run)
{
    LagSwitches *s = &run->switches;
    if (run->model->n_switches == 0)
        return 0;
    run->impacts.edges.is_in_force = run->impacts.comes_next = 0;
    int turned = settle(run);
    for (int impulses = 0; run->sliding.jams && impulses < MOST_JAMS && lag_impacts_press(run); ++impulses) {
        note_jam(run);
        lag_switches_forget(run);
        turned |= settle(run);
    }
    lag_edges_find(run);
    if (run->sliding.count > 0)
        lag_conditions_find_unknown(run, run->motion.t, run->motion.y);
    lag_contacts_foresee(run);
    for (int i = 0; i < run->model->n_switches; ++i)
        if (s->turned[i] && !s->slides[i] && !lag_is_event(run->model, i) && !is_thrown(run, i) && lag_depth(s, i, s->g) < 0)
            s->unknown[i] = lag_max(WRONG_SIDE * fabs(s->g[i]), s->unknown[i]); /* what is left of it is rounding */
    for (int i = 0; i < run->model->n_switches; ++i)
        if (s->is_idle[i])
            s->unknown[i] = INFINITY;
        else if (s->stands[i])
            s->unknown[i] = lag_max(fabs(s->g[i]), s->unknown[i]);
        else if (run->sliding.is_tied[i])
            s->unknown[i] = lag_max(lag_sliding_drift(run, i), s->unknown[i]);
    lag_cones_enter(run);
    lag_cones_look(run);
    lag_switches_forget(run);
    lag_sliding_forget_impact(run);
    run->impacts.is_known = 0;
    lag_levels_enter(run);
    lag_edges_enter(run);
    lag_loaded_enter(run);
    return turned;
}

void lag_switches_keep(const LagRun *run, double *kept)
{
    const int n = run->model->n_switches;
    for (int i = 0; i < n; ++i) {
        kept[i] = run->switches.slides[i] ? NAN : run->switches.held[i];
        kept[n + i] = run->switches.unknown[i];
    }
}

int lag_switches_resume(LagRun *run, const double *kept)
{
    LagSwitches *s = &run->switches;
    int is_same = 1;
    for (int i = 0; i < run->model->n_switches; ++i) {
        s->turned[i] = isnan(kept[i]);
        s->held[i] = s->turned[i] ? 0.5 : kept[i];
        s->stands[i] = kept[i] == 0.5; /* nothing else holds that; others that stand are found at the next event */
    }
    lag_switches_recall(run);
    run->sliding.is_lenient = run->model->n_cones > 0; /* that it holds is known */
    lag_sliding_settle(run, run->motion.t, run->motion.y, s->turned);
    run->sliding.is_lenient = 0;
    for (int i = 0; i < run->model->n_switches; ++i)
        is_same &= s->slides[i] == isnan(kept[i]);
    memcpy(s->unknown, kept + run->model->n_switches, (size_t)run->model->n_switches * sizeof *kept);
    lag_cones_enter(run);
    lag_switches_forget(run);
    return is_same;
}

int lag_switches_release(LagRun *run)
{
    LagSwitches *s = &run->switches;
    if (run->model->n_switches == 0 || s->is_live || run->sliding.count > 0)
        return 0;
    s->is_live = s->live_steps = 1;
    return 1;
}

/* -------- what is done where they change */

/* Whether condition i, which has just changed, goes no farther in that time than errors take it: what turns past stair after stair does. */
static int stays_near(LagRun *run, int i, double since)
{
    LagSwitches *s = &run->switches;
    lag_conditions_with_rates(run, run->motion.t, run->motion.y, s->g, s->rate);
    return !(fabs(s->rate[i]) * since > PASSED * lag_conditions_error(run, s->unknown[i]));
}

/* One that changes in step after short step is left to step control for a while; but what nothing moves is on both sides of its place at
 * every event. */
static void turn(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const int first = lag_changes_note(run, run->switches.g_after), is_event = lag_changes_come(run);
    const double since = run->motion.t - run->motion.t_old;
    const int stands = since <= lag_time_resolution(run->motion.t), is_soon = since < SOON * run->statistics.largest_step;
    const int is_again = first == s->last && is_soon;
    s->hurried = !is_event && (stands || (is_again && stays_near(run, first, since))) ? s->hurried + 1 : 0;
    s->last = first;
    if (s->hurried < HURRY)
        return;
    s->live_steps = s->spell;
    s->spell = s->spell < MOST_SPELL ? 2 * s->spell : s->spell;
    s->hurried = 0;
    s->last = -1;
}

void lag_switches_resolve(LagRun *run)
{
    LagSwitches *s = &run->switches;
    if (run->segment_over || !s->is_live || s->live_steps > 0 || !run->methods.table->holds_switches)
        return;
    lag_switches_enter(run);
    run->segment_over |= run->sliding.count > 0 || run->sliding.jams; /* what is held now is another motion */
}

/* Digits are lost where a step was far too long: its end is much larger than what is looked for. The next one is as long as it should
 * have been. */
static void step_shorter(LagRun *run, double x)
{
    LagMotion *m = &run->motion;
    const double h = m->t - m->t_old;
    lag_motion_take_back(m);
    lag_motion_slope(m, m->t, m->y, m->y + m->n, m->slope);
    if (run->methods.table->begins_low)
        lag_stepper_lead(run);
    run->methods.table->restart(run->methods.self, m);
    ++run->statistics.rejected;
    run->step = AMPLE * x * h;
    lag_step_set_units(run, run->step);
}

/* How large those of the kind of position or rate i have been up to a place inside the step, whose state is in switches.state. */
static double size_up_to(const LagRun *run, int i)
{
    const int n = run->motion.n, first = i < n ? 0 : n;
    const double *before = run->motion.other + first, *here = run->switches.state + first;
    double size = 0;
    for (int j = 0; j < n; ++j)
        if (run->scale.kind[j] == run->scale.kind[i - first])
            size = lag_max(lag_max(fabs(before[j]), fabs(here[j])), size);
    return size;
}

/* Whether the end of the step is so far away that what is inside it loses digits by that. */
static int goes_far(const LagRun *run)
{
    const LagMotion *m = &run->motion;
    for (int i = 0; i < 2 * m->n; ++i)
        if (DBL_EPSILON * fabs(m->y[i]) > LOST * run->scale.tolerance * size_up_to(run, i))
            return 1;
    return 0;
}

/* Takes the step back, where its end tells more than its dense output: the next one ends at the share x of it. Returns whether it
 * was. */
static int step_again(LagRun *run, double x)
{
    LagSwitches *s = &run->switches;
    LagMotion *m = &run->motion;
    const LagMethod *method = run->methods.table;
    const double h = m->t - m->t_old;
    const int is_longest = h > m->t_old - run->settings.t_start; /* than all that was before */
    const int is_early = is_longest && x < EARLY && x * h > lag_time_resolution(m->t_old) / EARLY && goes_far(run);
    const int is_inside = x > AT_END && x < 1 - AT_END;
    const int is_vague = method->take_back && is_inside && !(method->is_good_inside && !m->lacks_slopes);
    if (!(is_early || is_vague) || s->again == MOST_AGAIN)
        return 0;
    ++s->again;
    if (is_early)
        step_shorter(run, x);
    else
        method->take_back(run);
    lag_conditions_with_rates(run, m->t, m->y, s->g, s->rate);
    run->segment_over = 0;
    run->step = is_early ? run->step : x * h;
    return 1;
}

/* Whether what slides still does at the end of the step: the latest evaluation may have been one inside it. */
static int lasts(LagRun *run)
{
    LagSliding *s = &run->sliding;
    const LagMotion *m = &run->motion;
    if (s->count > 0)
        lag_conditions_by(run, m->t, m->y, m->y + m->n, run->switches.slope + m->n, s->g, s->rate);
    return lag_sliding_lasts(run);
}

static void watch_held(LagRun *run)
{
    LagSwitches *s = &run->switches;
    if (!s->is_live && lag_cones_turn_round(run)) {
        step_shorter(run, HALF / AMPLE);
        run->segment_over = 0;
        return;
    }
    lag_standing_know(run);
    lag_swap(&s->g, &s->g_begin);
    lag_swap(&s->rate, &s->rate_begin);
    const double x = lag_crossing_find(run);
    if (x == LAG_NOWHERE) {
        s->hurried = s->again = 0;
        run->segment_over |= !lasts(run);
        lag_sliding_grow(run);
        run->segment_over |= lag_cones_look(run);
        return;
    }
    if (step_again(run, x))
        return;
    if (x < 1)
        lag_go_back(run, lag_crossing_time(run, x));
    s->again = 0;
    turn(run);
    run->segment_over = 1;
}

void lag_switches_watch(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const int is_live = s->is_live;
    if (!is_live || run->model->n_whens > 0)
        watch_held(run);
    if (is_live && s->live_steps > 0)
        --s->live_steps;
}
