/* Model Exchange: the importer integrates q and v. Constraints of closed loops are kept in two ways.
 *
 * With P the projection onto the constraints (project.c), (Q, V) = P(q, v), the slopes are
 *     dq/dt = V + k (Q - q)       dv/dt = a(t, Q, V) + k (V - v).
 * On the constraints these are V and a; off them the distance decays with the rate k, and near singular positions, where the
 * accelerations of states off the constraints are wild, those of projected ones are not (E. Eich, SIAM J. Numer. Anal. 30
 * (1993)); outputs too are those of (Q, V). So no importer drifts, whatever it does about events. And when a completed step ends too far away all the same, an
 * event is asked for in which the state is projected.
 *
 * The energy account is integrated from completed step to completed step, over the polynomial of degree 5 between them where
 * that is the motion, and else along a motion of our own.
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
/* Of all energy, what the account may miss by errors of an importer's method, which add up: in its tolerances, at all and for each step
 * it tells of; at least and at most. */
static const double MISSED = 2e3, MISSED_EACH = 10, MISSED_ROUNDING = 1e-8, MOST_MISSED = 0.1;
static const double SOONER = 100, MOST_SOONER = 0.01; /* tolerances, and at most, of a step: so much sooner our run may meet its end */
static const double CLOSE = 1e-6; /* of the accelerations: the polynomial between two completed steps is the motion */

LagAnswer lag_instance_set_time(LagInstance *s, double t)
{
    if (!isfinite(t))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "the time is not finite");
    const int is_awaited = s->model->n_pieces > 0 && s->vital.inputs_changed; /* what moves places was set for this time */
    const LagAnswer answer = is_awaited ? LAG_ANSWER_OK : lag_instance_settle(s);
    s->vital.t = t;
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

static void take_slack(LagInstance *s)
{
    for (int k = 0; k < s->model->n_whens; ++k)
        if (s->indicators[lag_when(s->model, k)] >= (1 + CLEAR) * s->slack[k])
            s->slack[k] = 0;
}

LagAnswer lag_instance_get_indicators(LagInstance *s, double *indicators, size_t count)
{
    if (count != (size_t)s->model->n_switches || (count > 0 && !indicators))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "there are %d event indicators, not %lu",
                                s->model->n_switches, (unsigned long)count);
    LagAnswer answer = lag_instance_settle(s);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_indicators(s);
    if (answer == LAG_ANSWER_OK && count > 0)
        memcpy(indicators, s->indicators, count * sizeof *indicators);
    return answer;
}

/* ---------------------------------------------------------------- completed steps and events */

/* The run stands at a state (q, v). */
static void stand_at(LagInstance *s, double t, const double *x)
{
    LagMotion *motion = &s->run->motion;
    motion->t = motion->t_old = t;
    memset(motion->y, 0, (size_t)motion->size * sizeof *motion->y);
    memset(motion->carry, 0, (size_t)motion->size * sizeof *motion->carry);
    memcpy(motion->y, x, 2 * (size_t)motion->n * sizeof *x);
    lag_switches_start_anew(s->run);
}

/* The state at the share x of the last step, and its accelerations: q by the polynomial of degree 5 through both ends' q, v and
 * a, the others by its derivatives. */
static void state_between(const LagInstance *s, double x, double h, double *state, double *acceleration)
{
    const LagModel *m = s->model;
    for (int k = 0; k < m->n; ++k) {
        const int i = lag_fmu_place(m, k), r = lag_fmu_place(m, m->n + k);
        const double begin[3] = {s->last[i], s->last[r], s->last_slope[r]}, end[3] = {s->x[i], s->x[r], s->slope[r]};
        double found[3];
        lag_quintic(begin, end, h, x, found);
        state[i] = found[0];
        state[r] = found[1];
        acceleration[k] = found[2];
    }
    lag_attitudes_between(s, x, h, state, acceleration);
}

static int agree(const double *a, const double *b, int n)
{
    double size = 0, distance = 0;
    for (int i = 0; i < n; ++i) {
        size = fmax(size, fmax(fabs(a[i]), fabs(b[i])));
        distance = fmax(distance, fabs(a[i] - b[i]));
    }
    return distance <= CLOSE * size;
}

/* Dissipated and work over the last step, by Gauss-Lobatto quadrature with four nodes, two of them at the ends. Returns 0 when the
 * motion between the ends is not the polynomial's. */
static int account_by_polynomial(LagInstance *s, double h, double *sum)
{
    static const double INNER[2] = {0.27639320225002103, 0.72360679774997897}; /* (1 -+ 1/sqrt 5)/2 */
    const int n = s->model->n, states = lag_fmu_states(s->model);
    double *state = s->scratch, *slope = state + states, *acceleration = slope + states, power[2];
    int agrees = 1;
    for (int k = 0; k < 2; ++k)
        sum[k] = h / 12 * (s->last_power[k] + s->power[k]);
    for (int i = 0; i < 2; ++i) {
        state_between(s, INNER[i], h, state, acceleration);
        if (!lag_instance_slope_at(s, s->vital.last_time + h * INNER[i], state, slope, power))
            return 0;
        agrees &= agree(acceleration, slope + states - n, n);
        for (int k = 0; k < 2; ++k)
            sum[k] += h / 12 * 5 * power[k];
    }
    return agrees;
}

/* The same by a run of our own from the last state: importers that tell of every hundredth step only are held to account. A step often
 * ends at an event, which our run may meet a little sooner: it ends before that, and what is left has the power of its end. Not known
 * where it meets an event all the same, which the importer's step has not: that takes its share when it comes. Into `is_same`: whether
 * the equations are those that they were, which the importer must be told otherwise. */
static int account_by_run(LagInstance *s, double h, double *sum, int *is_same)
{
    LagRun *run = s->run;
    const int n = run->model->n;
    const double coarse = run->impacts.coarse, left = h * fmin(SOONER * s->vital.tolerance, MOST_SOONER), end = s->vital.t - left;
    const int64_t events = run->statistics.events;
    int done = 0;
    lag_switches_keep(run, s->switches);
    memcpy(s->modes, run->d, (size_t)run->model->n_modes * sizeof *run->d);
    stand_at(s, s->vital.last_time, lag_instance_plain(s, s->last));
    run->segment_over = 0;
    run->impacts.coarse = 0; /* errors are ours */
    run->guards.is_idle = 1; /* and so is the motion between two completed steps */
    run->segment_end = fmax(run->segment_end, s->vital.t); /* events are the importer's */
    const int is_known = lag_segment_evaluate(run) == LAG_OK && lag_run_advance(run, &end, 1, s->row, &done, 0) == LAG_OK;
    const double *account = s->row + 1 + 2 * n + run->model->n_outputs + 3;
    sum[0] = account[0] + left * s->power[0];
    sum[1] = account[1] + left * s->power[1];
    run->guards.is_idle = 0;
    if (run->model->n_pieces > 0 && run->statistics.events != events) /* by inputs as they were foreseen */
        memcpy(run->d, s->modes, (size_t)run->model->n_modes * sizeof *run->d);
    stand_at(s, s->vital.t, lag_instance_projected(s, s->vital.t, s->x));
    run->impacts.coarse = coarse;
    *is_same = lag_switches_resume(run, s->switches);
    lag_cones_note(run, s->vital.last_time, lag_instance_plain(s, s->last));
    return is_known && run->statistics.events == events;
}

/* Returns whether the equations are the same after it. */
static int keep_account(LagInstance *s)
{
    const double h = s->vital.t - s->vital.last_time;
    double sum[2];
    int is_same = 1;
    if (s->model->n_power == 2 && h > 0) {
        const int is_known = lag_instance_slope(s) == LAG_ANSWER_OK
            && (account_by_polynomial(s, h, sum) || account_by_run(s, h, sum, &is_same));
        s->vital.dissipated += is_known ? sum[0] : 0;
        s->vital.work += is_known ? sum[1] : 0;
        s->vital.is_unaccounted |= !is_known;
        s->vital.energies_are_current = 0;
    }
    if (!is_same)
        lag_instance_forget(s);
    lag_exchange_note(s);
    return is_same;
}

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

/* Whether a condition is another one than the equations hold, whatever the importer does about indicators, or what slides has been
 * drawn away by an input. */
static int has_switched_at(LagInstance *s)
{
    lag_instance_indicators(s);
    for (int i = 0; i < s->model->n_switches; ++i)
        if (s->indicators[i] < 0)
            return 1;
    return !lag_sliding_lasts(s->run);
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

/* A warning as long as the energy account misses more than errors of the importer's method explain; told when it begins. */
static LagAnswer judge_account(LagInstance *s)
{
    LagVital *vital = &s->vital;
    lag_instance_energies(s);
    for (int i = 0; i < LAG_ENERGY_RESIDUAL; ++i)
        if (isfinite(s->energies[i]))
            vital->energy_size = fmax(fabs(s->energies[i]), vital->energy_size);
    vital->energy_miss = fmax(fabs(s->energies[LAG_ENERGY_RESIDUAL]), vital->energy_miss);
    vital->steps += 1;
    const double explained = fmin(fmax(vital->tolerance * (MISSED + MISSED_EACH * vital->steps), MISSED_ROUNDING), MOST_MISSED);
    const int is_open = !vital->is_unaccounted && vital->energy_miss > explained * vital->energy_size;
    if (is_open && !vital->is_told_open)
        lag_instance_log(s, LAG_ANSWER_WARNING, "logStatusWarning",
                         "at t = %.6g s the energy account misses by %.1e J, more than a tolerance of %g explains: the states are not "
                         "the motion, which the importer has to integrate in smaller steps", vital->t, vital->energy_miss,
                         vital->tolerance);
    vital->is_told_open = is_open;
    return is_open ? LAG_ANSWER_WARNING : LAG_ANSWER_OK;
}

LagAnswer lag_instance_completed_step(LagInstance *s, int *needs_event)
{
    const LagAnswer answer = lag_instance_settle(s);
    const int has_switched = answer == LAG_ANSWER_OK && has_switched_at(s);
    take_slack(s);
    lag_scale_note(&s->run->scale, lag_instance_plain(s, s->x));
    const int has_changed = !keep_account(s);
    if (!has_switched)
        lag_cones_note(s->run, s->vital.t, lag_instance_projected(s, s->vital.t, s->x));
    *needs_event = answer == LAG_ANSWER_OK && (has_switched || has_changed || s->vital.t >= s->run->segment_end || is_astray(s));
    const LagAnswer met = answer == LAG_ANSWER_OK && s->model->n_guards > 0 ? meet_guards(s) : answer;
    return met == LAG_ANSWER_OK ? judge_account(s) : met;
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

/* What the equations hold from now on, and what slides; rates are reset. Returns whether the state was moved for it. */
static int switch_over(LagInstance *s)
{
    LagRun *run = s->run;
    const size_t n = (size_t)s->model->n, size = 2 * n * sizeof *s->x;
    if (s->model->n_switches == 0)
        return 0;
    const double *projected = lag_instance_projected(s, s->vital.t, s->x);
    stand_at(s, s->vital.t, projected);
    run->impacts.coarse = coarseness(s);
    lag_changes_note(run, NULL);
    choose_at_place(run);
    lag_cones_note_end(run);
    lag_impacts_note_jump(run, s->vital.t, run->motion.y);
    lag_impacts_strike(run);
    lag_cones_note_beyond(run);
    lag_cones_look(run);
    if (s->model->n_power == 2) {
        s->vital.dissipated += run->motion.y[2 * n];
        s->vital.work += run->motion.y[2 * n];
    }
    lag_switches_enter(run);
    lag_cones_begin(run);
    const int is_moved = memcmp(projected, run->motion.y, size) != 0;
    if (is_moved)
        lag_instance_tell(s, run->motion.y, s->x);
    return is_moved;
}

/* The modes after this time, and the impulses that come with them; a state that has gone astray is brought back. */
static int begin_segment(LagInstance *s)
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
        stand_at(s, s->vital.t, x);
        lag_scale_note(&run->scale, x);
        lag_project_present(run);
        lag_instance_tell(s, run->motion.y, s->x);
    }
    lag_sampling_meet(run, s->vital.t);
    lag_sampling_take(run, s->vital.t, lag_instance_plain(s, s->x), 0);
    const int is_moved = switch_over(s);
    give_slack(s);
    lag_energies(run, s->vital.t, lag_instance_plain(s, s->x), after);
    if (!astray) /* what projecting adds or takes is an error, and shows as one */
        s->vital.work += after[2] - before[2];
    lag_instance_forget(s);
    return astray || kicked || is_moved;
}

LagAnswer lag_instance_update_discrete(LagInstance *s, LagEventInfo *info)
{
    LagAnswer answer = lag_instance_settle(s);
    if (answer != LAG_ANSWER_OK)
        return answer;
    if (s->kind == LAG_MODEL_EXCHANGE) {
        info->values_changed = begin_segment(s);
        lag_exchange_note(s);
        if (s->model->n_guards > 0)
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
