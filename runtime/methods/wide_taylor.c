#include "methods/wide_taylor.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "methods/taylor.h"
#include "methods/taylor_attitudes.h"
#include "methods/wide_attitudes.h"
#include "methods/wide_orders.h"
#include "methods/wide_starts.h"
#include "model/function.h"
#include "numbers/extremes.h"
#include "numbers/wide_jets.h"
#include "state/account.h"
#include "state/ends.h"
#include "state/state.h"

enum { MOST_SLOTS = 1200 }; /* that stay near the processor */
static const double FAINT = 1e-16; /* what the last two terms of short steps may be in any case, relative to the state */

int lag_wide_taylor_serves(const LagModel *model)
{
    const int happens = model->n_looks + model->n_cones + model->n_delays;
    return happens + model->n_multipliers + model->n_islands == 0 && model->jet_code && model->jet_pitch == 1
        && !model->is_long_state && !model->series_may_hide && model->n_jet_slots <= MOST_SLOTS;
}

static void layout(void *self, const LagRun *like, LagArena *arena)
{
    LagWideTaylor *s = self;
    const LagModel *model = like->model;
    lag_wide_steps_layout(&s->lanes, like, arena);
    lag_wide_series_layout(&s->series, model, arena);
    s->weight = lag_take(arena, 2 * (size_t)model->n * LAG_ABREAST);
    s->next_weight = lag_take(arena, 2 * (size_t)model->n * LAG_ABREAST);
    s->slope = lag_take(arena, (size_t)model->n_inputs * LAG_ABREAST);
    s->first_u = lag_take(arena, (size_t)model->n_inputs * LAG_ABREAST); /* whole lines of the cache */
    s->first_slope = lag_take(arena, (size_t)model->n_inputs * LAG_ABREAST);
    s->rate = LAG_TAYLOR_REST / (like->settings.t_stop - like->settings.t_start);
}

/* The quaternions at states y, among what the line knows. */
static void place_turned(LagWideTaylor *s, const double *y)
{
    lag_wide_attitudes_present(&s->lanes, y, s->series.line + (size_t)lag_wide_quaternion(s->lanes.model, 0) * LAG_ABREAST);
}

/* Order and lengths are those of series alone. */
static void plan(LagWideTaylor *s, const LagRun *like)
{
    const LagTaylor *one = &like->methods.taylor;
    const size_t n_jets = (size_t)s->lanes.model->n_jets;
    for (size_t slot = 0; slot < n_jets && one->order < s->order; ++slot) /* zeros stand behind the last coefficients */
        memset(lag_wide_jet(s, (int)slot) + (one->order + 1) * LAG_ABREAST, 0,
               (size_t)(LAG_JET_STRIDE - 1 - one->order) * LAG_ABREAST * sizeof(double));
    s->order = one->order;
    s->last = log2(one->last);
    s->before_last = log2(one->before_last);
    s->faint = FAINT / like->scale.tolerance;
}

/* -------- motions come and go */

/* They follow from modes and parameters: each lane has runs of its own, and those of the same parameters have the same. */
static void place_numbers(LagWideTaylor *s, int lane, LagRun *run)
{
    LagTaylor *own = &run->methods.taylor;
    const int are_known = s->lanes.model->n_modes + s->lanes.model->n_switches == 0 && s->numbers_of[lane] == run->parameters_version;
    if (are_known)
        return;
    s->numbers_of[lane] = run->parameters_version;
    const double *in[] = {run->d, run->c};
    lag_call(&s->lanes.model->series, in, (double *[]){own->numbers}, own->work);
    lag_wide_place(s->series.numbers, lane, own->numbers, s->lanes.model->series.out_size[0]);
}

static double energy_weight(const LagRun *run)
{
    const double unit = lag_account_unit(run);
    return unit > 0 ? 1 / unit : 0;
}

static void enter(void *self, int lane, LagRun *run)
{
    LagWideTaylor *s = self;
    const int n_inputs = s->lanes.model->n_inputs;
    s->lanes.stop[lane] = lag_min(run->segment_end, run->settings.t_stop);
    s->lanes.is_fresh |= s->lanes.model->n_modes > 0;
    s->entered[lane] = 1;
    if (s->lanes.model->n_modes > 0) { /* what jumps may have set it in motion */
        lag_wide_scale_load(&s->lanes.scale, lane, &run->scale);
        lag_wide_place(s->lanes.y, lane, run->motion.y, s->lanes.size);
        lag_wide_place(s->lanes.carry, lane, run->motion.carry, s->lanes.size);
        lag_wide_place(s->series.line + LAG_ABREAST, lane, run->motion.y, 2 * s->lanes.n);
        place_numbers(s, lane, run);
        lag_wide_attitudes_load(&s->lanes, lane, run);
    }
    if (n_inputs == 0)
        return;
    lag_inputs_slope(&run->inputs, run->u);
    s->lanes.is_fresh = 1;
    lag_wide_place(s->slope, lane, run->u, n_inputs);
    lag_inputs_at(&run->inputs, s->lanes.t[lane], run->u);
    lag_wide_place(s->series.line + lag_wide_input(s) * LAG_ABREAST, lane, run->u, n_inputs);
}

static int load(void *self, int lane, LagRun *run)
{
    LagWideTaylor *s = self;
    const LagMotion *m = &run->motion;
    const LagTaylor *own = &run->methods.taylor;
    const int is_series = run->methods.solver == LAG_SOLVER_TAYLOR && run->stiffness.passes == 0 && !run->rests;
    const int goes_on = own->begun == 1 && !own->is_fresh && !run->scale.is_resting && m->t > m->t_old;
    if (run->carried_energy > 0 && !goes_on) /* their powers are looked at alone */
        return 0;
    if (!is_series || !(goes_on || (own->is_fresh && own->begun == 0 && !run->segment_over)))
        return 0;
    plan(s, run);
    lag_wide_steps_load(&s->lanes, lane, run);
    s->series.line[lane] = m->t;
    lag_wide_place(s->series.line + LAG_ABREAST, lane, m->y, 2 * s->lanes.n);
    place_numbers(s, lane, run);
    s->limit[lane] = s->wrong[lane] = INFINITY;
    s->lanes.energy[lane] = energy_weight(run);
    s->own[lane] = 0;
    enter(s, lane, run);
    s->begins[lane] = 0;
    if (run->statistics.steps == 0) {
        s->begins[lane] = goes_on ? 0 : LAG_BEGINS;
        lag_wide_starts_learn(s, lane);
    }
    return 1;
}

/* The jets of quaternions, and the same in fours. */
static void show_turned(const LagWideTaylor *s, int lane, double *jets)
{
    const LagModel *model = s->lanes.model;
    const int made = (int)s->own[lane] + 1;
    for (int i = 0; i < 4 * model->n_attitudes; ++i) {
        const int slot = lag_wide_quaternion(model, 0) + i;
        double *c = jets + (size_t)slot * LAG_JET_STRIDE;
        double *fours = jets + (size_t)(model->n_jets + i / 4 * 4) * LAG_JET_STRIDE + i % 4;
        lag_wide_take(lag_wide_jet(s, slot), lane, c, made);
        for (int k = 0; k <= s->order; ++k)
            fours[4 * k] = c[k] = k < made ? c[k] : 0;
    }
}

static void show(void *self, int lane, LagRun *run, LagShown shown)
{
    LagWideTaylor *s = self;
    LagMotion *m = &run->motion;
    LagTaylor *own = &run->methods.taylor;
    lag_wide_steps_show(&s->lanes, lane, run, shown);
    run->step = s->lanes.length[lane];
    s->lanes.energy[lane] = energy_weight(run);
    if (shown < LAG_SHOWN_DENSE)
        return;
    own->begun = own->old_top = 0;
    for (int i = 0; i < s->lanes.size; ++i) {
        const int slot = i < 2 * s->lanes.n ? 1 + i : s->lanes.model->jet_places[s->lanes.n + i - 2 * s->lanes.n];
        double *c = own->old_jets + (size_t)slot * LAG_JET_STRIDE;
        const int made = (int)s->own[lane] + (i < 2 * s->lanes.n);
        lag_wide_take(lag_wide_jet(s, slot), lane, c, made);
        for (int k = made; k <= s->order; ++k)
            c[k] = 0;
        c[0] = i < 2 * s->lanes.n ? m->other[i] : c[0];
    }
    show_turned(s, lane, own->old_jets);
}

/* -------- steps, of as many lanes from `lane` on as a register holds */

/* What the last steps have made becomes the beginning of the series, where they were good. */
static void begin_series(LagWideTaylor *s, int lane)
{
    const LagModel *model = s->lanes.model;
    const int n = model->n, n_jets = model->n_jets;
    const LagWide zero = LAG_WIDE_OF(0), good = lag_wide_read(s->lanes.taken + lane);
    const int are_all = !lag_wide_is_some(good - LAG_WIDE_OF(1));
    double *const jets = s->series.jets + lane;
    for (int slot = 0; slot < n_jets; ++slot) {
        double *c = jets + (size_t)slot * LAG_WIDE_JET;
        const LagWide made = lag_wide_of(s->series.line, slot, lane);
        lag_wide_write(c, are_all ? made : LAG_WIDE_SELECT(good > zero, made, lag_wide_read(c)));
    }
    for (int i = 0; i < n; ++i) {
        double *q = lag_wide_jet(s, 1 + i) + LAG_ABREAST + lane, *v = lag_wide_jet(s, 1 + n + i) + LAG_ABREAST + lane;
        lag_wide_write(q, lag_wide_read(lag_wide_jet(s, 1 + n + i) + lane));
        lag_wide_write(v, lag_wide_read(lag_wide_jet(s, model->jet_places[i]) + lane));
    }
    for (int i = 0; i < model->n_inputs; ++i)
        lag_wide_write(lag_wide_jet(s, lag_wide_input(s) + i) + LAG_ABREAST + lane, lag_wide_of(s->slope, i, lane));
    lag_wide_write(lag_wide_jet(s, 0) + LAG_ABREAST + lane, LAG_WIDE_OF(1));
}

/* A coefficient, and 0 where lanes have an order of their own, of which it is none. */
#define MADE(c, k) (is_own ? LAG_WIDE_SELECT(LAG_WIDE_OF((double)((k) + 1)) <= own, LAG_WIDE_TERM(c, k), zero) : LAG_WIDE_TERM(c, k))

/* Steps of all orders take `top` coefficients beyond the first: the same for some orders, so that no loop has an end that processors guess
 * wrong, as zeros stand behind (plan). 0: lanes have orders of their own. */
enum { OWN = 0, LOW = 9, MIDDLE = 13, HIGH = LAG_JET_ORDER - 1 };

/* c_0 + c_1 h + ... + c_order h^order, in two chains: whatever zeros stand behind. */
LAG_UNROLLED LagWide series(const double *c, int order, LagWide h, LagWide square, LagWide own, int top)
{
    const LagWide zero = LAG_WIDE_OF(0);
    const int is_own = top == OWN;
    LagWide even = zero, odd = zero;
    int k = order;
    LAG_UNROLL_ALL
    for (int m = top; m > 0; m -= 2) {
        odd = LAG_WIDE_FUSED(odd, square, LAG_WIDE_TERM(c, m));
        even = LAG_WIDE_FUSED(even, square, LAG_WIDE_TERM(c, m - 1));
    }
    if (is_own && order % 2 == 0) {
        even = MADE(c, k);
        --k;
    }
    for (; is_own && k > 0; k -= 2) {
        odd = LAG_WIDE_FUSED(odd, square, MADE(c, k));
        even = LAG_WIDE_FUSED(even, square, MADE(c, k - 1));
    }
    return LAG_WIDE_FUSED(odd, h, even);
}

/* The integral of a series from 0 to h, over h. */
LAG_UNROLLED LagWide mean(const double *c, int order, LagWide h, LagWide own, int is_own)
{
    const LagWide zero = LAG_WIDE_OF(0);
    LagWide sum = zero;
    for (int k = order; k >= 0; --k)
        sum = LAG_WIDE_FUSED(sum, h, MADE(c, k) * LAG_WIDE_OF(lag_inverse[k]));
    return sum;
}

void lag_wide_taylor_inside(const LagWideTaylor *s, double share, double *t, double *y)
{
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const LagWide begin = lag_wide_read(s->lanes.t_old + lane), own = lag_wide_read(s->own + lane);
        const LagWide h = LAG_WIDE_OF(share) * (lag_wide_read(s->lanes.t + lane) - begin), square = h * h;
        lag_wide_write(t + lane, begin + h);
        for (int i = 0; i < 2 * s->lanes.n; ++i) {
            const double *c = lag_wide_jet(s, 1 + i) + lane;
            const LagWide way = series(c + LAG_ABREAST, s->made_to - 1, h, square, own, OWN);
            lag_wide_write(y + (size_t)i * LAG_ABREAST + lane, lag_wide_read(c) + way * h);
        }
    }
}

static const double GROW = LAG_TAYLOR_GROW, WRONG = LAG_TAYLOR_WRONG, SHRINK = LAG_TAYLOR_SHRINK, REMAINS = LAG_TAYLOR_REMAINS,
                    NOISE = LAG_TAYLOR_NOISE, MOST_TURN = LAG_TAYLOR_MOST_TURN;

/* Where the steps end. */
LAG_UNROLLED LagWide next_time(const LagWideTaylor *s, int lane)
{
    const LagWide t = lag_wide_read(s->lanes.t + lane), before = lag_wide_max(lag_wide_read(s->lanes.length + lane), lag_wide_smallest(t));
    const LagWide all = LAG_WIDE_OF((double)s->order);
    if (s->made_to < s->order)
        return lag_wide_read(s->lanes.stop + lane);
    const LagWide most = lag_wide_min(LAG_WIDE_OF(GROW) * before, LAG_WIDE_OF(s->lanes.longest));
    const LagWide wish = lag_wide_min(lag_wide_read(s->reach + lane), lag_wide_min(most, lag_wide_read(s->limit + lane)));
    const LagWide stop = lag_wide_read(s->lanes.stop + lane), end = lag_wide_end_of(&s->lanes, lane, t, wish);
    return LAG_WIDE_SELECT(lag_wide_read(s->own + lane) < all, stop, end);
}

/* What the step turns attitudes by. */
LAG_UNROLLED void turn(LagWideTaylor *s, int lane, LagWide h, LagWide square, LagWide own, int top)
{
    const LagModel *model = s->lanes.model;
    for (int i = 0; i < model->n_attitudes; ++i) {
        const double *q = lag_wide_jet(s, lag_wide_quaternion(model, i));
        const size_t place = (size_t)lag_attitude_place(model->attitudes, i) * LAG_ABREAST;
        double x[4 * LAG_ABREAST] = {0}, by[3 * LAG_ABREAST] = {0};
        for (int m = 0; m < 4; ++m) {
            const double *c = q + m * LAG_WIDE_JET + LAG_ABREAST + lane;
            lag_wide_write(x + m * LAG_ABREAST, h * series(c, s->made_to - 1, h, square, own, top));
        }
        for (int k = 0; k < LAG_WIDE; ++k) {
            double from[4], change[4], turned[3];
            for (int m = 0; m < 4; ++m)
                from[m] = q[m * LAG_WIDE_JET + lane + k];
            lag_wide_take(x, k, change, 4);
            lag_taylor_turned_by(from, change, turned);
            lag_wide_place(by, k, turned, 3);
        }
        for (int m = 0; m < 3; ++m)
            lag_wide_add(&s->lanes, place + (size_t)m * LAG_ABREAST + (size_t)lane, lag_wide_read(by + m * LAG_ABREAST));
    }
}

LAG_UNROLLED void go(LagWideTaylor *s, int lane, int top)
{
    const int n = s->lanes.n, p = s->made_to, u = lag_wide_input(s);
    const LagWide own = lag_wide_read(s->own + lane), t_new = next_time(s, lane), h = t_new - lag_wide_read(s->lanes.t + lane);
    const LagWide square = h * h;
    for (int i = 0; i < s->lanes.size; ++i) {
        if (lag_taylor_is_turned(s->lanes.model, i))
            continue;
        const size_t place = (size_t)i * LAG_ABREAST + (size_t)lane;
        const double *c = (i < 2 * n ? lag_wide_jet(s, 1 + i) : lag_wide_power_jet(s, i - 2 * n)) + lane;
        const LagWide way = i < 2 * n ? series(c + LAG_ABREAST, p - 1, h, square, own, top) : mean(c, p - 1, h, own, top == OWN);
        const LagWide sum = lag_wide_add(&s->lanes, place, way * h);
        if (i < 2 * n)
            lag_wide_write(s->series.line + LAG_ABREAST + place, sum);
    }
    turn(s, lane, h, square, own, top);
    for (int i = 0; i < s->lanes.model->n_inputs; ++i)
        lag_wide_write(s->series.line + (size_t)(u + i) * LAG_ABREAST + (size_t)lane,
                       lag_wide_read(lag_wide_jet(s, u + i) + lane) + lag_wide_of(s->slope, i, lane) * h);
    lag_wide_write(s->series.line + lane, t_new);
    lag_wide_write(s->lanes.next + lane, t_new);
}

/* As in taylor.c: what counts for nothing of acceleration i. */
LAG_UNROLLED LagWide rounding_of(const LagWideTaylor *s, int lane, int i)
{
    const LagModel *model = s->lanes.model;
    LagWide size = LAG_WIDE_OF(0);
    for (int k = 0; k < model->n; ++k)
        if (model->coordinate_kind[k] == model->coordinate_kind[i])
            size = lag_wide_max(LAG_WIDE_ABS(lag_wide_of(s->series.line, model->jet_places[k], lane)), size);
    return LAG_WIDE_OF(LAG_TAYLOR_ROUNDING) * size;
}

/* How far the accelerations at the end of the step are from the slope of the series there, in units of rates, which are
 * worth `share` of an error each; `is_rounded`: what is rounding counts for nothing where it would be too many. */
LAG_UNROLLED LagWide gap_of(const LagWideTaylor *s, int lane, LagWide h, LagWide share, LagWide own, int top, int is_rounded)
{
    const LagWide zero = LAG_WIDE_OF(0), square = h * h;
    LagWide largest = zero;
    for (int i = 0; i < s->lanes.n; ++i) {
        const int place = s->lanes.model->jet_places[i];
        const LagWide slope = series(lag_wide_jet(s, place) + lane, s->made_to - 1, h, square, own, top);
        const LagWide miss = LAG_WIDE_ABS(lag_wide_of(s->series.line, place, lane) - slope);
        LagWide gap = miss * lag_wide_of(s->next_weight, s->lanes.n + i, lane);
        if (is_rounded) {
            const LagWide counted = LAG_WIDE_SELECT(miss <= rounding_of(s, lane, i), zero, gap);
            gap = LAG_WIDE_SELECT(gap * share <= LAG_WIDE_OF(WRONG), gap, counted);
        }
        largest = LAG_WIDE_SELECT(gap <= largest, largest, gap); /* a NaN stays */
    }
    return largest;
}

static LagWide gap_beyond_rounding(const LagWideTaylor *s, int lane, LagWide h, LagWide share, LagWide own)
{
    return gap_of(s, lane, h, share, own, OWN, 1);
}

LAG_UNROLLED LagWide gap(const LagWideTaylor *s, int lane, LagWide h, LagWide share, LagWide own, int top)
{
    const LagWide found = gap_of(s, lane, h, share, own, top, 0);
    const LagWide is_much = LAG_WIDE_SELECT(found * share <= LAG_WIDE_OF(WRONG), LAG_WIDE_OF(0), LAG_WIDE_OF(1));
    return lag_wide_is_some(is_much) ? gap_beyond_rounding(s, lane, h, share, own) : found;
}

/* The largest angular velocity of attitudes, squared, at states y. */
LAG_UNROLLED LagWide fastest(const LagWideTaylor *s, const double *y, int lane)
{
    LagWide found = LAG_WIDE_OF(0);
    for (int i = 0; i < s->lanes.model->n_attitudes; ++i) {
        const int place = s->lanes.n + lag_attitude_place(s->lanes.model->attitudes, i);
        const LagWide a = lag_wide_of(y, place, lane), b = lag_wide_of(y, place + 1, lane), c = lag_wide_of(y, place + 2, lane);
        found = lag_wide_max(a * a + b * b + c * c, found);
    }
    return found;
}

/* Attitudes are told against the present, and no step turns them further than they tell. */
static void begin_turns(LagWideTaylor *s)
{
    double square[LAG_ABREAST];
    if (s->lanes.model->n_attitudes == 0)
        return;
    lag_wide_attitudes_move(&s->lanes);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        lag_wide_write(square + lane, fastest(s, s->lanes.y, lane));
    for (int lane = 0; lane < LAG_ABREAST; ++lane)
        s->limit[lane] = lag_min(s->limit[lane], MOST_TURN / sqrt(square[lane]));
}

LAG_UNROLLED void judge(LagWideTaylor *s, int lane, int top)
{
    const LagWide own = lag_wide_read(s->own + lane);
    const LagWide part = top == OWN ? LAG_WIDE_OF(1) / (own + LAG_WIDE_OF(1)) : LAG_WIDE_OF(1.0 / (s->order + 1));
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1), infinite = LAG_WIDE_OF((double)INFINITY);
    const LagWide t = lag_wide_read(s->lanes.t + lane), h = lag_wide_read(s->lanes.next + lane) - t;
    lag_wide_weigh(s, lane, s->lanes.made, h, s->next_weight);
    const LagWide before = lag_wide_read(s->wrong + lane), wrong = gap(s, lane, h, h * part, own, top) * h * part;
    const LagWide is_faint = LAG_WIDE_SELECT(wrong * LAG_WIDE_OF(s->lanes.scale.tolerance) < LAG_WIDE_OF(NOISE), one, zero);
    const LagWide is_noise = LAG_WIDE_SELECT(wrong > LAG_WIDE_OF(REMAINS) * before, is_faint, zero);
    const LagWide is_near = LAG_WIDE_SELECT(wrong <= LAG_WIDE_OF(WRONG), one, is_noise);
    const LagWide is_long = LAG_WIDE_SELECT(h >= lag_wide_smallest(t), one, zero);
    const LagWide turn = fastest(s, s->lanes.made, lane) * h * h;
    const LagWide is_told = LAG_WIDE_SELECT(turn > LAG_WIDE_OF(MOST_TURN * MOST_TURN), zero, one);
    const LagWide good = is_near * is_told * is_long * lag_wide_read(s->lanes.moves + lane);
    lag_wide_write(s->lanes.missed + lane, lag_wide_read(s->lanes.missed + lane) + LAG_WIDE_SELECT(wrong > one, good, zero));
    lag_wide_write(s->wrong + lane, LAG_WIDE_SELECT(good > zero, infinite, wrong));
    lag_wide_write(s->limit + lane, LAG_WIDE_SELECT(good > zero, infinite, LAG_WIDE_OF(SHRINK) * h));
    const int are_all = lag_wide_accept(&s->lanes, lane, good, h);
    lag_wide_take_over(s->weight, s->next_weight, 2 * s->lanes.n, lane, good, are_all);
}

/* How many coefficients its steps take, if none has an order of its own. */
static int top_of(const LagWideTaylor *s)
{
    if (s->is_cut && lag_wide_orders_differ(s))
        return OWN;
    return s->order <= LOW + 1 ? LOW : s->order <= MIDDLE + 1 ? MIDDLE : HIGH;
}

#define EACH_TOP(what)                                              \
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)        \
        switch (top) {                                              \
        case LOW: what(s, lane, LOW); break;                        \
        case MIDDLE: what(s, lane, MIDDLE); break;                  \
        case HIGH: what(s, lane, HIGH); break;                      \
        default: what(s, lane, OWN);                                \
        }

static void go_all(LagWideTaylor *s, int top) { EACH_TOP(go) }

static void judge_all(LagWideTaylor *s, int top) { EACH_TOP(judge) }

void lag_wide_taylor_begin(LagWideTaylor *s)
{
    if (s->lanes.is_fresh) {
        place_turned(s, s->lanes.y);
        lag_wide_series_begin(&s->series);
    }
    s->lanes.is_fresh = 0;
}

static void step(void *self)
{
    LagWideTaylor *s = self;
    lag_wide_taylor_begin(s);
    begin_turns(s);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        begin_series(s, lane);
    lag_wide_series_turn(&s->series, 0);
    lag_wide_orders_expand(s);
    const int top = top_of(s);
    go_all(s, top);
    place_turned(s, s->lanes.made);
    lag_wide_series_begin(&s->series);
    judge_all(s, top);
}

const LagWideMethod lag_wide_taylor = {LAG_SOLVER_TAYLOR, layout, load, lag_wide_starts_place, lag_wide_starts_settle, enter, show, step, 0};
