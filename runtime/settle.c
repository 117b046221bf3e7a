/* Which slide. Rates of g are linear in the shares s of the jumps, as accelerations are in forces:  dg/dt = r + W s.  Each that slides
 * has dg/dt = 0 with 0 < s < 1; the others leave g = 0 to the side that they are on: dg/dt <= 0 with s = 0, dg/dt >= 0 with s = 1. Which
 * do what is found by principal pivoting: first all that are wrong at once, then one at a time, the least first (K.G. Murty, Note on a
 * Bard-type scheme for solving the complementarity problem, Opsearch 11 (1974)). Where two hold the same velocity each takes the same
 * share. Friction that presses with the force of a contact is a product of two shares: W is found anew at those that were chosen, until
 * rates are what it says.
 */
#include "sliding.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "evaluate.h"
#include "extremes.h"
#include "jams.h"
#include "rubs.h"
#include "state.h"

enum { LOW, HIGH, SLIDES, GIVEN }; /* states of candidates; given: it does not act on its own g */
enum { BLOCKS = 8, MOST_SINGLE = 3, MOST_TURNS = 20 };
/* What of dg/dt is rounding, by its terms: in the choice, and while they slide; what of accelerations is; the share of the largest jump
 * so far that is none. */
static const double ROUNDING = 1e-12, NOISE = DBL_EPSILON, UNKNOWN = 1024 * DBL_EPSILON, VANISHED = 1e-10;
static const double NEARLY = 1e-9; /* of the terms of dg/dt */
static const double NO_FORCE = 1e-13; /* of a force of the size of others: what others hold, a contact does not */
static const double MOMENT = 1e-3; /* s */
static const double LITTLE = 1e-3; /* of the largest change of an acceleration by a contact */

void lag_sliding_rates(LagRun *run, double t, const double *y)
{
    const int n = run->model->n;
    lag_motion_slope(&run->motion, t, y, y + n, run->switches.slope);
    lag_conditions_by(run, t, y, y + n, run->switches.slope + n, run->sliding.g, run->sliding.rate);
}

/* Contacts first: where friction and a contact hold the same rate, friction is what may not know its share. */
static int gather(LagRun *run, const int *candidates)
{
    LagSliding *s = &run->sliding;
    int count = 0;
    for (int contacts = 1; contacts >= 0; --contacts)
        for (int i = 0; i < run->model->n_switches && count < s->most; ++i)
            if (candidates[i] == 1 && lag_may_have_all(run, i) == !contacts)
                s->which[count++] = i;
    return count;
}

/* Takes notice of accelerations without the jumps, in slope_without, and of the latest ones, with one: rounding of what slides is that
 * of a difference of such ones. */
static void note_noise(LagRun *run)
{
    LagScale *scale = &run->scale;
    const int n = run->model->n;
    const double *with = run->switches.slope + n, *without = run->sliding.slope_without + n;
    for (int i = 0; i < n; ++i) {
        scale->onset[i] = lag_max(UNKNOWN * lag_max(fabs(with[i]), fabs(without[i])), scale->onset[i]);
        scale->noise[i] = lag_max(scale->onset[i], scale->noise[i]);
    }
}

/* What slides has energies of the size of what the latest jump would set in motion. */
static void note_energy(LagRun *run, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    double energies[3];
    for (int i = 0; i < n; ++i) {
        s->state_here[i] = y[i];
        s->state_here[n + i] = 2 * (run->switches.slope[n + i] - s->slope_without[n + i]);
    }
    lag_energies(run, t, s->state_here, energies);
    s->energy = fabs(energies[0]);
}

/* How much another share of candidate j changes all rates, by the share: into its column. */
static void probe(LagRun *run, double t, const double *y, int count, int j, double change)
{
    LagSliding *s = &run->sliding;
    *lag_share(run, s->which[j]) = s->base[j] + change;
    lag_sliding_rates(run, t, y);
    for (int k = 0; k < count; ++k)
        s->jump[k + j * count] = (s->rate[s->which[k]] - s->middle[k]) / change;
    *lag_share(run, s->which[j]) = s->base[j];
}

/* A force of a contact that changes accelerations by as much as they are without it, or usually: v^2/q. Those with it, 1, are the
 * latest. */
static double force_of_size(const LagRun *run)
{
    const double *without = run->sliding.slope_without, *with = run->switches.slope, *size = run->scale.floor;
    const int n = run->model->n;
    double most = 0, change = 0;
    for (int i = n; i < 2 * n; ++i)
        change = lag_max(fabs(with[i] - without[i]), change);
    for (int i = n; i < 2 * n; ++i) {
        const double place = lag_max(size[i - n], size[i] * MOMENT); /* what has just begun has no size yet */
        const double usual = place > 0 ? size[i] * size[i] / place : 0, own = lag_max(fabs(without[i]), usual);
        if (fabs(with[i] - without[i]) > LITTLE * change)
            most = lag_max(own / fabs(with[i] - without[i]), most);
    }
    return most > 0 && most < INFINITY ? most : 1;
}

/* What shares of candidate j are measured by. */
static void find_unit(LagRun *run, double t, const double *y, int count, int j)
{
    LagSliding *s = &run->sliding;
    const int is_jump = lag_may_have_all(run, s->which[j]);
    if (!is_jump)
        probe(run, t, y, count, j, 1);
    s->unit[j] = is_jump ? 1 : force_of_size(run);
    s->least[j] = is_jump ? 0 : NO_FORCE * s->unit[j];
}

/* Shares that a choice begins with. */
static void begin_shares(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k) {
        const int is_jump = lag_may_have_all(run, s->which[k]);
        s->share[k] = is_jump ? 0.5 : 0;
        s->limit[k] = is_jump ? 1 : INFINITY;
        *lag_share(run, s->which[k]) = s->share[k];
    }
}

/* The jumps of all `count` candidates, around the shares in d; of contacts by a force of the size that is needed. What is large and
 * what is rounding is learned at present states alone: stages of steps that are too long may be anywhere. */
enum { ELSEWHERE, PRESENT, FIRST }; /* the latter: at the present state, with nothing known of it */
static void find_jumps(LagRun *run, double t, const double *y, int count, int where)
{
    LagSliding *s = &run->sliding;
    lag_sliding_rates(run, t, y);
    memcpy(s->slope_without, run->switches.slope, 2 * (size_t)run->model->n * sizeof *y);
    for (int k = 0; k < count; ++k) {
        s->middle[k] = s->rate[s->which[k]];
        s->base[k] = *lag_share(run, s->which[k]);
    }
    for (int j = 0; j < count; ++j) {
        if (where == FIRST)
            find_unit(run, t, y, count, j);
        probe(run, t, y, count, j, lag_share_step(run, j));
        if (where != ELSEWHERE)
            note_noise(run);
    }
    for (int k = 0; k < count; ++k) {
        double *jump = &s->jump[k + k * count];
        const double size = fabs(*jump) * s->unit[k], most = lag_max(size, s->most_jump[s->which[k]]);
        if (where != ELSEWHERE)
            s->most_jump[s->which[k]] = most;
        const int rests = run->switches.slides[s->which[k]] && size + fabs(s->middle[k]) < VANISHED * most;
        *jump = rests ? -VANISHED * most / s->unit[k] : *jump; /* nothing holds it, or need to: friction may come again */
    }
}

/* Those that nothing is known of: whether they act on their own g. */
static void begin_states(LagSliding *s, int count, int is_first)
{
    for (int k = 0; k < count; ++k)
        if (is_first || s->state[k] == GIVEN || s->jump[k + k * count] >= 0)
            s->state[k] = s->jump[k + k * count] < 0 ? SLIDES : GIVEN;
}

/* dg/dt of candidate k by those that do not slide alone, or by all. */
static double rate_of(const LagSliding *s, int count, int k, int by_all)
{
    double rate = s->middle[k];
    for (int j = 0; j < count; ++j)
        if (by_all || s->state[j] != SLIDES)
            rate += s->jump[k + j * count] * (s->share[j] - s->base[j]);
    return rate;
}

/* The size of its terms, which tells what of it is rounding. */
static double size_of(const LagSliding *s, int count, int k)
{
    double size = fabs(s->middle[k]);
    for (int j = 0; j < count; ++j)
        size += fabs(s->jump[k + j * count] * s->unit[j]);
    return size;
}

/* Shares of those that slide. */
static void solve(LagSliding *s, int count)
{
    int free = 0;
    for (int k = 0; k < count; ++k)
        free += s->state[k] == SLIDES;
    s->lu.size = free;
    for (int k = 0, row = 0; k < count; ++k) {
        if (s->state[k] != SLIDES)
            continue;
        s->change[row] = -rate_of(s, count, k, 0);
        for (int j = 0, column = 0; j < count; ++j)
            if (s->state[j] == SLIDES)
                s->lu.re[row + free * column++] = s->jump[k + j * count];
        ++row;
    }
    lag_dense_lu_factor(&s->lu);
    lag_dense_lu_solve(&s->lu, s->change, NULL);
    for (int k = 0, row = 0; k < count; ++k)
        if (s->state[k] == SLIDES)
            s->share[k] = s->base[k] + s->change[row++];
}

/* The state that candidate k should have instead of its own; the same where it is right. */
static int better(const LagSliding *s, int count, int k)
{
    const double rate = rate_of(s, count, k, 1), rounding = ROUNDING * size_of(s, count, k);
    switch (s->state[k]) {
    case LOW: return rate > rounding ? SLIDES : LOW;
    case HIGH: return rate < -rounding ? SLIDES : HIGH;
    case SLIDES:
        if (fabs(rate) > rounding) /* others hold what it would: its own velocity is to be another one */
            return rate < 0 ? LOW : s->limit[k] < INFINITY ? HIGH : SLIDES;
        return s->share[k] < s->least[k] ? LOW : s->share[k] > s->limit[k] ? HIGH : SLIDES;
    default: return GIVEN;
    }
}

/* Finds the states and shares; returns whether they are right. */
static int pivot(LagSliding *s, int count)
{
    const int most = BLOCKS + MOST_SINGLE * count;
    int changes = 1;
    for (int turn = 0; changes > 0 && turn < most; ++turn) {
        solve(s, count);
        changes = 0;
        for (int k = 0; k < count; ++k) {
            s->next[k] = turn < BLOCKS || changes == 0 ? better(s, count, k) : s->state[k];
            changes += s->next[k] != s->state[k];
        }
        for (int k = 0; k < count; ++k) {
            s->state[k] = s->next[k];
            if (s->state[k] == LOW || s->state[k] == HIGH)
                s->share[k] = s->state[k] == HIGH;
        }
    }
    return changes == 0;
}

/* What does not act on its own g is at the end where that goes; where it goes nowhere, where it is. */
static void let_go(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k) {
        const double rate = rate_of(s, count, k, 1), g = s->g[s->which[k]];
        const int goes = fabs(rate) > ROUNDING * size_of(s, count, k);
        if (s->state[k] == GIVEN)
            s->share[k] = s->limit[k] == INFINITY ? 0 : goes ? rate > 0 : g != 0 ? g > 0 : run->switches.held[s->which[k]];
    }
}

/* Shares into d. */
static void set_shares(const LagRun *run, int count)
{
    const LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k)
        *lag_share(run, s->which[k]) = lag_max(0, lag_min(s->limit[k], s->share[k]));
}

/* Whether rates at the shares in d are what jumps make them out to be: they are not where friction presses with the force of a contact,
 * which is a product of two shares. */
static int is_linear(LagRun *run, double t, const double *y, int count)
{
    const LagSliding *s = &run->sliding;
    lag_sliding_rates(run, t, y);
    for (int k = 0; k < count; ++k)
        if (fabs(s->rate[s->which[k]] - rate_of(s, count, k, 1)) > NEARLY * size_of(s, count, k))
            return 0;
    return 1;
}

/* States and shares of `count` candidates; returns whether they are right. */
static int choose(LagRun *run, double t, const double *y, int count)
{
    LagSliding *s = &run->sliding;
    for (int turn = 1;; ++turn) { /* Newton's iterations, where shares are multiplied: what rubs has no jump before contacts press */
        const int may_end = turn > 1 || run->model->n_rubs == 0;
        begin_states(s, count, turn == 1);
        const int is_right = pivot(s, count);
        if (may_end)
            let_go(run, count);
        set_shares(run, count);
        if (!is_right || turn == MOST_TURNS || (may_end && is_linear(run, t, y, count)))
            return is_right && turn < MOST_TURNS;
        find_jumps(run, t, y, count, PRESENT);
    }
}

/* Whether a contact closes that nothing could hold: its friction would press it further. */
static int presses(const LagSliding *s, int count)
{
    for (int k = 0; k < count; ++k) {
        const double rounding = ROUNDING * size_of(s, count, k);
        const int is_jam = s->state[k] == GIVEN && s->jump[k + k * count] * s->unit[k] > rounding;
        if (is_jam && s->limit[k] == INFINITY && rate_of(s, count, k, 1) > rounding)
            return 1;
    }
    return 0;
}

/* The same where each depends on the others. */
static int choose_together(LagRun *run, double t, const double *y, int count)
{
    LagSliding *s = &run->sliding;
    static const int states[] = {SLIDES, LOW, HIGH};
    if (!lag_jams_solve(run, t, y, count))
        return 0;
    for (int k = 0; k < count; ++k) {
        s->state[k] = lag_jams_may_act(run, k) ? states[run->impacts.problem.state[k]] : s->limit[k] == INFINITY ? LOW : GIVEN;
        s->unit[k] = s->limit[k] == INFINITY && s->state[k] == SLIDES ? lag_max(s->share[k], s->unit[k]) : s->unit[k];
    }
    set_shares(run, count);
    find_jumps(run, t, y, count, PRESENT);
    s->lu.dependent = run->impacts.problem.lu.dependent;
    solve(s, count);
    let_go(run, count);
    set_shares(run, count);
    return is_linear(run, t, y, count);
}

/* What the switches hold, and those that slide to the front of `which`. Returns how many do. */
static int hold(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    int sliding = 0;
    for (int k = 0; k < count; ++k) {
        const int i = s->which[k];
        run->switches.held[i] = *lag_share(run, i);
        run->switches.slides[i] = s->state[k] == SLIDES;
        run->switches.is_idle[i] = s->state[k] == GIVEN && s->jump[k + k * count] == 0 && lag_rubs_alone(run->model, i);
        s->noise[k] = NOISE * size_of(s, count, k);
    }
    for (int k = 0; k < count; ++k)
        if (s->state[k] == SLIDES) {
            s->noise[sliding] = s->noise[k];
            s->unit[sliding] = s->unit[k];
            s->which[sliding++] = s->which[k];
        }
    return sliding;
}

void lag_sliding_settle(LagRun *run, double t, const double *y, const int *candidates)
{
    LagSliding *s = &run->sliding;
    const int count = gather(run, candidates);
    s->count = 0; /* accelerations as the shares say */
    if (count > 0) {
        begin_shares(run, count);
        find_jumps(run, t, y, count, FIRST);
    }
    lag_sliding_end(run);
    s->jams = 0;
    if (count == 0)
        return;
    note_energy(run, t, y);
    s->lu.dependent = LAG_SLIDING_DEPENDENT;
    const int is_right = (choose(run, t, y, count) && !presses(s, count)) || choose_together(run, t, y, count);
    s->jams = !is_right && run->model->n_rubs > 0;
    const int sliding = hold(run, count);
    if (is_right)
        s->count = sliding;
    else /* step control makes the best of it */
        lag_sliding_end(run);
}

void lag_sliding_refresh(LagRun *run, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    const int count = s->count;
    s->count = 0; /* accelerations as the shares say */
    find_jumps(run, t, y, count, ELSEWHERE);
    for (int k = 0; k < count; ++k)
        s->state[k] = SLIDES;
    solve(s, count);
    for (int k = 0; k < count; ++k)
        *lag_share(run, s->which[k]) = s->share[k];
    s->count = count;
}
