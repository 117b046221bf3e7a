/* Forces at which rates are looked at: none; each alone; all contacts press, with friction and without. Differences tell the direction of
 * each friction, its own range, and how much of it each contact brings.
 */
#include "events/jams.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "state/state.h"

static int is_contact(const LagRun *run, int k) { return !lag_may_have_all(run, run->sliding.which[k]); }

/* dg/dt of all candidates at the shares in d: into `rate`. */
static void look(LagRun *run, double t, const double *y, double *rate)
{
    const LagSliding *s = &run->sliding;
    lag_sliding_rates(run, t, y);
    for (int k = 0; k < run->impacts.problem.size; ++k)
        rate[k] = s->rate[s->which[k]];
}

/* The share of friction candidate k becomes 1, and it is seen what that changes. */
static void look_at_range(LagRun *run, double t, const double *y, int k, double *change)
{
    const LagComplementarity *p = &run->impacts.problem;
    look(run, t, y, p->change);
    *lag_share(run, run->sliding.which[k]) = 1;
    look(run, t, y, change);
    *lag_share(run, run->sliding.which[k]) = 0;
    for (int i = 0; i < p->size; ++i)
        change[i] -= p->change[i];
}

/* How many times `direction` the change is. */
static double part_of(const double *change, const double *direction, int size)
{
    double with = 0, square = 0;
    for (int i = 0; i < size; ++i) {
        with += change[i] * direction[i];
        square += direction[i] * direction[i];
    }
    return square > 0 ? with / square : 0;
}

static void set_contacts(const LagRun *run, double units)
{
    for (int k = 0; k < run->impacts.problem.size; ++k)
        if (is_contact(run, k))
            *lag_share(run, run->sliding.which[k]) = units * run->sliding.unit[k];
}

static void find_contact(LagRun *run, double t, const double *y, int k)
{
    LagComplementarity *p = &run->impacts.problem;
    double *column = p->jump + k * p->size;
    *lag_share(run, run->sliding.which[k]) = run->sliding.unit[k];
    look(run, t, y, column);
    *lag_share(run, run->sliding.which[k]) = 0;
    for (int i = 0; i < p->size; ++i)
        column[i] = (column[i] - p->rate[i]) / run->sliding.unit[k];
}

/* Its direction is what it does where all contacts press. */
static void find_friction(LagRun *run, double t, const double *y, int k)
{
    LagSliding *s = &run->sliding;
    LagComplementarity *p = &run->impacts.problem;
    double *column = p->jump + k * p->size, *change = p->force;
    set_contacts(run, 1);
    look_at_range(run, t, y, k, column);
    set_contacts(run, 0);
    look_at_range(run, t, y, k, change);
    p->own[k] = part_of(change, column, p->size);
    for (int j = 0; j < p->size; ++j) {
        if (!is_contact(run, j))
            continue;
        *lag_share(run, s->which[j]) = s->unit[j];
        look_at_range(run, t, y, k, change);
        *lag_share(run, s->which[j]) = 0;
        p->press[k + j * p->size] = (part_of(change, column, p->size) - p->own[k]) / s->unit[j];
    }
}

/* The problem at a state. */
static void fill(LagRun *run, double t, const double *y, int count)
{
    LagSliding *s = &run->sliding;
    LagComplementarity *p = &run->impacts.problem;
    lag_complementarity_begin(p, count);
    for (int k = 0; k < count; ++k) {
        p->kind[k] = is_contact(run, k) ? LAG_PUSHES : LAG_RUBS;
        *lag_share(run, s->which[k]) = 0;
    }
    look(run, t, y, p->rate);
    for (int k = 0; k < count; ++k)
        if (is_contact(run, k))
            find_contact(run, t, y, k);
        else
            find_friction(run, t, y, k);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j)
            p->terms[i] += fabs(p->jump[i + j * count]) * (is_contact(run, j) ? s->unit[j] : 1);
}

int lag_jams_may_act(const LagRun *run, int k)
{
    return is_contact(run, k) ? run->impacts.problem.state[k] == LAG_HOLDS : lag_complementarity_limit(&run->impacts.problem, k) > 0;
}

int lag_jams_solve(LagRun *run, double t, const double *y, int count)
{
    LagSliding *s = &run->sliding;
    LagComplementarity *p = &run->impacts.problem;
    fill(run, t, y, count);
    if (!lag_complementarity_solve(p))
        return 0;
    for (int k = 0; k < count; ++k)
        s->share[k] = is_contact(run, k) ? p->force[k] : lag_jams_may_act(run, k) ? p->force[k] / lag_complementarity_limit(p, k) : 0.5;
    return 1;
}
