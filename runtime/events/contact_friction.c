/* Impulses push and do not pull, and the friction of an impact is mu P against the slip that it leaves, with the impulse P of the contact,
 * as its force is mu N; or it leaves no slip: one complementarity problem of all that is struck at once, by Newton's restitution
 * (C. Glocker, F. Pfeiffer, Multiple impacts with friction in rigid multibody systems, Nonlinear Dynamics 7 (1995)).
 *
 * Friction acts with a share s of its range, from 0 to 1. Each way of an impulse is taken at s = 0; what s = 1 adds to it is the
 * direction of the friction, and how much of it there is, that of its range.
 */
#include "events/contact_friction.h"

#include <math.h>
#include <string.h>

#include "state/evaluate.h"
#include "events/impulses.h"
#include "state/state.h"

static const double FAINT = 1e-6; /* of the speed at which a contact would close if its slip were stopped: the least that presses */

static int switch_of(const LagModel *model, int rub) { return model->rubs[3 * rub]; }

static int event_of(const LagModel *model, int rub) { return model->rubs[3 * rub + 1]; }

static int acts(const LagRun *run, int rub) { return run->impacts.fires[event_of(run->model, rub)]; }

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

int lag_rubs_nowhere(const LagModel *model, int i, const int *candidates)
{
    for (int k = 0; k < model->n_rubs; ++k)
        if (switch_of(model, k) == i && candidates[lag_contact(model, event_of(model, k))] == 1)
            return 0;
    return lag_rubs_alone(model, i);
}

int lag_rubs_on_what_rests(const LagRun *run, int i)
{
    for (int k = 0; k < run->model->n_rubs; ++k)
        if (switch_of(run->model, k) == i && run->switches.slides[lag_contact(run->model, event_of(run->model, k))])
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
    lag_conditions_of_motion(run, run->motion.t, run->motion.y, v, s->slope + run->model->n, s->g_inside, s->rate_inside);
    return s->g_inside;
}

/* -------- ways */

static void set_acting(LagRun *run, double share)
{
    for (int k = 0; k < run->model->n_rubs; ++k)
        if (acts(run, k))
            *lag_share(run, switch_of(run->model, k)) = share;
}

/* The places in the problem of what rubs, behind `count` resets: each switch has one. Returns the size of the problem. */
static int find_places(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    for (int k = 0; k < model->n_rubs; ++k) {
        s->place[k] = -1;
        for (int other = 0; other < k && acts(run, k); ++other)
            if (s->place[other] >= 0 && switch_of(model, other) == switch_of(model, k))
                s->place[k] = s->place[other];
        if (acts(run, k) && s->place[k] < 0)
            s->place[k] = count++;
    }
    return count;
}

static double product(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += a[i] * b[i];
    return sum;
}

/* How friction k goes with the impulse of the reset at place j of which: its direction, where none is known yet, and how much that
 * impulse raises its range. */
static void find_direction(LagRun *run, int k, int j)
{
    LagImpacts *s = &run->impacts;
    LagComplementarity *p = &s->problem;
    const int n = run->model->n, place = s->place[k], size = p->size;
    double *share = lag_share(run, switch_of(run->model, k)), *direction = s->way + (size_t)place * (size_t)n;
    *share = 1;
    lag_impulses_find_way(run, s->which[j], s->after);
    *share = 0;
    for (int i = 0; i < n; ++i)
        s->after[i] -= s->way[i + j * n];
    const double square = product(direction, direction, n);
    if (!(square > 0))
        memcpy(direction, s->after, (size_t)n * sizeof *direction);
    p->press[place + j * size] = square > 0 ? product(s->after, direction, n) / square : product(s->after, s->after, n) > 0;
}

/* Ways of all that is struck, and of what rubs there; the sense in which the former push, into s->sense. */
static void find_ways(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    set_acting(run, 0.5);
    lag_impulses_find_ways(run, count);
    lag_impulses_look_at_rest(run);
    for (int j = 0; j < count; ++j)
        s->sense[j] = lag_impulses_push(run, s->which[j]) && lag_impulses_opening(run, j) < 0 ? -1 : 1;
    set_acting(run, 0);
    lag_impulses_find_ways(run, count);
    for (int place = count; place < s->problem.size; ++place)
        memset(s->way + (size_t)place * (size_t)model->n, 0, (size_t)model->n * sizeof *s->way);
    for (int k = 0; k < model->n_rubs; ++k)
        for (int j = 0; j < count && acts(run, k); ++j)
            if (lag_event_of(model, s->which[j]) == event_of(model, k) && lag_is_contact(model, s->which[j]))
                find_direction(run, k, j);
}

/* -------- the problem */

/* What a way does to all rates: into column j. */
static void fill_column(LagRun *run, int count, int j)
{
    LagImpacts *s = &run->impacts;
    LagComplementarity *p = &s->problem;
    const LagModel *model = run->model;
    const double *way = lag_impulses_rates(run, s->way + (size_t)j * (size_t)model->n), sense = j < count ? s->sense[j] : 1;
    double *column = p->jump + (size_t)j * (size_t)p->size;
    lag_impulses_look(run, way, s->rate_after, s->lu.scale);
    for (int i = 0; i < count; ++i) {
        const double towards = p->kind[i] == LAG_PUSHES ? -s->sense[i] : 1;
        column[i] = towards * sense * (s->rate_after[s->which[i]] - s->impulse[s->which[i]]);
    }
    const double *slip = slips(run, way);
    for (int k = 0; k < model->n_rubs; ++k)
        if (s->place[k] >= 0)
            column[s->place[k]] = sense * (slip[switch_of(model, k)] - s->slip[k]);
}

/* w at rates v[n]: what closes faster than it should after the impulses, and slips. */
static void fill_rates(LagRun *run, int count, const double *v)
{
    LagImpacts *s = &run->impacts;
    LagComplementarity *p = &s->problem;
    const LagModel *model = run->model;
    lag_impulses_look(run, v, s->rate_after, s->lu.scale);
    for (int i = 0; i < count; ++i) {
        const int j = s->which[i];
        p->rate[i] = (p->kind[i] == LAG_PUSHES ? -s->sense[i] : 1) * (s->rate_after[j] - s->wanted[j]);
        p->terms[i] = fabs(s->rate[j]) + fabs(s->wanted[j]);
    }
    const double *slip = slips(run, v);
    for (int k = 0; k < model->n_rubs; ++k)
        if (s->place[k] >= 0)
            p->rate[s->place[k]] = slip[switch_of(model, k)];
}

static void fill(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    LagComplementarity *p = &s->problem;
    const LagModel *model = run->model;
    for (int i = 0; i < p->size; ++i)
        p->kind[i] = i >= count ? LAG_RUBS : lag_impulses_push(run, s->which[i]) ? LAG_PUSHES : LAG_BINDS;
    const double *still = lag_impulses_rates(run, NULL);
    lag_impulses_look(run, still, s->impulse, s->rate_after); /* rates that supports have */
    const double *slip = slips(run, still);
    for (int k = 0; k < model->n_rubs; ++k)
        s->slip[k] = slip[switch_of(model, k)];
    for (int j = 0; j < p->size; ++j)
        fill_column(run, count, j);
    fill_rates(run, count, run->motion.y + model->n);
}

/* Where contacts press without approaching: they approach so slowly that nothing else is changed by it. */
static void press(LagComplementarity *p, int count)
{
    for (int i = 0; i < count; ++i)
        p->rate[i] = p->kind[i] == LAG_PUSHES ? 0 : p->rate[i];
    for (int i = 0; i < count; ++i)
        for (int j = count; j < p->size && p->kind[i] == LAG_PUSHES; ++j)
            p->rate[i] += FAINT * fabs(p->rate[j] * p->jump[i + j * p->size] / p->jump[j + j * p->size]);
}

/* The impulses that were found act on the rates in impacts.after. */
static void act(LagRun *run, int count)
{
    LagImpacts *s = &run->impacts;
    const LagComplementarity *p = &s->problem;
    const int n = run->model->n;
    for (int j = 0; j < p->size; ++j) {
        const double impulse = (j < count ? s->sense[j] : 1) * p->force[j];
        for (int i = 0; i < n; ++i)
            s->after[i] += s->way[i + j * n] * impulse;
    }
}

/* Of what rubs, into d. */
static void set_shares(const LagRun *run)
{
    const LagImpacts *s = &run->impacts;
    for (int k = 0; k < run->model->n_rubs; ++k) {
        const double limit = s->place[k] >= 0 ? lag_complementarity_limit(&s->problem, s->place[k]) : 0;
        if (limit > 0)
            *lag_share(run, switch_of(run->model, k)) = s->problem.force[s->place[k]] / limit;
    }
}

int lag_rubs_solve(LagRun *run, int count, int presses)
{
    LagImpacts *s = &run->impacts;
    LagComplementarity *p = &s->problem;
    const double *v = run->motion.y + run->model->n;
    if (run->switches.is_live)
        lag_switches_set(run, run->motion.t, run->motion.y, v);
    run->switches.is_live = 0;
    lag_complementarity_begin(p, find_places(run, count));
    find_ways(run, count);
    fill(run, count);
    if (presses)
        press(p, count);
    if (!lag_complementarity_solve(p))
        return 0;
    memcpy(s->after, v, (size_t)run->model->n * sizeof *v);
    for (int turn = 0; turn < 2; ++turn) { /* what is left of the rates that are none is rounding of the impulses: it goes, too */
        fill_rates(run, count, s->after);
        lag_complementarity_find_forces(p);
        act(run, count);
        if (turn == 0)
            set_shares(run);
    }
    return 1;
}
