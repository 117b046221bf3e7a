/* A contact is closed where its gap is 0, but for what cannot be told, and what else its condition asks for holds. What leaves it so slowly
 * that a bounce cannot be told from none rests there: the rate of its gap slides (sliding.h), held by a force that only pushes. So does a
 * rate that may go one way, where it is at its end.
 */
#include "events/contacts.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "events/levels.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "events/impulses.h"
#include "events/contact_friction.h"
#include "model/schedule.h"
#include "state/state.h"

static const double MOMENT = 1e-3; /* s */
/* Of the time that a bounce takes at the accelerations after the impact: no first step is longer. */
static const double BOUNCE = 1.25;
static const double SLACK = 1.0 / 1024; /* of one tolerance: what stands where nothing presses comes no sooner */
/* Units of time in which what gaps change by shows above their rounding. */
static const double MANY = 32;
/* A bounce shorter than so many times what tells times apart is none. */
static const double SHORT = 256, LOW = 1.0 / 64; /* of what is unknown of positions, which is that of many steps */

/* Whether event k is a contact: no rate that may go one way. */
static int is_place(const LagRun *run, int k) { return run->impacts.has_contact[k] == LAG_CONTACT; }

double lag_contacts_margin(const LagRun *run, int i)
{
    const double own = run->impacts.coarse > 0 ? run->impacts.coarse * run->sliding.error[i] : LOW * run->switches.unknown[i];
    return own + run->impacts.by_time[i - (lag_is_event(run->model, i) ? lag_when(run->model, 0) : lag_gap(run->model, 0))];
}

/* Too slow, back too soon, or not higher than rounding. */
int lag_contacts_stay(const LagRun *run, int k, double speed, double returns)
{
    return speed <= run->sliding.error[lag_contact(run->model, k)] || 2 * speed <= SHORT * lag_time_resolution(run->motion.t) * returns
        || speed * speed <= 2 * returns * lag_contacts_margin(run, lag_gap(run->model, k));
}

double lag_contacts_lateness(const LagRun *run, int k)
{
    const LagSwitches *s = &run->switches;
    const int gap = lag_gap(run->model, k);
    const double g = s->g[gap], speed = s->g[lag_contact(run->model, k)], gained = 2 * s->rate[lag_contact(run->model, k)] * g;
    if (!(g > LOW * s->unknown[gap] && gained > 0))
        return 1;
    return gained < speed * speed ? sqrt(1 - gained / (speed * speed)) : 0;
}

int lag_contacts_are_closed(const LagRun *run, int k, const double *g, double near)
{
    const LagSwitches *s = &run->switches;
    const int i = lag_when(run->model, k), gap = lag_gap(run->model, k), slides = s->slides[lag_contact(run->model, k)];
    const int is_late = !is_place(run, k) || g[i] > run->sliding.error[i]; /* else it may be passed, where all else comes true */
    const double far = is_late ? INFINITY : lag_max(near, run->sliding.error[gap]);
    const int touches = slides || (g[gap] >= -near && g[gap] <= far), is_inside = s->held[i] > 0 || s->turned[i] == LAG_TO_1;
    return touches && !is_inside && g[i] >= 0;
}

/* Raises errors of conditions from `first` to before `end` to what they have moved by. */
static inline void note_moved(LagRun *run, const double *moved, int first, int end)
{
    const double *g = run->switches.g;
    double *error = run->sliding.error;
    for (int i = first; i < end; ++i)
        error[i] = lag_max(fabs(moved[i] - g[i]), error[i]);
}

/* How much one tolerance of positions changes conditions and gaps, and one of rates what rests, for a pattern of signs. Rates may
 * jump with positions (|x|): these are left as they are for them. */
static void note_errors(LagRun *run, int pattern)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    const LagMotion *m = &run->motion;
    double *state = run->impacts.state, *slope = s->slope + m->n;
    lag_conditions_disturb(run, m->y, s->error, pattern, state);
    if (pattern < lag_conditions_patterns(m->n)) /* else as by another one */
        lag_conditions_by(run, m->t, state, m->y + m->n, slope, s->g_inside, s->rate_inside);
    lag_conditions_by(run, m->t, m->y, state + m->n, slope, s->rate_begin, s->rate_inside);
    note_moved(run, s->g_inside, lag_when(model, 0), lag_gap(model, 0));
    for (int k = 0, gap = lag_gap(model, 0); k < model->n_whens; ++k, ++gap)
        note_moved(run, run->impacts.has_contact[k] == LAG_ONE_WAY ? s->rate_begin : s->g_inside, gap, gap + 1);
    note_moved(run, s->rate_begin, lag_contact(model, 0), model->n_switches);
}

/* By how much gaps, and conditions of events that are no contacts, cannot be told because times cannot, where supports move by
 * themselves. */
static void note_times(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    const LagMotion *m = &run->motion;
    const double later = m->t + MANY * lag_time_resolution(m->t);
    if (model->is_steady)
        return;
    lag_conditions_by(run, later, m->y, m->y + m->n, s->slope + m->n, s->g_inside, s->rate_inside);
    for (int k = 0; k < model->n_whens; ++k) {
        const int i = run->impacts.has_contact[k] ? lag_gap(model, k) : lag_when(model, k);
        run->impacts.by_time[k] = fabs(s->g_inside[i] - s->g[i]) / MANY;
    }
}

/* At the start nothing may have a size yet: the largest acceleration of each kind tells of one by what it does in a moment, but
 * where something of the kind moves already, no more than that does. */
static void foresee_errors(LagRun *run, double *error)
{
    const LagScale *scale = &run->scale;
    const int n = run->model->n;
    double *speed = run->switches.slope; /* those of the state are not asked for */
    lag_scale_find_motion(scale, run->motion.y + n);
    for (int i = 0; i < n; ++i)
        speed[i] = scale->motion[scale->kind[i]] > 0 ? scale->motion[scale->kind[i]] : INFINITY;
    lag_scale_find_motion(scale, run->switches.slope + n);
    for (int i = 0; i < n; ++i) {
        const double size = scale->tolerance * lag_min(speed[i], MOMENT * scale->motion[scale->kind[i]]);
        error[i] = lag_max(size * MOMENT, error[i]);
        error[n + i] = lag_max(size, error[n + i]);
    }
}

int lag_contacts_key(const LagModel *model)
{
    return 1 + 4 * model->n + model->n_modes + model->n_switches + model->n_resets + model->n_rests;
}

/* Whether errors were found at this state and by these units already, since conditions were entered last; notes where they are. */
static int are_known(LagRun *run)
{
    const LagModel *model = run->model;
    const LagMotion *m = &run->motion;
    LagImpacts *s = &run->impacts;
    const size_t size = 2 * (size_t)m->n, held = (size_t)lag_contacts_key(model) - 1 - 2 * size;
    double *y = s->known_at + 1, *units = y + size, *d = units + size;
    const int is_same = s->is_known && s->known_at[0] == m->t && memcmp(y, m->y, size * sizeof *y) == 0
        && memcmp(units, run->switches.error, size * sizeof *y) == 0 && memcmp(d, run->d, held * sizeof *d) == 0;
    s->known_at[0] = m->t;
    memcpy(y, m->y, size * sizeof *y);
    memcpy(units, run->switches.error, size * sizeof *y);
    memcpy(d, run->d, held * sizeof *d);
    s->is_known = model->n_delays == 0;
    return is_same;
}

int lag_contacts_find_errors(LagRun *run)
{
    const LagModel *model = run->model;
    const int first = lag_when(model, 0);
    LagSwitches *s = &run->switches;
    double *error = run->sliding.error + first;
    const size_t size = 3 * (size_t)model->n_whens * sizeof *error;
    const LagScale scale = run->scale;
    if (model->n_whens == 0 || !model->switches_need_acceleration)
        return 0;
    lag_conditions_of_events(run, s->g, s->rate);
    note_times(run);
    run->scale.rate_rounding = run->scale.step = run->scale.reach = 0; /* a rate is known as well after a step as short as can be */
    lag_conditions_units(run, run->motion.y, 1, s->error);
    run->scale = scale;
    if (!run->started)
        foresee_errors(run, s->error);
    if (are_known(run)) {
        memcpy(error, run->impacts.known, size);
        return 1;
    }
    memset(error, 0, size);
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * model->n); ++pattern)
        note_errors(run, pattern);
    memcpy(run->impacts.known, error, size);
    return 1;
}

/* Whether event k, no contact, is held as it was, whatever its condition g says: what is chosen to be held decides on it. */
static int is_kept(LagRun *run, int k, double g)
{
    return run->impacts.is_level[k] || lag_edges_keep(run, k, g) || lag_levels_meet(run, k, g);
}

int lag_contacts_is_inside(LagRun *run, int i, double g)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    const int k = i - lag_when(run->model, 0), gap = lag_gap(run->model, k);
    if (!lag_is_event(run->model, i))
        return 0;
    if (run->impacts.loaded.is_loaded[k])
        return s->held[i] > 0;
    if (!run->impacts.has_contact[k])
        return is_kept(run, k, g) ? s->held[i] > 0 : g > 0;
    const double near = run->sliding.error[gap];
    if (!(g > 0) || (run->started && !(s->held[i] > 0)))
        return 0;
    if (g > near)
        return 1;
    lag_conditions_by(run, m->t, m->y, m->y + m->n, s->slope + m->n, s->g_inside, s->rate_inside);
    return s->g_inside[gap] > near; /* what else it asks for is on its edge, and holds there: x <= 0 at 0 */
}

/* Whether event k is no contact, and would leave all that it resets as it is; or comes where a condition changes, to both sides. */
static int changes_nothing(LagRun *run, int k)
{
    const LagModel *model = run->model;
    LagImpacts *s = &run->impacts;
    int count = 0;
    lag_impulses_look(run, run->motion.y + model->n, s->rate, s->wanted);
    for (int j = 0; j < model->n_resets; ++j) {
        if (lag_event_of(model, j) != k)
            continue;
        if (model->reset_places[3 * j + 1] & LAG_CHANGE)
            return 1;
        if (lag_is_contact(model, j) == LAG_CONTACT || s->rate[j] != s->wanted[j])
            return 0;
        ++count;
    }
    return count > 0;
}

int lag_contacts_find_passed(LagRun *run)
{
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int is_passed = run->switches.held[lag_when(run->model, k)] > 0 && !run->switches.slides[lag_contact(run->model, k)];
        if (is_passed && !changes_nothing(run, k))
            return 1 + k;
    }
    return 0;
}

/* Whether the position of contact k has drifted while it slid, or it was found late. */
static int has_drifted(const LagRun *run, int k)
{
    const LagSwitches *s = &run->switches;
    const int i = lag_when(run->model, k), gap = lag_gap(run->model, k), rests = s->slides[lag_contact(run->model, k)];
    const double g = rests || (s->turned[i] == LAG_TO_0 && s->g[gap] > 0) ? s->g[gap] : 0;
    return fabs(g) > LOW * s->unknown[gap] && s->g[i] >= 0;
}

/* Where a contact has drifted, all that are closed are gathered, which it must not be pushed through: their resets into s->which.
 * Returns how many there are. */
static int find_drifted(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    int count = 0, some = 0;
    for (int j = 0, last = -1; j < model->n_resets; ++j) {
        const int k = lag_event_of(model, j);
        if (k == last || lag_is_contact(model, j) != LAG_CONTACT)
            continue;
        last = k;
        some |= has_drifted(run, k);
        if (has_drifted(run, k) || lag_contacts_are_closed(run, k, run->switches.g, run->sliding.error[lag_gap(model, k)]))
            s->which[count++] = j;
    }
    return some ? count : 0;
}

void lag_contacts_put_back(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    LagMotion *m = &run->motion;
    const int n = m->n, count = find_drifted(run);
    if (count == 0)
        return;
    lag_rubs_let_go(run);
    lag_impulses_find_ways(run, count);
    lag_switches_recall(run);
    lag_impulses_look_at_rest(run);
    s->lu.size = count;
    for (int i = 0; i < count; ++i)
        s->impulse[i] = -run->switches.g_inside[lag_gap(run->model, lag_event_of(run->model, s->which[i]))];
    for (int j = 0; j < count; ++j) {
        lag_impulses_look_along(run, j);
        for (int i = 0; i < count; ++i)
            s->lu.re[i + count * j] = lag_impulses_closing(run, i);
    }
    lag_dense_lu_factor(&s->lu);
    lag_dense_lu_solve(&s->lu, s->impulse, NULL);
    for (int k = 0; k < count; ++k)
        for (int i = 0; i < n; ++i)
            m->y[i] += s->way[i + k * n] * s->impulse[k];
}

/* The rate up to which contact k is taken for one that rests. */
static double slow_rate(const LagRun *run, int k)
{
    const int rests = lag_contact(run->model, k);
    return lag_max(lag_sliding_held(run, rests), run->sliding.error[rests]);
}

/* What rested and has been thrown up in an importer's run, where others are struck late, presses no more: its force would keep it from
 * coming back. Rates are those without it. */
static void let_go_thrown(LagRun *run)
{
    LagSwitches *s = &run->switches;
    int some = 0;
    for (int k = 0; k < run->model->n_whens && run->impacts.coarse > 0; ++k) {
        const int rests = lag_contact(run->model, k);
        if (*lag_share(run, rests) == 0 || !(-s->g_inside[rests] > slow_rate(run, k)))
            continue;
        s->held[rests] = *lag_share(run, rests) = 0;
        some = 1;
    }
    if (some)
        lag_conditions_of_events(run, s->g_inside, s->rate_inside);
}

int lag_contacts_find_rest(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    int found = 0;
    if (model->n_whens > 0)
        lag_conditions_of_events(run, s->g_inside, s->rate_inside);
    let_go_thrown(run);
    for (int k = 0; k < model->n_whens; ++k) {
        const int gap = lag_gap(model, k), rests = lag_contact(model, k), has_left = s->turned[rests] == LAG_TO_0;
        const double slow = slow_rate(run, k);
        const double leaves = -s->g_inside[rests], returns = s->rate_inside[rests];
        const int touches = run->impacts.has_contact[k] && lag_contacts_are_closed(run, k, s->g_inside, run->sliding.error[gap]);
        const int bounces = leaves > 0 && is_place(run, k) && lag_contacts_stay(run, k, leaves, returns);
        const int stands = touches && (fabs(leaves) <= slow || bounces);
        run->impacts.slack[k] = stands ? lag_max(s->unknown[gap], SLACK * run->sliding.error[gap]) : 0;
        if (stands && !has_left) {
            s->turned[rests] = LAG_CHANGES;
            found = 1;
        } else
            s->held[rests] = *lag_share(run, rests) = 0;
    }
    return found;
}

/* When a gap of `depth` is closed that grows at the speed `leaves` and is drawn back by the acceleration `returns`. */
static double closes_in(double depth, double leaves, double returns)
{
    const double square = leaves * leaves + 2 * returns * depth;
    if (square < 0 || (returns <= 0 && leaves >= 0))
        return INFINITY;
    return leaves > 0 ? (leaves + sqrt(square)) / returns : 2 * depth / (sqrt(square) - leaves);
}

void lag_contacts_foresee(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    double *seen = &run->impacts.seen;
    *seen = INFINITY;
    if (model->n_whens > 0)
        lag_conditions_of_events(run, s->g_inside, s->rate_inside);
    for (int k = 0; k < model->n_whens; ++k) {
        const int gap = lag_gap(model, k), rests = lag_contact(model, k);
        const double leaves = -s->g_inside[rests], depth = -s->g_inside[gap], near = run->sliding.error[gap];
        const int is_closed = lag_contacts_are_closed(run, k, s->g_inside, near);
        if (is_place(run, k) && !s->slides[rests] && (depth > near || (is_closed && leaves > 0)))
            *seen = lag_min(run->motion.t + BOUNCE * closes_in(is_closed ? 0 : depth, leaves, s->rate_inside[rests]), *seen);
        if (!run->started && is_place(run, k) && !s->slides[rests] && is_closed && -leaves > run->sliding.error[rests])
            run->segment_over = 1; /* what closes at the start is struck before anything moves: nothing would tell then what touches */
    }
}
