/* A step is left alone where crossing.c, which looks at it as closely, would find nothing in it: where no condition has changed at its
 * end, none goes down and up again in the cubic of its ends, and that describes each at two places inside. */
#include "methods/wide_conditions.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "events/crossing.h"
#include "model/wide_tape.h"
#include "state/state.h"

int lag_wide_conditions_serve(const LagModel *model)
{
    const int others = model->n_loaded + model->n_cones + model->n_delays + model->n_held + model->n_hiding + model->n_multipliers;
    const int is_plain = others + model->n_attitudes + model->n_inputs + model->n_islands + model->n_guards == 0 && !model->conditions_may_hide;
    return model->n_switches == 0 || (is_plain && model->switches.tape);
}

static size_t d_size(const LagModel *model)
{
    return (size_t)(model->n_modes + model->n_switches + model->n_resets + model->n_rests);
}

void lag_wide_conditions_layout(LagWideConditions *s, const LagModel *model, LagArena *arena)
{
    const size_t all = model->n_switches > 0 ? LAG_ABREAST : 0, count = (size_t)model->n_switches * all, n = (size_t)model->n * all;
    double **const vectors[] = {&s->g, &s->rate, &s->g_old, &s->rate_old, &s->g_inside, &s->rate_inside, &s->sense, &s->unknown};
    s->model = model;
    s->watched = lag_gap(model, 0);
    s->has_contact = lag_take_ints(arena, (size_t)model->n_whens);
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
        *vectors[i] = lag_take(arena, count);
    s->state = lag_take(arena, 2 * n);
    s->acceleration = lag_take(arena, n);
    s->time = lag_take(arena, all);
    s->u_slope = lag_take(arena, all);
    s->d = lag_take(arena, d_size(model) * all);
    s->c = lag_take(arena, (size_t)model->n_hoisted * all);
    s->work = lag_take(arena, model->switches.n_work * all);
}

/* -------- a motion comes */

int lag_wide_conditions_suit(const LagRun *run)
{
    const LagSwitches *s = &run->switches;
    if (run->model->n_switches == 0)
        return 1;
    if (run->statistics.steps == 0 || run->statistics.steps_by[LAG_SOLVER_IMPLICIT] > 0 || run->sliding.count > 0)
        return 0;
    if (s->is_live || s->calms || run->rests || run->segment_over || run->impacts.edges.is_in_force)
        return 0;
    for (int i = 0; i < run->model->n_switches; ++i)
        if (s->stands[i])
            return 0;
    return 1;
}

/* Of conditions at present: contacts come where their gaps have closed and all else holds. */
static void join_own_gaps(const LagRun *run, double *g, double *rate)
{
    for (int k = 0; k < run->model->n_whens; ++k) {
        const int i = lag_when(run->model, k), gap = lag_gap(run->model, k);
        if (run->impacts.has_contact[k] && g[gap] < g[i]) {
            g[i] = g[gap];
            rate[i] = rate[gap];
        }
    }
}

/* What a condition is held to be. That of an event which waits for what is held elsewhere is far from everything. */
static double sense_of(const LagRun *run, int i)
{
    const LagSwitches *s = &run->switches;
    const int is_level = lag_is_event(run->model, i) && run->impacts.is_level[i - lag_when(run->model, 0)];
    return s->is_idle[i] || is_level ? 0 : s->held[i] > 0 ? 1 : -1;
}

void lag_wide_conditions_enter(LagWideConditions *s, int lane, LagRun *run)
{
    const LagModel *model = s->model;
    LagSwitches *own = &run->switches;
    const LagMotion *m = &run->motion;
    if (model->n_switches == 0)
        return;
    memcpy(s->has_contact, run->impacts.has_contact, (size_t)model->n_whens * sizeof *s->has_contact);
    if (model->switches_need_acceleration)
        lag_motion_slope(&run->motion, m->t, m->y, m->y + m->n, own->slope);
    lag_conditions_by(run, m->t, m->y, m->y + m->n, own->slope + m->n, own->g_inside, own->rate_inside);
    join_own_gaps(run, own->g_inside, own->rate_inside);
    lag_wide_place(s->g, lane, own->g_inside, model->n_switches);
    lag_wide_place(s->rate, lane, own->rate_inside, model->n_switches);
    lag_wide_place(s->unknown, lane, own->unknown, model->n_switches);
    for (int i = 0; i < s->watched; ++i)
        s->sense[i * LAG_ABREAST + lane] = sense_of(run, i);
    s->u_slope[lane] = run->u_slope[0];
    lag_wide_place(s->d, lane, run->d, (int)d_size(model));
    lag_wide_place(s->c, lane, run->c, model->n_hoisted);
}

/* -------- of as many lanes from `lane` on as a register holds */

static void join_gaps(const LagWideConditions *s, double *g, double *rate)
{
    for (int k = 0; k < s->model->n_whens; ++k) {
        const int i = lag_when(s->model, k), gap = lag_gap(s->model, k);
        for (int lane = 0; lane < LAG_ABREAST && s->has_contact[k]; lane += LAG_WIDE) {
            const LagWide a = lag_wide_of(g, i, lane), b = lag_wide_of(g, gap, lane);
            const LagWide change = LAG_WIDE_SELECT(b < a, lag_wide_of(rate, gap, lane), lag_wide_of(rate, i, lane));
            lag_wide_write(rate + (size_t)i * LAG_ABREAST + lane, change);
            lag_wide_write(g + (size_t)i * LAG_ABREAST + lane, lag_wide_min(a, b));
        }
    }
}

static void find(const LagWideConditions *s, const double *t, const double *y, const double *a, double *g, double *rate)
{
    const double *in[] = {t, y, y + (size_t)s->model->n * LAG_ABREAST, a, NULL, s->u_slope, s->d, s->c};
    double *out[] = {g, rate};
    lag_wide_tape_run(s->model->switches.tape, in, 0, out, s->work);
    join_gaps(s, g, rate);
}

/* Whether condition i has changed, or goes down and up again. */
LAG_UNROLLED LagWide may_change(const LagWideConditions *s, int i, int lane, LagWide h)
{
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1), sense = lag_wide_of(s->sense, i, lane);
    const LagWide a = sense * lag_wide_of(s->g_old, i, lane), b = sense * lag_wide_of(s->g, i, lane);
    const LagWide ra = h * sense * lag_wide_of(s->rate_old, i, lane), rb = h * sense * lag_wide_of(s->rate, i, lane);
    const LagWide meet = (a - b + rb) / (rb - ra), lowest = a + ra * meet;
    const LagWide is_low = LAG_WIDE_SELECT(lowest < LAG_WIDE_OF(LAG_CROSSING_SHALLOW) * lag_wide_max(a, b), one, zero);
    const LagWide dips = LAG_WIDE_SELECT(ra < zero, LAG_WIDE_SELECT(rb > zero, is_low, zero), zero);
    return LAG_WIDE_SELECT(b > lag_wide_of(s->unknown, i, lane), dips, one);
}

/* Whether condition i is another one at the share x of the step than the cubic of its ends tells. */
LAG_UNROLLED LagWide is_unlike(const LagWideConditions *s, int i, int lane, LagWide h, double share)
{
    const LagWide x = LAG_WIDE_OF(share), two = LAG_WIDE_OF(2), three = LAG_WIDE_OF(3), here = lag_wide_of(s->g_inside, i, lane);
    const LagWide a = lag_wide_of(s->g_old, i, lane), b = lag_wide_of(s->g, i, lane);
    const LagWide ra = h * lag_wide_of(s->rate_old, i, lane), rb = h * lag_wide_of(s->rate, i, lane);
    const LagWide c2 = three * (b - a) - two * ra - rb, c3 = ra + rb - two * (b - a);
    const LagWide miss = LAG_WIDE_ABS(a + x * (ra + x * (c2 + x * c3)) - here);
    const LagWide size = lag_wide_max(lag_wide_max(LAG_WIDE_ABS(a), LAG_WIDE_ABS(b)), LAG_WIDE_ABS(here));
    const LagWide most = LAG_WIDE_OF(LAG_CROSSING_ROUGH) * size + lag_wide_of(s->unknown, i, lane);
    return LAG_WIDE_SELECT(miss <= most, LAG_WIDE_OF(0), LAG_WIDE_OF(1));
}

LAG_UNROLLED LagWide length_of(const LagWideTaylor *taylor, int lane)
{
    return lag_wide_read(taylor->lanes.t + lane) - lag_wide_read(taylor->lanes.t_old + lane);
}

/* Steps that were no good end where they began. */
static void keep_those_in_vain(LagWideConditions *s, const LagWideTaylor *taylor)
{
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const LagWide vain = LAG_WIDE_OF(1) - lag_wide_read(taylor->lanes.taken + lane);
        if (!lag_wide_is_some(vain))
            continue;
        lag_wide_take_over(s->g, s->g_old, s->watched, lane, vain, 0);
        lag_wide_take_over(s->rate, s->rate_old, s->watched, lane, vain, 0);
    }
}

/* Raises `suspect` where conditions are other than cubics at that share of the steps. */
static void look_inside(LagWideConditions *s, const LagWideTaylor *taylor, double share)
{
    lag_wide_taylor_inside(taylor, share, s->time, s->state);
    find(s, s->time, s->state, s->acceleration, s->g_inside, s->rate_inside);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        LagWide found = lag_wide_read(s->suspect + lane);
        for (int i = 0; i < s->watched; ++i) {
            const LagWide sense = lag_wide_of(s->sense, i, lane), unlike = is_unlike(s, i, lane, length_of(taylor, lane), share);
            found = lag_wide_max(LAG_WIDE_ABS(sense) * unlike, found);
        }
        lag_wide_write(s->suspect + lane, found);
    }
}

void lag_wide_conditions_look(LagWideConditions *s, const LagWideTaylor *taylor)
{
    const int n = s->model->n;
    lag_swap(&s->g, &s->g_old);
    lag_swap(&s->rate, &s->rate_old);
    for (int i = 0; i < n; ++i)
        memcpy(s->acceleration + (size_t)i * LAG_ABREAST, taylor->series.line + (size_t)s->model->jet_places[i] * LAG_ABREAST,
               LAG_ABREAST * sizeof *s->acceleration);
    find(s, taylor->lanes.t, taylor->lanes.y, s->acceleration, s->g, s->rate);
    keep_those_in_vain(s, taylor);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        LagWide found = LAG_WIDE_OF(0);
        for (int i = 0; i < s->watched; ++i) {
            const LagWide sense = lag_wide_of(s->sense, i, lane);
            found = lag_wide_max(LAG_WIDE_ABS(sense) * may_change(s, i, lane, length_of(taylor, lane)), found);
        }
        lag_wide_write(s->suspect + lane, found);
    }
    look_inside(s, taylor, LAG_CROSSING_EARLY);
    look_inside(s, taylor, LAG_CROSSING_LATE);
}
