/* Taylor steps: A. Jorba, M. Zou, Experimental Mathematics 14 (2005). The order is that which makes digits cheapest; the length
 * of a step follows from the last two coefficients, so hardly one is ever rejected. The series at the end of a step, differentiated,
 * is compared with the accelerations there: a check that costs next to nothing, as they are the first coefficients of the next step.
 */
#include "methods/taylor.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "numbers/lanes.h"
#include "methods/taylor_attitudes.h"
#include "methods/taylor_defect.h"
#include "methods/taylor_long.h"
#include "model/function.h"
#include "model/jet_tape.h"
#include "numbers/rough_power.h"
#include "state/account.h"
#include "steps/rounding.h"
#include "steps/segment.h"
#include "steps/step.h"
#include "steps/turns.h"

enum { LEAST_ORDER = 4, PATIENCE = 3, MOST_PLANS = 40 }; /* PATIENCE: rejections after which rounding is asked for */
static const double DOMINANT = 0.03; /* share of the end of a step */
/* What the rest of the series may be worth in units of error, so that errors are those of Dormand-Prince at the same tolerance; by
 * how much a step may be wrong at its end; shrinking after a step that was. */
static const double REST = LAG_TAYLOR_REST, WRONG = LAG_TAYLOR_WRONG, SHRINK = LAG_TAYLOR_SHRINK, GROW = LAG_TAYLOR_GROW;
/* An error falls with the power of the order as steps shrink, rounding does not: what remains of it as large as this share, and is
 * less than NOISE of the state, is let pass. */
static const double REMAINS = LAG_TAYLOR_REMAINS, NOISE = LAG_TAYLOR_NOISE;
static const double SHORTEST = 16; /* of the smallest step: where something jumps there, a part of it is rounding of time */

/* What a step costs, in tenths of a nanosecond, here and by Dormand-Prince 8(5,3), and by how much its steps of order 8 are
 * longer than eps^(1/8) radii of convergence: measured on pendulums, springs, chains of springs and Kepler orbits. What goes
 * beyond MANY products in all orders costs more. A jet without products costs EACH a step and PASSING an order. */
static const double EACH = 80, PASSING = 7.6;
static const double STEP = 1500, JET = 9.5, PRODUCT = 1.3, MANY = 1400, CROWDED = 2.6;
/* The same for eight motions at once: each order waits for the one before. Measured on a double pendulum, orders 8 to 18. */
static const double EIGHT = 2000, EIGHT_JETS = 6, EIGHT_PRODUCTS = 1.9;
static const double OTHER_STEP = 3300, OTHER_SUM = 500, OTHER_STAGES = 12, OTHER_LENGTH = 1.1;

const double lag_inverse[LAG_JET_ORDER] = {1, 1. / 2, 1. / 3, 1. / 4, 1. / 5, 1. / 6, 1. / 7, 1. / 8, 1. / 9, 1. / 10, 1. / 11,
                                            1. / 12, 1. / 13, 1. / 14, 1. / 15, 1. / 16, 1. / 17, 1. / 18};

static inline double *power_jet(const LagModel *model, double *jets, int i)
{
    return lag_taylor_jet(model, jets, model->jet_places[model->is_long_state ? i : model->n + i]);
}

static void layout(void *self, const LagMotion *motion, LagArena *arena)
{
    LagTaylor *s = self;
    const LagModel *model = ((const LagRun *)motion->context)->model;
    const size_t size = lag_jet_room(model) * LAG_JET_STRIDE;
    s->jets = lag_take(arena, size);
    s->old_jets = lag_take(arena, size);
    s->unit = lag_take(arena, 2 * (size_t)motion->n + LAG_LANES);
    s->share = lag_take(arena, 2 * (size_t)motion->n + 2 * LAG_LANES);
    s->numbers = lag_take(arena, model->series.n_out > 0 ? (size_t)model->series.out_size[0] : 0);
    s->work = lag_take(arena, model->series.n_work);
    s->scratch = lag_take(arena, lag_jet_scratch(model));
}

static double cost_of(const LagModel *model, int order)
{
    if (model->jet_pitch > 1)
        return STEP + model->n_weighed * (EACH + PASSING * order);
    const double products = 0.5 * order * order * model->n_products;
    return STEP + JET * order * model->n_weighed + PRODUCT * products + CROWDED * lag_max(products - MANY, 0);
}

static double cost_of_eight(const LagModel *model, int order)
{
    return EIGHT + EIGHT_JETS * order * model->n_weighed + EIGHT_PRODUCTS * order * order * model->n_products;
}

typedef double (*Cost)(const LagModel *model, int order);

/* Time per radius of convergence; steps of order p are eps^(1/p) radii long. */
static double pace_of(Cost cost, const LagModel *model, double eps, int order)
{
    return cost(model, order) * lag_rough_power(1 / eps, lag_inverse[order - 1]);
}

/* Where time is spent mostly on the sums, it is near -ln(eps)/2 + 1; where each step has a price, it is higher. */
static int order_for(Cost cost, const LagModel *model, double eps)
{
    int best = LEAST_ORDER;
    double least = pace_of(cost, model, eps, best);
    for (int order = LEAST_ORDER + 1; order <= LAG_JET_ORDER; ++order) {
        const double pace = pace_of(cost, model, eps, order);
        if (pace < least) {
            least = pace;
            best = order;
        }
    }
    return best;
}

static void plan(LagTaylor *s, Cost cost, const LagModel *model, double tolerance)
{
    s->tolerance = tolerance;
    s->order = order_for(cost, model, REST * tolerance);
    const double share = exp(log(REST * tolerance) / s->order); /* of the radius of convergence in a step */
    s->last = REST * (1 - share) / share;
    s->before_last = s->last / share;
}

void lag_taylor_plan_for_eight(LagTaylor *s, const LagModel *model, double tolerance)
{
    plan(s, cost_of_eight, model, tolerance);
}

static void restart(void *self, LagMotion *motion)
{
    LagTaylor *s = self;
    const LagRun *run = motion->context;
    if (s->tolerance != run->scale.tolerance)
        plan(s, cost_of, run->model, run->scale.tolerance);
    s->begun = 0;
    s->is_fresh = 1;
    motion->t_old = motion->t;
}

/* The coefficients of value + slope h. */
static void place_line(const LagModel *model, double *jets, int slot, double value, double slope)
{
    double *c = lag_taylor_jet(model, jets, slot);
    for (int k = 2; k < LAG_JET_STRIDE; ++k)
        c[k * model->jet_pitch] = 0;
    c[0] = value;
    c[model->jet_pitch] = slope;
}

/* Coefficients of time and inputs, which are linear in a segment. */
static void place_known(LagRun *run, double *jets)
{
    const LagModel *model = run->model;
    const LagMotion *m = &run->motion;
    const int n_inputs = model->n_inputs, first = 1 + 2 * m->n;
    place_line(model, jets, 0, m->t, 1);
    if (n_inputs == 0)
        return;
    lag_inputs_slope(&run->inputs, run->u);
    for (int i = 0; i < n_inputs; ++i)
        place_line(model, jets, first + i, 0, run->u[i]);
    lag_inputs_at(&run->inputs, m->t, run->u);
    for (int i = 0; i < n_inputs; ++i)
        *lag_taylor_jet(model, jets, first + i) = run->u[i];
}

/* The coefficients of everything from order `first` to before `end`, and those of the state of order `end`. Returns 1 when the
 * last of them are finite: what is not, at a lower order, makes them NaN. */
static int expand(LagRun *run, const LagTaylor *s, double *jets, int first, int end)
{
    const LagModel *model = run->model;
    const double *in[] = {run->d, run->c};
    double probe = 0;
    const int n = model->n, pitch = model->jet_pitch, is_long = model->is_long_state;
    if (model->taylor) {
        model->taylor(first, end, in, jets);
    } else {
        lag_call(&model->series, in, (double *[]){s->numbers}, s->work);
        lag_jet_tape_run(model, first, end, s->numbers, jets, s->scratch);
    }
    for (int i = 0; i < (is_long ? 0 : n) + model->n_power; ++i)
        probe += 0 * lag_taylor_jet(model, jets, model->jet_places[i])[(end - 1) * pitch];
    for (int i = 0; i < (is_long ? n : 0); ++i)
        probe += 0 * jets[end * pitch + 1 + n + i];
    return probe == 0;
}

/* The series at the present state up to the given order. Returns 1 when all is finite. */
static int build(LagRun *run, LagTaylor *s, int order)
{
    const LagMotion *m = &run->motion;
    if (s->begun == 0) {
        place_known(run, s->jets);
        for (int i = 0; i < 2 * m->n; ++i)
            *lag_taylor_jet(run->model, s->jets, 1 + i) = m->y[i];
        lag_taylor_place_turned(run, m->y, s->jets);
        ++run->motion.evaluations;
    }
    const int first = s->begun;
    s->begun = order;
    return first >= order || expand(run, s, s->jets, first, order);
}

/* The integral of a series from 0 to h, in two chains. */
LAG_UNROLLED double integral(const double *c, int pitch, int order, double h)
{
    const double square = h * h;
    double even = 0, odd = 0;
    for (int k = (order - 1) / 2 * 2; k >= 0; k -= 2) {
        odd = odd * square + (k + 1 < order ? c[(k + 1) * pitch] * lag_inverse[k + 1] : 0);
        even = even * square + c[k * pitch] * lag_inverse[k];
    }
    return (even + odd * h) * h;
}

LAG_UNROLLED void integrate_powers(const LagModel *model, double *jets, int order, double h, double *step)
{
    for (int i = 0; i < model->n_power; ++i)
        step[2 * model->n + i] = integral(power_jet(model, jets, i), model->jet_pitch, order, h);
}

/* What a step of length h adds to a short state, but for what is turned. */
LAG_UNROLLED void sum_up(const LagModel *model, double *jets, int order, double h, double *step)
{
    const int n = model->n, pitch = model->jet_pitch;
    integrate_powers(model, jets, order, h, step);
    if (pitch > 1) /* apart from the next loop, whose pitch is a constant: 4 % of a small scene's time */
        for (int i = 0; i < 2 * n; ++i)
            step[i] = lag_jet_value(jets + pitch + 1 + i, pitch, order - 1, h) * h;
    else
        for (int i = 0; i < 2 * n; ++i)
            if (!lag_taylor_is_turned(model, i))
                step[i] = lag_jet_value(jets + (1 + i) * LAG_JET_STRIDE + 1, 1, order - 1, h) * h;
}

/* What a step of length h adds to the state; beyond `order` nothing is left of the series. */
static void displacement(const LagTaylor *s, const LagModel *model, double *jets, int order, double h, double *step)
{
    if (model->is_long_state) {
        lag_long_displacement(model, jets, order, h, step, s->share);
        integrate_powers(model, jets, order, h, step);
    } else if (order <= LEAST_ORDER) /* a throw's: its sums are short, and of a length that is known */
        sum_up(model, jets, LEAST_ORDER, h, step);
    else
        sum_up(model, jets, order, h, step);
    if (model->n_attitudes > 0)
        lag_taylor_turn(model, jets, order, h, step);
}

/* A state near the end of the planned step, which units are taken for: that before the latest one serves as well, if there is one
 * that moved. */
static const double *other_end(LagRun *run, const LagTaylor *s, double planned)
{
    LagMotion *m = &run->motion;
    if (!s->is_fresh && !run->scale.is_resting)
        return m->other;
    displacement(s, run->model, s->jets, s->top, planned, m->sum);
    for (int i = 0; i < 2 * m->n; ++i)
        m->point[i] = m->y[i] + m->sum[i];
    return m->point;
}

/* Raises the last two coefficients, in units, to those of what the energy account integrates. */
static void weigh_powers(const LagRun *run, const LagTaylor *s, double *last, double *before)
{
    const LagModel *model = run->model;
    const double unit = lag_account_unit(run);
    for (int i = 0; i < model->n_power && unit > 0; ++i) {
        const double *power = power_jet(model, s->jets, i);
        *last = lag_max(fabs(power[(s->order - 1) * model->jet_pitch]) * lag_inverse[s->order - 1] / unit, *last);
        *before = lag_max(fabs(power[(s->order - 2) * model->jet_pitch]) * lag_inverse[s->order - 2] / unit, *before);
    }
}

/* The last coefficients of the state and those before, in units, as far as they are larger than *last and *before. */
static void weigh_state(LagRun *run, const LagTaylor *s, const double *end, double *last, double *before)
{
    const int p = s->order, pitch = run->model->jet_pitch;
    for (int i = 0; i < 2 * run->model->n; ++i) {
        if (lag_taylor_is_turned(run->model, i))
            continue;
        const double unit = lag_scale_unit(&run->scale, i, run->motion.y, end), weight = unit > 0 ? 1 / unit : 0;
        const double *c = lag_taylor_jet(run->model, s->jets, 1 + i), size = fabs(c[p * pitch]) * weight;
        if (size > *last) {
            *last = size;
            run->statistics.worst = i;
        }
        *before = lag_max(fabs(c[(p - 1) * pitch]) * weight, *before);
    }
}

/* The length at which the last two coefficients are worth a unit of error, where units are those of a step of the planned length. */
static double length_by(LagRun *run, const LagTaylor *s, double planned)
{
    const int p = s->order;
    const double *end = other_end(run, s, planned);
    double last = 0, before = 0;
    if (run->model->is_long_state)
        lag_long_weigh(run, end, &last, &before);
    else
        weigh_state(run, s, end, &last, &before);
    lag_taylor_weigh_turned(run, end, &last, &before);
    weigh_powers(run, s, &last, &before);
    return lag_min(lag_rough_power(s->last / last, lag_inverse[p - 1]), lag_rough_power(s->before_last / before, lag_inverse[p - 2]));
}

/* The same by the planned step, or, where that is so long that its last coefficients make much of its end, by shorter ones: what is stiff
 * ends anywhere then, and its units tell nothing. */
static double length_of(LagRun *run, const LagTaylor *s)
{
    double planned = run->step, h = length_by(run, s, planned);
    for (int k = 0; k < MOST_PLANS && (s->is_fresh || run->scale.is_resting) && h < planned; ++k) {
        if (!(s->last * lag_rough_power(planned / h, s->order) * run->scale.tolerance > DOMINANT))
            break;
        planned = h;
        h = length_by(run, s, planned);
    }
    return h;
}

/* The first coefficients of the next step, in the place of those of the step before this one. */
static int look_ahead(LagRun *run, LagTaylor *s, double t_new)
{
    LagMotion *m = &run->motion;
    const double t = m->t;
    m->t = t_new;
    place_known(run, s->old_jets);
    m->t = t;
    for (int i = 0; i < 2 * m->n; ++i)
        *lag_taylor_jet(run->model, s->old_jets, 1 + i) = m->other[i];
    lag_taylor_place_turned(run, m->other, s->old_jets);
    ++m->evaluations;
    return expand(run, s, s->old_jets, 0, 1);
}

/* The same of powers, in units of the account, where motion that time prescribes sets out from rest: few coefficients tell of it there. */
static double power_defect(const LagRun *run, const LagTaylor *s, double length)
{
    const LagModel *model = run->model;
    double largest = 0;
    for (int i = 0; i < model->n_power && run->carried_energy > 0; ++i) {
        const double at_end = lag_jet_value(power_jet(model, s->jets, i), model->jet_pitch, s->order - 1, length);
        largest = lag_max(fabs(at_end - *power_jet(model, s->old_jets, i)), largest);
    }
    return largest > 0 ? largest * length * lag_inverse[s->order - 1] / lag_account_unit(run) : 0;
}

/* Whether the step of this length to m->other is good; *wrong: by how much the last one tried was not. */
static int is_good(LagRun *run, LagTaylor *s, double t_new, double length, double *wrong)
{
    int worst, is_jump;
    const double before = *wrong;
    if (lag_project_step(run, t_new, 1, &worst) > 0)
        return 0;
    *wrong = INFINITY;
    if (lag_taylor_turns_too_far(run, run->motion.other, length) || !look_ahead(run, s, t_new))
        return 0;
    *wrong = lag_max(lag_taylor_defect(run, length, &is_jump), power_defect(run, s, length));
    const int may_be_noise = !is_jump || length < SHORTEST * lag_step_smallest(run->motion.t);
    const int is_noise = may_be_noise && *wrong > REMAINS * before && *wrong * run->scale.tolerance < NOISE;
    run->statistics.tolerance_missed += is_noise && *wrong > 1;
    return *wrong <= WRONG || is_noise;
}

/* What rests at its origin on constraints is moved by rounding alone, of which a series makes a motion in units of its own. */
static int rests_at_origin(const LagRun *run) { return run->model->n_holonomic > 0 && lag_scale_at_rest(&run->scale); }

static void take(LagRun *run, LagTaylor *s, double t_new, double length)
{
    double *const jets = s->jets;
    s->jets = s->old_jets;
    s->old_jets = jets;
    s->begun = 1;
    s->is_fresh = 0;
    s->old_top = s->top;
    lag_motion_take(&run->motion, t_new);
    run->step = length;
    lag_step_record(run, length);
}

/* A series holds switches, and what it holds may have no value at the end of any step beyond its change. */
static int needs_live_switches(const LagRun *run, int in_vain, double wrong)
{
    return run->switches.is_live || (in_vain >= PATIENCE && !(wrong < INFINITY) && run->model->n_switches > 0);
}

/* The order from which on nothing is left of a series: digits are the same without. */
static int top_of(const LagTaylor *s, const LagModel *model, double *jets)
{
    const int n = model->n, pitch = model->jet_pitch;
    int top = model->is_long_state ? s->order : lag_taylor_top_of_turned(model, jets, s->order);
    top = top > 1 ? top : 1;
    for (int i = 0; i < 2 * n + model->n_power; ++i) {
        const int is_power = i >= 2 * n; /* whose integral counts, of an order more */
        const double *c = is_power ? power_jet(model, jets, i - 2 * n) : lag_taylor_jet(model, jets, 1 + i);
        int k = s->order;
        while (k - 3 > top && lag_jet_ends(c + (k - is_power) * pitch, pitch))
            k -= 4;
        while (k > top && c[(k - is_power) * pitch] == 0)
            --k;
        top = k > top ? k : top;
    }
    return top;
}

/* Leaves to others all that comes, or, where it was asked for and something is held, some steps: friction begins where loads are 0. */
static int leaves(LagRun *run) { return lag_turn_fall_back(run) || (run->model->n_switches > 0 && lag_turn_pass(run)); }

static LagStatus step(LagRun *run)
{
    LagTaylor *s = &run->methods.taylor;
    LagMotion *m = &run->motion;
    double wrong = INFINITY;
    int in_vain = 0;
    const int is_live = needs_live_switches(run, 0, 0);
    if ((rests_at_origin(run) && lag_turn_fall_back(run)) || ((is_live || run->model->n_cones > 0) && leaves(run)))
        return run->methods.table->step(run);
    if (is_live || !build(run, s, s->order))
        return leaves(run) ? run->methods.table->step(run) : lag_step_give_up(run, 0);
    s->top = top_of(s, run->model, s->jets);
    const double longest = GROW * lag_max(run->step, lag_step_smallest(m->t)); /* at rest a series says nothing of what comes */
    double h = lag_min(length_of(run, s), longest);
    if (lag_taylor_turns_too_far(run, m->y, h))
        h = lag_taylor_longest_turn(run, m->y);
    if (run->settings.max_step > 0)
        h = lag_min(h, run->settings.max_step);
    for (;; h *= SHRINK) {
        const double t_new = lag_step_end(run, h), length = t_new - m->t;
        if (!(h >= lag_step_smallest(m->t))) /* what is left before an end may be shorter */
            return leaves(run) ? run->methods.table->step(run) : lag_step_give_up(run, run->statistics.worst);
        displacement(s, run->model, s->jets, s->top, length, m->sum);
        lag_motion_add(m, m->sum);
        m->t_old = m->t;
        if (is_good(run, s, t_new, length, &wrong)) {
            take(run, s, t_new, length);
            return LAG_OK;
        }
        ++run->statistics.rejected;
        if (needs_live_switches(run, ++in_vain, wrong) && lag_turn_fall_back(run))
            return run->methods.table->step(run);
        if (in_vain == PATIENCE)
            lag_rounding_look(run);
        run->scale.step = in_vain >= PATIENCE ? length : 0;
        h = lag_min(h, length);
    }
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagTaylor *s = self;
    const LagRun *run = m->context;
    if (s->old_top == 0)
        s->old_top = top_of(s, run->model, s->old_jets);
    displacement(s, run->model, s->old_jets, s->old_top, t - m->t_old, y);
    for (int i = 0; i < m->size; ++i)
        y[i] += m->other[i];
}

/* The coefficients of each position and rate, one after another. */
static void keep(const void *self, const LagMotion *m, double *place)
{
    const LagTaylor *s = self;
    const LagModel *model = ((const LagRun *)m->context)->model;
    for (int i = 0; i < 2 * m->n; ++i) {
        const double *c = lag_taylor_jet(model, s->old_jets, 1 + i);
        for (int k = 0; k <= s->order; ++k)
            place[i * LAG_JET_STRIDE + k] = c[k * model->jet_pitch];
    }
}

static void recall(void *self, LagMotion *m, double *place, double begin, double length, double t, double *y)
{
    const LagTaylor *s = self;
    const double h = t - begin;
    (void)length;
    for (int i = 0; i < 2 * m->n; ++i) {
        const double *c = place + i * LAG_JET_STRIDE;
        double rest = 0;
        for (int k = s->order; k > 0; --k)
            rest = rest * h + c[k];
        y[i] = c[0] + rest * h;
    }
}

static const LagRecord RECORD = {keep, recall};

double lag_taylor_eps(double tolerance) { return REST * lag_scale_caution(tolerance); }

double lag_taylor_pace(const LagModel *model, double tolerance)
{
    const double eps = lag_taylor_eps(tolerance);
    return pace_of(cost_of, model, eps, order_for(cost_of, model, eps));
}

double lag_taylor_erk_cost(const LagModel *model)
{
    return OTHER_STEP + OTHER_SUM * model->n + OTHER_STAGES * model->series_rhs_cost;
}

double lag_taylor_cost(const LagModel *model, double tolerance)
{
    const double eps = lag_scale_caution(tolerance), other_length = OTHER_LENGTH * pow(eps, 1.0 / 8);
    return lag_taylor_pace(model, tolerance) * other_length;
}

const LagMethod lag_taylor = {
    .name = "taylor", .order = 8, .layout = layout, .restart = restart, .step = step, .interpolate = interpolate,
    .holds_switches = 1, .stride = 1, .record = &RECORD,
};
