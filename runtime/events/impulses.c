/* Impulses act for no time, so that positions and all other forces stay as they are: M dv = sum_j J_j^T L_j, with the rates J v of
 * what is reset. Ways M^-1 J_j^T are differences of accelerations with a force and without it, which knows of constraints and
 * of singular positions all that steps know. Contacts push and do not pull: of several at once those are left out that would.
 */
#include "events/impulses.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "model/function.h"
#include "events/contact_friction.h"
#include "state/state.h"

/* Forces that a way is looked for with are so much larger than all others. */
static const double LARGE = 1024;
static const double GAINED = 1e-12; /* of the kinetic energy: by rounding */
static const double FELT = 10; /* of the errors that a rate may have: a slip that follows from them stops untold */
enum { HALVINGS = 50, ROUNDINGS = 64 };

static double *impulse_in_d(const LagRun *run, int reset) { return &run->d[run->model->n_modes + run->model->n_switches + reset]; }

/* -------- ways */

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
    const double size = lag_largest(s->slope + n, (size_t)n), other = lag_largest(s->slope_without + n, (size_t)n);
    if (size > 0 && other > 0) {
        force = ldexp(1, ilogb(LARGE * other / size));
        difference(run, reset, force);
    }
    for (int i = 0; i < n; ++i)
        way[i] = s->slope[n + i] / force;
}

void lag_impulses_find_way(LagRun *run, int reset, double *way)
{
    lag_motion_slope(&run->motion, run->motion.t, run->motion.y, run->motion.y + run->model->n, run->impacts.slope_without);
    find_way(run, reset, way);
}

void lag_impulses_look(LagRun *run, const double *v, double *rate, double *wanted)
{
    const double *in[] = {&run->motion.t, run->motion.y, v, run->u, run->d, run->c};
    double *out[] = {rate, wanted};
    if (run->model->n_resets == 0) /* events that end the run alone */
        return;
    lag_inputs_at(&run->inputs, run->motion.t, run->u);
    lag_call(&run->model->resets, in, out, run->work);
}

const double *lag_impulses_rates(LagRun *run, const double *way)
{
    const int n = run->model->n;
    double *v = run->impacts.state;
    for (int i = 0; i < n; ++i)
        v[i] = way ? way[i] : 0;
    for (int k = 0; k < run->model->n_kept; ++k)
        v[run->model->kept[k]] += run->motion.y[n + run->model->kept[k]];
    return v;
}

void lag_impulses_find_ways(LagRun *run, int count)
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
    lag_impulses_look(run, lag_impulses_rates(run, NULL), s->impulse, s->rate_after); /* rates that supports have */
    s->lu.size = count;
    for (int j = 0; j < count; ++j) {
        lag_impulses_look(run, lag_impulses_rates(run, s->way + (size_t)j * (size_t)n), s->rate_after, s->lu.scale);
        for (int i = 0; i < count; ++i)
            s->lu.re[i + count * j] = s->rate_after[s->which[i]] - s->impulse[s->which[i]];
    }
}

/* -------- impulses */

/* The impulses that reset the rates of s->which, into s->impulse by their places there. */
static void solve(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    lag_impulses_find_ways(run, count);
    fill_matrix(run, count);
    for (int i = 0; i < count; ++i)
        s->impulse[i] = s->wanted[s->which[i]] - s->rate[s->which[i]];
    lag_dense_lu_factor(&s->lu);
    lag_dense_lu_solve(&s->lu, s->impulse, NULL);
}

/* Conditions at other rates, where accelerations do not count. */
static void look_at_conditions(LagRun *run, const double *v, double *g)
{
    LagSwitches *switches = &run->switches;
    lag_conditions_of_motion(run, run->motion.t, run->motion.y, v, switches->slope + run->model->n, g, switches->rate_inside);
}

void lag_impulses_look_at_rest(LagRun *run)
{
    look_at_conditions(run, lag_impulses_rates(run, NULL), run->switches.g_inside);
}

void lag_impulses_look_along(LagRun *run, int k)
{
    look_at_conditions(run, lag_impulses_rates(run, run->impacts.way + k * run->model->n), run->switches.g_begin);
}

double lag_impulses_closing(const LagRun *run, int k)
{
    const int rests = lag_contact(run->model, lag_event_of(run->model, run->impacts.which[k]));
    return run->switches.g_begin[rests] - run->switches.g_inside[rests];
}

double lag_impulses_opening(LagRun *run, int k)
{
    lag_impulses_look_along(run, k);
    return -lag_impulses_closing(run, k);
}

int lag_impulses_push(const LagRun *run, int reset)
{
    const int i = lag_when(run->model, lag_event_of(run->model, reset));
    return lag_is_contact(run->model, reset) && run->switches.turned[i] != LAG_TO_1;
}

/* Leaves out the contact that pulls most. Returns whether one did. */
static int leave_out(LagRun *run, int *count)
{
    LagImpacts *s = &run->impacts;
    int worst = -1;
    double most = 0;
    if (*count < 2)
        return 0;
    lag_impulses_look_at_rest(run);
    for (int i = 0; i < *count; ++i) {
        const double opens = lag_impulses_push(run, s->which[i]) ? s->impulse[i] * lag_impulses_opening(run, i) : 0;
        if (opens < most) {
            most = opens;
            worst = i;
        }
    }
    if (worst < 0)
        return 0;
    memmove(s->which + worst, s->which + worst + 1, (size_t)(*count - worst - 1) * sizeof *s->which);
    --*count;
    return 1;
}

static double kinetic_energy(LagRun *run)
{
    double energies[3];
    lag_energies(run, run->motion.t, run->motion.y, energies);
    return energies[0];
}

/* By Kelvin's theorem: each works along the mean of its rates before and after. */
static double energy_taken(LagRun *run, int count)
{
    const LagImpacts *s = &run->impacts;
    double lost = 0;
    lag_impulses_look(run, run->motion.y + run->model->n, s->rate_after, s->lu.scale);
    for (int i = 0; i < count; ++i)
        if (!lag_is_signal(run->model, s->which[i]))
            lost -= s->impulse[i] * (s->rate[s->which[i]] + s->rate_after[s->which[i]]) / 2;
    return lost;
}

/* The energy that impulses take is dissipated; what they add is work. */
static void count_energy(LagRun *run, double lost)
{
    if (run->model->n_power != 2 || !(lost > 0))
        return;
    run->motion.y[2 * run->model->n] += lost;
    run->energy_before -= lost;
}

/* The coordinate whose rate itself reset k sets, which changes no other, and which no other reset changes; -1: there is no such one. */
static int alone_at(const LagRun *run, int k, int count)
{
    const LagImpacts *s = &run->impacts;
    const int n = run->model->n, place = lag_own_place(run->model, s->which[k]);
    for (int i = 0; i < n && place >= 0; ++i)
        if (i != place && s->way[i + k * n] != 0)
            return -1;
    for (int other = 0; other < count && place >= 0; ++other)
        if (other != k && s->way[place + other * n] != 0)
            return -1;
    return place;
}

/* Rates that resets set alone become what is wanted to the last digit: others may be compared with it. */
static void set_exactly(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    for (int k = 0; k < count; ++k) {
        const int place = lag_is_contact(run->model, s->which[k]) ? -1 : alone_at(run, k, count);
        if (place >= 0)
            s->after[place] = s->wanted[s->which[k]];
    }
}

/* Of `count` resets, where nothing rubs. Returns how many act. */
static int solve_smooth(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    const int n = run->model->n;
    solve(run, count);
    while (leave_out(run, &count))
        solve(run, count);
    memcpy(s->after, run->motion.y + n, (size_t)n * sizeof *s->after);
    for (int k = 0; k < count; ++k)
        for (int i = 0; i < n; ++i)
            s->after[i] += s->way[i + k * n] * s->impulse[k];
    set_exactly(run, count);
    return count;
}

/* Of rates v[n] as they are, with no rate of time. */
static double energy_of(LagRun *run, const double *v)
{
    double *present = run->motion.y + run->model->n, energy = 0;
    const int n = run->model->n;
    memcpy(run->impacts.state, present, (size_t)n * sizeof *v);
    for (int sign = 1; sign >= -1; sign -= 2) {
        for (int i = 0; i < n; ++i)
            present[i] = sign * v[i];
        energy += kinetic_energy(run) / 2;
    }
    memset(present, 0, (size_t)n * sizeof *v);
    energy -= kinetic_energy(run);
    memcpy(present, run->impacts.state, (size_t)n * sizeof *v);
    return energy;
}

/* What the impulses that were found give to the motion, as it looks to who moves along with what is struck (s->impulse, s->slip: its rates):
 * with rates at which nothing there closes or slips. */
static double energy_gained(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    LagComplementarity *p = &s->problem;
    const int n = run->model->n;
    double *seen = s->slope, *rate = p->change;
    for (int i = 0; i < count; ++i)
        rate[i] = -s->sense[i] * s->impulse[s->which[i]];
    for (int k = 0; k < run->model->n_rubs; ++k)
        if (s->place[k] >= 0)
            rate[s->place[k]] = s->slip[k];
    lag_complementarity_find_balance(p, rate);
    for (int turn = 0; turn < 2; ++turn) {
        const double *v = turn == 0 ? run->motion.y + n : s->after;
        double *to = seen + turn * n;
        memcpy(to, v, (size_t)n * sizeof *v);
        for (int j = 0; j < p->size; ++j)
            for (int i = 0; i < n; ++i)
                to[i] -= s->way[i + j * n] * (j < count ? s->sense[j] : 1) * rate[j];
    }
    return energy_of(run, seen + n) - energy_of(run, seen);
}

/* Whether all that is struck are contacts, some of which turn back. */
static int turns_back(const LagRun *run, int count)
{
    int some = 0;
    for (int j = 0; j < count; ++j) {
        if (!lag_impulses_push(run, run->impacts.which[j]))
            return 0;
        some |= run->impacts.wanted[run->impacts.which[j]] != 0;
    }
    return some;
}

/* With Newton's restitution friction may give energy (T.R. Kane, D.A. Levinson, Dynamics: theory and applications (1985), sec. 5.8), or
 * there are no impulses, where a body is wedged: restitution is as large then as it can be. Returns 0 where there are none even without. */
static int lessen(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    double low = 0, high = 1, present = 1;
    for (int turn = 0; turn < HALVINGS; ++turn) {
        const double share = turn < HALVINGS - 1 ? (low + high) / 2 : low;
        for (int j = 0; j < count; ++j)
            s->wanted[s->which[j]] *= share / present;
        const int is_found = lag_rubs_solve(run, count, 0);
        if (turn == HALVINGS - 1)
            return is_found;
        *(is_found && energy_gained(run, count) <= 0 ? &low : &high) = present = share;
    }
    return 0;
}

/* Where something rubs. Returns 0 where there are no impulses. */
static int solve_rough(LagRun *run, int count, int presses, double before)
{
    const int is_found = lag_rubs_solve(run, count, presses), may_lessen = !presses && turns_back(run, count);
    if (may_lessen && (!is_found || energy_gained(run, count) > GAINED * before))
        return lessen(run, count);
    return is_found;
}

/* By how much rates may be off that resets change: by rounding of what they were, are, and of what the impulses do. */
static void note_rounding(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    const int n = run->model->n;
    const double *v = run->motion.y + n;
    for (int i = 0; i < n; ++i) {
        double size = fabs(v[i]) + fabs(s->after[i]);
        for (int k = 0; k < count; ++k)
            size += fabs(s->way[i + k * n] * s->impulse[k]);
        if (s->after[i] != v[i])
            s->rounding[n + i] = lag_max(ROUNDINGS * DBL_EPSILON * size, s->rounding[n + i]);
    }
}

/* Whether rates become others than they may have been before. */
static int is_felt(const LagRun *run)
{
    const LagImpacts *s = &run->impacts;
    const int n = run->model->n;
    const double *y = run->motion.y;
    for (int i = 0; i < n; ++i)
        if (fabs(s->after[i] - y[n + i]) > FELT * lag_scale_unit(&run->scale, n + i, y, y))
            return 1;
    return 0;
}

int lag_impulses_reset(LagRun *run, int presses)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    const size_t size = (size_t)model->n * sizeof(double);
    double *v = run->motion.y + model->n;
    const int rubs = lag_rubs_act(run), is_live = run->switches.is_live;
    int count = 0;
    for (int j = 0; j < model->n_resets; ++j)
        if (s->fires[lag_event_of(model, j)])
            s->which[count++] = j;
    const double before = rubs ? kinetic_energy(run) : 0;
    const int is_found = rubs ? solve_rough(run, count, presses, before) : 1;
    if (!rubs)
        count = solve_smooth(run, count);
    run->switches.is_live = is_live;
    if (!is_found)
        return 0;
    note_rounding(run, rubs ? 0 : count);
    s->is_felt = is_felt(run);
    s->has_changed |= memcmp(v, s->after, size) != 0;
    memcpy(v, s->after, size);
    memset(run->motion.carry + model->n, 0, size);
    count_energy(run, rubs ? before - kinetic_energy(run) : energy_taken(run, count));
    return 1;
}
