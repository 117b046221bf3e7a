/* Between two completed steps of an importer of Model Exchange: what inputs do, which it sets at times and tells no rates of, and the
 * energy account, over the polynomial of degree 5 between the two where that is the motion, and else along a motion of our own.
 *
 * Rates of inputs are those of a parabola through what they were at the two completed steps before and are now, or of a line after they
 * have jumped: what is held at an input follows it with the force that takes. What they work is that of the same, and of straight lines
 * in a run of our own.
 */
#include <math.h>
#include <string.h>

#include "fmi/instance.h"

#include "events/changes.h"
#include "events/cones.h"
#include "model/schedule.h"
#include "steps/segment.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double MOMENT = 1e-6; /* of a step: of less no rate is known but the last one */
/* Of all energy, what the account may miss by errors of an importer's method, which add up: in its tolerances, at all and for each step
 * it tells of; at least and at most. */
static const double MISSED = 2e3, MISSED_EACH = 10, MISSED_ROUNDING = 1e-8, MOST_MISSED = 0.1;
static const double MOST_DOUBTED = 3; /* times what inputs may have done otherwise: at the end of a step its power may be less */
static const double SOONER = 100, MOST_SOONER = 0.01; /* tolerances, and at most, of a step: so much sooner our run may meet its end */
/* Of the accelerations: the polynomial between two completed steps is the motion; and is more so than a run of our own by straight lines
 * of inputs. */
static const double CLOSE = 1e-6, CLOSER_THAN_LINES = 1e-4;

enum { MOST_STEPS = 10000 }; /* of our run for one of an importer's */

/* ---------------------------------------------------------------- inputs */

/* A table of inputs is in force from its first row on. */
static void put_inputs(LagRun *run, const double *times, const double *values, int rows)
{
    lag_inputs_set(&run->inputs, times, values, rows); /* there is room for two */
    lag_inputs_enter(&run->inputs, times[0]);
    lag_inputs_read(&run->inputs, run->d);
}

/* Whether inputs say their rates themselves. */
static int tell_rates(const LagModel *m)
{
    for (int k = 0; k < m->n_pieces; ++k)
        if (m->pieces[4 * k + 1] >= 0)
            return 1;
    return 0;
}

/* Whether polynomials go on at rates that are found here. */
static int has_pieces(const LagInstance *s)
{
    return s->model->n_pieces > 0 && s->foreseen.rows == 0 && !tell_rates(s->model);
}

void lag_exchange_hold_inputs(LagInstance *s)
{
    if (s->vital.has_started && has_pieces(s))
        put_inputs(s->run, &s->vital.t, s->u, 1);
}

/* Those that have jumped go on at the rates they had, of which no more is known. */
static void begin_inputs(LagInstance *s)
{
    for (int i = 0; i < s->model->n_inputs; ++i) {
        if (s->vital.knows_inputs && s->last_u[i] == s->u[i])
            continue;
        s->last_u[i] = s->u[i];
        s->earlier_u[i] = NAN;
        s->last_rate[i] = s->vital.knows_inputs ? s->last_rate[i] : 0;
        s->rate[i] = s->last_rate[i];
    }
    s->vital.knows_inputs = s->model->n_inputs > 0;
}

/* Of so long a step more is known than the last rate. */
static int tells_rate(const LagInstance *s, int i, double h)
{
    const int has_two = !isnan(s->earlier_u[i]);
    return h > (has_two ? MOMENT * (s->vital.last_time - s->vital.earlier_time) : lag_time_resolution(s->vital.t) / MOMENT);
}

void lag_exchange_draw_inputs(LagInstance *s)
{
    const LagVital *vital = &s->vital;
    const double h = vital->t - vital->last_time, before = vital->last_time - vital->earlier_time;
    for (int i = 0; i < s->model->n_inputs; ++i) {
        const double rate = (s->u[i] - s->last_u[i]) / h;
        const double earlier = isnan(s->earlier_u[i]) ? rate : (s->last_u[i] - s->earlier_u[i]) / before;
        s->rate[i] = tells_rate(s, i, h) ? rate + (rate - earlier) * h / (h + before) : s->last_rate[i];
    }
}

double lag_exchange_rate_by_input(const LagInstance *s, int i)
{
    const double h = s->vital.t - s->vital.last_time, both = s->vital.t - s->vital.earlier_time;
    if (s->kind == LAG_CO_SIMULATION || !s->vital.knows_inputs || !tells_rate(s, i, h))
        return 0;
    return 1 / h + (isnan(s->earlier_u[i]) ? 0 : 1 / both);
}

/* Importers try other inputs there, as for derivatives, and go back to those that were. */
static void jump(LagInstance *s)
{
    const size_t size = (size_t)s->model->n_inputs * sizeof *s->u;
    if (!s->vital.has_jump)
        memcpy(s->before_jump, s->last_u, 3 * size);
    const int is_undone = s->vital.has_jump && memcmp(s->before_jump, s->u, size) == 0;
    if (is_undone)
        memcpy(s->last_u, s->before_jump, 3 * size);
    else
        begin_inputs(s);
    s->vital.has_jump = !is_undone;
}

void lag_exchange_jump_inputs(LagInstance *s)
{
    double power[2];
    const int was_noted = s->vital.knows_inputs;
    jump(s);
    if (was_noted && s->model->n_power == 2
        && lag_instance_slope_at(s, s->vital.last_time, s->last, s->scratch, power)) {
        memcpy(s->last_slope, s->scratch, (size_t)lag_fmu_states(s->model) * sizeof *s->scratch);
        memcpy(s->last_power, power, sizeof power);
    }
}

int lag_exchange_has_jumped(const LagInstance *s)
{
    const size_t size = (size_t)s->model->n_inputs * sizeof *s->u;
    const int is_there = s->vital.knows_inputs && s->vital.t == s->vital.last_time;
    return is_there && (s->vital.has_jump || memcmp(s->u, s->last_u, size) != 0);
}

/* On its way there, which nobody tells: of one that moves places all is open then. */
void lag_exchange_widen(LagInstance *s, int i)
{
    s->least_u[i] = fmin(s->u[i], s->least_u[i]);
    s->most_u[i] = fmax(s->u[i], s->most_u[i]);
    s->vital.is_unaccounted |= s->model->n_pieces > 0;
}

/* By how much one may have been another than it is taken for over the last step of h: what it was set to beside its way from there to
 * here, and what its last rate does not foretell of that. */
static double doubt_of_input(const LagInstance *s, int i, double h)
{
    const double way = s->u[i] - s->last_u[i], range = s->most_u[i] - s->least_u[i];
    return fmin(range, range - fabs(way) + fabs(way - s->last_rate[i] * h));
}

static void note_inputs(LagInstance *s)
{
    const size_t size = (size_t)s->model->n_inputs * sizeof *s->u;
    if (size == 0)
        return;
    s->vital.has_jump = 0;
    memcpy(s->least_u, s->u, size);
    memcpy(s->most_u, s->u, size);
    if (s->vital.t == s->vital.last_time || !s->vital.knows_inputs) {
        begin_inputs(s);
    } else {
        lag_exchange_draw_inputs(s);
        memcpy(s->earlier_u, s->last_u, size);
        memcpy(s->last_u, s->u, size);
        memcpy(s->last_rate, s->rate, size);
        s->vital.earlier_time = s->vital.last_time;
    }
    lag_exchange_hold_inputs(s);
}

/* The straight line that they go along at the share x of the last step of h, by the parabola. */
static void bend_inputs(LagInstance *s, double x, double h)
{
    const int n = s->model->n_inputs;
    const double t = s->vital.last_time + x * h, before = s->vital.last_time - s->vital.earlier_time;
    double *times = s->table, *values = s->table + 2;
    times[0] = t - h;
    times[1] = t + h;
    for (int i = 0; i < n; ++i) {
        const double rate = (s->u[i] - s->last_u[i]) / h;
        const double bend = isnan(s->earlier_u[i]) ? 0 : (rate - (s->last_u[i] - s->earlier_u[i]) / before) / (h + before);
        const double value = s->last_u[i] + x * h * (rate - (1 - x) * h * bend), rise = h * (rate - (1 - 2 * x) * h * bend);
        values[i] = value - rise;
        values[n + i] = value + rise;
    }
    put_inputs(s->run, times, values, 2);
}

/* Whether they have moved over the last step, or go on at rates. */
static int are_moving(const LagInstance *s)
{
    for (int i = 0; i < s->model->n_inputs; ++i)
        if (s->u[i] != s->last_u[i] || (has_pieces(s) && (s->rate[i] != 0 || s->last_rate[i] != 0)))
            return 1;
    return 0;
}

/* Puts them on straight lines over the last step, where they move: returns whether they do, and since when they are held. */
static int move_inputs(LagInstance *s, double *since)
{
    const size_t n = (size_t)s->model->n_inputs, size = n * sizeof *s->u;
    double *times = s->table, *values = s->table + 2;
    if (n == 0 || s->foreseen.rows > 0 || !s->vital.knows_inputs || !are_moving(s))
        return 0;
    *since = s->run->inputs.times[0];
    times[0] = s->vital.last_time;
    times[1] = s->vital.t;
    memcpy(values, s->last_u, size);
    memcpy(values + n, s->u, size);
    put_inputs(s->run, times, values, 2);
    return 1;
}

/* ---------------------------------------------------------------- the energy account */

void lag_exchange_stand_at(LagInstance *s, double t, const double *x)
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

static int agree(const double *a, const double *b, int n, double close)
{
    double size = 0, distance = 0;
    for (int i = 0; i < n; ++i) {
        size = fmax(size, fmax(fabs(a[i]), fabs(b[i])));
        distance = fmax(distance, fabs(a[i] - b[i]));
    }
    return distance <= close * size;
}

typedef enum { NO_ACCOUNT, ROUGH_ACCOUNT, ACCOUNT } Account;

/* Dissipated and work over the last step, by Gauss-Lobatto quadrature with four nodes, two of them at the ends: a rough account where
 * the motion between the ends is not the polynomial's. What moves places has its rates itself. */
static Account account_by_polynomial(LagInstance *s, double h, int moves, double *sum)
{
    static const double NODES[4] = {0, 0.27639320225002103, 0.72360679774997897, 1}; /* (1 -+ 1/sqrt 5)/2 */
    const int n = s->model->n, states = lag_fmu_states(s->model), bends = moves && !tell_rates(s->model);
    double *state = s->scratch, *slope = state + states, *acceleration = slope + states, power[2];
    int agrees = 1;
    for (int k = 0; k < 2; ++k)
        sum[k] = bends ? 0 : h / 12 * (s->last_power[k] + s->power[k]);
    for (int i = bends ? 0 : 1; i < (bends ? 4 : 3); ++i) {
        const int is_end = i == 0 || i == 3;
        if (bends)
            bend_inputs(s, NODES[i], h);
        state_between(s, NODES[i], h, state, acceleration);
        if (!lag_instance_slope_at(s, s->vital.last_time + h * NODES[i], state, slope, power))
            return NO_ACCOUNT;
        agrees &= is_end || agree(acceleration, slope + states - n, n, bends ? CLOSER_THAN_LINES : CLOSE);
        for (int k = 0; k < 2; ++k)
            sum[k] += h / 12 * (is_end ? 1 : 5) * power[k];
    }
    return agrees ? ACCOUNT : ROUGH_ACCOUNT;
}

/* The same by a run of our own from the last state: importers that tell of every hundredth step only are held to account. A step often
 * ends at an event, which our run may meet a little sooner: it ends before that, and what is left has the power of its end. Not known
 * where it meets an event all the same, which the importer's step has not: that takes its share when it comes. Into `is_same`: whether
 * the equations are those that they were, which the importer must be told otherwise. */
static int account_by_run(LagInstance *s, double h, double *sum, int *is_same)
{
    LagRun *run = s->run;
    const int n = run->model->n;
    const double *const rates = run->inputs.rates;
    const double coarse = run->impacts.coarse, left = h * fmin(SOONER * s->vital.tolerance, MOST_SOONER), end = s->vital.t - left;
    const int64_t events = run->statistics.events;
    int done = 0;
    lag_switches_keep(run, s->switches);
    memcpy(s->modes, run->d, (size_t)run->model->n_modes * sizeof *run->d);
    lag_exchange_stand_at(s, s->vital.last_time, lag_instance_plain(s, s->last));
    run->segment_over = 0;
    run->impacts.coarse = 0; /* errors are ours */
    run->inputs.rates = NULL; /* inputs are on straight lines here, or held */
    run->settings.max_steps = run->statistics.steps + MOST_STEPS;
    run->guards.is_idle = 1; /* and so is the motion between two completed steps */
    run->segment_end = fmax(run->segment_end, s->vital.t); /* events are the importer's */
    const int is_known = lag_segment_evaluate(run) == LAG_OK && lag_run_advance(run, &end, 1, s->row, &done, 0) == LAG_OK;
    const double *account = s->row + 1 + 2 * n + run->model->n_outputs + 3;
    sum[0] = account[0] + left * s->power[0];
    sum[1] = account[1] + left * s->power[1];
    run->guards.is_idle = 0;
    run->inputs.rates = rates;
    run->settings.max_steps = 0;
    if (run->model->n_pieces > 0 && run->statistics.events != events) /* by inputs as they were foreseen */
        memcpy(run->d, s->modes, (size_t)run->model->n_modes * sizeof *run->d);
    lag_exchange_stand_at(s, s->vital.t, lag_instance_projected(s, s->vital.t, s->x));
    run->impacts.coarse = coarse;
    *is_same = lag_switches_resume(run, s->switches);
    lag_cones_note(run, s->vital.last_time, lag_instance_plain(s, s->last));
    return is_known && run->statistics.events == events;
}

int lag_exchange_account_so_far(LagInstance *s, double *sum)
{
    const double h = s->vital.t - s->vital.last_time;
    double since = 0;
    if (s->model->n_power != 2 || !(h > 0) || lag_instance_slope(s) != LAG_ANSWER_OK)
        return 0;
    const int moves = move_inputs(s, &since);
    const Account account = account_by_polynomial(s, h, moves, sum);
    if (moves)
        put_inputs(s->run, &since, s->u, 1);
    s->vital.slope_is_current = 0; /* what slides has the shares of the latest evaluation */
    return lag_instance_slope(s) == LAG_ANSWER_OK && (account == ACCOUNT || (account == ROUGH_ACCOUNT && moves));
}

/* What inputs may have done otherwise over the last step of h, by how their power changes with them at its end; not known of what is
 * held at them. */
static void doubt_inputs(LagInstance *s, double h)
{
    LagRun *run = s->run;
    const double since = run->inputs.times[0], power_here = s->power[1] - s->power[0];
    double power[2];
    int is_doubted = 0;
    if (!s->vital.knows_inputs || s->foreseen.rows > 0 || s->vital.is_unaccounted)
        return;
    for (int i = 0; i < s->model->n_inputs; ++i) {
        const double doubt = doubt_of_input(s, i, h), here = s->u[i];
        s->vital.is_unaccounted |= s->most_u[i] > s->least_u[i] && run->sliding.count > 0;
        if (!(doubt > 0))
            continue;
        s->u[i] += here > s->last_u[i] ? -doubt : doubt;
        put_inputs(run, &since, s->u, 1);
        s->u[i] = here;
        is_doubted = 1;
        s->vital.is_unaccounted |= !lag_instance_slope_at(s, s->vital.t, s->x, s->scratch, power);
        s->vital.energy_doubt += h * fabs(power[1] - power[0] - power_here);
    }
    if (is_doubted)
        put_inputs(run, &since, s->u, 1);
}

int lag_exchange_keep_account(LagInstance *s)
{
    const double h = s->vital.t - s->vital.last_time;
    double sum[2], of_run[2], since = 0, line = 0;
    int is_same = 1;
    if (s->model->n_power == 2 && h > 0 && lag_instance_slope(s) == LAG_ANSWER_OK) {
        doubt_inputs(s, h);
        const int moves = move_inputs(s, &since);
        const Account account = account_by_polynomial(s, h, moves, sum);
        if (moves && account != ACCOUNT)
            move_inputs(s, &line);
        const int is_known = account == ACCOUNT || account_by_run(s, h, of_run, &is_same);
        if (account != ACCOUNT && is_known)
            memcpy(sum, of_run, sizeof of_run);
        if (moves)
            put_inputs(s->run, &since, s->u, 1);
        const int is_counted = is_known || (account == ROUGH_ACCOUNT && moves); /* what our run meets an importer's inputs may not */
        s->vital.dissipated += is_counted ? sum[0] : 0;
        s->vital.work += is_counted ? sum[1] : 0;
        s->vital.is_unaccounted |= !is_known;
        s->vital.energies_are_current = 0;
    } else if (s->model->n_power == 2 && h > 0) {
        s->vital.is_unaccounted = 1;
    }
    if (!is_same)
        lag_instance_forget(s);
    lag_exchange_note(s);
    return is_same;
}

void lag_exchange_note(LagInstance *s)
{
    const size_t size = (size_t)lag_fmu_states(s->model) * sizeof *s->x;
    note_inputs(s);
    s->vital.last_time = s->vital.t;
    if (s->model->n_power == 0 || lag_instance_slope(s) != LAG_ANSWER_OK)
        return;
    memcpy(s->last, s->x, size);
    memcpy(s->last_slope, s->slope, size);
    memcpy(s->last_power, s->power, (size_t)s->model->n_power * sizeof *s->power);
}

LagAnswer lag_instance_energies(LagInstance *s)
{
    const LagVital *vital = &s->vital;
    double of_state[3], since[2];
    if (vital->energies_are_current || !s->run)
        return LAG_ANSWER_OK;
    if (!(s->kind == LAG_MODEL_EXCHANGE && lag_exchange_account_so_far(s, since)))
        since[0] = since[1] = 0;
    lag_energies(s->run, vital->t, lag_instance_plain(s, s->x), of_state);
    const double dissipated = vital->dissipated + since[0], work = vital->work + since[1];
    const double total = of_state[0] + of_state[1];
    s->energies[LAG_ENERGY_KINETIC] = of_state[0];
    s->energies[LAG_ENERGY_POTENTIAL] = of_state[1];
    s->energies[LAG_ENERGY_TOTAL] = total;
    s->energies[LAG_ENERGY_DISSIPATED] = dissipated;
    s->energies[LAG_ENERGY_WORK] = work + (total - of_state[2] - vital->supports_energy);
    s->energies[LAG_ENERGY_RESIDUAL] = of_state[2] - vital->start_energy + dissipated - work;
    s->vital.energies_are_current = 1;
    return LAG_ANSWER_OK;
}

LagAnswer lag_exchange_judge_account(LagInstance *s)
{
    LagVital *vital = &s->vital;
    lag_instance_energies(s);
    for (int i = 0; i < LAG_ENERGY_RESIDUAL; ++i)
        if (isfinite(s->energies[i]))
            vital->energy_size = fmax(fabs(s->energies[i]), vital->energy_size);
    vital->energy_miss = fmax(fabs(s->energies[LAG_ENERGY_RESIDUAL]), vital->energy_miss);
    vital->steps += 1;
    const double explained = fmin(fmax(vital->tolerance * (MISSED + MISSED_EACH * vital->steps), MISSED_ROUNDING), MOST_MISSED);
    const double limit = explained * vital->energy_size + MOST_DOUBTED * vital->energy_doubt;
    const int is_open = !vital->is_unaccounted && vital->energy_miss > limit;
    if (is_open && !vital->is_told_open)
        lag_instance_log(s, LAG_ANSWER_WARNING, "logStatusWarning",
                         "at t = %.6g s the energy account misses by %.1e J, more than a tolerance of %g explains: the states are not "
                         "the motion, which the importer has to integrate in smaller steps", vital->t, vital->energy_miss,
                         vital->tolerance);
    vital->is_told_open = is_open;
    return is_open ? LAG_ANSWER_WARNING : LAG_ANSWER_OK;
}
