#include "events/approaches.h"

#include "events/contacts.h"
#include "events/impulses.h"
#include "numbers/extremes.h"
#include "state/state.h"

static const double ROUNDING = 1e-12; /* of the fastest approach */

int lag_approaches_passed(const LagRun *run, int k) { return run->switches.turned[lag_when(run->model, k)] == LAG_TO_1; }

int lag_approaches_touch(const LagRun *run, int k)
{
    const LagSwitches *s = &run->switches;
    const int gap = lag_gap(run->model, k);
    return lag_contacts_are_closed(run, k, s->g, lag_max(s->unknown[gap], lag_contacts_margin(run, gap)));
}

/* Whether what is reset by event k is stopped, whichever way it goes: what is turned back is so where it approaches. */
static int stops(LagRun *run, int k)
{
    LagImpacts *s = &run->impacts;
    lag_impulses_look(run, run->motion.y + run->model->n, s->rate, s->wanted);
    for (int j = 0; j < run->model->n_resets; ++j)
        if (lag_event_of(run->model, j) == k && s->wanted[j] != 0)
            return 0;
    return 1;
}

static double speed_of(const LagRun *run, int k) { return run->switches.g[lag_contact(run->model, k)]; }

static double error_of(const LagRun *run, int k) { return run->sliding.error[lag_contact(run->model, k)]; }

static int keeps_together(const LagRun *run, int k) { return run->impacts.is_plastic[k] && speed_of(run, k) > -error_of(run, k); }

int lag_approaches_find(LagRun *run, int k)
{
    LagImpacts *s = &run->impacts;
    const int comes = s->comes[k], is_stopped = comes && lag_approaches_passed(run, k) && stops(run, k);
    const int is_asked = is_stopped || (comes && s->has_contact[k] == LAG_ONE_WAY);
    const int may = comes || lag_approaches_touch(run, k);
    const int approaches = is_asked || (may && speed_of(run, k) > (comes ? 0 : error_of(run, k)));
    s->fires[k] = approaches || (may && keeps_together(run, k));
    s->comes[k] = comes && approaches && !is_asked;
    return approaches;
}

/* Whether contact k is struck now, by its approach. */
static int is_struck(const LagRun *run, int k)
{
    return run->impacts.fires[k] && run->impacts.has_contact[k] == LAG_CONTACT && !lag_approaches_passed(run, k);
}

static int is_slow(const LagRun *run, int k, double fastest)
{
    return speed_of(run, k) <= lag_max(error_of(run, k), ROUNDING * fastest);
}

void lag_approaches_let_wait(LagRun *run, int rank)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    double fastest = 0;
    int some = 0;
    for (int k = 0; k < model->n_whens; ++k)
        fastest = is_struck(run, k) ? lag_max(speed_of(run, k), fastest) : fastest;
    for (int k = 0; k < model->n_whens; ++k)
        some |= is_struck(run, k) && !is_slow(run, k, fastest);
    for (int k = 0; k < model->n_whens; ++k) {
        const int waits = some && is_struck(run, k) && is_slow(run, k, fastest);
        if (lag_rank_of(model, k) == rank)
            s->comes[k] = s->comes[k] && waits;
        if (waits)
            s->fires[k] = keeps_together(run, k);
    }
}
