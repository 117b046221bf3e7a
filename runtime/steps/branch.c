/* Where ways of moving meet (a crank as long as its rod, upright: its slide may go on, or stay) constraints are of the kind x y = 0, and
 * what is held there to rounding is x y = 1e-17: short steps follow that hyperbola round its corner, from one way to the other, in some
 * 1e-9 s. Rates go on as they were in truth, as nothing but an impulse changes them. So rates are compared across the place.
 */
#include "steps/branch.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "state/state.h"

/* Shares of a usual step: what is usual still, and the time within which nothing makes other rates. Its multiple after which a usual step
 * is forgotten. Of the largest rate of its kind: another one. */
static const double USUAL = 0.1, MOMENT = 1e-5, FADES = 10, OTHER = 0.1;

void lag_branch_layout(LagBranch *branch, const LagModel *model, LagArena *arena)
{
    branch->rate = lag_take(arena, model->n_multipliers > 0 ? (size_t)model->n : 0);
}

void lag_branch_forget(LagRun *run)
{
    run->branch.step = 0;
    run->branch.turned = -1;
}

/* The coordinate whose rate has become another one; -1: none. */
static int turned(const LagRun *run)
{
    const LagScale *scale = &run->scale;
    const int n = run->model->n;
    for (int i = 0; i < n; ++i)
        if (fabs(run->motion.y[n + i] - run->branch.rate[i]) > OTHER * scale->group[scale->kinds + scale->kind[i]])
            return i;
    return -1;
}

void lag_branch_watch(LagRun *run)
{
    LagBranch *s = &run->branch;
    const LagMotion *m = &run->motion;
    const double h = m->t - m->t_old, past = m->t - s->time;
    const int is_soon = past < MOMENT * s->step;
    if (h >= USUAL * s->step || !is_soon) {
        s->step = lag_max(h, s->step - past / FADES);
        s->time = m->t;
        memcpy(s->rate, m->y + m->n, (size_t)m->n * sizeof *s->rate);
    }
    s->turned = turned(run);
}
