/* A.F. Filippov, Differential equations with discontinuous righthand sides (1988). Rates of g are linear in the shares s of the
 * jumps, as accelerations are in forces:  dg/dt = r + W s.  Each that slides has dg/dt = 0 with 0 < s < 1; the others leave g = 0 to
 * the side that they are on: dg/dt <= 0 with s = 0, dg/dt >= 0 with s = 1. Which do what is found by principal pivoting: first all
 * that are wrong at once, then one at a time, the least first (K.G. Murty, Note on a Bard-type scheme for solving the
 * complementarity problem, Opsearch 11 (1974)). Where two hold the same velocity each takes the same share.
 *
 * W changes little while they slide: it is kept, and the shares of each evaluation are corrected until accelerations keep g.
 */
#include "sliding.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "evaluate.h"
#include "extremes.h"
#include "state.h"

enum { LOW, HIGH, SLIDES, GIVEN }; /* states of candidates; given: it does not act on its own g */
/* A change of shares is rounding below ENOUGH, and below FAINT where the next one is not much smaller. */
static const double ENOUGH = 2e-15, FAINT = 1e-5, SLOW = 0.3, ROUNDING = 1e-12, MOMENT = 1e-6, UNKNOWN = 32 * DBL_EPSILON, NOISE = DBL_EPSILON, VANISHED = 1e-10, MOST_RATIO = 0.9, DRIFT = 10;
enum { MOST_TRIES = 12, BLOCKS = 8, MOST_SINGLE = 3 };

void lag_sliding_layout(LagSliding *s, const LagModel *model, int size, LagArena *arena)
{
    const int possible = model->switches_need_acceleration ? model->n_switches : 0;
    s->most = possible < 2 * model->n ? possible : 2 * model->n;
    const size_t most = (size_t)s->most, count = (size_t)possible, whole = count > 0 ? (size_t)size : 0;
    s->which = lag_take_ints(arena, most);
    s->state = lag_take_ints(arena, most);
    s->next = lag_take_ints(arena, most);
    s->share = lag_take(arena, most);
    s->share_here = lag_take(arena, most);
    s->jump = lag_take(arena, most * most);
    s->middle = lag_take(arena, most);
    s->change = lag_take(arena, most);
    s->error = lag_take(arena, count);
    s->most_jump = lag_take(arena, count);
    s->g = lag_take(arena, count);
    s->rate = lag_take(arena, count);
    s->noise = lag_take(arena, most);
    s->state_here = lag_take(arena, whole);
    s->state_before = lag_take(arena, whole);
    s->slope_before = lag_take(arena, whole);
    lag_dense_lu_layout(&s->lu, s->most, 0, arena);
}

void lag_sliding_end(LagRun *run)
{
    run->sliding.count = run->sliding.is_lost = 0;
    run->sliding.energy = 0;
    memset(run->switches.slides, 0, (size_t)run->model->n_switches * sizeof *run->switches.slides);
}

/* Of switch i. */
static double *share_of(const LagRun *run, int i) { return &run->d[run->model->n_modes + i]; }

/* -------- which slide */

/* dg/dt at a state by the shares in d. */
static void rates(LagRun *run, double t, const double *y)
{
    const int n = run->model->n;
    lag_motion_slope(&run->motion, t, y, y + n, run->switches.slope);
    lag_conditions_by(run, t, y, y + n, run->switches.slope + n, run->sliding.g, run->sliding.rate);
}

static int gather(LagRun *run, const int *candidates)
{
    LagSliding *s = &run->sliding;
    int count = 0;
    for (int i = 0; i < run->model->n_switches && count < s->most; ++i)
        if (candidates[i] == 1)
            s->which[count++] = i;
    return count;
}

/* Takes notice of the latest accelerations, those with one jump: rounding of what slides is that of a difference of such ones, and its
 * energies have the size of what they would set in motion. */
static void note_jump(LagRun *run, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    LagScale *scale = &run->scale;
    const int n = run->model->n;
    const double *a = run->switches.slope + n;
    double energies[3];
    for (int i = 0; i < n; ++i) {
        scale->onset[i] = lag_max(UNKNOWN * fabs(a[i]), scale->onset[i]);
        scale->noise[i] = lag_max(scale->onset[i], scale->noise[i]);
    }
    memcpy(s->state_here, y, (size_t)n * sizeof *y);
    memcpy(s->state_here + n, a, (size_t)n * sizeof *a);
    lag_energies(run, t, s->state_here, energies);
    s->energy = fabs(energies[0]);
}

/* The jumps of all `count` candidates, around shares of 1/2. */
static void find_jumps(LagRun *run, double t, const double *y, int count)
{
    LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k)
        *share_of(run, s->which[k]) = 0.5;
    rates(run, t, y);
    for (int k = 0; k < count; ++k)
        s->middle[k] = s->rate[s->which[k]];
    for (int j = 0; j < count; ++j) {
        *share_of(run, s->which[j]) = 1;
        rates(run, t, y);
        for (int k = 0; k < count; ++k)
            s->jump[k + j * count] = 2 * (s->rate[s->which[k]] - s->middle[k]);
        *share_of(run, s->which[j]) = 0.5;
    }
    for (int k = 0; k < count; ++k) {
        double *jump = &s->jump[k + k * count], *most = &s->most_jump[s->which[k]];
        *most = lag_max(fabs(*jump), *most);
        s->share[k] = run->switches.held[s->which[k]];
        const int rests = run->switches.slides[s->which[k]] && fabs(*jump) + fabs(s->middle[k]) < VANISHED * *most;
        *jump = rests ? -VANISHED * *most : *jump; /* nothing holds it, or need to: friction may come again */
        s->state[k] = *jump < 0 ? SLIDES : GIVEN;
    }
}

/* dg/dt of candidate k by those that do not slide alone, or by all. */
static double rate_of(const LagSliding *s, int count, int k, int by_all)
{
    double rate = s->middle[k];
    for (int j = 0; j < count; ++j)
        if (by_all || s->state[j] != SLIDES)
            rate += s->jump[k + j * count] * (s->share[j] - 0.5);
    return rate;
}

/* The size of its terms, which tells what of it is rounding. */
static double size_of(const LagSliding *s, int count, int k)
{
    double size = fabs(s->middle[k]);
    for (int j = 0; j < count; ++j)
        size += fabs(s->jump[k + j * count]);
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
            s->share[k] = 0.5 + s->change[row++];
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
            return rate > 0 ? HIGH : LOW;
        return s->share[k] < 0 ? LOW : s->share[k] > 1 ? HIGH : SLIDES;
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

/* Shares into d and what the switches hold, and those that slide to the front of `which`. Returns how many do. */
static int hold(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    int sliding = 0;
    for (int k = 0; k < count; ++k) {
        const int i = s->which[k], slides = s->state[k] == SLIDES;
        run->switches.held[i] = *share_of(run, i) = lag_max(0, lag_min(1, s->share[k]));
        run->switches.slides[i] = slides;
        if (!slides)
            continue;
        s->noise[sliding] = NOISE * size_of(s, count, k);
        s->which[sliding++] = i;
    }
    return sliding;
}

void lag_sliding_settle(LagRun *run, double t, const double *y, const int *candidates)
{
    LagSliding *s = &run->sliding;
    const int count = gather(run, candidates);
    s->count = 0; /* accelerations as the shares say */
    if (count > 0)
        find_jumps(run, t, y, count);
    lag_sliding_end(run);
    if (count == 0)
        return;
    note_jump(run, t, y);
    const int is_right = pivot(s, count), sliding = hold(run, count);
    if (is_right)
        s->count = sliding;
    else /* step control makes the best of it */
        lag_sliding_end(run);
}

/* Velocities are known to the tolerance, and to that of what those who hold them make of them in a step. */
double lag_sliding_drift(const LagRun *run, int i)
{
    const LagSliding *s = &run->sliding;
    return DRIFT * (s->error[i] + run->scale.tolerance * run->scale.step * s->most_jump[i]);
}

void lag_sliding_stop(LagRun *run)
{
    LagSliding *s = &run->sliding;
    LagMotion *m = &run->motion;
    const double *held = run->switches.held;
    const int count = s->count;
    double largest = 0;
    int jumps = 0;
    s->count = 0; /* accelerations as the shares say */
    rates(run, m->t, m->y);
    for (int k = 0; k < count; ++k) {
        s->change[k] = -s->g[s->which[k]];
        largest = lag_max(fabs(s->change[k]), largest);
        jumps |= fabs(s->change[k]) > LAG_SLIDING_FAR * lag_sliding_drift(run, s->which[k]);
    }
    const int has_rest = largest > 0 && !jumps;
    lag_dense_lu_solve(&s->lu, s->change, NULL);
    for (int with = 0; with <= 1 && has_rest; ++with) {
        for (int k = 0; k < count; ++k)
            *share_of(run, s->which[k]) = held[s->which[k]] + with * s->change[k];
        rates(run, m->t, m->y);
        for (int i = 0; i < m->n; ++i)
            s->slope_before[i] = run->switches.slope[m->n + i] - with * s->slope_before[i];
    }
    for (int i = 0; i < m->n && has_rest; ++i)
        m->y[m->n + i] += s->slope_before[i];
    for (int k = 0; k < count; ++k)
        *share_of(run, s->which[k]) = held[s->which[k]];
    s->count = count;
}

/* -------- while they slide */

/* The largest of the changes that would make dg/dt vanish: into `change`. */
static double find_change(LagRun *run, double t, const double *q, const double *v, const double *a)
{
    LagSliding *s = &run->sliding;
    double largest = 0;
    lag_conditions_by(run, t, q, v, a, s->g, s->rate);
    for (int k = 0; k < s->count; ++k) {
        const double rate = s->rate[s->which[k]];
        s->change[k] = fabs(rate) <= s->noise[k] ? 0 : -rate; /* the jump may be rounding, too */
    }
    lag_dense_lu_solve(&s->lu, s->change, NULL);
    for (int k = 0; k < s->count; ++k)
        largest = fabs(s->change[k]) <= largest ? largest : fabs(s->change[k]); /* what is no number stays */
    return largest;
}

/* The jumps of those that slide, and the shares by them, at a state. */
static void refresh(LagRun *run, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    const int count = s->count;
    s->count = 0; /* accelerations as the shares say */
    find_jumps(run, t, y, count);
    for (int k = 0; k < count; ++k)
        s->state[k] = SLIDES;
    solve(s, count);
    for (int k = 0; k < count; ++k)
        *share_of(run, s->which[k]) = s->share[k];
    s->count = count;
}

/* Whether their rates have vanished, which they do not where a jump has. */
static int are_kept(const LagRun *run)
{
    const LagSliding *s = &run->sliding;
    for (int k = 0; k < s->count; ++k)
        if (fabs(s->rate[s->which[k]]) > s->noise[k] + FAINT * s->most_jump[s->which[k]])
            return 0;
    return 1;
}

/* The jump of the only one that slides, by the secant: forces are linear in its share. Returns 0 where it does not tell. */
static int learn(LagSliding *s, double ratio)
{
    if (s->count != 1 || !(fabs(ratio) < MOST_RATIO))
        return 0;
    s->lu.re[0] /= 1 - ratio; /* the inverse of its jump */
    s->change[0] /= 1 - ratio;
    return 1;
}

LagShares lag_sliding_correct(LagRun *run, int tries, double t, const double *q, const double *v, const double *a)
{
    LagSliding *s = &run->sliding;
    const size_t size = (size_t)run->model->n * sizeof *q;
    const double change = find_change(run, t, q, v, a);
    const int is_settled = change <= ENOUGH || (tries > 0 && change < FAINT && change > SLOW * s->latest);
    if (is_settled && are_kept(run))
        return LAG_SHARES_KEPT;
    const int is_slow = tries > 0 && change * pow(change / s->latest, s->count + 1) > ENOUGH, was_lost = tries == 0 && s->is_lost;
    s->is_lost = !was_lost && (!(change < INFINITY) || tries == MOST_TRIES);
    if (s->is_lost) {
        lag_switches_recall(run);
        return LAG_SHARES_LOST;
    }
    const double ratio = s->change[0] / s->first;
    s->latest = change;
    if (was_lost || is_settled || (is_slow && !learn(s, ratio))) { /* the jumps that are known may be those of nowhere */
        memcpy(s->state_here, q, size);
        memcpy(s->state_here + run->model->n, v, size);
        refresh(run, t, s->state_here);
    } else {
        for (int k = 0; k < s->count; ++k)
            *share_of(run, s->which[k]) += s->change[k];
    }
    s->first = s->change[0];
    return LAG_SHARES_CHANGED;
}

void lag_sliding_margins(const LagRun *run, double *g)
{
    const LagSliding *s = &run->sliding;
    for (int k = 0; k < s->count; ++k) {
        const double share = *share_of(run, s->which[k]);
        g[s->which[k]] = share * (1 - share);
    }
}

void lag_sliding_margin_rates(LagRun *run, double t, const double *y, const double *slope, double span, double *rate)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    const double moment = MOMENT * span;
    for (int k = 0; k < s->count; ++k)
        s->share_here[k] = *share_of(run, s->which[k]);
    for (int i = 0; i < 2 * n; ++i)
        s->state_before[i] = y[i] - moment * slope[i];
    lag_motion_slope(&run->motion, t - moment, s->state_before, s->state_before + n, s->slope_before);
    for (int k = 0; k < s->count; ++k) {
        double *share = share_of(run, s->which[k]);
        rate[s->which[k]] = (1 - 2 * s->share_here[k]) * (s->share_here[k] - *share) / moment;
        *share = s->share_here[k];
    }
}

int lag_sliding_lasts(LagRun *run)
{
    const LagSliding *s = &run->sliding;
    for (int k = 0; k < s->count; ++k)
        if (fabs(s->g[s->which[k]]) > lag_sliding_drift(run, s->which[k]))
            return 0;
    return 1;
}
