/* Which slide. Rates of g are linear in the shares s of the jumps, as accelerations are in forces:  dg/dt = r + W s.  Each that slides
 * has dg/dt = 0 with 0 < s < 1; the others leave g = 0 to the side that they are on: dg/dt <= 0 with s = 0, dg/dt >= 0 with s = 1. Which
 * do what is found by principal pivoting: first all that are wrong at once, then one at a time, the least first (K.G. Murty, Note on a
 * Bard-type scheme for solving the complementarity problem, Opsearch 11 (1974)). Where two hold the same velocity each takes the same
 * share. Friction that presses with the force of a contact is a product of two shares: W is found anew at those that were chosen, until
 * rates are what it says.
 */
#include "events/slide_states.h"

#include <math.h>

#include "events/candidates.h"
#include "events/jams.h"
#include "events/jumps.h"
#include "numbers/extremes.h"
#include "state/state.h"

enum { BLOCKS = 8, MOST_SINGLE = 3, MOST_TURNS = 20 };
static const double ROUNDING = LAG_STATES_ROUNDING;
static const double NEARLY = 1e-9; /* of the terms of dg/dt */

/* Whether candidate k acts on its own g, or as a component of a force that acts on the other one. */
static int acts(const LagSliding *s, int count, int k)
{
    const int other = lag_candidates_place(s, count, s->partner[s->which[k]]);
    return s->jump[k + k * count] < 0 || (other >= 0 && s->jump[other + other * count] < 0);
}

/* Those that nothing is known of. */
static void begin_states(LagSliding *s, int count, int is_first)
{
    for (int k = 0; k < count; ++k)
        if (is_first || s->state[k] == LAG_GIVEN || s->jump[k + k * count] >= 0)
            s->state[k] = acts(s, count, k) ? LAG_SLIDES : LAG_GIVEN;
}

/* The state that candidate k should have instead of its own; the same where it is right. */
static int better(const LagSliding *s, int count, int k)
{
    const double rate = lag_candidates_rate(s, count, k, 1), rounding = ROUNDING * lag_candidates_size(s, count, k);
    const double tie = lag_candidates_tie(s, count, k, ROUNDING);
    switch (s->state[k]) {
    case LAG_LOW: return rate > rounding ? LAG_SLIDES : LAG_LOW;
    case LAG_HIGH: return rate < -rounding ? LAG_SLIDES : LAG_HIGH;
    case LAG_SLIDES:
        if (fabs(rate) > rounding) /* others hold what it would: its own velocity is to be another one */
            return rate < 0 ? LAG_LOW : s->limit[k] < INFINITY ? LAG_HIGH : LAG_SLIDES;
        return s->share[k] < s->least[k] + tie ? LAG_LOW : s->share[k] > s->limit[k] - tie ? LAG_HIGH : LAG_SLIDES;
    default: return LAG_GIVEN;
    }
}

/* Whether a contact closes although it holds, as another one wants the same velocity to change less: one has to let go. */
static int contradict(const LagSliding *s, int count)
{
    for (int k = 0; k < count; ++k)
        if (s->state[k] == LAG_SLIDES && lag_candidates_rate(s, count, k, 1) > ROUNDING * lag_candidates_size(s, count, k))
            return 1;
    return 0;
}

/* Finds the states and shares; returns whether they are right. */
static int pivot(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    const int most = BLOCKS + MOST_SINGLE * count;
    int changes = 1;
    for (int turn = 0; changes > 0 && turn < most; ++turn) {
        lag_candidates_solve(run, count);
        changes = 0;
        for (int k = 0; k < count; ++k) {
            s->next[k] = turn < BLOCKS || changes == 0 ? better(s, count, k) : s->state[k];
            changes += s->next[k] != s->state[k];
        }
        for (int k = 0; k < count; ++k) {
            s->state[k] = s->next[k];
            if (s->state[k] == LAG_LOW || s->state[k] == LAG_HIGH)
                s->share[k] = s->state[k] == LAG_HIGH;
        }
    }
    return changes == 0 && !contradict(s, count);
}

int lag_states_goes(const LagSliding *s, int count, int k)
{
    return fabs(lag_candidates_rate(s, count, k, 1)) > ROUNDING * lag_candidates_size(s, count, k);
}

/* What does not act on its own g is at the end where that goes; where it goes nowhere, where it is. */
static void let_go(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k) {
        const double g = s->g[s->which[k]], toward = lag_states_goes(s, count, k) ? lag_candidates_rate(s, count, k, 1) : g;
        const int stays = toward == 0 || run->switches.stands[s->which[k]];
        if (s->state[k] == LAG_GIVEN)
            s->share[k] = s->limit[k] == INFINITY ? 0 : stays ? run->switches.held[s->which[k]] : toward > 0;
    }
}

/* Whether rates at the shares in d are what jumps make them out to be: they are not where friction presses with the force of a contact,
 * which is a product of two shares. */
static int is_linear(LagRun *run, double t, const double *y, int count)
{
    const LagSliding *s = &run->sliding;
    lag_sliding_rates(run, t, y);
    for (int k = 0; k < count; ++k)
        if (fabs(s->rate[s->which[k]] - lag_candidates_rate(s, count, k, 1)) > NEARLY * lag_candidates_size(s, count, k))
            return 0;
    return 1;
}

int lag_states_choose(LagRun *run, double t, const double *y, int count)
{
    LagSliding *s = &run->sliding;
    for (int turn = 1;; ++turn) { /* Newton's iterations, where shares are multiplied: what rubs has no jump before contacts press */
        const int may_end = turn > 1 || run->model->n_rubs == 0;
        begin_states(s, count, turn == 1);
        const int is_right = pivot(run, count);
        if (may_end)
            let_go(run, count);
        lag_candidates_set(run, count);
        if (!is_right || turn == MOST_TURNS)
            return 0;
        if (may_end && is_linear(run, t, y, count)) {
            if (turn > 1) {
                lag_jumps_find(run, t, y, count, LAG_PRESENT);
                lag_sliding_rates(run, t, y);
            }
            return 1;
        }
        lag_jumps_find(run, t, y, count, LAG_ELSEWHERE); /* forces on the way may be large without measure */
    }
}

/* Whether a contact closes that nothing could hold: its friction would press it further. */
static int presses(const LagSliding *s, int count)
{
    for (int k = 0; k < count; ++k) {
        const double rounding = ROUNDING * lag_candidates_size(s, count, k);
        const int is_jam = s->state[k] == LAG_GIVEN && s->jump[k + k * count] * s->unit[k] > rounding;
        if (is_jam && s->limit[k] == INFINITY && lag_candidates_rate(s, count, k, 1) > rounding)
            return 1;
    }
    return 0;
}

/* The same where each depends on the others. */
static int choose_together(LagRun *run, double t, const double *y, int count)
{
    LagSliding *s = &run->sliding;
    static const int states[] = {LAG_SLIDES, LAG_LOW, LAG_HIGH};
    if (!lag_jams_solve(run, t, y, count))
        return 0;
    for (int k = 0; k < count; ++k) {
        s->state[k] = lag_jams_may_act(run, k) ? states[run->impacts.problem.state[k]] : s->limit[k] == INFINITY ? LAG_LOW : LAG_GIVEN;
        if (s->state[k] == LAG_SLIDES && s->limit[k] == INFINITY)
            s->unit[k] = lag_max(s->share[k], s->unit[k]);
    }
    lag_candidates_set(run, count);
    lag_jumps_find(run, t, y, count, LAG_PRESENT);
    s->lu.dependent = run->impacts.problem.lu.dependent;
    lag_candidates_solve(run, count);
    let_go(run, count);
    lag_candidates_set(run, count);
    return is_linear(run, t, y, count);
}

int lag_states_choose_any(LagRun *run, double t, const double *y, int count)
{
    return (lag_states_choose(run, t, y, count) && !presses(&run->sliding, count)) || choose_together(run, t, y, count);
}
