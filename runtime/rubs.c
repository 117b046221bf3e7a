/* The friction of an impact is mu P against the slip, with the impulse P of the contact, as its force is mu N: to where the slip was
 * before, unless that would turn it round. Then it takes what leaves no slip (C. Glocker, F. Pfeiffer, Multiple impacts with friction in
 * rigid multibody systems, Nonlinear Dynamics 7 (1995), by one law for each contact, and Newton's restitution).
 */
#include "rubs.h"

#include <math.h>

#include "evaluate.h"
#include "extremes.h"
#include "impulses.h"
#include "state.h"

enum { MOST_SWEEPS = 100, MOST_ITERATIONS = 60, PATIENCE = 5 };
static const double NOTHING = 1e-13; /* of the slips before and after */
static const double UNCHANGED = 1e-12; /* of a share */

static int switch_of(const LagModel *model, int rub) { return model->rubs[3 * rub]; }

static int acts(const LagRun *run, int rub) { return run->impacts.fires[run->model->rubs[3 * rub + 1]]; }

int lag_rubs_act(const LagRun *run)
{
    for (int k = 0; k < run->model->n_rubs; ++k)
        if (acts(run, k))
            return 1;
    return 0;
}

int lag_rubs_alone(const LagModel *model, int i)
{
    for (int k = 0; k < model->n_rubs; ++k)
        if (switch_of(model, k) == i && model->rubs[3 * k + 2])
            return 1;
    return 0;
}

void lag_rubs_let_go(LagRun *run)
{
    for (int k = 0; k < run->model->n_rubs; ++k)
        *lag_share(run, switch_of(run->model, k)) = 0.5;
}

/* Conditions of all at rates v[n], into switches.g_inside. */
static const double *slips(LagRun *run, const double *v)
{
    LagSwitches *s = &run->switches;
    lag_conditions_by(run, run->motion.t, run->motion.y, v, s->slope + run->model->n, s->g_inside, s->rate_inside);
    return s->g_inside;
}

/* The slip of switch i after impulses with this share. */
static double slip_after(LagRun *run, int i, double share)
{
    *lag_share(run, i) = share;
    lag_impulses_solve(run);
    return slips(run, run->impacts.after)[i];
}

/* The share between 0 and 1 that leaves no slip, where friction of one sign leaves one and of the other another: by the regula falsi
 * (Illinois), halving now and then. */
static double find_share(LagRun *run, int i, double at_0, double at_1, double enough)
{
    double low = 0, high = 1, a = at_0, b = at_1, x = 0.5;
    int side = 0;
    for (int k = 1; k <= MOST_ITERATIONS && high - low > UNCHANGED; ++k) {
        x = k % PATIENCE != 0 ? low + (high - low) * (a / (a - b)) : low + (high - low) / 2;
        const double here = slip_after(run, i, x);
        const int now = here > 0 ? 1 : -1;
        if (fabs(here) <= enough)
            return x;
        *(here > 0 ? &low : &high) = x;
        *(here > 0 ? &a : &b) = here;
        if (now == side)
            *(here > 0 ? &b : &a) *= 0.5;
        side = now;
    }
    return x;
}

/* Finds the share of switch i anew, the others given. Returns whether it is another one. */
static int adjust(LagRun *run, int i)
{
    const double before = *lag_share(run, i), slip = slips(run, run->motion.y + run->model->n)[i];
    const double at_0 = slip_after(run, i, 0), at_1 = slip_after(run, i, 1);
    const double enough = NOTHING * lag_max(fabs(slip), lag_max(fabs(at_0), fabs(at_1)));
    double share = at_1 >= -enough ? 1 : at_0 <= enough ? 0 : find_share(run, i, at_0, at_1, enough);
    if (at_0 - at_1 <= enough) /* nothing rubs */
        share = before;
    *lag_share(run, i) = share;
    return fabs(share - before) > UNCHANGED;
}

void lag_rubs_settle(LagRun *run)
{
    const LagModel *model = run->model;
    const LagMotion *m = &run->motion;
    int changes = 1;
    if (run->switches.is_live)
        lag_switches_set(run, m->t, m->y, m->y + m->n);
    run->switches.is_live = 0;
    for (int k = 0; k < model->n_rubs; ++k)
        if (acts(run, k))
            *lag_share(run, switch_of(model, k)) = slips(run, m->y + m->n)[switch_of(model, k)] > 0;
    for (int sweep = 0; changes && sweep < MOST_SWEEPS; ++sweep) {
        changes = 0;
        for (int k = 0; k < model->n_rubs; ++k)
            if (acts(run, k))
                changes |= adjust(run, switch_of(model, k));
    }
}
