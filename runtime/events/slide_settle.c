/* Which of those that may slide do (slide_states.c), which hold more than they rub, and what those do that have no force yet: by what they
 * do a moment later.
 */
#include "events/sliding.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events/candidates.h"
#include "events/cones.h"
#include "numbers/extremes.h"
#include "events/jumps.h"
#include "events/pressed.h"
#include "events/slide_states.h"
#include "events/contact_friction.h"
#include "state/state.h"

enum { LOOKS = 16 };
/* What of dg/dt is rounding, by its terms: in the choice, and while they slide. */
static const double ROUNDING = LAG_STATES_ROUNDING, NOISE = DBL_EPSILON;
static const double UNIT = 32; /* of rounding, that counts as an error of one unit: rounding.c */
static const double MOMENT = 1e-3; /* of a step; of a second where no step tells of one */
static const double FAINT = 1e-6;  /* of the jump a moment later, or of the largest so far */
static const double TIE = 1e-9; /* of the own jump */
static const double ASTRAY = 1000; /* a share: nothing presses at a stage of a step */
static const double LARGE = 16; /* times the force of the usual size: forces hold each other, and it is theirs */

/* Contacts first: where friction and a contact hold the same rate, friction is what may not know its share. What nothing presses is none. */
static int gather(LagRun *run, const int *candidates)
{
    LagSliding *s = &run->sliding;
    int count = 0;
    for (int contacts = 1; contacts >= 0; --contacts)
        for (int i = 0; i < run->model->n_switches && count < s->most; ++i)
            if (candidates[i] == 1 && lag_may_have_all(run, i) == !contacts && !lag_rubs_nowhere(run->model, i, candidates))
                s->which[count++] = i;
    return count;
}

/* -------- what holds more than it rubs */

/* Whether candidate k stays at 0: it slides, or what slides holds it. */
static int is_held(const LagSliding *s, int count, int k)
{
    int is_acted_on = 0;
    for (int j = 0; j < count; ++j)
        is_acted_on |= s->state[j] == LAG_SLIDES && s->jump[k + j * count] != 0;
    return s->state[k] == LAG_SLIDES || (is_acted_on && fabs(lag_candidates_rate(s, count, k, 1)) <= ROUNDING * lag_candidates_size(s, count, k));
}

/* Whether there is enough of what holds candidate j, where that is in the plane. */
static int may_hold(const LagRun *run, int j) { return run->sliding.is_lenient || !lag_cones_break(run, run->sliding.which[j]); }

/* All candidates may hold. */
static void begin_rests(LagRun *run, int count)
{
    for (int k = 0; k < run->model->n_rests; ++k)
        *lag_rest(run, k) = lag_candidates_place(&run->sliding, count, run->model->rests[k]) >= 0;
}

/* Which of them hold: those that do not have less force, which may set others in motion, or else hold after all. */
static int choose_rests(LagRun *run, double t, const double *y, int count, int is_right)
{
    const LagSliding *s = &run->sliding;
    int changes = run->model->n_rests > 0;
    for (int turn = 0; changes && is_right; ++turn) {
        changes = 0;
        lag_candidates_balance(run, count);
        for (int k = 0; k < run->model->n_rests; ++k) {
            const int j = lag_candidates_place(&run->sliding, count, run->model->rests[k]), may_act = j >= 0 && s->state[j] == LAG_GIVEN && s->jump[j + j * count] == 0;
            const int holds = j >= 0 && (may_act || (is_held(s, count, j) && may_hold(run, j)));
            if (*lag_rest(run, k) == holds || (holds && turn > count)) /* in the end what has let go stays so */
                continue;
            *lag_rest(run, k) = holds;
            changes = 1;
        }
        if (changes) {
            lag_jumps_find(run, t, y, count, LAG_PRESENT);
            is_right = lag_states_choose_any(run, t, y, count);
        }
    }
    return is_right;
}

/* Those that nothing holds move. */
static void end_rests(LagRun *run, int count)
{
    for (int k = 0; k < run->model->n_rests; ++k) {
        const int j = lag_candidates_place(&run->sliding, count, run->model->rests[k]);
        *lag_rest(run, k) *= j >= 0 && is_held(&run->sliding, count, j);
    }
}

/* What the switches hold, and those that slide to the front of `which`. Returns how many do. */
static int hold(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    int sliding = 0;
    end_rests(run, count);
    for (int k = 0; k < count; ++k) {
        const int i = s->which[k];
        run->switches.held[i] = *lag_share(run, i);
        run->switches.slides[i] = s->state[k] == LAG_SLIDES;
        s->is_tied[i] = s->is_light[k] && !lag_states_goes(s, count, k) && (s->state[k] == LAG_LOW || s->state[k] == LAG_HIGH);
        run->switches.is_idle[i] = s->state[k] == LAG_GIVEN && s->jump[k + k * count] == 0 && lag_rubs_alone(run->model, i)
            && !(lag_rubs_on_what_rests(run, i) && lag_states_goes(s, count, k)); /* which may press it soon */
        if (s->state[k] == LAG_SLIDES && s->limit[k] == INFINITY && s->share[k] > LARGE * s->unit[k])
            s->unit[k] = s->share[k];
    }
    for (int k = 0; k < count; ++k)
        s->noise[k] = NOISE * lag_candidates_size(s, count, k);
    for (int k = 0; k < count; ++k)
        if (s->state[k] == LAG_SLIDES) {
            s->noise[sliding] = s->noise[k];
            s->unit[sliding] = s->unit[k];
            memmove(s->way + sliding * n, s->way + k * n, (size_t)n * sizeof *s->way);
            s->which[sliding++] = s->which[k];
        }
    return sliding;
}

/* What is held together shares its rounding: a light one between heavy ones shakes what lies on it. Of the rates of what slides, into what is
 * noise of accelerations; no more than the largest of those of its kind. */
static void spread_noise(LagRun *run, int sliding)
{
    LagSliding *s = &run->sliding;
    LagScale *scale = &run->scale;
    const int n = run->model->n;
    double *most = scale->motion;
    memset(most, 0, (size_t)scale->kinds * sizeof *most);
    for (int i = 0; i < n; ++i)
        most[scale->kind[i]] = lag_max(scale->onset[i], most[scale->kind[i]]);
    for (int k = 0; k < sliding; ++k)
        s->change[k] = UNIT * s->noise[k];
    lag_shares_solve(run, s->change);
    for (int i = 0; i < n; ++i) {
        double a = 0;
        for (int k = 0; k < sliding; ++k)
            a += fabs(s->way[i + k * n] * s->change[k]);
        scale->onset[i] = lag_max(lag_min(a, most[scale->kind[i]]), scale->onset[i]);
        scale->noise[i] = lag_max(scale->onset[i], scale->noise[i]);
    }
}

/* -------- what holds with no force yet */

/* What the present state does not tell: what friction that has no force, or a contact at which nothing presses, does where it need not
 * do anything; and whether friction that has all its force, which is just enough, holds. */
enum { TOLD, NOTHING_ACTS, JUST_HOLDS };

/* That of candidate k; `size`: of the change of its rate by a share. */
static int find_openness(const LagSliding *s, int count, int k, int is_jump, double size)
{
    const double jump = is_jump ? fabs(s->jump[k + k * count]) : 0, rate = fabs(s->rate[s->which[k]]);
    const int is_at_end = s->state[k] == LAG_HIGH || (is_jump && s->state[k] == LAG_LOW), slides = s->state[k] == LAG_SLIDES;
    if (is_at_end)
        return rate <= TIE * jump && !s->is_light[k] ? JUST_HOLDS : TOLD;
    return (is_jump || !slides) && jump + rate <= FAINT * size ? NOTHING_ACTS : TOLD;
}

/* Whether there may be such, where nothing was known of it before, or where it has been much more: into `open`. */
static int find_open(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    const int touches = !lag_may_have_all(run, s->which[0]); /* contacts come first */
    int some = 0;
    for (int k = 0; k < count; ++k) {
        const int i = s->which[k], is_jump = lag_may_have_all(run, i), may_press = touches || !lag_rubs_alone(run->model, i);
        const double size = is_jump && s->is_new[k] ? INFINITY : s->most_jump[i];
        const int other = lag_candidates_place(s, count, s->partner[i]);
        const int acts_aside = other >= 0 && fabs(s->jump[other + other * count]) > fabs(s->jump[k + k * count]);
        s->open[k] = may_press && !acts_aside ? find_openness(s, count, k, is_jump, size) : TOLD;
        some |= s->open[k] != TOLD;
    }
    return some;
}

/* The state a moment later, into state_before. Returns the moment. */
static double look_ahead(LagRun *run, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    const int n = run->model->n;
    const double step = run->step > 0 ? MOMENT * run->step : MOMENT * MOMENT;
    const double moment = lag_min(step, MOMENT * (run->segment_end - t));
    lag_sliding_rates(run, t, y);
    for (int i = 0; i < n; ++i) {
        const double a = run->switches.slope[n + i];
        s->state_before[i] = y[i] + moment * (y[n + i] + moment * a / 2);
        s->state_before[n + i] = y[n + i] + moment * a;
    }
    return moment;
}

/* Forces of the time to come, with the present state, tell what of accelerations and energies will be rounding. */
static void note_sizes_to_come(LagRun *run, double t, const double *y, int count)
{
    const double end = lag_min(run->segment_end, run->settings.t_stop), whole = isfinite(end) ? end - t : lag_max(1, fabs(t));
    for (int look = 1; look <= LOOKS; ++look)
        lag_jumps_find(run, t + look * (whole / (LOOKS + 1)), y, count, LAG_PRESENT);
}

static void remember(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k) {
        const int is_jump = lag_may_have_all(run, s->which[k]);
        s->known[k] = s->state[k];
        s->known_share[k] = *lag_share(run, s->which[k]);
        s->known_rate[k] = fabs(s->rate[s->which[k]]) + (is_jump ? fabs(s->jump[k + k * count]) : 0);
    }
    for (int k = 0; k < run->model->n_rests; ++k)
        s->known_rest[k] = *lag_rest(run, k);
}

/* What is open, and is torn off as soon as it has force, does not hold from now on: the others do, or not, as they do at present. */
static void take_over_rests(LagRun *run, int count)
{
    const LagSliding *s = &run->sliding;
    for (int k = 0; k < run->model->n_rests; ++k) {
        const int j = lag_candidates_place(s, count, run->model->rests[k]);
        if (j < 0 || s->open[j] != NOTHING_ACTS || *lag_rest(run, k) != 0)
            *lag_rest(run, k) = s->known_rest[k];
    }
}

/* Of the choice a moment later, what was open at the present state, and has more force by then. Returns whether something has force
 * that had none. */
static int take_over(LagRun *run, int count, int is_right)
{
    LagSliding *s = &run->sliding;
    int some = 0;
    for (int k = 0; k < count; ++k) {
        const int i = s->which[k], is_jump = lag_may_have_all(run, i);
        const double size = fabs(s->jump[k + k * count]) * (is_jump ? 1 : s->share[k]);
        const int acts = is_right && s->state[k] != LAG_GIVEN && s->known_rate[k] <= FAINT * size && size > 0;
        const int holds = is_right && s->state[k] == LAG_SLIDES && s->open[k] == JUST_HOLDS;
        s->open[k] = s->open[k] == NOTHING_ACTS && acts ? NOTHING_ACTS : TOLD;
        if (s->open[k] == NOTHING_ACTS) {
            s->share[k] = is_jump ? s->share[k] : 0;
            s->most_jump[i] = lag_max(size, s->most_jump[i]);
            some = 1;
        } else {
            s->state[k] = holds ? LAG_SLIDES : s->known[k];
            s->share[k] = s->known_share[k];
        }
    }
    return some;
}

/* Friction whose limit grows from nothing, with a load that does: the share that it begins with is that of a moment later, and so is the
 * side to which it does not hold; and where a contact begins to press, it holds from now on. The choice at the present state is known,
 * and stays for all others. */
static void choose_open(LagRun *run, double t, const double *y, int count)
{
    LagSliding *s = &run->sliding;
    remember(run, count);
    const double moment = look_ahead(run, t, y);
    lag_jumps_begin(run, count);
    lag_jumps_find(run, t + moment, s->state_before, count, LAG_ELSEWHERE);
    int is_right = lag_states_choose(run, t + moment, s->state_before, count);
    if (run->model->n_cones > 0) { /* on lines, what turns round is known by its state alone */
        is_right = choose_rests(run, t + moment, s->state_before, count, is_right);
        take_over_rests(run, count);
    }
    s->grows |= take_over(run, count, is_right);
    lag_candidates_set(run, count);
    if (s->grows)
        note_sizes_to_come(run, t, y, count);
    lag_jumps_find(run, t, y, count, LAG_ELSEWHERE);
    for (int k = 0; k < count; ++k)
        if (s->open[k] == NOTHING_ACTS && lag_may_have_all(run, s->which[k]))
            s->jump[k + k * count] = -LAG_VANISHED * s->most_jump[s->which[k]];
    lag_candidates_solve(run, count);
    lag_candidates_set(run, count);
}

void lag_sliding_settle(LagRun *run, double t, const double *y, const int *candidates)
{
    LagSliding *s = &run->sliding;
    const int count = gather(run, candidates);
    s->count = 0; /* accelerations as the shares say */
    s->energy = 0;
    if (count > 0) {
        begin_rests(run, count);
        lag_jumps_begin(run, count);
        lag_jumps_find(run, t, y, count, LAG_FIRST);
    }
    const double energy = s->energy;
    lag_sliding_end(run);
    s->jams = 0;
    for (int i = 0; i < run->model->n_switches; ++i)
        run->switches.is_idle[i] = candidates[i] == 1 && lag_rubs_nowhere(run->model, i, candidates);
    if (count == 0)
        return;
    s->energy = energy;
    s->lu.dependent = LAG_SLIDING_DEPENDENT;
    begin_rests(run, count);
    const int is_right = choose_rests(run, t, y, count, lag_states_choose_any(run, t, y, count));
    s->jams = !is_right && run->model->n_rubs > 0 && !run->switches.is_live;
    if (is_right && find_open(run, count))
        choose_open(run, t, y, count);
    const int sliding = hold(run, count);
    if (is_right)
        spread_noise(run, sliding);
    s->grows &= sliding > 0;
    if (is_right)
        s->count = sliding;
    else /* step control makes the best of it */
        lag_sliding_end(run);
}

void lag_sliding_grow(LagRun *run)
{
    const LagMotion *m = &run->motion;
    const int count = run->sliding.count;
    if (!run->sliding.grows || count == 0)
        return;
    run->sliding.count = 0; /* accelerations as the shares say */
    lag_jumps_find(run, m->t, m->y, count, LAG_PRESENT);
    run->sliding.count = count;
}

/* Shares of friction that went astray begin anew at an end, and what presses with a force of its size: since friction is linear in both,
 * Newton's second iteration is exact then. */
static void call_back(const LagRun *run, int count)
{
    const LagSliding *s = &run->sliding;
    int some = 0;
    for (int k = 0; k < count; ++k)
        some |= lag_may_have_all(run, s->which[k]) && !(fabs(*lag_share(run, s->which[k])) < ASTRAY);
    for (int k = 0; k < count && some; ++k) {
        double *share = lag_share(run, s->which[k]);
        *share = lag_may_have_all(run, s->which[k]) ? lag_max(0, lag_min(1, *share)) : lag_max(s->unit[k], *share);
    }
}

void lag_sliding_refresh(LagRun *run, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    const int count = s->count;
    s->count = 0; /* accelerations as the shares say */
    call_back(run, count);
    lag_jumps_find(run, t, y, count, LAG_ELSEWHERE);
    for (int k = 0; k < count; ++k)
        s->state[k] = LAG_SLIDES;
    lag_candidates_solve(run, count);
    for (int k = 0; k < count; ++k) {
        s->change[k] = s->share[k] - s->base[k];
        s->share[k] = s->base[k];
    }
    lag_pressed_add(run, count, 1, s->share);
    for (int k = 0; k < count; ++k)
        *lag_share(run, s->which[k]) = s->share[k];
    s->count = count;
}
