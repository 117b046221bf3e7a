/* While they slide: A.F. Filippov, Differential equations with discontinuous righthand sides (1988). How dg/dt changes with the shares
 * changes little: it is kept, and the shares of each evaluation are corrected until accelerations keep g. Where that takes long it is
 * found anew.
 */
#include "events/sliding.h"

#include <math.h>
#include <string.h>

#include "events/cones.h"
#include "events/pressed.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "state/state.h"

/* A change of shares is rounding below ENOUGH, and below FAINT where the next one is not much smaller; the secant tells of a jump where
 * a change is not as large as the one before. */
static const double ENOUGH = 2e-15, FAINT = 1e-5, SLOW = 0.3, MOST_RATIO = 0.9, MANY = 1000, REPEATED = 1e-8, MOST_FORCE = 3;
static const double MOMENT = 1e-6, DRIFT = 10; /* of a step; of tolerances */
static const double LEAST = 1e-6; /* change of a share of which accelerations have digits */
static const double ROUGH = 1e-2; /* rounding of a small rate that is the difference of large ones */
static const double MOVED = 2; /* times as far from 0 as before an impact: it was moved */
/* Where equations contradict each other those of contacts, which come first, are kept. */
static const double EARLY = 0.1;
enum { MOST_TRIES = 12, SPARE = 16 }; /* what holds more than once, as feet of one body do */

int lag_sliding_most(const LagModel *model)
{
    const int possible = model->switches_need_acceleration ? model->n_switches : 0;
    return possible < 2 * model->n + SPARE ? possible : 2 * model->n + SPARE;
}

static void lay_out_holds(LagSliding *s, const LagModel *model, size_t count, LagArena *arena)
{
    s->way = lag_take(arena, (size_t)s->most * (size_t)model->n);
    s->partner = lag_take_ints(arena, count);
    s->holds = lag_take_ints(arena, count);
    s->drift = lag_take(arena, 2 * (size_t)s->most);
    s->factored = lag_take(arena, (size_t)s->most);
    s->which_all = lag_take_ints(arena, (size_t)s->most);
    s->is_spent = lag_take_ints(arena, (size_t)s->most);
    s->of_all = lag_take(arena, 2 * (size_t)s->most);
    lag_dense_lu_layout(&s->held, s->most, 0, arena);
    s->held.dependent = LAG_SLIDING_DEPENDENT;
    s->held.early = EARLY;
}

static void lay_out_knowledge(LagSliding *s, const LagModel *model, size_t most, LagArena *arena)
{
    s->is_new = lag_take_ints(arena, most);
    s->is_light = lag_take_ints(arena, most);
    s->open = lag_take_ints(arena, most);
    s->known = lag_take_ints(arena, most);
    s->known_share = lag_take(arena, most);
    s->known_rate = lag_take(arena, most);
    s->known_rest = lag_take(arena, (size_t)model->n_rests);
}

static void layout_cones(LagSliding *s, const LagModel *model, LagArena *arena)
{
    s->leaves = lag_take_ints(arena, (size_t)model->n_cones);
    s->slip = lag_take(arena, 2 * (size_t)model->n_cones);
    s->beyond = lag_take(arena, (size_t)model->n_cones);
    s->speed = lag_take(arena, (size_t)model->n_cones);
    s->mirrored = lag_take(arena, model->n_cones > 0 ? (size_t)model->n : 0);
}

void lag_sliding_layout(LagSliding *s, const LagModel *model, int size, LagArena *arena)
{
    const int possible = model->switches_need_acceleration ? model->n_switches : 0;
    s->most = lag_sliding_most(model);
    const size_t most = (size_t)s->most, count = (size_t)possible, whole = count > 0 ? (size_t)size : 0;
    s->which = lag_take_ints(arena, most);
    s->state = lag_take_ints(arena, most);
    s->next = lag_take_ints(arena, most);
    lay_out_knowledge(s, model, most, arena);
    layout_cones(s, model, arena);
    s->share = lag_take(arena, most);
    s->share_here = lag_take(arena, most);
    s->jump = lag_take(arena, most * most);
    s->middle = lag_take(arena, most);
    s->change = lag_take(arena, most);
    s->still = lag_take_ints(arena, model->n_switches > 0 ? (size_t)model->n : 0);
    s->is_tied = lag_take_ints(arena, (size_t)model->n_switches);
    s->error = lag_take(arena, count);
    s->before = lag_take(arena, count);
    s->most_jump = lag_take(arena, count);
    s->g = lag_take(arena, count);
    s->rate = lag_take(arena, count);
    s->unit = lag_take(arena, most);
    s->base = lag_take(arena, most);
    s->least = lag_take(arena, most);
    s->limit = lag_take(arena, most);
    s->noise = lag_take(arena, most);
    s->state_here = lag_take(arena, whole);
    s->state_before = lag_take(arena, whole);
    s->slope_before = lag_take(arena, whole);
    s->slope_without = lag_take(arena, whole);
    lag_dense_lu_layout(&s->lu, s->most, 0, arena);
    s->lu.dependent = LAG_SLIDING_DEPENDENT;
    s->lu.early = EARLY;
    lag_shares_layout(&s->system, model, s->most, arena);
    lay_out_holds(s, model, count, arena);
}

static void find_partners(LagRun *run)
{
    for (int i = 0; i < run->model->n_switches && run->model->switches_need_acceleration; ++i)
        run->sliding.partner[i] = lag_cones_partner(run, i);
}

static void forget_holds(LagRun *run)
{
    for (int i = 0; i < run->model->n_switches && run->model->switches_need_acceleration; ++i)
        run->sliding.holds[i] = LAG_HELD_UNKNOWN;
}

void lag_sliding_reset(LagRun *run)
{
    LagSliding *s = &run->sliding;
    const size_t size = run->model->switches_need_acceleration ? (size_t)run->model->n_switches * sizeof *s->error : 0;
    lag_sliding_end(run);
    lag_sliding_forget_impact(run);
    s->latest = s->first = 0;
    s->grows = s->is_lenient = 0;
    s->stops = s->known_error = INFINITY;
    s->creep = s->drawn = 0;
    memset(s->beyond, 0, (size_t)run->model->n_cones * sizeof *s->beyond);
    lag_shares_reset(run);
    find_partners(run);
    forget_holds(run);
    if (size > 0) {
        memset(s->error, 0, size);
        memset(s->most_jump, 0, size);
    }
}

void lag_sliding_end(LagRun *run)
{
    run->sliding.count = run->sliding.is_lost = 0;
    run->sliding.energy = 0;
    memset(run->switches.slides, 0, (size_t)run->model->n_switches * sizeof *run->switches.slides);
    for (int k = 0; k < run->model->n_rests; ++k)
        *lag_rest(run, k) = 0;
    memset(run->switches.is_idle, 0, (size_t)run->model->n_switches * sizeof *run->switches.is_idle);
    memset(run->sliding.is_tied, 0, (size_t)run->model->n_switches * sizeof *run->sliding.is_tied);
}

double *lag_share(const LagRun *run, int i) { return &run->d[run->model->n_modes + i]; }

double *lag_rest(const LagRun *run, int k)
{
    return &run->d[run->model->n_modes + run->model->n_switches + run->model->n_resets + k];
}

double lag_share_step(const LagRun *run, int k)
{
    const LagSliding *s = &run->sliding;
    return !lag_may_have_all(run, s->which[k]) ? s->unit[k] : *lag_share(run, s->which[k]) > 0.5 ? -0.5 : 0.5;
}

int lag_may_have_all(const LagRun *run, int i) { return i < lag_when(run->model, 0); }

/* Velocities are known to the tolerance, and to that of what those who hold them make of them in a step. */
double lag_sliding_drift(const LagRun *run, int i)
{
    const LagSliding *s = &run->sliding;
    const double error = lag_may_have_all(run, i) ? s->error[i] : lag_max(1, run->impacts.coarse) * s->error[i];
    return DRIFT * (error + run->scale.tolerance * run->scale.step * s->most_jump[i]);
}

double lag_sliding_held(const LagRun *run, int i)
{
    const LagSliding *s = &run->sliding;
    if (!run->switches.slides[i] && !s->is_tied[i])
        return 0;
    const double drift = LAG_SLIDING_FAR * lag_sliding_drift(run, i), most = lag_may_have_all(run, i) ? s->most_jump[i] : INFINITY;
    const double drawn = s->drawn > 0 ? s->drawn * most : 0; /* contacts push with any force */
    return lag_min(MOVED * s->before[i], lag_max(drift, drawn));
}

void lag_sliding_note_impact(LagRun *run, const double *g)
{
    for (int i = 0; i < run->model->n_switches && run->model->switches_need_acceleration; ++i)
        run->sliding.before[i] = fabs(g[i]);
}

void lag_sliding_forget_impact(LagRun *run)
{
    for (int i = 0; i < run->model->n_switches && run->model->switches_need_acceleration; ++i)
        run->sliding.before[i] = INFINITY;
}

/* Whether at rates that differ by that share of slope_before no more is left of the g of those that slide, but for rounding. */
static int mends(LagRun *run, int count, double share, double most)
{
    LagSliding *s = &run->sliding;
    const LagMotion *m = &run->motion;
    for (int i = 0; i < m->n; ++i)
        s->state_here[i] = m->y[m->n + i] + share * s->slope_before[i];
    lag_conditions_of_motion(run, m->t, m->y, s->state_here, run->switches.slope + m->n, s->g, s->rate);
    for (int k = 0; k < count; ++k)
        if (!(fabs(s->g[s->which[k]]) <= (1 + ROUGH) * most))
            return 0;
    return 1;
}

/* A contact that has changed, or a slip in the plane that an importer's steps have not stopped at its place. */
static int comes_to_rest(LagRun *run, int i)
{
    const int stops = run->impacts.coarse > 0 && lag_cones_have(run, i) && !lag_cones_have_left(run, i);
    return (stops || !lag_may_have_all(run, i)) && run->switches.turned[i] == LAG_CHANGES;
}

void lag_sliding_stop(LagRun *run)
{
    LagSliding *s = &run->sliding;
    LagMotion *m = &run->motion;
    const int count = s->count;
    double largest = 0, most = 0;
    int jumps = 0;
    s->count = 0; /* accelerations as the shares say */
    lag_sliding_rates(run, m->t, m->y);
    for (int k = 0; k < count; ++k) {
        s->share_here[k] = *lag_share(run, s->which[k]);
        s->change[k] = lag_cones_kick(run, s->which[k]) - s->g[s->which[k]];
        largest = lag_max(fabs(s->change[k]), largest);
        jumps |= !comes_to_rest(run, s->which[k]) && fabs(s->g[s->which[k]]) > lag_max(lag_sliding_held(run, s->which[k]), run->switches.unknown[s->which[k]]);
    }
    lag_shares_solve(run, s->change);
    for (int k = 0; k < count; ++k) {
        jumps |= !isfinite(s->change[k]);
        most = lag_max(lag_pressed_change(run, count, k), most);
    }
    const double times = lag_max(1, LEAST / most); /* accelerations are linear, and tell no less */
    const int has_rest = largest > 0 && !jumps;
    for (int with = 0; with <= 1 && has_rest; ++with) {
        memcpy(s->share, s->share_here, (size_t)count * sizeof *s->share);
        lag_pressed_add(run, count, with * times, s->share);
        for (int k = 0; k < count; ++k)
            *lag_share(run, s->which[k]) = s->share[k];
        lag_sliding_rates(run, m->t, m->y);
        for (int i = 0; i < m->n; ++i)
            s->slope_before[i] = run->switches.slope[m->n + i] - with * s->slope_before[i];
    }
    const int is_mended = has_rest && mends(run, count, 1 / times, largest);
    for (int i = 0; i < m->n && is_mended; ++i)
        m->y[m->n + i] += s->slope_before[i] / times;
    if (has_rest && s->grows)
        lag_cones_throw(run);
    for (int k = 0; k < count; ++k)
        *lag_share(run, s->which[k]) = s->share_here[k];
    s->count = count;
}

/* The largest of the changes that would make dg/dt vanish: into `change`; into s->left, how much of a jump is left of it. */
static double find_change(LagRun *run, double t, const double *q, const double *v, const double *a)
{
    LagSliding *s = &run->sliding;
    double largest = 0;
    s->left = 0;
    lag_conditions_of_motion(run, t, q, v, a, s->g, s->rate);
    for (int k = 0; k < s->count; ++k) {
        const double rate = s->rate[s->which[k]];
        s->change[k] = fabs(rate) <= s->noise[k] ? 0 : -rate; /* the jump may be rounding, too */
        s->left = lag_max(fabs(s->change[k]) / s->most_jump[s->which[k]], s->left);
    }
    lag_shares_solve(run, s->change);
    for (int k = 0; k < s->count; ++k) {
        const double change = lag_pressed_change(run, s->count, k);
        largest = change <= largest ? largest : change; /* what is no number stays */
    }
    return largest;
}

/* Whether their rates have vanished, which they do not where a jump has, or where shares are found of nothing: of them no more is left than
 * the latest change of shares makes, or, where several hold the same, than they contradict each other: which is not asked of friction that
 * would take many times its force, of a contact that does not press, nor, where an importer's step goes on beyond where they hold, of
 * friction in the plane across the way it goes. */
static int are_kept(const LagRun *run, double change)
{
    const LagSliding *s = &run->sliding;
    double most = 0;
    for (int k = 0; k < s->count; ++k)
        most = lag_max(s->most_jump[s->which[k]], most);
    for (int k = 0; k < s->count; ++k) {
        const double share = *lag_share(run, s->which[k]), jump = s->most_jump[s->which[k]];
        const int is_bounded = lag_may_have_all(run, s->which[k]) && !lag_cones_have(run, s->which[k]);
        const int is_possible = !is_bounded || fabs(2 * share - 1) < MOST_FORCE;
        const double left = lag_max(MANY * change * most, is_possible ? REPEATED * jump : 0);
        const double rate = s->is_limited ? lag_shares_along(run, k) : s->rate[s->which[k]];
        if (fabs(rate) > s->noise[k] + lag_min(FAINT * jump, left))
            return 0;
    }
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
    const double left = s->left, change = find_change(run, t, q, v, a);
    s->is_fresh &= tries > 0;
    const int is_known = !s->grows || s->is_fresh; /* jumps that grow are others than a moment before */
    const int stays = is_known && tries > 0 && change > SLOW * s->latest && s->left > SLOW * left; /* both: either may come later */
    const int is_settled = change <= ENOUGH || (stays && change < FAINT);
    if (is_settled && are_kept(run, change))
        return LAG_SHARES_KEPT;
    const int is_slow = tries > 0 && change * pow(change / s->latest, s->count + 1) > ENOUGH, was_lost = tries == 0 && s->is_lost;
    s->is_lost = !was_lost && (!(change < INFINITY) || tries == MOST_TRIES);
    if (s->is_lost) {
        lag_switches_recall(run);
        return LAG_SHARES_LOST;
    }
    const double ratio = s->change[0] / s->first;
    s->latest = change;
    const int is_far = tries == 0 && change > 1; /* shares that are multiplied are not looked for where they are of nothing */
    const int is_untold = tries == 0 && lag_shares_are_untold(run); /* by accelerations: ways turn */
    if (was_lost || is_far || is_untold || is_settled || (!is_known && tries > 0) || (is_slow && !learn(s, ratio))) {
        /* the jumps that are known may be those of nowhere */
        memcpy(s->state_here, q, size);
        memcpy(s->state_here + run->model->n, v, size);
        lag_sliding_refresh(run, t, s->state_here);
        s->is_fresh = 1;
    } else {
        for (int k = 0; k < s->count; ++k)
            s->share[k] = *lag_share(run, s->which[k]);
        lag_pressed_add(run, s->count, 1, s->share);
        for (int k = 0; k < s->count; ++k)
            *lag_share(run, s->which[k]) = s->share[k];
    }
    s->first = s->change[0];
    return LAG_SHARES_CHANGED;
}

/* Of a share between 0 and 1, and of one beyond; shares of friction that presses with no force any more are infinite. */
static double margin(double share)
{
    return isinf(share) ? -0.5 : share * (1 - share) / (1 - 2 * share * (1 - share));
}

static double margin_slope(double share)
{
    const double whole = 1 - 2 * share * (1 - share);
    return (1 - 2 * share) / (whole * whole);
}

void lag_sliding_margins(const LagRun *run, int is_held, double *g)
{
    const LagSliding *s = &run->sliding;
    int jumps = 0; /* friction has come to its end before what presses it has */
    for (int k = 0; k < s->count; ++k)
        jumps |= lag_may_have_all(run, s->which[k]);
    for (int k = 0; k < s->count; ++k) {
        const double share = lag_pressed_is_pulled(run, s->count, k) ? INFINITY : *lag_share(run, s->which[k]);
        const int is_jump = lag_may_have_all(run, s->which[k]), is_beyond = !is_held && is_jump == jumps;
        g[s->which[k]] = is_beyond ? -1 : is_jump ? margin(share) : share / s->unit[k];
    }
    if (is_held && s->count > 0)
        lag_cones_margins(run, g);
}

void lag_sliding_margin_rates(LagRun *run, double t, const double *y, const double *slope, double span, double *rate)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    const double moment = MOMENT * span;
    for (int k = 0; k < s->count; ++k)
        s->share_here[k] = *lag_share(run, s->which[k]);
    for (int i = 0; i < 2 * n; ++i)
        s->state_before[i] = y[i] - moment * slope[i];
    lag_motion_slope(&run->motion, t - moment, s->state_before, s->state_before + n, s->slope_before);
    for (int k = 0; k < s->count; ++k) {
        double *share = lag_share(run, s->which[k]);
        const int is_plain = lag_may_have_all(run, s->which[k]) && !lag_cones_hold(run, s->which[k]);
        const double by_share = is_plain ? margin_slope(s->share_here[k]) : 1 / s->unit[k];
        rate[s->which[k]] = by_share * (s->share_here[k] - *share) / moment;
        *share = s->share_here[k];
    }
    lag_cones_margin_rates(run, rate);
}

/* Whether the position of what rests at a contact has drifted. */
static int has_left(const LagRun *run, int i)
{
    const int gap = i - run->model->n_whens, k = gap - lag_gap(run->model, 0);
    const int is_place = !lag_may_have_all(run, i) && run->impacts.has_contact[k] == LAG_CONTACT;
    return is_place && fabs(run->sliding.g[gap]) > lag_max(1, run->impacts.coarse) * run->sliding.error[gap];
}

int lag_sliding_lasts(LagRun *run)
{
    const LagSliding *s = &run->sliding;
    for (int k = 0; k < s->count; ++k)
        if (fabs(s->g[s->which[k]]) > lag_sliding_drift(run, s->which[k]) || has_left(run, s->which[k]))
            return 0;
    return 1;
}
