/* One impact brings about the next (Newton's cradle), until nothing approaches (E.J. Routh, Dynamics of a system of rigid bodies, I
 * (1905), ch. VIII). Those at once are struck together. Other events come when a reset makes their conditions true, too.
 */
#include "events/impacts.h"

#include <math.h>
#include <string.h>

#include "events/approaches.h"
#include "events/conditions.h"
#include "events/contacts.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "events/impulses.h"
#include "events/contact_friction.h"
#include "events/walls.h"
#include "events/sampling.h"
#include "model/schedule.h"
#include "state/state.h"

/* Events that bring each other about so many times, or come again without time passing, do not end. */
enum { MOST_ROUNDS = 100000, MOST_AT_ONCE = 100000 };

/* Of impulses, or of what holds. */
static int largest_problem(const LagModel *model)
{
    const int impulses = model->n_resets + model->n_rubs, held = lag_sliding_most(model);
    return impulses > held ? impulses : held;
}

void lag_impacts_layout(LagImpacts *s, const LagModel *model, int size, LagArena *arena)
{
    const size_t resets = (size_t)model->n_resets, rubs = (size_t)model->n_rubs, whole = model->n_whens > 0 ? (size_t)size : 0;
    s->fires = lag_take_ints(arena, (size_t)model->n_whens);
    s->is_plastic = lag_take_ints(arena, (size_t)model->n_whens);
    s->has_contact = lag_take_ints(arena, (size_t)model->n_whens);
    s->is_on = lag_take_ints(arena, (size_t)model->n_whens);
    s->comes = lag_take_ints(arena, (size_t)model->n_whens);
    s->at_once = lag_take_ints(arena, (size_t)model->n_whens);
    s->is_level = lag_take_ints(arena, (size_t)model->n_whens);
    lag_held_ways_layout(&s->ways, model, arena);
    lag_edges_layout(&s->edges, model, arena);
    lag_loaded_layout(&s->loaded, model, size, arena);
    s->before = lag_take(arena, (size_t)model->n_whens);
    s->gap_before = lag_take(arena, (size_t)model->n_whens);
    s->carried = lag_take(arena, (size_t)model->n_whens);
    s->met = lag_take(arena, (size_t)model->n_whens);
    s->came = lag_take(arena, (size_t)model->n_whens);
    s->rounding = lag_take(arena, model->n_whens > 0 ? 2 * (size_t)model->n : 0);
    s->by_time = lag_take(arena, (size_t)model->n_whens);
    s->slack = lag_take(arena, (size_t)model->n_whens);
    s->known_at = lag_take(arena, model->n_whens > 0 ? (size_t)lag_contacts_key(model) : 0);
    s->known = lag_take(arena, 3 * (size_t)model->n_whens);
    s->which = lag_take_ints(arena, resets);
    s->rate = lag_take(arena, resets);
    s->wanted = lag_take(arena, resets);
    s->chosen = lag_take(arena, resets);
    s->rate_after = lag_take(arena, resets);
    s->way = lag_take(arena, (resets + rubs) * (size_t)model->n);
    s->place = lag_take_ints(arena, rubs);
    s->slip = lag_take(arena, rubs);
    s->sense = lag_take(arena, resets);
    lag_complementarity_layout(&s->problem, largest_problem(model), arena);
    s->impulse = lag_take(arena, resets);
    s->after = lag_take(arena, model->n_whens > 0 ? (size_t)model->n : 0);
    s->state = lag_take(arena, whole);
    s->slope = lag_take(arena, whole);
    s->slope_without = lag_take(arena, whole);
    lag_dense_lu_layout(&s->lu, model->n_resets, 0, arena);
}

void lag_impacts_reset(LagRun *run)
{
    for (int j = 0; j < run->model->n_resets; ++j)
        run->impacts.has_contact[lag_event_of(run->model, j)] = 0;
    for (int j = 0; j < run->model->n_resets; ++j)
        run->impacts.has_contact[lag_event_of(run->model, j)] |= lag_is_contact(run->model, j);
    memset(run->impacts.carried, 0, (size_t)run->model->n_whens * sizeof *run->impacts.carried);
    run->impacts.edges.is_in_force = run->impacts.edges.is_placed = 0;
    memset(run->impacts.is_level, 0, (size_t)run->model->n_whens * sizeof *run->impacts.is_level);
    lag_loaded_reset(run);
    run->impacts.coarse = 0;
    run->impacts.is_known = 0;
    run->impacts.in_a_row = 0;
    run->impacts.seen = INFINITY;
    run->impacts.struck = NAN;
}

/* Of event k by the latest conditions inside: positive where it is true. */
static double truth(const LagRun *run, int k)
{
    const double *g = run->switches.g_inside;
    const double all = g[lag_when(run->model, k)];
    return run->impacts.has_contact[k] ? fmin(all, g[lag_gap(run->model, k)]) : all;
}

static void look_at_events(LagRun *run, double t, const double *y)
{
    LagSwitches *s = &run->switches;
    lag_conditions_at(run, t, y, s->slope + run->model->n, s->g_inside, s->rate_inside);
}

void lag_impacts_await_jump(LagRun *run, double t, const double *y)
{
    if (run->model->n_whens == 0)
        return;
    look_at_events(run, t, y);
    for (int k = 0; k < run->model->n_whens; ++k) {
        run->impacts.before[k] = truth(run, k);
        run->impacts.gap_before[k] = run->switches.g_inside[lag_gap(run->model, k)];
    }
}

void lag_impacts_hold_as_before(LagRun *run)
{
    for (int k = 0; k < run->model->n_whens; ++k)
        run->switches.held[lag_when(run->model, k)] = run->impacts.before[k] > 0 && !run->impacts.loaded.is_loaded[k];
}

/* What a condition has been last, also by events of the same moment. */
static int holds(const LagSwitches *s, int i) { return s->turned[i] == LAG_TO_1 || (s->turned[i] != LAG_TO_0 && s->held[i] > 0); }

int lag_impacts_note_jump(LagRun *run, double t, const double *y)
{
    int some = 0;
    if (run->model->n_whens == 0)
        return 0;
    look_at_events(run, t, y);
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int i = lag_when(run->model, k), gap = lag_gap(run->model, k), is_after = truth(run, k) > 0;
        const double depth = run->switches.g_inside[gap];
        if (run->impacts.loaded.is_loaded[k])
            continue;
        const int is_moved = lag_walls_have_moved(run, k, depth), is_new = is_moved && depth > run->sliding.error[gap];
        const int is_carried = !is_moved && run->switches.slides[lag_contact(run->model, k)];
        some |= is_moved;
        if (!is_carried && (is_new || run->impacts.before[k] <= 0) && is_after && !holds(&run->switches, i)) {
            run->switches.turned[i] = run->impacts.carried[k] > 0 && !is_moved ? LAG_CHANGES : LAG_JUMPS;
            some = 1;
        } else if (run->switches.turned[i] == LAG_TO_1 && !run->impacts.has_contact[k] && !is_after)
            run->switches.turned[i] = LAG_TO_0;
    }
    return some;
}

/* What rates become. */
static void read_wanted(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    lag_impulses_look(run, run->motion.y + model->n, s->rate, s->wanted);
    for (int j = 0; j < model->n_resets; ++j) {
        const int k = lag_event_of(model, j);
        if (!lag_is_contact(model, j) || !s->fires[k] || lag_approaches_passed(run, k))
            continue;
        s->is_plastic[k] |= s->wanted[j] == 0 || s->has_contact[k] == LAG_ONE_WAY;
        if (s->has_contact[k] == LAG_ONE_WAY)
            continue;
        const double approach = run->switches.g[lag_contact(model, k)];
        if (approach > run->sliding.error[lag_contact(model, k)] && s->wanted[j] * s->rate[j] > 1e-6 * s->rate[j] * s->rate[j])
            s->onward = 1 + k;
        s->wanted[j] *= lag_contacts_lateness(run, k);
        const double speed = fabs(approach * s->wanted[j] / s->rate[j]);
        if (lag_contacts_stay(run, k, speed, run->switches.rate[lag_contact(model, k)]))
            s->wanted[j] = 0;
    }
}

/* Whether a condition is true; where it is neither, whether it is about to be. */
static int is_true(const LagSwitches *s, int i) { return fabs(s->g[i]) > s->unknown[i] ? s->g[i] > 0 : s->rate[i] > 0; }

/* Whether an event that is no contact compares a rate with what resets may set it to. */
static int has_levels(const LagRun *run)
{
    for (int k = 0; k < run->model->n_whens; ++k)
        if (!run->impacts.has_contact[k] && run->model->on_level[k] >= 0)
            return 1;
    return 0;
}

/* How far conditions may be off after resets, by rounding of the rates that these have changed. */
static void find_met(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagMotion *m = &run->motion;
    double *met = run->impacts.met, *state = run->impacts.state;
    memset(met, 0, (size_t)run->model->n_whens * sizeof *met);
    if (!has_levels(run))
        return;
    for (int pattern = 0; pattern < lag_conditions_patterns(2 * m->n); ++pattern) {
        lag_conditions_disturb(run, m->y, run->impacts.rounding, pattern, state);
        lag_conditions_at(run, m->t, state, s->slope + m->n, s->g_inside, s->rate_inside);
        for (int k = 0; k < run->model->n_whens; ++k)
            met[k] = lag_max(fabs(s->g_inside[lag_when(run->model, k)] - s->g[lag_when(run->model, k)]), met[k]);
    }
}

/* Whether resets have set the rates of event k to what its condition compares them with, but for rounding. */
static int is_on_level(const LagRun *run, int k)
{
    return run->model->on_level[k] >= 0 && fabs(run->switches.g[lag_when(run->model, k)]) < run->impacts.met[k];
}

/* Whether resets have made the condition of event k another one. */
static int has_jumped(const LagRun *run, int k)
{
    const LagSwitches *s = &run->switches;
    const int i = lag_when(run->model, k);
    return fabs(s->g[i] - run->impacts.before[k]) > s->unknown[i];
}

/* Whether a condition is true after resets: on its level as it says of that; else by its sign where these have changed it; else
 * where it has been true at this instant, in which places stay; else where it comes true by itself, or is about to. Forces are not known
 * before all is chosen that holds. */
static int has_become_true(const LagRun *run, int k)
{
    const LagSwitches *s = &run->switches;
    const int i = lag_when(run->model, k), was_true = run->impacts.comes[k] || run->impacts.is_on[k];
    if (run->impacts.loaded.is_loaded[k])
        return was_true;
    if (is_on_level(run, k))
        return run->model->on_level[k] & 1;
    if (has_jumped(run, k))
        return s->g[i] > 0;
    if (was_true || run->impacts.is_level[k])
        return was_true;
    return (fabs(s->g[i]) > s->unknown[i] || s->rate[i] != 0) && is_true(s, i);
}

/* At an instant: conditions that have come true by themselves. Contacts that are passed already, where the rest of the condition comes
 * true, are so from then on: a place where both come true is closed. */
static void begin(LagRun *run, int is_seen)
{
    LagImpacts *s = &run->impacts;
    LagSwitches *switches = &run->switches;
    const LagModel *model = run->model;
    memset(s->is_plastic, 0, (size_t)model->n_whens * sizeof *s->is_plastic);
    if (!is_seen)
        lag_conditions_of_events(run, switches->g, switches->rate);
    for (int k = 0; k < model->n_whens; ++k) {
        lag_walls_let_go(run, k);
        const int i = lag_when(model, k), turned = switches->turned[i];
        s->comes[k] = turned == LAG_JUMPS || (turned == LAG_CHANGES && switches->held[i] == 0);
        s->is_on[k] = !s->comes[k] && holds(switches, i);
        s->before[k] = switches->g[i];
        s->gap_before[k] = switches->g[lag_gap(model, k)];
        if (s->has_contact[k] && s->comes[k]) {
            const double passed = switches->g[lag_gap(model, k)], near = run->sliding.error[lag_gap(model, k)];
            switches->turned[i] = passed > near && (turned == LAG_JUMPS || switches->g[i] < passed) ? LAG_TO_1 : LAG_TO_0;
        }
    }
}

/* Whether event k is of a branch behind that of event `first`, of one `when`. */
static int is_behind(const LagModel *model, int k, int first)
{
    return lag_chain_of(model, first) == lag_chain_of(model, k) && lag_branch_of(model, first) < lag_branch_of(model, k);
}

/* Contact k as resets have made it. Where its condition has come true while its place was passed already, by discrete variables, which
 * gates and walls have, nothing holds it there; nor at a wall that has gone. Where all but its gap has become false, the event is over,
 * and may come again. */
static void note_change(LagRun *run, int k)
{
    LagSwitches *s = &run->switches;
    const LagImpacts *before = &run->impacts;
    const int i = lag_when(run->model, k), gap = lag_gap(run->model, k), is_true = s->g[i] > 0;
    const double near = run->sliding.error[gap];
    const int is_moved = lag_walls_have_moved(run, k, s->g[gap]), was_passed = before->before[k] > 0 && before->gap_before[k] > near;
    if (is_true && s->g[gap] > near && !was_passed && (is_moved || before->before[k] <= 0)) {
        s->turned[i] = LAG_TO_1;
        run->impacts.comes[k] = 1;
    } else if (s->turned[i] == LAG_TO_1 && ((!is_true && has_jumped(run, k)) || (is_moved && s->g[gap] <= 0)))
        s->turned[i] = LAG_TO_0;
    if (is_moved && s->g[gap] < -near && s->turned[i] != LAG_TO_1) /* gone before it was struck */
        run->impacts.comes[k] = 0;
}

/* Of a `when` with elsewhen, the first branch that comes is the one; contacts are struck nevertheless. */
static void leave_to_first(LagRun *run)
{
    int *fires = run->impacts.fires;
    for (int k = 0; k < run->model->n_whens; ++k)
        for (int first = 0; fires[k] && first < run->model->n_whens; ++first)
            if (fires[first] && is_behind(run->model, k, first))
                fires[k] = run->impacts.has_contact[k];
}

/* Events of a rank whose conditions have come true, and contacts that are closed and approach; `is_new`: nothing has been reset or
 * sampled at this instant since these were looked at; `is_seen`: it was, and they are those of now. Returns whether some come. */
static int find_events(LagRun *run, int rank, int is_new, int is_seen)
{
    LagImpacts *s = &run->impacts;
    LagSwitches *switches = &run->switches;
    const LagModel *model = run->model;
    int found = 0;
    if (!is_new && !is_seen)
        lag_conditions_of_events(run, switches->g, switches->rate);
    if (!is_new)
        find_met(run);
    for (int k = 0; k < model->n_whens; ++k) {
        const int i = lag_when(model, k);
        s->fires[k] = 0;
        if (lag_rank_of(model, k) != rank)
            continue;
        if (s->has_contact[k] == LAG_CONTACT && !is_new)
            note_change(run, k);
        if (s->has_contact[k]) {
            s->comes[k] = s->comes[k] && !(has_jumped(run, k) && switches->g[i] <= 0);
            found |= lag_approaches_find(run, k);
        } else {
            const int is_now = is_new ? s->comes[k] || s->is_on[k] : has_become_true(run, k);
            s->fires[k] = is_now && !s->is_on[k];
            s->is_on[k] = is_now;
            found |= s->fires[k];
            s->comes[k] = 0;
        }
        s->before[k] = switches->g[i];
        s->gap_before[k] = switches->g[lag_gap(model, k)];
    }
    lag_approaches_let_wait(run, rank);
    if (model->order)
        leave_to_first(run);
    return found;
}

/* What events of a rank set: where one comes, discrete variables have it from the next rank on, rates with those of all ranks. */
static void keep_wanted(LagRun *run, int comes)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    read_wanted(run);
    for (int k = 0; k < model->n_whens; ++k) /* also those that end the run alone */
        s->at_once[k] |= s->fires[k];
    for (int j = 0; j < model->n_resets; ++j) {
        const int place = lag_own_place(model, j);
        if (!s->fires[lag_event_of(model, j)])
            continue;
        s->chosen[j] = s->wanted[j];
        for (int i = 0; comes && i < model->n_kept; ++i)
            if (model->kept[i] == place) {
                s->has_changed |= run->motion.y[model->n + place] != s->wanted[j];
                run->motion.y[model->n + place] = s->wanted[j];
            }
    }
}

static void note_time(LagRun *run)
{
    for (int k = 0; k < run->model->n_whens; ++k)
        if (run->impacts.fires[k] && !run->impacts.has_contact[k])
            run->impacts.came[k] = run->motion.t;
}

/* All that comes at once, rank by rank: each event reads what those of lower ranks set, and what is held of its own (held values of
 * rank 0 were taken before). Returns whether there is some. */
static int find_round(LagRun *run, int is_new, int is_seen)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    int last = lag_sampling_last_rank(model), some = 0, is_changed = !is_new;
    for (int k = 0; k < model->n_whens; ++k)
        last = lag_rank_of(model, k) > last ? lag_rank_of(model, k) : last;
    s->has_changed = 0;
    memset(s->at_once, 0, (size_t)model->n_whens * sizeof *s->at_once);
    for (int rank = 0; rank <= last; ++rank) {
        is_changed |= is_new && rank > 0 && lag_sampling_take(run, run->motion.t, run->motion.y, rank);
        const int comes = find_events(run, rank, !is_changed, is_seen && rank == 0);
        some |= comes;
        is_changed |= comes;
        if (last > 0)
            keep_wanted(run, comes);
    }
    if (last > 0 && some) {
        memcpy(s->fires, s->at_once, (size_t)model->n_whens * sizeof *s->fires);
        lag_impulses_look(run, run->motion.y + model->n, s->rate, s->wanted);
        for (int j = 0; j < model->n_resets; ++j)
            if (s->fires[lag_event_of(model, j)])
                s->wanted[j] = s->chosen[j];
    } else if (some)
        read_wanted(run);
    note_time(run);
    return some;
}

/* Where closed contacts still approach, slower than can be told, all that move so slowly stop together. Returns 0 where nothing stops
 * them. */
static int calm(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const LagSwitches *switches = &run->switches;
    int some = 0;
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int rests = lag_contact(run->model, k), closed = s->has_contact[k] && lag_approaches_touch(run, k);
        s->fires[k] = closed && fabs(switches->g[rests]) <= run->sliding.error[rests];
        some |= s->fires[k] && switches->g[rests] > 0;
    }
    if (!some)
        return 1;
    read_wanted(run);
    return lag_impulses_reset(run, 0);
}

/* What conditions of events that are no contacts have become: on its level, rounding would tell otherwise; and what goes back from where
 * it came true is true no more. */
static void note_events(LagRun *run)
{
    LagSwitches *s = &run->switches;
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int i = lag_when(run->model, k), is_level = is_on_level(run, k) || run->impacts.is_level[k];
        const int goes_back = !is_level && s->g[i] <= s->unknown[i] && s->rate[i] < 0 && !run->impacts.loaded.is_loaded[k];
        const int is_on = run->impacts.is_on[k] && !goes_back;
        if (!run->impacts.has_contact[k] && (s->turned[i] || is_on != (s->held[i] > 0) || is_on_level(run, k)))
            s->turned[i] = is_on ? LAG_TO_1 : LAG_TO_0;
    }
}

int lag_impacts_striking(const LagRun *run)
{
    for (int k = 0; k < run->model->n_whens; ++k)
        if (run->impacts.fires[k])
            return 1 + k;
    return 0;
}

/* Whether nothing of what is reset now comes from the motion. */
static int are_known(const LagRun *run)
{
    for (int j = 0; j < run->model->n_resets; ++j)
        if (run->impacts.fires[lag_event_of(run->model, j)] && !lag_is_known(run->model, j))
            return 0;
    return 1;
}

LagStatus lag_impacts_strike(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const int sliding = run->sliding.count;
    int rounds = 0, still = 0, is_found = 1, is_known = 1, latest = 0, is_seen;
    if (run->model->n_whens == 0)
        return LAG_OK;
    run->sliding.count = 0; /* accelerations as the shares say: forces that hold give no impulses but by events of their own */
    is_seen = lag_contacts_find_errors(run);
    s->onward = 0;
    memset(s->rounding, 0, 2 * (size_t)run->model->n * sizeof *s->rounding);
    begin(run, is_seen);
    int fire = find_round(run, 1, 0);
    if (fire)
        lag_sliding_note_impact(run, run->switches.g);
    for (; fire && is_found && still <= run->model->n_whens && rounds < MOST_ROUNDS; ++rounds) {
        latest = lag_impacts_striking(run);
        is_known = is_known && are_known(run);
        is_found = lag_impulses_reset(run, 0);
        still = s->has_changed ? 0 : still + 1; /* what changes nothing comes by rounding, and would for ever */
        is_seen = (rounds & (rounds + 1)) == 0 && lag_contacts_find_errors(run); /* what was at rest has a speed now */
        fire = find_round(run, 0, is_seen);
    }
    if (rounds > 0) {
        s->struck = is_known ? run->motion.t : NAN;
        is_found = is_found && calm(run);
        note_events(run);
        run->switches.resolved = run->switches.unlooked = 0; /* conditions are as quick as the motion is now */
    }
    lag_contacts_put_back(run);
    memset(s->carried, 0, (size_t)run->model->n_whens * sizeof *s->carried);
    run->sliding.count = sliding;
    const int stands = run->motion.t - run->motion.t_old <= lag_time_resolution(run->motion.t);
    s->in_a_row = stands ? s->in_a_row + 1 : 0;
    if (s->onward || !is_found)
        return lag_fail(run, LAG_NO_IMPULSE, -1, s->onward > 0, s->onward ? s->onward : lag_impacts_striking(run));
    if (rounds < MOST_ROUNDS && s->in_a_row < MOST_AT_ONCE)
        return LAG_OK;
    return lag_fail(run, LAG_EVENTS_GO_ON, -1, 0, lag_impacts_striking(run) ? lag_impacts_striking(run) : latest);
}

int lag_impacts_press(LagRun *run)
{
    LagImpacts *s = &run->impacts;
    const LagModel *model = run->model;
    for (int k = 0; k < model->n_whens; ++k)
        s->fires[k] = s->has_contact[k] && run->switches.turned[lag_contact(model, k)] == LAG_CHANGES;
    if (!lag_rubs_act(run))
        return 0;
    run->sliding.count = 0; /* accelerations as the shares say */
    lag_conditions_of_events(run, run->switches.g, run->switches.rate);
    lag_sliding_note_impact(run, run->switches.g);
    lag_impulses_look(run, run->motion.y + model->n, s->rate, s->wanted);
    for (int j = 0; j < model->n_resets; ++j)
        s->wanted[j] = lag_is_contact(model, j) ? 0 : s->rate[j];
    return lag_impulses_reset(run, 1);
}
