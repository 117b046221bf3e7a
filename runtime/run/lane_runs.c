#include "run/lane_runs.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "run/advance.h"
#include "run/lane_events.h"
#include "state/account.h"
#include "state/ends.h"
#include "state/state.h"
#include "steps/branch.h"
#include "steps/segment.h"

/* Steps that a run makes before it goes into a lane, at most: they set in motion what rests. */
enum { MOST_FIRST = 3 };
/* Steps to the first glance at energies, which costs as much as one and a half steps in a lane, and from one to the next at most; from
 * one look at stability, which costs as much as 20, to the next, and the same while it seems to rule; looks in a row after which it
 * does. */
enum { GLANCE = 16, MOST_GLANCE = 64, LOOK = 256, CLOSE_LOOK = 16, LOOKS = 4 };
enum { LOOK_FOR_PROGRESS = 1 << 17 };
/* A run whose events come sooner than after so many steps, again and again, stays outside. */
enum { SOON = 3, MOST_IN_VAIN = 4 };
static const double MOST_STEPS = 1e10; /* as in step.c */

/* -------- a run comes and goes */

/* Returns 0 when it was stopped. */
static int make_alone(LagRunLanes *s, int64_t i)
{
    ++s->counts[LAG_LANES_ALONE];
    s->done[i] = (uint8_t)lag_batch_alone(s->batch, i);
    return s->done[i];
}

void lag_lanes_leave(LagRunLanes *s, int lane)
{
    s->busy -= s->job[lane] >= 0;
    s->job[lane] = -1;
    s->begins[lane] = s->bare.is_bare[lane] = 0;
    s->steps->moves[lane] = 0;
}

int lag_lanes_end_run(LagRunLanes *s, int lane, LagStatus status)
{
    const int64_t i = s->job[lane];
    LagFollower *f = &s->follower[lane];
    lag_lanes_leave(s, lane);
    if (status == LAG_OK)
        status = lag_follow_end(f);
    if (status != LAG_OK)
        return make_alone(s, i);
    lag_batch_conclude(s->batch, f, i, status);
    if (s->batch->outcomes[i].kind != LAG_RUN_DONE)
        return make_alone(s, i);
    ++s->counts[LAG_LANES_RUNS];
    s->done[i] = 1;
    return 1;
}

/* How far steps may go: a short bounce is seen where one ends soon enough. */
static void set_due(LagRunLanes *s, int lane)
{
    const LagFollower *f = &s->follower[lane];
    const LagRun *run = f->run;
    const double end = lag_min(run->segment_end, run->settings.t_stop), seen = run->impacts.seen;
    if (s->has_events)
        s->steps->stop[lane] = seen > run->motion.t ? lag_min(seen, end) : end;
    if (s->method->ends_at_rows)
        s->steps->stop[lane] = lag_min(f->next, end);
    s->due[lane] = f->n_pending > 0 || s->is_guarded || s->is_loop ? -INFINITY : lag_min(f->next, s->steps->stop[lane]);
}

/* Other inputs are in force from the present time of the lane on, or other modes. */
static LagStatus enter_segment(LagRunLanes *s, int lane)
{
    LagFollower *f = &s->follower[lane];
    LagRun *run = f->run;
    LagStatus status = LAG_OK;
    if (run->model->n_modes > 0)
        status = lag_segment_next(run);
    else if (run->inputs.rows > 1)
        lag_segment_enter(run);
    run->segment_over = 0;
    if (status != LAG_OK)
        return status;
    s->method->enter(s->steps, lane, run);
    lag_wide_roots_enter(&s->roots, lane, run);
    return f->n_pending > 0 ? lag_follow_enter(f, run->motion.t) : LAG_OK;
}

/* The run that was put into the lane goes on there. */
static int settle_in(LagRunLanes *s, int lane)
{
    LagRun *run = lag_lanes_run(s, lane);
    const int is_over = run->segment_over || lag_run_time(run) >= s->steps->stop[lane];
    lag_wide_roots_enter(&s->roots, lane, run);
    lag_wide_conditions_enter(&s->conditions, lane, run);
    s->came[lane] = (double)run->statistics.steps;
    const LagStatus status = is_over ? enter_segment(s, lane) : LAG_OK;
    s->glance[lane] = (double)(run->statistics.steps + GLANCE);
    s->look[lane] = LOOK;
    set_due(s, lane);
    s->begins[lane] = s->method->settle && run->statistics.steps == 0;
    return status == LAG_OK ? 1 : lag_lanes_end_run(s, lane, status);
}

/* A step outside of lanes. */
static LagStatus step_alone(LagFollower *f)
{
    const int is_watched = f->n_pending > 0;
    f->starts_again = 0;
    const LagStatus status = is_watched ? lag_follow_step(f) : lag_advance_step(f->run);
    return status == LAG_OK && !is_watched ? lag_follow_visit(f, lag_run_time(f->run)) : status;
}

/* Whether a lane may take the run. */
static int suits(const LagRunLanes *s, int lane)
{
    return !s->has_events || (s->in_vain[lane] < MOST_IN_VAIN && lag_wide_conditions_suit(lag_lanes_run(s, lane)));
}

/* The first steps of a run, or those after an event, until a lane can take it, or it is over: then there is nothing in the lane.
 * `is_refused`: as it is, it cannot. */
static int seat(LagRunLanes *s, int lane, LagStatus status, int is_refused)
{
    LagFollower *f = &s->follower[lane];
    LagRun *run = f->run;
    const int64_t i = s->job[lane];
    for (int k = 0; status == LAG_OK; ++k) {
        if (lag_run_time(run) >= s->batch->sweep.t_stop)
            return lag_lanes_end_run(s, lane, status);
        if (run->guards.broken)
            break;
        if (!(is_refused && k == 0) && suits(s, lane) && s->method->load(s->steps, lane, run))
            return settle_in(s, lane);
        const int repeats = s->is_loop && run->doubtful > 0; /* some constraint another one: for longer than these steps */
        const int has_enough = s->has_events ? k % LOOK == LOOK - 1 && lag_follow_is_over(f) : run->statistics.steps >= MOST_FIRST;
        if (has_enough || repeats)
            break;
        status = step_alone(f);
    }
    lag_lanes_leave(s, lane);
    return make_alone(s, i);
}

static int begin_run(LagRunLanes *s, int lane, int64_t i)
{
    LagFollower *f = &s->follower[lane];
    LagStatus status = lag_batch_begin(s->batch, f, i);
    if (s->batch->outcomes[i].kind == LAG_RUN_PARAMETER) {
        lag_batch_conclude(s->batch, f, i, status);
        s->done[i] = 1;
        return 1;
    }
    s->job[lane] = i;
    s->in_vain[lane] = 0;
    ++s->busy;
    status = status == LAG_OK ? lag_follow_begin(f) : status;
    f->starts_again = s->starts_again && status == LAG_OK;
    return seat(s, lane, status, 0);
}

/* -------- bare runs */

/* Whether a run that begins in the lane is a bare one, by what the one before has left there. */
static int begins_bare(const LagRunLanes *s, int lane)
{
    const int is_told = s->batch->sweep.n_rows > 0 ? s->batch->held != NULL : s->taylor.first_stop >= s->batch->sweep.t_stop;
    return s->is_bare && s->follower[lane].starts_again && is_told;
}

static void place_bare(LagRunLanes *s, int lane, int64_t i)
{
    s->method->place(s->steps, lane, lag_bare_find_start(&s->bare, i, lag_lanes_run(s, lane)));
    lag_bare_place(&s->bare, lane, i, lag_lanes_run(s, lane));
    s->job[lane] = i;
    ++s->busy;
    s->begins[lane] = s->bare.is_bare[lane] = 1;
}

static void begin_bare(LagRunLanes *s, int lane)
{
    lag_bare_begin(&s->bare, lane, s->job[lane], lag_lanes_run(s, lane));
    s->glance[lane] = MOST_GLANCE;
    s->look[lane] = LOOK;
    s->due[lane] = s->steps->stop[lane];
}

/* More is asked of the bare run in the lane than its state: it is one like all others from now on. */
static LagStatus recall(LagRunLanes *s, int lane)
{
    LagFollower *f = &s->follower[lane];
    s->bare.is_bare[lane] = 0;
    const LagStatus status = lag_batch_begin(s->batch, f, s->job[lane]);
    f->run->scale.is_resting = 0;
    f->run->statistics.energy_scale = s->bare.seen[lane];
    if (status != LAG_OK || s->batch->sweep.n_rows == 0)
        return status == LAG_OK ? lag_follow_begin(f) : status;
    const LagStatus held = lag_follow_resume(f, s->bare.next_row[lane]);
    lag_segment_enter(f->run);
    return held;
}

static void tell_bare(const LagRunLanes *s, int64_t i, double steps, double missed)
{
    LagOutcome *outcome = &s->batch->outcomes[i];
    const LagOutcome fresh = {0};
    *outcome = fresh;
    outcome->failure.index = -1;
    outcome->steps = (int64_t)steps;
    outcome->methods = steps > 0 ? (int64_t)1 << s->method->solver : 0;
    outcome->energy = missed;
}

int lag_lanes_conclude(LagRunLanes *s)
{
    double misses[LAG_ABREAST];
    const int count = s->bare.count;
    if (count == 0)
        return 1;
    lag_bare_close(&s->bare, lag_lanes_run(s, 0), misses);
    for (int k = 0; k < count; ++k) {
        const int64_t i = s->bare.ended[k];
        if (isnan(misses[k])) {
            if (!make_alone(s, i))
                return 0;
            continue;
        }
        tell_bare(s, i, s->bare.steps[k], misses[k]);
        ++s->counts[LAG_LANES_RUNS];
        s->done[i] = 1;
    }
    return 1;
}

/* A step to a row says nothing of stability. */
static void pass_bare(LagRunLanes *s, int lane)
{
    lag_bare_pass(&s->bare, lane, s->job[lane], lag_lanes_run(s, lane));
    s->due[lane] = s->steps->stop[lane];
    ++s->look[lane];
}

/* As lag_lanes_attend, unless more is to be looked at: then the run is bare no more. */
static int attend_bare(LagRunLanes *s, int lane)
{
    const double t = s->steps->t[lane], steps = s->steps->steps[lane];
    if (t >= s->batch->sweep.t_stop) {
        lag_bare_end(&s->bare, lane, s->job[lane], lag_lanes_run(s, lane));
        lag_lanes_leave(s, lane);
        return s->bare.count < LAG_ABREAST || lag_lanes_conclude(s);
    }
    if (steps >= s->glance[lane] && steps < (double)s->look[lane]) {
        s->glance[lane] = lag_min(steps + MOST_GLANCE, (double)s->look[lane]);
        if (!lag_bare_closes(&s->bare, lane, lag_lanes_run(s, lane)))
            return lag_lanes_end_run(s, lane, LAG_PAUSED);
    }
    if (t >= s->steps->stop[lane])
        pass_bare(s, lane);
    if (steps < (double)s->look[lane])
        return 1;
    s->glance[lane] = steps;
    const LagStatus status = recall(s, lane);
    return status == LAG_OK ? 1 : lag_lanes_end_run(s, lane, status);
}

/* -------- in between */

/* Whether what choice.c would pass on to implicit steps, nobody waits for, or asks for stricter steps, as all lanes have one tolerance, is
 * better made alone. */
static int is_unfit(LagRunLanes *s, int lane)
{
    LagRun *run = lag_lanes_run(s, lane);
    const int64_t steps = run->statistics.steps;
    if (run->scale.tolerance < run->scale.asked)
        return 1;
    if (steps < s->look[lane])
        return 0;
    const double t = run->motion.t, done = t - s->batch->sweep.t_start;
    s->follower[lane].starts_again = 0;
    const int looks = s->may_turn ? lag_stiffness_look(run, s->steps->length[lane]) : 0;
    s->look[lane] = steps + (looks > 0 ? CLOSE_LOOK : LOOK);
    return looks >= LOOKS
        || (steps > LOOK_FOR_PROGRESS && (s->batch->sweep.t_stop - t) / done * (double)steps > MOST_STEPS);
}

/* After how many steps the next glance comes: twice as many as there were, where these are few, and for the next look at stability. */
static double next_glance(const LagRunLanes *s, int lane)
{
    const double steps = s->steps->steps[lane];
    return lag_min(lag_min(2 * steps, steps + MOST_GLANCE), (double)s->look[lane]);
}

/* The end of the step as a row: that of coordinates and rates alone where nothing else is asked for, without energies but now and then
 * where these are not. */
static LagStatus end_row(LagRunLanes *s, int lane, int glances)
{
    LagFollower *f = &s->follower[lane];
    LagRun *run = f->run;
    f->window.end_time = run->motion.t;
    if (!f->window.is_plain && (glances || f->window.has_energies))
        return lag_run_row(run, f->window.end);
    if (!f->window.is_plain)
        return lag_advance_motion_row(run, run->motion.t, f->window.end);
    f->window.end[0] = run->motion.t;
    memcpy(f->window.end + 1, run->motion.y, 2 * (size_t)s->steps->n * sizeof *run->motion.y);
    return LAG_OK;
}

static LagStatus watch(LagRunLanes *s, int lane, LagShown shown, int glances)
{
    LagFollower *f = &s->follower[lane];
    LagStatus status = end_row(s, lane, glances);
    if (status != LAG_OK)
        return status;
    const int open = lag_follow_glance(f);
    if (open && shown < LAG_SHOWN_DENSE)
        s->method->show(s->steps, lane, f->run, LAG_SHOWN_DENSE);
    f->starts_again &= !open;
    return lag_follow_watch(f, open);
}

/* What a run with loops notes of each step. Returns whether it goes on in its lane: where ways of moving meet, it does not. */
static int note_loop(LagRun *run)
{
    lag_account_rise(run);
    lag_branch_watch(run);
    return run->branch.turned < 0;
}

/* The run goes on alone until it is what lanes serve again, if it was for some steps. */
static int go_outside(LagRunLanes *s, int lane, LagStatus status)
{
    const int is_soon = s->steps->steps[lane] - s->came[lane] < SOON;
    ++s->counts[LAG_LANES_LEFT];
    s->in_vain[lane] = is_soon ? s->in_vain[lane] + 1 : 0;
    s->steps->moves[lane] = 0;
    return seat(s, lane, status, 0);
}

/* After a step of a run that is not bare. */
static int attend(LagRunLanes *s, int lane)
{
    LagFollower *f = &s->follower[lane];
    const double t = s->steps->t[lane];
    const int glances = s->steps->steps[lane] >= s->glance[lane], is_over = t >= s->batch->sweep.t_stop;
    const int has_event = !is_over && t >= s->steps->stop[lane];
    const int is_dense = s->is_guarded || t > f->next || (has_event && s->batch->model->n_modes + s->has_events > 0);
    const LagShown shown = is_dense ? LAG_SHOWN_DENSE : glances || is_over || s->is_loop ? LAG_SHOWN_STEP : LAG_SHOWN_STATE;
    LagStatus status = LAG_OK;
    s->method->show(s->steps, lane, f->run, shown);
    f->starts_again &= shown < LAG_SHOWN_DENSE;
    if (s->is_guarded)
        lag_guards_watch(f->run);
    if (f->run->guards.broken || (s->is_loop && !note_loop(f->run)))
        return lag_lanes_end_run(s, lane, LAG_PAUSED);
    if (glances) {
        lag_account_glance(f->run);
        if (lag_follow_is_over(f) || is_unfit(s, lane))
            return lag_lanes_end_run(s, lane, LAG_PAUSED);
        s->glance[lane] = next_glance(s, lane);
    }
    if (t >= f->next)
        status = lag_follow_visit(f, t);
    if (status == LAG_OK && f->n_pending > 0)
        status = watch(s, lane, shown, glances);
    if (status != LAG_OK || is_over)
        return lag_lanes_end_run(s, lane, status);
    if (s->has_events && (f->run->segment_over = t == f->run->segment_end))
        return go_outside(s, lane, LAG_OK);
    if (has_event && !s->has_events && (status = enter_segment(s, lane)) != LAG_OK)
        return lag_lanes_end_run(s, lane, status);
    set_due(s, lane);
    return 1;
}

/* The run has come to an event in the latest step, or would have to make it again: what was asked for until then is told. */
static int leave_for_event(LagRunLanes *s, int lane)
{
    LagFollower *f = &s->follower[lane];
    const double t = f->run->motion.t;
    LagStatus status = t >= f->next ? lag_follow_visit(f, t) : LAG_OK;
    if (status == LAG_OK && f->n_pending > 0 && t > f->run->motion.t_old)
        status = watch(s, lane, LAG_SHOWN_DENSE, 1);
    return go_outside(s, lane, status);
}

int lag_lanes_look(LagRunLanes *s, int lane)
{
    LagRun *run = lag_lanes_run(s, lane);
    s->method->show(s->steps, lane, run, LAG_SHOWN_DENSE);
    s->follower[lane].starts_again = 0;
    if (lag_lane_events_look(run))
        return leave_for_event(s, lane);
    s->steps->length[lane] = lag_min(run->step, s->steps->length[lane]);
    const int is_due = s->steps->t[lane] >= s->due[lane] || s->steps->steps[lane] >= s->glance[lane];
    return is_due ? attend(s, lane) : 1;
}

int lag_lanes_attend(LagRunLanes *s, int lane)
{
    const int goes_on = !s->bare.is_bare[lane] || attend_bare(s, lane), is_told = s->job[lane] < 0 || s->bare.is_bare[lane];
    return goes_on && !is_told ? attend(s, lane) : goes_on;
}

/* -------- all of them */

/* Those that are bare, or for which nothing tells how fast what rests will be, begin otherwise. */
static int settle_one(LagRunLanes *s, int lane)
{
    const int64_t i = s->job[lane];
    const int goes = s->steps->moves[lane] > 0, is_bare = s->bare.is_bare[lane];
    LagRun *run = lag_lanes_run(s, lane);
    s->begins[lane] = 0;
    if (goes && begins_bare(s, lane))
        begin_bare(s, lane);
    if (goes && !is_bare)
        run->scale.is_resting = 0;
    if (goes)
        return 1;
    if (is_bare) {
        lag_lanes_leave(s, lane);
        return begin_run(s, lane, i);
    }
    run->step = s->steps->length[lane];
    return seat(s, lane, LAG_OK, 1);
}

/* What has come into lanes at its start begins, all at once. Returns 0 when it was stopped. */
static int settle(LagRunLanes *s)
{
    int some = 0, begins[LAG_ABREAST];
    for (int lane = 0; lane < LAG_ABREAST; ++lane)
        some |= begins[lane] = s->begins[lane];
    if (!some)
        return 1;
    s->method->settle(s->steps);
    if (s->is_bare)
        lag_bare_look(&s->bare, lag_lanes_run(s, 0));
    if (s->batch->model->n_roots > 0)
        lag_wide_roots_begin(&s->roots, s->steps);
    for (int lane = 0; lane < LAG_ABREAST; ++lane)
        if (begins[lane] && !settle_one(s, lane))
            return 0;
    return settle(s);
}

int lag_lanes_fill(LagRunLanes *s)
{
    while (s->busy < LAG_ABREAST && s->next < s->runs) {
        for (int lane = 0; lane < LAG_ABREAST; ++lane)
            while (s->job[lane] < 0 && s->next < s->runs) {
                const int64_t i = s->next++;
                if (*s->batch->stop)
                    return 0;
                if (begins_bare(s, lane))
                    place_bare(s, lane, i);
                else if (!begin_run(s, lane, i))
                    return 0;
            }
        if (!settle(s))
            return 0;
    }
    return 1;
}
