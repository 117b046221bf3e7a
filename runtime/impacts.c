/* Impulses act for no time, so that positions and all other forces stay as they are: M dv = sum_j J_j^T L_j, with the rates J v of
 * what is reset. Ways M^-1 J_j^T are differences of accelerations with a force and without it, which knows of constraints and
 * of singular positions all that steps know.
 *
 * Contacts push and do not pull: of several at once those are left out that would. One contact brings about the next (Newton's
 * cradle), until nothing approaches (E.J. Routh, Dynamics of a system of rigid bodies, I (1905), ch. VIII). What bounces back
 * slower than the tolerance tells of stays. Other events come when a reset makes their conditions true, too.
 */
#include "impacts.h"

#include <math.h>
#include <string.h>

#include "conditions.h"
#include "evaluate.h"
#include "extremes.h"
#include "function.h"
#include "schedule.h"
#include "state.h"

/* Forces that a way is looked for with are so much larger than all others. */
static const double LARGE = 1024;
static const double MOMENT = 1e-3; /* s */
/* Of the time that a bounce takes at the accelerations after the impact: no first step is longer. */
static const double BOUNCE = 1.25;
static const double SLACK = 1.0 / 1024; /* of one tolerance: what stands where nothing presses comes no sooner */
/* A bounce shorter than so many times what tells times apart is none. */
static const double SHORT = 256, LOW = 1.0 / 64; /* of what is unknown of positions, which is that of many steps */
/* Events that bring each other about so many times, or come again without time passing, do not end. */
enum { MOST_ROUNDS = 100000, MOST_AT_ONCE = 1000, PATTERNS = 3 };

void lag_impacts_layout(LagImpacts *s, const LagModel *model, int size, LagArena *arena)
{
    const size_t resets = (size_t)model->n_resets, whole = resets > 0 ? (size_t)size : 0;
    s->fires = lag_take_ints(arena, (size_t)model->n_whens);
    s->has_contact = lag_take_ints(arena, (size_t)model->n_whens);
    s->is_on = lag_take_ints(arena, (size_t)model->n_whens);
    s->slack = lag_take(arena, (size_t)model->n_whens);
    s->which = lag_take_ints(arena, resets);
    s->rate = lag_take(arena, resets);
    s->wanted = lag_take(arena, resets);
    s->rate_after = lag_take(arena, resets);
    s->way = lag_take(arena, resets * (size_t)model->n);
    s->impulse = lag_take(arena, resets);
    s->state = lag_take(arena, whole);
    s->slope = lag_take(arena, whole);
    s->slope_without = lag_take(arena, whole);
    lag_dense_lu_layout(&s->lu, model->n_resets, 0, arena);
}

static int event_of(const LagModel *model, int reset) { return model->reset_places[2 * reset]; }

static int is_contact(const LagModel *model, int reset) { return model->reset_places[2 * reset + 1]; }

void lag_impacts_reset(LagRun *run)
{
    for (int j = 0; j < run->model->n_resets; ++j)
        run->impacts.has_contact[event_of(run->model, j)] |= is_contact(run->model, j);
    run->impacts.coarse = 0;
    run->impacts.at_once = 0;
    run->impacts.seen = INFINITY;
}

static double *impulse_in_d(const LagRun *run, int reset) { return &run->d[run->model->n_modes + run->model->n_switches + reset]; }

/* -------- ways */

static double largest_of(const double *x, int n)
{
    double largest = 0;
    for (int i = 0; i < n; ++i)
        largest = lag_max(fabs(x[i]), largest);
    return largest;
}

/* slope - slope_without with a force on what is reset, in s->slope. */
static void difference(LagRun *run, int reset, double force)
{
    LagImpacts *s = &run->impacts;
    const int n = run->model->n;
    *impulse_in_d(run, reset) = force;
    lag_motion_slope(&run->motion, run->motion.t, run->motion.y, run->motion.y + n, s->slope);
    *impulse_in_d(run, reset) = 0;
    for (int i = n; i < 2 * n; ++i)
        s->slope[i] -= s->slope_without[i];
}

/* Accelerations are linear in the force: it is made large enough for the others not to count. */
static void find_way(LagRun *run, int reset, double *way)
{
    LagImpacts *s = &run->impacts;
    const int n = run->model->n;
    double force = 1;
    difference(run, reset, force);
    const double size = largest_of(s->slope + n, n), other = largest_of(s->slope_without + n, n);
    if (size > 0 && other > 0) {
        force = ldexp(1, ilogb(LARGE * other / size));
        difference(run, reset, force);
    }
    for (int i = 0; i < n; ++i)
        way[i] = s->slope[n + i] / force;
}

/* Rates of what is reset, and what they are to become, at rates v[n]. */
static void look_at(LagRun *run, const double *v, double *rate, double *wanted)
{
    const double *in[] = {&run->motion.t, run->motion.y, v, run->u, run->d, run->c};
    double *out[] = {rate, wanted};
    lag_inputs_at(&run->inputs, run->motion.t, run->u);
    lag_call(&run->model->resets, in, out, run->work);
}

/* The ways of the `count` resets in s->which, and what they do to each other, into the matrix of s->lu. */
static void find_ways(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    const int n = run->model->n;
    lag_motion_slope(&run->motion, run->motion.t, run->motion.y, run->motion.y + n, s->slope_without);
    for (int k = 0; k < count; ++k)
        find_way(run, s->which[k], s->way + (size_t)k * (size_t)n);
}

static void fill_matrix(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    const int n = run->model->n;
    memset(s->state, 0, (size_t)n * sizeof *s->state);
    look_at(run, s->state, s->impulse, s->rate_after); /* rates that supports have */
    s->lu.size = count;
    for (int j = 0; j < count; ++j) {
        look_at(run, s->way + (size_t)j * (size_t)n, s->rate_after, s->lu.scale);
        for (int i = 0; i < count; ++i)
            s->lu.re[i + count * j] = s->rate_after[s->which[i]] - s->impulse[s->which[i]];
    }
}

/* -------- impulses */

/* The impulses that reset the rates of s->which, into s->impulse by their places there. */
static void solve(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    find_ways(run, count);
    fill_matrix(run, count);
    for (int i = 0; i < count; ++i)
        s->impulse[i] = s->wanted[s->which[i]] - s->rate[s->which[i]];
    lag_dense_lu_factor(&s->lu);
    lag_dense_lu_solve(&s->lu, s->impulse, NULL);
}

/* Leaves out the contact that pulls most. Returns whether one did. */
static int leave_out(LagRun *run, int *count)
{
    LagImpacts *s = &run->impacts;
    int worst = -1;
    double most = 0;
    for (int i = 0; i < *count; ++i) {
        const double work = s->impulse[i] * (s->wanted[s->which[i]] - s->rate[s->which[i]]);
        if (is_contact(run->model, s->which[i]) && work < most) {
            most = work;
            worst = i;
        }
    }
    if (worst < 0 || *count == 1)
        return 0;
    memmove(s->which + worst, s->which + worst + 1, (size_t)(*count - worst - 1) * sizeof *s->which);
    --*count;
    return 1;
}

/* The energy that impulses take, by Kelvin's theorem (each works along the mean of its rates before and after), is dissipated;
 * what they add is work. */
static void count_energy(LagRun *run, int count)
{
    const LagImpacts *s = &run->impacts;
    double lost = 0;
    look_at(run, run->motion.y + run->model->n, s->rate_after, s->lu.scale);
    for (int i = 0; i < count; ++i)
        lost -= s->impulse[i] * (s->rate[s->which[i]] + s->rate_after[s->which[i]]) / 2;
    if (run->model->n_power != 2 || !(lost > 0))
        return;
    run->motion.y[2 * run->model->n] += lost;
    run->energy_before -= lost;
}

static void reset(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    double *v = run->motion.y + model->n;
    int count = 0;
    for (int j = 0; j < model->n_resets; ++j)
        if (s->fires[event_of(model, j)])
            s->which[count++] = j;
    solve(run, count);
    while (leave_out(run, &count))
        solve(run, count);
    for (int k = 0; k < count; ++k)
        for (int i = 0; i < model->n; ++i)
            v[i] += s->way[i + k * model->n] * s->impulse[k];
    memset(run->motion.carry + model->n, 0, (size_t)model->n * sizeof *v);
    count_energy(run, count);
}

/* -------- which events */

double lag_impacts_margin(const LagRun *run, int i)
{
    return run->impacts.coarse > 0 ? run->impacts.coarse * run->sliding.error[i] : LOW * run->switches.unknown[i];
}


/* Whether what leaves contact k so fast, and is drawn back so, cannot be told from what rests: too slow, back too soon, or not higher than rounding. */
static int stays(const LagRun *run, int k, double speed, double returns)
{
    return speed <= run->sliding.error[lag_contact(run->model, k)] || 2 * speed <= SHORT * lag_time_resolution(run->motion.t) * returns
        || speed * speed <= 2 * returns * lag_impacts_margin(run, lag_gap(run->model, k));
}

/* What is left of the speed at which contact k is found late, at the place where it closed. */
static double lateness(const LagRun *run, int k)
{
    const LagSwitches *s = &run->switches;
    const int gap = lag_gap(run->model, k);
    const double g = s->g[gap], speed = s->rate[gap], gained = 2 * s->rate[lag_contact(run->model, k)] * g;
    if (!(g > LOW * s->unknown[gap] && gained > 0))
        return 1;
    return gained < speed * speed ? sqrt(1 - gained / (speed * speed)) : 0;
}

/* What rates become. */
static void read_wanted(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    look_at(run, run->motion.y + model->n, s->rate, s->wanted);
    for (int j = 0; j < model->n_resets; ++j) {
        const int k = event_of(model, j);
        if (!is_contact(model, j) || !s->fires[k])
            continue;
        s->wanted[j] *= lateness(run, k);
        const double speed = fabs(run->switches.rate[lag_gap(model, k)] * s->wanted[j] / s->rate[j]);
        if (stays(run, k, speed, run->switches.rate[lag_contact(model, k)]))
            s->wanted[j] = 0;
    }
}

/* Whether something rests at contact k, or it is closed but for `near`; g: all conditions. */
static int is_closed(const LagRun *run, int k, const double *g, double near)
{
    const LagSwitches *s = &run->switches;
    const int touches = s->slides[lag_contact(run->model, k)] || g[lag_gap(run->model, k)] >= -near;
    return touches && s->held[lag_when(run->model, k)] == 0 && g[lag_when(run->model, k)] >= 0;
}

/* How much one tolerance of positions changes conditions and gaps, and one of rates what rests, for a pattern of signs. Rates may
 * jump with positions (|x|): these are left as they are for them. */
static void note_errors(LagRun *run, int pattern)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    const LagMotion *m = &run->motion;
    double *state = run->impacts.state, *slope = s->slope + m->n;
    for (int i = 0; i < 2 * m->n; ++i)
        state[i] = m->y[i] + ((i >> pattern) % 2 == 0 ? 1 : -1) * lag_scale_unit(&run->scale, i, m->y, m->y);
    lag_conditions_by(run, m->t, state, m->y + m->n, slope, s->g_inside, s->rate_inside);
    lag_conditions_by(run, m->t, m->y, state + m->n, slope, s->rate_begin, s->rate_inside);
    for (int k = 0; k < model->n_whens; ++k) {
        const int places[] = {lag_when(model, k), lag_gap(model, k), lag_contact(model, k)};
        for (int j = 0; j < 3; ++j) {
            const double moved = j < 2 ? s->g_inside[places[j]] : s->rate_begin[places[j]];
            double *error = &run->sliding.error[places[j]];
            *error = lag_max(fabs(moved - s->g_begin[places[j]]), *error);
        }
    }
}

/* At the start nothing may have a size yet: accelerations tell of one by what they do in a moment. */
void lag_impacts_find_errors(LagRun *run)
{
    const LagModel *model = run->model;
    const int first = lag_when(model, 0);
    LagSwitches *s = &run->switches;
    double *error = run->sliding.error;
    if (model->n_whens == 0 || !model->switches_need_acceleration)
        return;
    memset(error + first, 0, (size_t)(model->n_switches - first) * sizeof *error);
    lag_conditions_of_events(run, s->g_begin, s->rate);
    for (int pattern = 0; pattern < PATTERNS; ++pattern)
        note_errors(run, pattern);
    for (int k = 0; k < model->n_whens && !run->started; ++k) {
        const int i = lag_when(model, k), gap = lag_gap(model, k), rests = lag_contact(model, k);
        const double speed = run->scale.tolerance * MOMENT * fabs(s->rate[rests]);
        error[i] = lag_max(speed * MOMENT, error[i]);
        error[gap] = lag_max(speed * MOMENT, error[gap]);
        error[rests] = lag_max(speed, error[rests]);
    }
}

int lag_impacts_is_inside(const LagRun *run, int i, double g)
{
    const int k = i - lag_when(run->model, 0), is_event = lag_is_event(run->model, i);
    if (!is_event || !run->impacts.has_contact[k])
        return g > 0;
    return g > run->sliding.error[lag_gap(run->model, k)] && (!run->started || run->switches.held[i] > 0);
}

/* Whether a condition is true; where it is neither, whether it is about to be. */
static int is_true(const LagSwitches *s, int i) { return fabs(s->g[i]) > s->unknown[i] ? s->g[i] > 0 : s->rate[i] > 0; }

/* Events whose conditions have come true, and contacts that are closed and approach. Returns whether there are some. */
static int find_events(LagRun *run, int is_first)
{
    LagImpacts *s = &run->impacts;
    LagSwitches *switches = &run->switches;
    const LagModel *model = run->model;
    int found = 0;
    lag_conditions_of_events(run, switches->g, switches->rate);
    for (int k = 0; k < model->n_whens; ++k) {
        const int i = lag_when(model, k), comes = is_first && switches->turned[i] == LAG_CHANGES && switches->held[i] == 0;
        if (run->impacts.has_contact[k]) {
            const double slow = is_first ? 0 : run->sliding.error[lag_contact(model, k)];
            const double near = lag_max(switches->unknown[lag_gap(model, k)], lag_impacts_margin(run, lag_gap(model, k)));
            s->fires[k] = (is_first ? comes : is_closed(run, k, switches->g, near)) && switches->rate[lag_gap(model, k)] > slow;
            switches->turned[i] = comes ? LAG_TO_0 : switches->turned[i];
        } else {
            const int is_now = comes || is_true(switches, i);
            s->fires[k] = is_first ? comes : is_now && !s->is_on[k];
            s->is_on[k] = is_first && !comes ? switches->held[i] > 0 : is_now;
        }
        found |= s->fires[k];
    }
    return found;
}

/* Closed contacts that still approach, slower than can be told, stop together. */
static void calm(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const LagSwitches *switches = &run->switches;
    int some = 0;
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int gap = lag_gap(run->model, k);
        s->fires[k] = run->impacts.has_contact[k] && is_closed(run, k, switches->g, switches->unknown[gap]) && switches->rate[gap] > 0;
        some |= s->fires[k];
    }
    if (!some)
        return;
    read_wanted(run);
    reset(run);
}

/* What conditions of events that are no contacts have become. */
static void note_events(LagRun *run)
{
    LagSwitches *s = &run->switches;
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int i = lag_when(run->model, k), is_on = run->impacts.is_on[k];
        if (!run->impacts.has_contact[k] && (s->turned[i] || is_on != (s->held[i] > 0)))
            s->turned[i] = is_on ? LAG_TO_1 : LAG_TO_0;
    }
}

/* -------- what rests */

/* Whether the position of contact k has drifted while it slid, or it was found late. */
static int has_drifted(const LagRun *run, int k)
{
    const LagSwitches *s = &run->switches;
    const int i = lag_when(run->model, k), gap = lag_gap(run->model, k), rests = s->slides[lag_contact(run->model, k)];
    const double g = rests || (s->turned[i] == LAG_TO_0 && s->g[gap] > 0) ? s->g[gap] : 0;
    return fabs(g) > LOW * s->unknown[gap] && s->g[i] >= 0;
}

/* Where a contact has drifted, all that are closed are gathered, which it must not be pushed through: their resets into s->which.
 * Returns how many there are. */
static int find_drifted(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    int count = 0, some = 0;
    for (int j = 0, last = -1; j < model->n_resets; ++j) {
        const int k = event_of(model, j);
        if (k == last || !is_contact(model, j))
            continue;
        last = k;
        some |= has_drifted(run, k);
        if (has_drifted(run, k) || is_closed(run, k, run->switches.g, run->sliding.error[lag_gap(model, k)]))
            s->which[count++] = j;
    }
    return some ? count : 0;
}

/* Moves positions along the ways of their impulses: none is left, on the shortest way in the metric of masses. */
static void put_back(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    LagSwitches *switches = &run->switches;
    LagMotion *m = &run->motion;
    const int n = m->n, count = find_drifted(run);
    if (count == 0)
        return;
    find_ways(run, count);
    memset(s->state, 0, (size_t)n * sizeof *s->state);
    lag_conditions_by(run, m->t, m->y, s->state, switches->slope + n, switches->g, switches->rate_inside);
    s->lu.size = count;
    for (int j = 0; j < count; ++j) {
        lag_conditions_by(run, m->t, m->y, s->way + j * n, switches->slope + n, switches->g, switches->rate);
        for (int i = 0; i < count; ++i) {
            const int place = lag_gap(run->model, event_of(run->model, s->which[i]));
            s->lu.re[i + count * j] = switches->rate[place] - switches->rate_inside[place];
            s->impulse[i] = -switches->g[place];
        }
    }
    lag_dense_lu_factor(&s->lu);
    lag_dense_lu_solve(&s->lu, s->impulse, NULL);
    for (int k = 0; k < count; ++k)
        for (int i = 0; i < n; ++i)
            m->y[i] += s->way[i + k * n] * s->impulse[k];
}

LagStatus lag_impacts_strike(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const int sliding = run->sliding.count;
    int rounds = 0;
    if (run->model->n_whens == 0)
        return LAG_OK;
    run->sliding.count = 0; /* accelerations as the shares say: forces that hold give no impulses but by events of their own */
    lag_impacts_find_errors(run);
    for (int fire = find_events(run, 1); fire && rounds < MOST_ROUNDS; ++rounds) {
        read_wanted(run);
        reset(run);
        if ((rounds & (rounds + 1)) == 0) /* now and then: what was at rest has a speed now */
            lag_impacts_find_errors(run);
        fire = find_events(run, 0);
    }
    if (rounds > 0) {
        calm(run);
        note_events(run);
    }
    put_back(run);
    run->sliding.count = sliding;
    const int stands = run->motion.t - run->motion.t_old <= lag_time_resolution(run->motion.t);
    s->at_once = stands ? s->at_once + 1 : 0;
    return rounds < MOST_ROUNDS && s->at_once < MOST_AT_ONCE ? LAG_OK : lag_fail(run, LAG_EVENTS_GO_ON, -1, 0, 0);
}

int lag_impacts_find_rest(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    int found = 0;
    if (model->n_whens > 0)
        lag_conditions_of_events(run, s->g_inside, s->rate_inside);
    for (int k = 0; k < model->n_whens; ++k) {
        const int gap = lag_gap(model, k), rests = lag_contact(model, k), has_left = s->turned[rests] == LAG_TO_0;
        const double slow = s->slides[rests] ? LAG_SLIDING_FAR * lag_sliding_drift(run, rests) : run->sliding.error[rests];
        const double leaves = -s->rate_inside[gap], returns = s->rate_inside[rests];
        const int touches = run->impacts.has_contact[k] && is_closed(run, k, s->g_inside, run->sliding.error[gap]);
        const int stands = touches && (fabs(leaves) <= slow || (leaves > 0 && stays(run, k, leaves, returns)));
        run->impacts.slack[k] = stands ? lag_max(s->unknown[gap], SLACK * run->sliding.error[gap]) : 0;
        if (stands && !has_left) {
            s->turned[rests] = LAG_CHANGES;
            found = 1;
        } else
            s->held[rests] = *lag_share(run, rests) = 0;
    }
    return found;
}

void lag_impacts_foresee(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    double *seen = &run->impacts.seen;
    *seen = INFINITY;
    if (model->n_whens > 0)
        lag_conditions_of_events(run, s->g_inside, s->rate_inside);
    for (int k = 0; k < model->n_whens; ++k) {
        const int is_open = run->impacts.has_contact[k] && !s->slides[lag_contact(model, k)];
        const double leaves = -s->rate_inside[lag_gap(model, k)], returns = s->rate_inside[lag_contact(model, k)];
        if (is_open && is_closed(run, k, s->g_inside, run->sliding.error[lag_gap(model, k)]) && leaves > 0 && returns > 0)
            *seen = lag_min(run->motion.t + BOUNCE * 2 * leaves / returns, *seen);
    }
}
