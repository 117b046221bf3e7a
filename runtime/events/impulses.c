/* Impulses act for no time, so that positions and all other forces stay as they are: M dv = sum_j J_j^T L_j, with the rates J v of
 * what is reset. Ways M^-1 J_j^T are differences of accelerations with a force and without it, which knows of constraints and
 * of singular positions all that steps know. Contacts push and do not pull: of several at once those are left out that would.
 */
#include "events/impulses.h"

#include <math.h>
#include <string.h>

#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "model/function.h"
#include "events/contact_friction.h"
#include "state/state.h"

/* Forces that a way is looked for with are so much larger than all others. */
static const double LARGE = 1024;

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
    lag_inputs_at(&run->inputs, run->motion.t, run->u);
    lag_call(&run->model->resets, in, out, run->work);
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
    memset(s->state, 0, (size_t)n * sizeof *s->state);
    lag_impulses_look(run, s->state, s->impulse, s->rate_after); /* rates that supports have */
    s->lu.size = count;
    for (int j = 0; j < count; ++j) {
        lag_impulses_look(run, s->way + (size_t)j * (size_t)n, s->rate_after, s->lu.scale);
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
    lag_conditions_by(run, run->motion.t, run->motion.y, v, switches->slope + run->model->n, g, switches->rate_inside);
}

void lag_impulses_look_at_rest(LagRun *run)
{
    memset(run->impacts.state, 0, (size_t)run->model->n * sizeof *run->impacts.state);
    look_at_conditions(run, run->impacts.state, run->switches.g_inside);
}

void lag_impulses_look_along(LagRun *run, int k)
{
    look_at_conditions(run, run->impacts.way + k * run->model->n, run->switches.g_begin);
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
    return count;
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
    const int is_found = rubs ? lag_rubs_solve(run, count, presses) : 1;
    if (!rubs)
        count = solve_smooth(run, count);
    run->switches.is_live = is_live;
    if (!is_found)
        return 0;
    const double before = rubs ? kinetic_energy(run) : 0;
    memcpy(v, s->after, size);
    memset(run->motion.carry + model->n, 0, size);
    count_energy(run, rubs ? before - kinetic_energy(run) : energy_taken(run, count));
    return 1;
}
