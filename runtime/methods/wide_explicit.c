#include "methods/wide_explicit.h"

#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "methods/wide_attitudes.h"
#include "model/attitude_places.h"
#include "model/function.h"
#include "model/wide_tape.h"
#include "numbers/extremes.h"
#include "numbers/wide_power.h"
#include "state/account.h"
#include "state/ends.h"
#include "state/evaluate.h"
#include "state/project.h"
#include "state/state.h"

/* As in adaptive.c. */
static const double SAFETY = 0.8, SHRINK = 1.0 / 3, FIRST_GROW = 6, GROW = 3, NOT_FINITE_SHRINK = 0.25, CUT = 0.9;
static const double SMALLEST_ERROR = 1e-20; /* squared */
static const double LEAVES = 1e9; /* steps in vain of a motion that is left to others */
static const double TRIES = 2; /* of a step of loops: singular positions ask for more than shorter ones (attempts.c) */

int lag_wide_explicit_serves(const LagModel *model)
{
    const int other_modes = model->n_modes - 4 * model->n_attitudes; /* than references */
    const int happens = model->n_looks + model->n_switches + model->n_resets + model->n_cones + model->n_delays + other_modes;
    const int turns_in_loops = model->n_multipliers > 0 && model->n_attitudes > 0;
    return happens + model->n_islands + turns_in_loops == 0 && (model->wide_each || lag_usual_rhs(model)->tape) && model->n > 0;
}

static void layout(LagWideExplicit *s, const LagTableau *tableau, int order, const LagRun *like, LagArena *arena)
{
    const LagModel *model = like->model;
    const LagFunction *rhs = lag_usual_rhs(model);
    const size_t size = (size_t)like->motion.size * LAG_ABREAST, inputs = (size_t)model->n_inputs * LAG_ABREAST;
    const size_t rest = rhs->n_out > 2 && rhs->out_size[2] > 1 ? (size_t)rhs->out_size[2] : 1;
    lag_wide_steps_layout(&s->lanes, like, arena);
    s->tableau = tableau;
    s->order = order;
    for (int i = 0; i <= tableau->stages; ++i)
        s->k[i] = lag_take(arena, size);
    s->point = lag_take(arena, (size_t)model->n * LAG_ABREAST);
    s->time = lag_take(arena, LAG_ABREAST);
    s->u = lag_take(arena, inputs);
    s->u_first = lag_take(arena, inputs);
    s->u_slope = lag_take(arena, inputs);
    s->c = lag_take(arena, (size_t)model->n_hoisted * LAG_ABREAST);
    s->lost = lag_take(arena, 2 * (size_t)model->n_power * LAG_ABREAST);
    s->rest = lag_take(arena, rest * LAG_ABREAST);
    s->work = lag_take(arena, rhs->tape ? rhs->n_work * LAG_ABREAST : 0);
}

static void layout_verner9(void *self, const LagRun *like, LagArena *arena)
{
    layout(self, &lag_verner9_tableau, lag_verner9.order, like, arena);
}

static void layout_dop853(void *self, const LagRun *like, LagArena *arena)
{
    layout(self, &lag_dop853_tableau, lag_dop853.order, like, arena);
}

static void layout_tsit5(void *self, const LagRun *like, LagArena *arena)
{
    layout(self, &lag_tsit5_tableau, lag_tsit5.order, like, arena);
}

/* -------- motions come and go */

static void enter(void *self, int lane, LagRun *run)
{
    LagWideExplicit *s = self;
    const int n_inputs = s->lanes.model->n_inputs;
    s->lanes.stop[lane] = lag_min(run->segment_end, run->settings.t_stop);
    s->entered[lane] = s->lanes.t[lane];
    if (n_inputs == 0)
        return;
    s->is_new[lane] = 1;
    s->lanes.is_fresh = 1;
    lag_inputs_slope(&run->inputs, run->u);
    lag_wide_place(s->u_slope, lane, run->u, n_inputs);
    lag_inputs_at(&run->inputs, s->lanes.t[lane], run->u);
    lag_wide_place(s->u_first, lane, run->u, n_inputs);
}

static double energy_weight(const LagRun *run)
{
    return run->motion.energy > 0 ? 1 / (run->scale.tolerance * run->motion.energy) : 0;
}

static int load(void *self, int lane, LagRun *run)
{
    LagWideExplicit *s = self;
    const LagMotion *m = &run->motion;
    const int is_at_rest = run->scale.is_resting || run->rests || m->strength > 0 || !(m->t > m->t_old);
    if (run->methods.solver != s->lanes.solver || is_at_rest || run->stiffness.passes + run->doubtful > 0)
        return 0;
    lag_wide_steps_load(&s->lanes, lane, run);
    s->run[lane] = run;
    s->step[lane] = run->step;
    s->grows[lane] = run->is_starting ? FIRST_GROW : GROW;
    s->lanes.energy[lane] = energy_weight(run);
    const double *slope = run->methods.table->slope(run->methods.self);
    lag_wide_place(s->k[0], lane, slope, s->lanes.size);
    lag_wide_place(s->k[s->tableau->stages], lane, slope, s->lanes.size);
    for (int i = 0; i < s->lanes.model->n_power; ++i)
        s->lost[(s->lanes.model->n_power + i) * LAG_ABREAST + lane] = 0;
    lag_wide_place(s->c, lane, run->c, s->lanes.model->n_hoisted);
    enter(s, lane, run);
    s->is_new[lane] = 1;
    return 1;
}

static void show(void *self, int lane, LagRun *run, LagShown shown)
{
    LagWideExplicit *s = self;
    LagExplicit *own = run->methods.self;
    lag_wide_steps_show(&s->lanes, lane, run, shown);
    run->step = s->step[lane];
    s->lanes.energy[lane] = energy_weight(run);
    for (int i = 0; i < s->lanes.model->n_power; ++i) {
        double *lost = &s->lost[(s->lanes.model->n_power + i) * LAG_ABREAST + lane];
        run->motion.doubt += *lost;
        *lost = 0;
    }
    if (shown < LAG_SHOWN_DENSE)
        return;
    for (int i = 0; i <= s->tableau->stages; ++i)
        lag_wide_take(s->k[i], lane, own->k[i], s->lanes.size);
    own->first_slope_is_last = 1;
    own->dense_ready = own->has_other_stages = 0;
    run->motion.lacks_slopes = 0;
}

/* -------- slopes */

/* The slope at the points and times, whose rates stand where the slopes of positions belong. */
static void evaluate(LagWideExplicit *s, double *k)
{
    const LagModel *model = s->lanes.model;
    const LagFunction *rhs = lag_usual_rhs(model);
    const size_t n = (size_t)model->n;
    const LagWideCode wide = model->wide_each;
    const double *in[] = {s->time, s->point, k, s->u, s->lanes.reference, s->c};
    double *out[] = {k + n * LAG_ABREAST, k + 2 * n * LAG_ABREAST, s->rest};
    for (int i = 0; i < model->n_inputs; ++i)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
            const LagWide since = lag_wide_read(s->time + lane) - lag_wide_read(s->entered + lane);
            lag_wide_write(s->u + (size_t)i * LAG_ABREAST + lane,
                           LAG_WIDE_FUSED(lag_wide_of(s->u_slope, i, lane), since, lag_wide_of(s->u_first, i, lane)));
        }
    if (wide)
        wide(in, out);
    else
        lag_wide_tape_run(rhs->tape, in, 0, out, s->work);
    lag_wide_attitudes_turn_slope(model, s->point, k);
    if (wide || lag_present(&model->regular))
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
            lag_wide_write(s->doubt + lane, lag_wide_read(s->doubt + lane) + LAG_WIDE_ABS(lag_wide_read(s->rest + lane)));
}

/* Those of states at their times. */
static void evaluate_at(LagWideExplicit *s, const double *t, const double *y, double *k)
{
    const size_t n = (size_t)s->lanes.n * LAG_ABREAST;
    memcpy(s->time, t, LAG_ABREAST * sizeof *t);
    memcpy(s->point, y, n * sizeof *y);
    memcpy(k, y + n, n * sizeof *y);
    evaluate(s, k);
}

/* First slopes where motions are new: the others have theirs, whose digits are not those of another reference. */
static void evaluate_first(LagWideExplicit *s)
{
    evaluate_at(s, s->lanes.t, s->lanes.y, s->k[1]);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        for (int i = 0; i < s->lanes.size; ++i)
            lag_wide_choose(s->k[0], i, lane, lag_wide_read(s->is_new + lane), lag_wide_of(s->k[1], i, lane));
    memset(s->is_new, 0, sizeof s->is_new);
    s->lanes.is_fresh = 0;
}

/* Weights of the row times slopes, of component i. */
LAG_UNROLLED LagWide combined(const LagWideExplicit *s, const LagTableauRow *row, int i, int lane)
{
    const size_t place = (size_t)i * LAG_ABREAST + (size_t)lane;
    LagWide total = LAG_WIDE_OF(0);
    for (int j = 0; j < row->count; ++j)
        total = LAG_WIDE_FUSED(LAG_WIDE_OF(row->weight[j]), lag_wide_read(s->k[row->column[j]] + place), total);
    return total;
}

static void stage(LagWideExplicit *s, int i)
{
    const int n = s->lanes.n;
    const LagTableauRow *row = &s->tableau->stage[i];
    double *k = s->k[i];
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const LagWide t = lag_wide_read(s->lanes.t + lane), h = lag_wide_read(s->lanes.next + lane) - t;
        lag_wide_write(s->time + lane, LAG_WIDE_FUSED(LAG_WIDE_OF(s->tableau->node[i]), h, t));
        for (int c = 0; c < n; ++c) {
            const size_t place = (size_t)c * LAG_ABREAST + (size_t)lane;
            lag_wide_write(s->point + place, LAG_WIDE_FUSED(h, combined(s, row, c, lane), lag_wide_of(s->lanes.y, c, lane)));
            lag_wide_write(k + place, LAG_WIDE_FUSED(h, combined(s, row, n + c, lane), lag_wide_of(s->lanes.y, n + c, lane)));
        }
    }
    evaluate(s, k);
}

/* The latest slopes become the first ones where steps were good, and where the next steps end. */
static void begin(LagWideExplicit *s, int lane)
{
    const LagWide t = lag_wide_read(s->lanes.t + lane), taken = lag_wide_read(s->lanes.taken + lane);
    const LagWide wish = lag_wide_min(lag_wide_max(lag_wide_read(s->step + lane), lag_wide_smallest(t)), LAG_WIDE_OF(s->lanes.longest));
    for (int i = 0; i < s->lanes.size; ++i)
        lag_wide_choose(s->k[0], i, lane, taken, lag_wide_of(s->k[s->tableau->stages], i, lane));
    for (int i = 0; i < 3 * s->lanes.model->n_attitudes; ++i) { /* which have just been moved: they turn as they say */
        const int place = lag_attitude_place(s->lanes.model->attitudes, i / 3) + i % 3;
        lag_wide_choose(s->k[0], place, lane, taken, lag_wide_of(s->lanes.y, s->lanes.n + place, lane));
    }
    lag_wide_write(s->lanes.next + lane, lag_wide_end_of(&s->lanes, lane, t, wish));
    lag_wide_write(s->doubt + lane, LAG_WIDE_OF(0));
}

/* -------- errors, squared */

/* Hairer's combination of squares, where there are two embedded errors. */
LAG_UNROLLED LagWide both(LagWide fine, LagWide coarse)
{
    const LagWide zero = LAG_WIDE_OF(0), sum = fine + LAG_WIDE_OF(0.01) * coarse;
    return LAG_WIDE_SELECT(fine == zero, zero, fine * (fine / sum));
}

/* Of steps of length h: root mean square in units over what moves. */
static LagWide error_of(const LagWideExplicit *s, int lane, LagWide h)
{
    const LagTableau *tableau = s->tableau;
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1), before = lag_wide_read(s->lanes.length + lane);
    LagWide fine = zero, coarse = zero, moving = zero;
    for (int i = 0; i < s->lanes.n; ++i) {
        LagWide unit[2];
        lag_wide_scale_units(&s->lanes.scale, i, lane, s->lanes.y, s->lanes.made, before, LAG_WIDE_OF(DBL_EPSILON) / before, &unit[0],
                             &unit[1]);
        for (int is_rate = 0; is_rate < 2; ++is_rate) {
            const int c = i + is_rate * s->lanes.n;
            const LagWide share = LAG_WIDE_SELECT(unit[is_rate] > zero, h / unit[is_rate], zero);
            const LagWide error = combined(s, tableau->error, c, lane) * share;
            const LagWide other = tableau->coarse_error ? combined(s, tableau->coarse_error, c, lane) * share : zero;
            fine = LAG_WIDE_FUSED(error, error, fine);
            coarse = LAG_WIDE_FUSED(other, other, coarse);
            moving += LAG_WIDE_SELECT(unit[is_rate] > zero, one, zero);
        }
    }
    const double factor = s->caution * tableau->caution;
    const LagWide caution = LAG_WIDE_OF(factor * factor);
    return caution * both(fine, coarse) / LAG_WIDE_SELECT(moving > zero, moving, one);
}

/* Of the energy quadratures, the largest in units. */
static LagWide work_of(const LagWideExplicit *s, int lane, LagWide h)
{
    const LagWide weight = lag_wide_read(s->lanes.energy + lane), zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1);
    const LagWide least = LAG_WIDE_SELECT(weight > zero, one / weight, zero);
    LagWide largest = zero;
    for (int i = 0; i < s->lanes.model->n_power; ++i) {
        const int c = 2 * s->lanes.n + i;
        const LagWide fine = h * combined(s, s->tableau->error, c, lane);
        const LagWide coarse = s->tableau->coarse_error ? h * combined(s, s->tableau->coarse_error, c, lane) : zero;
        const LagWide error = both(fine * fine, coarse * coarse);
        const LagWide size = LAG_WIDE_OF(s->lanes.scale.tolerance) * LAG_WIDE_ABS(lag_wide_of(s->lanes.made, c, lane));
        const LagWide unit = lag_wide_max(size, least);
        lag_wide_write(s->lost + (size_t)i * LAG_ABREAST + lane, error);
        largest = lag_wide_max(error / (unit * unit), largest);
    }
    return LAG_WIDE_SELECT(weight > zero, largest, zero);
}

/* Errors of quadratures, squared, count as lag_account_count says, one motion after another. */
static void count_work(LagWideExplicit *s, const double *work)
{
    for (int lane = 0; lane < LAG_ABREAST; ++lane) {
        if (s->lanes.moves[lane] == 0 || !(s->error[lane] <= 1) || !(s->lanes.energy[lane] > 0))
            continue;
        LagMotion *m = &s->run[lane]->motion;
        m->t = s->lanes.t[lane];
        const double counts = lag_account_count(m, s->lanes.next[lane] - m->t, sqrt(work[lane]));
        s->error[lane] = lag_max(counts * counts, s->error[lane]);
    }
}

static void estimate(LagWideExplicit *s)
{
    double work[LAG_ABREAST] = {0};
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const LagWide h = lag_wide_read(s->lanes.next + lane) - lag_wide_read(s->lanes.t + lane);
        lag_wide_write(s->error + lane, error_of(s, lane, h));
        if (s->lanes.model->n_power > 0)
            lag_wide_write(work + lane, work_of(s, lane, h));
    }
    if (s->lanes.model->n_power > 0)
        count_work(s, work);
}

/* -------- steps */

static void finish(LagWideExplicit *s, int lane)
{
    const LagTableauRow *row = &s->tableau->stage[s->tableau->stages];
    const LagWide h = lag_wide_read(s->lanes.next + lane) - lag_wide_read(s->lanes.t + lane);
    for (int i = 0; i < s->lanes.size; ++i)
        lag_wide_add(&s->lanes, (size_t)i * LAG_ABREAST + (size_t)lane, h * combined(s, row, i, lane));
}

/* 0, where all slopes at the ends of steps are finite. */
LAG_UNROLLED LagWide unfit(const LagWideExplicit *s, int lane)
{
    LagWide sum = lag_wide_read(s->doubt + lane);
    for (int i = s->lanes.n; i < s->lanes.size; ++i)
        sum += LAG_WIDE_OF(0) * lag_wide_of(s->k[s->tableau->stages], i, lane);
    return sum;
}

static void judge(LagWideExplicit *s, int lane)
{
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1), t = lag_wide_read(s->lanes.t + lane);
    const LagWide h = lag_wide_read(s->lanes.next + lane) - t, step = lag_wide_read(s->step + lane);
    const LagWide error = lag_wide_read(s->error + lane), grows = lag_wide_read(s->grows + lane);
    const LagWide is_fit = LAG_WIDE_SELECT(unfit(s, lane) == zero, one, zero);
    const LagWide is_near = LAG_WIDE_SELECT(error <= one, is_fit, zero);
    const LagWide is_long = LAG_WIDE_SELECT(h >= lag_wide_smallest(t), one, zero);
    const LagWide good = is_near * is_long * lag_wide_read(s->lanes.moves + lane);
    const LagWide power = lag_wide_power_of(lag_wide_max(error, LAG_WIDE_OF(SMALLEST_ERROR)), -0.5 / s->order);
    const LagWide wish = lag_wide_max(LAG_WIDE_OF(SAFETY) * power, LAG_WIDE_OF(SHRINK));
    const LagWide planned = LAG_WIDE_SELECT(h < LAG_WIDE_OF(CUT) * step, step, zero);
    const LagWide longer = lag_wide_max(planned, h * lag_wide_min(grows, wish));
    const LagWide is_known = LAG_WIDE_SELECT(error <= LAG_WIDE_OF(DBL_MAX), is_fit, zero);
    const LagWide shorter = h * LAG_WIDE_SELECT(is_known > zero, wish, LAG_WIDE_OF(NOT_FINITE_SHRINK));
    const LagWide starts = LAG_WIDE_SELECT(grows > LAG_WIDE_OF(GROW), LAG_WIDE_SELECT(wish > LAG_WIDE_OF(GROW), one, zero), zero);
    const LagWide next = LAG_WIDE_SELECT(starts > zero, LAG_WIDE_OF(FIRST_GROW), LAG_WIDE_OF(GROW));
    lag_wide_write(s->step + lane, LAG_WIDE_SELECT(good > zero, longer, shorter));
    lag_wide_write(s->grows + lane, LAG_WIDE_SELECT(good > zero, next, one));
    lag_wide_accept(&s->lanes, lane, good, h);
}

/* Errors of quadratures that steps were not limited by. */
static void note_lost(LagWideExplicit *s, int lane)
{
    const int n_power = s->lanes.model->n_power;
    for (int i = 0; i < n_power; ++i)
        s->lost[(n_power + i) * LAG_ABREAST + lane] += sqrt(s->lost[i * LAG_ABREAST + lane]);
}

/* Where loops close, one motion after another, as lag_step_adaptive does. */
static void project(LagWideExplicit *s)
{
    const int states = 2 * s->lanes.n;
    for (int lane = 0; lane < LAG_ABREAST; ++lane) {
        LagRun *run = s->run[lane];
        int worst;
        if (s->lanes.moves[lane] == 0 || !(s->error[lane] <= 1))
            continue;
        lag_wide_take(s->lanes.made, lane, run->motion.other, states);
        lag_wide_take(s->lanes.made_carry, lane, run->motion.other_carry, states);
        if (lag_project_waits(run, s->lanes.next[lane]))
            continue;
        s->error[lane] = lag_max(lag_project_step(run, s->lanes.next[lane], 1, &worst), s->error[lane]);
        s->doubt[lane] += s->error[lane] < INFINITY ? 0 : 1;
        lag_wide_place(s->lanes.made, lane, run->motion.other, states);
        lag_wide_place(s->lanes.made_carry, lane, run->motion.other_carry, states);
    }
}

/* The errors of steps, and the slopes at their ends; of what is projected after errors are known of these, rates are taken alone. */
static void end(LagWideExplicit *s)
{
    const size_t n = (size_t)s->lanes.n * LAG_ABREAST;
    const int is_loop = s->lanes.model->n_multipliers > 0;
    double *k = s->k[s->tableau->stages];
    if (s->tableau->error_at_end)
        evaluate_at(s, s->lanes.next, s->lanes.made, k);
    estimate(s);
    if (is_loop)
        project(s);
    if (!s->tableau->error_at_end)
        evaluate_at(s, s->lanes.next, s->lanes.made, k);
    else if (is_loop)
        memcpy(k, s->lanes.made + n, n * sizeof *k);
}

static void step(void *self)
{
    LagWideExplicit *s = self;
    const int stages = s->tableau->stages;
    lag_wide_attitudes_move(&s->lanes);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        begin(s, lane);
    if (s->lanes.is_fresh)
        evaluate_first(s);
    for (int i = 1; i < stages; ++i)
        stage(s, i);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        finish(s, lane);
    end(s);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        judge(s, lane);
    for (int lane = 0; lane < LAG_ABREAST; ++lane) {
        const int is_left = !(s->doubt[lane] == 0) || (s->lanes.model->n_multipliers > 0 && s->lanes.in_vain[lane] >= TRIES);
        if (s->lanes.moves[lane] > 0 && is_left)
            s->lanes.in_vain[lane] = LEAVES;
        else if (s->lanes.taken[lane] > 0)
            note_lost(s, lane);
    }
}

const LagWideMethod lag_wide_verner9 = {LAG_SOLVER_ERK9, layout_verner9, load, NULL, NULL, enter, show, step, 1};
const LagWideMethod lag_wide_dop853 = {LAG_SOLVER_ERK, layout_dop853, load, NULL, NULL, enter, show, step, 0};
const LagWideMethod lag_wide_tsit5 = {LAG_SOLVER_ERK5, layout_tsit5, load, NULL, NULL, enter, show, step, 0};
