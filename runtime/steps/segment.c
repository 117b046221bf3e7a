#include "steps/segment.h"

#include <math.h>

#include "events/accelerations.h"
#include "state/account.h"
#include "state/attitudes.h"
#include "state/first_step.h"
#include "model/function.h"
#include "state/holds.h"
#include "state/onset.h"
#include "events/rest.h"
#include "events/sampling.h"
#include "events/walls.h"
#include "model/schedule.h"
#include "model/table.h"
#include "steps/branch.h"
#include "steps/delays.h"
#include "steps/step.h"
#include "state/stepper.h"
#include "steps/turns.h"

static const double FIRST_PART = 0.1; /* of what is left: no first step is longer */
static const double FAR = 1e3; /* times all that was before */
static const double BLURRED = 64; /* times what tells times apart: accelerations that change sooner are little but rounding */
static const double MILD = 10; /* steps in which accelerations change by about themselves */

/* A time inside the segment, away from its ends, where modes are sure not to be just changing. */
static double middle(double t, double t_event, double t_stop)
{
    const double end = t_stop > t && t_stop < t_event ? t_stop : t_event;
    return isfinite(end) ? t + (end - t) / 2 : t + fmax(1, fabs(t));
}

/* Events that follow inputs, which have no corner before this time. Rates that are guessed of them foresee none. */
static void foresee(LagRun *run, double corner)
{
    const double *in[] = {run->p, run->d_given}, *const rates = run->inputs.rates;
    double *out[] = {run->event_a, run->event_b};
    if (run->model->n_pieces == 0)
        return;
    lag_inputs_enter(&run->inputs, middle(run->motion.t, corner, run->settings.t_stop));
    run->inputs.rates = NULL;
    lag_inputs_read(&run->inputs, run->d_given);
    run->inputs.rates = rates;
    lag_call(&run->model->events, in, out, run->work);
}

void lag_segment_enter(LagRun *run)
{
    const LagModel *model = run->model;
    const double t = run->motion.t;
    const double corner = lag_inputs_next(&run->inputs, t + lag_time_resolution(t));
    foresee(run, corner);
    const double scheduled = lag_schedule_next(model, run->event_a, run->event_b, t);
    run->segment_end = lag_delays_enter(run, fmin(scheduled, corner));
    run->segment_over = 0;
    const double inside = middle(t, run->segment_end, run->settings.t_stop);
    const double *in[] = {&inside, run->p, run->d_given};
    run->inputs_version = run->inputs.version;
    lag_inputs_enter(&run->inputs, inside);
    for (int i = 0; i < model->n_modes; ++i)
        run->d_before[i] = run->d[i];
    lag_call(&model->modes, in, &run->d, run->work);
    lag_sampling_keep(run);
    lag_attitudes_keep(run);
    run->silent_table = lag_tables_read(model, run->event_a, run->event_b, inside, run->d);
    lag_inputs_read(&run->inputs, run->d);
}

/* How soon accelerations change by about themselves, and what of them is rounding of the time at which they were let go. */
static double find_slowness(LagRun *run, double longest, int may_bend)
{
    const double moment = lag_time_resolution(run->motion.t), slowness = lag_slowness(&run->motion, &run->scale, longest, may_bend ? 1 : 0);
    if (!may_bend || slowness > BLURRED * moment)
        return slowness;
    lag_onset_blur(&run->motion, &run->scale, BLURRED * moment);
    return lag_slowness(&run->motion, &run->scale, longest, 1);
}

/* `is_bend`: a switch has changed. Where accelerations are hardly another function of time for it, steps stay as they are. */
static double first_step(LagRun *run, int is_bend)
{
    const LagSettings *settings = &run->settings;
    const double t = run->motion.t, end = fmin(run->segment_end, settings->t_stop);
    double longest = isfinite(end) && end > t ? FIRST_PART * (end - t) : 1;
    if (settings->max_step > 0)
        longest = fmin(longest, settings->max_step);
    if (settings->first_step > 0)
        return fmin(longest, settings->first_step);
    if (is_bend)
        longest = fmin(longest, run->step);
    const int may_bend = run->model->n_switches > 0 && run->started;
    const double slowness = find_slowness(run, longest, may_bend);
    const int is_far = run->model->n_whens > 0 && longest > FAR * (t - settings->t_start); /* contacts are passed by then */
    const double past = is_far ? t - settings->t_start : INFINITY;
    if (may_bend)
        lag_onset_expect(&run->motion, &run->scale, fmin(fmin(slowness, longest), past));
    const int is_mild = slowness > MILD * longest || (run->sliding.count > 0 && slowness >= longest); /* what holds may change nothing */
    if (is_bend && is_mild)
        return longest;
    return fmin(longest, lag_first_step(&run->scale, slowness, run->methods.table->order));
}

/* What the loads will be: with switches as they will be, and nothing that holds. */
static void look_ahead(LagRun *run)
{
    const int is_live = run->switches.is_live, sliding = run->sliding.count;
    run->switches.is_live = run->model->n_switches > 0;
    run->sliding.count = 0;
    lag_onset_look(&run->motion, &run->scale, fmin(run->segment_end, run->settings.t_stop));
    run->switches.is_live = is_live;
    run->sliding.count = sliding;
    lag_switches_recall(run);
}

/* A table that says nothing here ends the run. */
static LagStatus look_at_tables(LagRun *run)
{
    if (run->silent_table < 0)
        return LAG_OK;
    run->segment_over = 1;
    return lag_fail(run, LAG_TABLE_ENDED, -1, 0, run->silent_table);
}

LagStatus lag_segment_evaluate(LagRun *run)
{
    LagMotion *motion = &run->motion;
    const int n = motion->n;
    motion->t_old = motion->t;
    lag_attitudes_move(run);
    if (look_at_tables(run) != LAG_OK)
        return run->failure.status;
    if (run->methods.solver == LAG_SOLVER_ORBIT) { /* the state or the equations are others now */
        lag_stepper_choose(run, run->choice.trouble(run, LAG_TROUBLE_DISTURBED));
        run->choice.reset(run);
    }
    const int is_bend = lag_delays_look_for_bend(run, lag_switches_enter(run)) && run->started;
    if (run->sliding.jams)
        return lag_fail(run, LAG_NO_IMPULSE, -1, 0, lag_impacts_striking(run));
    if (lag_turn_release(run) && run->sliding.count > run->methods.table->most_sliding)
        lag_turn_pass(run);
    else if (run->methods.table->begins_low)
        lag_stepper_lead(run);
    lag_account_begin(run);
    if (!lag_turn_evaluate(run)) {
        run->segment_over = 1;
        return lag_fail(run, LAG_NOT_FINITE, lag_first_not_finite(motion->slope + n, n), 1, 0);
    }
    lag_rest_note(run);
    lag_holds_enter(run);
    if (!run->methods.table->is_exact) {
        look_ahead(run);
        run->step = first_step(run, is_bend);
    }
    if (is_bend) /* steps before were of another motion */
        run->calm_step = fmin(run->calm_step, run->step);
    run->is_starting = 1;
    run->methods.table->restart(run->methods.self, motion);
    lag_step_set_units(run, run->step);
    lag_orbit_restart(run);
    lag_branch_forget(run);
    return LAG_OK;
}

/* Events at the start, by what is sampled there: what was held before is put back, and sampled anew in the order of the instant. */
static LagStatus strike_first(LagRun *run)
{
    const double t = run->motion.t, *y = run->motion.y;
    lag_account_open(run);
    lag_sampling_put_back(run);
    lag_impacts_hold_as_before(run);
    lag_sampling_take(run, t, y, 0);
    lag_impacts_note_jump(run, t, y);
    const LagStatus status = lag_impacts_strike(run);
    lag_project_present(run);
    lag_account_close(run);
    return status;
}

LagStatus lag_segment_begin(LagRun *run)
{
    const LagMotion *m = &run->motion;
    if (run->model->n_held > 0)
        lag_switches_look(run, m->t, m->y);
    const LagStatus status = run->model->n_held > 0 && lag_impacts_note_jump(run, m->t, m->y) ? strike_first(run) : LAG_OK;
    return status == LAG_OK ? lag_segment_evaluate(run) : status;
}

LagStatus lag_segment_next(LagRun *run)
{
    const double t = run->motion.t;
    const int was_known = t == run->segment_end;
    lag_account_come(run);
    lag_impacts_await_jump(run, t, run->motion.y);
    lag_walls_await_inputs(run, t, run->motion.y);
    const int is_new = run->inputs_version != run->inputs.version;
    double jump;
    lag_segment_enter(run);
    const int jumping = lag_inputs_jump(&run->inputs, run->d_before, run->d, t, is_new, &jump);
    if (jumping >= 0)
        return lag_fail(run, LAG_INPUT_JUMPS, jumping, 0, jump);
    lag_delays_await_kick(run);
    lag_kick(run, t, run->motion.y);
    lag_sampling_meet(run, t);
    lag_sampling_take(run, t, run->motion.y, 0);
    lag_impacts_note_jump(run, t, run->motion.y);
    LagStatus status = lag_impacts_strike(run);
    if (status != LAG_OK)
        return status;
    lag_delays_look_for_kick(run);
    lag_project_present(run);
    lag_account_leave(run);
    if (run->logged < run->most_logged)
        run->event_log[run->logged++] = t;
    ++run->statistics.events;
    run->scheduled += was_known;
    return lag_segment_evaluate(run);
}
