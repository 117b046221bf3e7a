/* Co-Simulation: the run steps as it likes and communication points are rows inside its steps, until something is set at one
 * of them: then the run is cut there and goes on anew. So a scene that nobody disturbs costs what it costs alone. Events end a
 * communication step where the importer has event mode and lets steps return early; else they are only told of.
 */
#include <math.h>
#include <string.h>

#include "fmi/instance.h"

#include "model/schedule.h"
#include "run/advance.h"
#include "state/state.h"
#include "steps/step.h"

static const double LONGEST_STEP = 1e6, CLOSE = 1e-6; /* s; of a step */
enum { MOST_STEPS = 10000000 };

static LagAnswer check_step(const LagInstance *s, double t, double h)
{
    const LagVital *vital = &s->vital;
    if (!(h > 0 && h <= LONGEST_STEP))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "a step of %g s is not taken: 0 < h <= %g", h, LONGEST_STEP);
    if (!(fabs(t - vital->t) <= CLOSE * h + lag_time_resolution(vital->t)))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "the step begins at %.17g s, but the time is %.17g s", t,
                                vital->t);
    if (vital->has_stop && t + h > vital->stop + CLOSE * h + lag_time_resolution(vital->stop))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "a step from %.17g by %g s goes past the stop time %.17g s",
                                t, h, vital->stop);
    return LAG_ANSWER_OK;
}

/* Whether inputs change in the step that begins: those slopes that were not given for it end. */
static int begin_slopes(LagInstance *s)
{
    int some = 0;
    for (int i = 0; i < s->model->n_inputs; ++i) {
        s->u_slope[i] = s->vital.has_slopes ? s->u_slope[i] : 0;
        some |= s->u_slope[i] != 0;
    }
    s->vital.has_slopes = 0;
    return some;
}

/* What moves places goes on as its rates say; where its slope was given instead, the rates beside it say nothing. */
static void extrapolate_pieces(const LagInstance *s, double h, double *before, double *after)
{
    for (int k = 0; k < s->model->n_pieces; ++k) {
        const int *places = s->model->pieces + 4 * k, y = places[0], rate = places[1], second = places[2];
        if (rate < 0)
            continue;
        if (s->u_slope[y] != 0) {
            before[rate] = after[rate] = NAN;
        } else {
            after[y] = s->u[y] + h * (s->u[rate] + h * s->u[second] / 2);
            after[rate] = s->u[rate] + h * s->u[second];
        }
    }
}

/* Inputs go on with their slopes over this step; from its end on they are held, unless told otherwise. */
static LagAnswer interpolate_inputs(LagInstance *s, double end)
{
    const int n = s->model->n_inputs;
    double *times = s->table, *values = s->table + 2;
    times[0] = s->vital.t;
    times[1] = end;
    for (int i = 0; i < n; ++i) {
        values[i] = s->u[i];
        values[n + i] = s->u[i] + s->u_slope[i] * (end - s->vital.t);
    }
    extrapolate_pieces(s, end - s->vital.t, values, values + n);
    LagStatus status = lag_run_cut(s->run, s->vital.t);
    if (status == LAG_OK)
        status = lag_run_set_inputs(s->run, times, values, 2);
    return status == LAG_OK ? LAG_ANSWER_OK : lag_instance_failed(s, status);
}

/* Where they are after a step that began at `begin`. */
static void keep_inputs(LagInstance *s, double begin)
{
    const double h = s->vital.t - begin;
    for (int i = 0; i < s->model->n_inputs; ++i)
        s->u[i] += s->u_slope[i] * h;
    for (int k = 0; k < s->model->n_pieces; ++k) {
        const int *places = s->model->pieces + 4 * k;
        if (places[1] >= 0 && s->u_slope[places[0]] == 0) {
            s->u[places[0]] += h * (s->u[places[1]] + h * s->u[places[2]] / 2);
            s->u[places[1]] += h * s->u[places[2]];
        }
    }
    s->vital.inputs_changed = 1;
}

static LagAnswer advance(LagInstance *s, double target)
{
    int done = 0;
    const LagStatus status = lag_run_advance(s->run, &target, 1, s->row, &done, 0);
    lag_instance_warn(s);
    if (status == LAG_ENDED)
        lag_instance_end(s);
    else if (status != LAG_OK)
        return lag_instance_failed(s, status);
    if (done > 0)
        lag_cosimulation_take(s);
    return LAG_ANSWER_OK;
}

/* Whether the latest step of the run has ended at a condition that changes. */
static int is_state_event(const LagRun *run)
{
    int some = 0;
    for (int i = 0; i < run->model->n_switches && run->segment_over; ++i)
        some |= run->switches.turned[i] != LAG_STAYS;
    return some;
}

/* Until the target, or an event that has not been told of; the run may step beyond the target. */
static LagAnswer advance_to_event(LagInstance *s, double target, LagStepResult *result)
{
    LagRun *run = s->run;
    const double begin = s->vital.t;
    int is_event = run->motion.t > begin + lag_time_resolution(begin) && is_state_event(run);
    run->wanted = target;
    run->row_spacing = target - run->motion.t;
    while (run->motion.t < target && !(is_event && s->may_return_early)) {
        const LagStatus status = lag_advance_step(run);
        if (status == LAG_ENDED)
            return advance(s, target);
        if (status != LAG_OK)
            return lag_instance_failed(s, status);
        result->is_event |= is_event;
        is_event = is_state_event(run);
    }
    result->is_event |= is_event && run->motion.t <= target + lag_time_resolution(target);
    result->is_early |= run->motion.t < target - lag_time_resolution(target);
    return advance(s, result->is_early && run->motion.t < target ? run->motion.t : target);
}

/* One internal step after another, each followed by the importer's intermediate update; inputs that it sets hold from there on. */
static LagAnswer advance_watched(LagInstance *s, double target, LagStepResult *result)
{
    double wanted = INFINITY;
    lag_run_set_stop(s->run, target);
    while (s->vital.t < target && s->vital.t < wanted) {
        int done = 0;
        const LagStatus status = lag_run_advance_steps(s->run, 1, s->row, &done, 0);
        lag_instance_warn(s);
        if (status == LAG_ENDED)
            lag_instance_end(s);
        else if (status != LAG_OK)
            return lag_instance_failed(s, status);
        if (done == 0)
            break;
        lag_cosimulation_take(s);
        const int is_event = s->uses_events && is_state_event(s->run);
        double time = target;
        s->vital.mode = LAG_MODE_INTERMEDIATE;
        const int early = s->intermediate(s, s->vital.t, &time);
        s->vital.mode = LAG_MODE_STEP;
        result->is_event |= is_event;
        const LagAnswer answer = s->vital.inputs_changed ? lag_instance_settle(s) : LAG_ANSWER_OK;
        if (answer != LAG_ANSWER_OK)
            return answer;
        lag_run_set_stop(s->run, target);
        if (s->may_return_early && (early || is_event))
            wanted = is_event ? s->vital.t : time;
    }
    result->is_early |= s->vital.t < target;
    return LAG_ANSWER_OK;
}

/* Where the step ends at the latest: at an event of a known time, where one is asked for. */
static double end_of_step(const LagInstance *s, double t, double h, LagStepResult *result)
{
    const LagVital *vital = &s->vital;
    const LagRun *run = s->run;
    const double target = vital->has_stop ? fmin(t + h, vital->stop) : t + h;
    const double event = lag_schedule_next(s->model, run->event_a, run->event_b, vital->t);
    if (!s->uses_events || event > target + lag_time_resolution(target))
        return target;
    result->is_event = 1;
    result->is_early = s->may_return_early && event < target - lag_time_resolution(target);
    return s->may_return_early ? event : target;
}

/* A warning as long as rows are not those of the scene; told when it begins. */
static LagAnswer judge_account(LagInstance *s)
{
    const LagStatistics *statistics = lag_run_statistics(s->run);
    const int is_news = statistics->energy_is_open && !s->vital.is_told_open;
    s->vital.is_told_open = statistics->energy_is_open;
    if (is_news)
        lag_instance_log(s, LAG_ANSWER_WARNING, "logStatusWarning",
                         "from t = %.6g s on the energy account misses by %.1e J, more than the tolerance %g explains: the values are not "
                         "the motion, which needs a smaller tolerance", statistics->energy_open, statistics->energy_residual,
                         s->vital.tolerance);
    return statistics->energy_is_open ? LAG_ANSWER_WARNING : LAG_ANSWER_OK;
}

LagAnswer lag_instance_step(LagInstance *s, double t, double h, LagStepResult *result)
{
    LagVital *vital = &s->vital;
    LagRun *run = s->run;
    const double begin = vital->t;
    result->is_event = result->is_early = 0;
    result->time = vital->t;
    LagAnswer answer = check_step(s, t, h);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_settle(s);
    if (answer != LAG_ANSWER_OK)
        return answer;
    const double target = end_of_step(s, t, h, result);
    const int has_slopes = begin_slopes(s);
    if (has_slopes)
        answer = interpolate_inputs(s, target);
    lag_run_set_stop(run, vital->has_stop ? vital->stop : INFINITY);
    run->settings.max_steps = run->statistics.steps + MOST_STEPS;
    if (answer == LAG_ANSWER_OK && s->intermediate)
        answer = advance_watched(s, target, result);
    else if (answer == LAG_ANSWER_OK && s->uses_events)
        answer = advance_to_event(s, target, result);
    else if (answer == LAG_ANSWER_OK)
        answer = advance(s, target);
    result->time = vital->t;
    result->is_early |= vital->is_over && s->may_return_early && vital->t < target - lag_time_resolution(target);
    if (has_slopes)
        keep_inputs(s, begin);
    return answer == LAG_ANSWER_OK ? judge_account(s) : answer;
}

LagAnswer lag_instance_input_slope(LagInstance *s, unsigned int reference, int order, double value)
{
    int index = 0;
    if (lag_instance_locate(s->fmu, reference, &index) != LAG_GROUP_INPUT || order != 1 || !isfinite(value))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "inputs have first derivatives that are finite, and no others");
    if (!s->vital.has_slopes) /* those in force are of the last step */
        memset(s->u_slope, 0, (size_t)s->model->n_inputs * sizeof *s->u_slope);
    s->u_slope[index] = value;
    s->vital.has_slopes = 1;
    return LAG_ANSWER_OK;
}
