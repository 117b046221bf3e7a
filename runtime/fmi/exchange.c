/* Model Exchange: the importer integrates q and v. Constraints of closed loops are kept in two ways.
 *
 * With P the projection onto the constraints (project.c), (Q, V) = P(q, v), the slopes are
 *     dq/dt = V + k (Q - q)       dv/dt = a(t, Q, V) + k (V - v).
 * On the constraints these are V and a; off them the distance decays with the rate k, and near singular positions, where the
 * accelerations of states off the constraints are wild, those of projected ones are not (E. Eich, SIAM J. Numer. Anal. 30
 * (1993)); outputs too are those of (Q, V). So no importer drifts, whatever it does about events. And when a completed step ends too far away all the same, an
 * event is asked for in which the state is projected.
 * The energy account is kept from completed step to completed step: exchange_steps.c.
 */
#include <math.h>
#include <string.h>

#include "fmi/instance.h"

#include "events/accelerations.h"
#include "events/changes.h"
#include "events/conditions.h"
#include "events/cones.h"
#include "events/contacts.h"
#include "events/sampling.h"
#include "events/walls.h"
#include "model/function.h"
#include "model/schedule.h"
#include "steps/segment.h"
#include "state/state.h"

static const double FARTHEST = 1e-7; /* correction of a position, of its nominal value, that is left to the stabilisation */
static const double AFTER_EVENTS = 10; /* errors of an importer's first steps, in its tolerances */
static const double CLEAR = 2;     /* slacks: farther from its place a condition needs none */

LagAnswer lag_instance_set_time(LagInstance *s, double t)
{
    if (!isfinite(t))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "the time is not finite");
    /* Inputs that were set and not asked for are of this time: what moves places, and those of importers that set them first. */
    const int is_awaited = s->vital.inputs_changed && !s->vital.parameters_changed
        && (s->model->n_pieces > 0 || (s->vital.mode & LAG_MODE_CONTINUOUS) != 0);
    const LagAnswer answer = is_awaited ? LAG_ANSWER_OK : lag_instance_settle(s);
    s->vital.t = t;
    lag_exchange_hold_inputs(s);
    lag_instance_forget(s);
    return answer;
}

static LagAnswer check_count(const LagInstance *s, const double *x, size_t count)
{
    if (count == (size_t)lag_fmu_states(s->model) && (x || count == 0))
        return LAG_ANSWER_OK;
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "there are %d states, not %lu", lag_fmu_states(s->model),
                            (unsigned long)count);
}

LagAnswer lag_instance_set_states(LagInstance *s, const double *x, size_t count)
{
    const LagAnswer answer = check_count(s, x, count);
    if (answer != LAG_ANSWER_OK)
        return answer;
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(x[i]))
            return lag_instance_log(s, LAG_ANSWER_DISCARD, "logStatusDiscard", "%.200s is not finite", s->fmu->names[1 + i]);
    if (!lag_instance_has_attitudes(s->model, x))
        return lag_instance_log(s, LAG_ANSWER_DISCARD, "logStatusDiscard", "a quaternion of the length 0 is no attitude");
    if (count > 0)
        memcpy(s->x, x, count * sizeof *x);
    lag_instance_forget(s);
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_get_states(LagInstance *s, double *x, size_t count)
{
    LagAnswer answer = check_count(s, x, count);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_settle(s);
    if (answer == LAG_ANSWER_OK && count > 0)
        memcpy(x, s->x, count * sizeof *x);
    return answer;
}

LagAnswer lag_instance_get_slopes(LagInstance *s, double *slope, size_t count)
{
    LagAnswer answer = check_count(s, slope, count);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_settle(s);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_slope(s);
    if (answer == LAG_ANSWER_OK && count > 0)
        memcpy(slope, s->slope, count * sizeof *slope);
    return answer;
}

LagAnswer lag_instance_nominals(LagInstance *s, double *nominal, size_t count)
{
    const LagAnswer answer = check_count(s, nominal, count);
    if (answer == LAG_ANSWER_OK && count > 0)
        memcpy(nominal, s->fmu->nominal, count * sizeof *nominal);
    return answer;
}

/* How far the condition of event k may be beyond its place without being taken for it, where it has just come: of a contact that of
 * its gap; while something rests, none. */
static double event_margin(const LagRun *run, int k)
{
    const int i = lag_when(run->model, k);
    if (!run->impacts.has_contact[k])
        return lag_contacts_margin(run, i);
    return run->switches.slides[lag_contact(run->model, k)] ? 0 : lag_contacts_margin(run, lag_gap(run->model, k));
}

/* At an event: states are errors of the importer away from places at which they are. From there on conditions are given a slack until
 * they are clear of it, so that what has come does not come again; all others change sign where they are. */
static void give_slack(LagInstance *s)
{
    for (int k = 0; k < s->model->n_whens; ++k)
        s->slack[k] = 0;
    lag_instance_indicators(s);
    for (int k = 0; k < s->model->n_whens; ++k) {
        const double margin = event_margin(s->run, k);
        s->slack[k] = s->indicators[lag_when(s->model, k)] < CLEAR * margin ? margin : 0;
    }
}

/* Of the indicators that were found last. */
static void take_slack(LagInstance *s)
{
    for (int k = 0; k < s->model->n_whens; ++k) {
        double *indicator = &s->indicators[lag_when(s->model, k)];
        if (!(*indicator >= (1 + CLEAR) * s->slack[k]))
            continue;
        *indicator -= s->slack[k];
        s->slack[k] = 0;
    }
}

LagAnswer lag_instance_get_indicators(LagInstance *s, double *indicators, size_t count)
{
    if (count != (size_t)s->model->n_switches || (count > 0 && !indicators))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "there are %d event indicators, not %lu",
                                s->model->n_switches, (unsigned long)count);
    LagAnswer answer = lag_instance_settle(s);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_indicators(s);
    if (answer == LAG_ANSWER_OK && s->kind == LAG_MODEL_EXCHANGE && (s->vital.mode & LAG_MODE_CONTINUOUS) != 0)
        take_slack(s); /* importers may tell of no step that is completed before the next event */
    if (answer == LAG_ANSWER_OK && count > 0)
        memcpy(indicators, s->indicators, count * sizeof *indicators);
    return answer;
}

/* ---------------------------------------------------------------- completed steps and events */

/* Whether the positions are too far from the constraints. */
static int is_astray(LagInstance *s)
{
    LagRun *run = s->run;
    const LagModel *m = s->model;
    const double t = s->vital.t, *in[] = {&t, lag_instance_plain(s, s->x), run->u, run->d, run->c};
    double *out[] = {run->projection.correction};
    if (m->n_holonomic == 0 || lag_call(&m->place, in, out, run->work) != 0)
        return 0;
    for (int i = 0; i < m->n; ++i)
        if (fabs(out[0][i]) > FARTHEST * s->fmu->nominal[lag_fmu_place(m, i)])
            return 1;
    return 0;
}

/* Whether a condition is another one than the equations hold, whatever the importer does about indicators. */
static int has_switched_at(LagInstance *s)
{
    lag_instance_indicators(s);
    for (int i = 0; i < s->model->n_switches; ++i)
        if (s->indicators[i] < 0)
            return 1;
    return 0;
}

/* Whether what slides has been drawn away, which the event puts back as far as its force could have held it over the step. */
static int is_drawn(LagInstance *s, int has_switched)
{
    const double h = s->vital.t - s->vital.last_time;
    const int is_drawn = !lag_sliding_lasts(s->run);
    if (h > 0)
        s->run->sliding.drawn = is_drawn && !has_switched ? h : 0;
    return is_drawn;
}

/* Where the importer has come to: between completed steps nobody looks. */
static LagAnswer meet_guards(LagInstance *s)
{
    const LagStatus status = lag_guards_meet(s->run, s->vital.t, lag_instance_projected(s, s->vital.t, s->x));
    lag_instance_warn(s);
    if (status == LAG_ENDED)
        lag_instance_end(s);
    return status == LAG_OK || status == LAG_ENDED ? LAG_ANSWER_OK : lag_instance_failed(s, status);
}

LagAnswer lag_instance_completed_step(LagInstance *s, int *needs_event)
{
    const LagAnswer answer = lag_instance_settle(s);
    int has_switched = answer == LAG_ANSWER_OK && has_switched_at(s);
    has_switched |= answer == LAG_ANSWER_OK && is_drawn(s, has_switched);
    take_slack(s);
    lag_scale_note(&s->run->scale, lag_instance_plain(s, s->x));
    const int has_changed = !lag_exchange_keep_account(s);
    if (!has_switched)
        lag_cones_note(s->run, s->vital.t, lag_instance_projected(s, s->vital.t, s->x));
    *needs_event = answer == LAG_ANSWER_OK && (has_switched || has_changed || s->vital.t >= s->run->segment_end || is_astray(s));
    const LagAnswer met = answer == LAG_ANSWER_OK && s->model->n_guards > 0 ? meet_guards(s) : answer;
    return met == LAG_ANSWER_OK ? lag_exchange_judge_account(s) : met;
}

static double next_event(LagInstance *s)
{
    return lag_schedule_next(s->model, s->run->event_a, s->run->event_b, s->vital.t);
}

/* How far off the importer's states may be, by what an error of ours is. */
static double coarseness(LagInstance *s)
{
    const double *x = lag_instance_plain(s, s->x);
    double most = 1;
    for (int i = 0; i < s->model->n; ++i) {
        const double unit = lag_scale_unit(&s->run->scale, i, x, x);
        most = fmax(AFTER_EVENTS * s->vital.tolerance * s->fmu->nominal[lag_fmu_place(s->model, i)] / unit, most);
    }
    return isfinite(most) ? most : 1;
}

/* Bends that are at their very place have not been passed: what they hold is chosen by the way they go. The start lies on many, as on
 * that of abs(sin(t)). */
static void choose_at_place(LagRun *run)
{
    LagSwitches *s = &run->switches;
    for (int i = 0; i < lag_when(run->model, 0); ++i)
        if (s->turned[i] == LAG_CHANGES && s->g[i] == 0)
            s->turned[i] = LAG_STAYS;
}

/* What has gone over to the other side with inputs that have jumped has not come to rest on the way, nor has what slips in the plane. */
static void pass_with_inputs(LagInstance *s)
{
    LagRun *run = s->run;
    const int first = run->model->switches_need_acceleration ? lag_when(run->model, 0) : 0;
    if (!lag_exchange_has_jumped(s))
        return;
    lag_cones_note(run, run->motion.t, run->motion.y);
    for (int i = 0; i < first; ++i)
        if (run->switches.turned[i] == LAG_CHANGES && fabs(run->switches.g[i]) > lag_sliding_drift(run, i))
            run->switches.turned[i] = LAG_STAYS;
}

/* Events at an instant, and those that come at once by what is held after them. */
static LagStatus strike(LagRun *run)
{
    LagStatus status = LAG_OK;
    run->impacts.in_a_row = 0; /* time passes between the importer's */
    do {
        status = lag_impacts_strike(run);
        lag_cones_note_beyond(run);
        lag_cones_look(run);
        lag_switches_enter(run);
        lag_sampling_meet(run, run->motion.t); /* each instant is sampled once */
    } while (status == LAG_OK && run->impacts.comes_next);
    if (status == LAG_OK && run->sliding.jams)
        return lag_fail(run, LAG_NO_IMPULSE, -1, 0, lag_impacts_striking(run));
    return status;
}

/* What the equations hold from now on, and what slides; rates are reset. Tells whether the state was moved for it. */
static LagStatus switch_over(LagInstance *s, int *is_moved)
{
    LagRun *run = s->run;
    const size_t n = (size_t)s->model->n, size = 2 * n * sizeof *s->x;
    *is_moved = 0;
    if (s->model->n_switches == 0)
        return LAG_OK;
    const double *projected = lag_instance_projected(s, s->vital.t, s->x);
    lag_exchange_stand_at(s, s->vital.t, projected);
    run->impacts.coarse = coarseness(s);
    lag_changes_note(run, NULL);
    choose_at_place(run);
    pass_with_inputs(s);
    lag_cones_note_end(run);
    lag_impacts_note_jump(run, s->vital.t, run->motion.y);
    const LagStatus status = strike(run);
    if (s->model->n_power == 2) {
        s->vital.dissipated += run->motion.y[2 * n];
        s->vital.work += run->motion.y[2 * n];
    }
    lag_cones_begin(run);
    *is_moved = memcmp(projected, run->motion.y, size) != 0;
    if (*is_moved)
        lag_instance_tell(s, run->motion.y, s->x);
    return status;
}

/* The modes after this time, and the impulses that come with them; a state that has gone astray is brought back. Tells whether the
 * state is another one. */
static LagStatus begin_segment(LagInstance *s, int *is_changed)
{
    LagRun *run = s->run;
    double before[3], after[3], *x = lag_instance_plain(s, s->x);
    lag_energies(run, s->vital.t, x, before);
    run->motion.t = run->motion.t_old = s->vital.t;
    lag_impacts_await_jump(run, s->vital.t, x);
    lag_walls_await_inputs(run, s->vital.t, x);
    lag_walls_await_errors(run);
    lag_segment_enter(run);
    const int kicked = lag_kick(run, s->vital.t, x);
    if (kicked)
        lag_instance_tell(s, x, s->x);
    const int astray = is_astray(s);
    if (astray) {
        x = lag_instance_plain(s, s->x);
        lag_exchange_stand_at(s, s->vital.t, x);
        lag_scale_note(&run->scale, x);
        lag_project_present(run);
        lag_instance_tell(s, run->motion.y, s->x);
    }
    lag_sampling_meet(run, s->vital.t);
    lag_sampling_take(run, s->vital.t, lag_instance_plain(s, s->x), 0);
    int is_moved;
    const LagStatus status = switch_over(s, &is_moved);
    run->sliding.drawn = 0;
    give_slack(s);
    lag_energies(run, s->vital.t, lag_instance_plain(s, s->x), after);
    if (!astray) /* what projecting adds or takes is an error, and shows as one */
        s->vital.work += after[2] - before[2];
    lag_instance_forget(s);
    *is_changed = astray || kicked || is_moved;
    return status;
}

LagAnswer lag_instance_update_discrete(LagInstance *s, LagEventInfo *info)
{
    LagAnswer answer = lag_instance_settle(s);
    if (answer != LAG_ANSWER_OK)
        return answer;
    if (s->kind == LAG_MODEL_EXCHANGE) {
        const LagStatus status = begin_segment(s, &info->values_changed);
        lag_exchange_note(s);
        if (status != LAG_OK)
            answer = lag_instance_failed(s, status);
        else if (s->model->n_guards > 0)
            answer = meet_guards(s);
        if (answer != LAG_ANSWER_OK)
            return answer;
    } else if (s->run->segment_over && s->run->motion.t == s->vital.t) {
        const LagStatus status = lag_segment_next(s->run);
        if (status != LAG_OK)
            return lag_instance_failed(s, status);
        lag_cosimulation_take_row(s);
    }
    const double next = next_event(s);
    info->has_next = isfinite(next);
    info->next = info->has_next ? next : 0;
    return LAG_ANSWER_OK;
}
