/* Gauss collocation of order 16 for q'' = a(t, q, q'), its stages found by iteration: each sweep evaluates all eight at once, in
 * registers that hold as many numbers, and takes about as long as one evaluation (wide.h). P.J. van der Houwen, B.P. Sommeijer, J.
 * Comput. Appl. Math. 29 (1990): parallel iterated Runge-Kutta methods.
 *
 * The polynomial of the step before foresees the stages; that of a rejected step those of a shorter one, in two or three sweeps,
 * unless its sweeps ran away. What is inside a step is found when somebody looks (pirk_dense.c): so rows do not change steps.
 *
 * Coefficients of the accelerations by Legendre polynomials tell the error: they fall like powers, and those of degree 16 and more
 * are what a step leaves out.
 */
#include "methods/pirk.h"

#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"
#include "methods/pirk_attitudes.h"
#include "methods/pirk_edges.h"
#include "methods/pirk_tableau.h"
#include "numbers/rough_power.h"
#include "steps/step.h"
#include "methods/taylor.h"

/* Sweeps have converged when what the next ones would change is below this share of the error allowed, or is rounding: so small in the
 * same measure, or beside accelerations. What sweeps change by tells how quickly they come nearer where it is larger than this. */
static const double CONVERGED = 0.03, NOISE = 0.3, ROUNDING = 1e-14, TOLD = 1;
static const double SLOW = 0.9, LEAST = 0.01, MOST = 0.8, UNKNOWN = 0.5; /* factors by which sweeps come nearer */
static const double BEST = 0.4; /* the one at which steps of given length take least: longer ones take more sweeps than they save */
enum { MOST_SWEEPS = 20, EARLY = 2, PATIENT = 4, TURNS = 2 };
static const double HOPELESS = 3; /* error, as it looks early, of a step that is given up then */
static const double FLAT = 0.3; /* share of the first coefficients that the last ones have of rounding */
static const double DOUBTED = 4; /* units: the error of a series that falls as its last coefficients do */
static const double JUMPED = 10, UNLIKE = 0.5; /* of last coefficients: what rounding is not, and what smooth series have of those before */
static const double CAUTION = 4; /* errors are as those of Dormand-Prince at the same tolerance */
static const double SAFETY = 0.75, GROW = 2, SHRINK = 0.3, CLEARLY_LESS = 0.9;

static double *take_wide(LagArena *arena, size_t count) { return lag_take(arena, LAG_ABREAST * count); }

static size_t tape_work(const LagFunction *function) { return function->tape ? function->n_work : 0; }

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    LagPirk *s = self;
    const LagModel *model = ((const LagRun *)m->context)->model;
    const LagFunction *rhs = &model->rhs, *usual = lag_usual_rhs(model);
    const size_t n = (size_t)m->n, all = (size_t)(m->size - m->n);
    arena->used = (arena->used + LAG_CACHE_LINE - 1) / LAG_CACHE_LINE * LAG_CACHE_LINE;
    const size_t rows = all + (size_t)lag_pirk_detours(m);
    s->a = take_wide(arena, rows);
    s->tried = take_wide(arena, rows);
    s->known = take_wide(arena, rows);
    s->q = take_wide(arena, n);
    s->v = take_wide(arena, n);
    s->u = take_wide(arena, (size_t)model->n_inputs);
    s->rest = take_wide(arena, rhs->n_out > 2 && rhs->out_size[2] > 1 ? (size_t)rhs->out_size[2] : 1);
    s->work = take_wide(arena, tape_work(rhs) > tape_work(usual) ? tape_work(rhs) : tape_work(usual));
    s->end = take_wide(arena, rows);
    s->slope = lag_take(arena, all);
    s->reached = lag_take(arena, (size_t)m->size);
    s->unit = lag_take(arena, 2 * n);
    s->weight = lag_take(arena, n + (size_t)lag_pirk_detours(m));
    s->one = lag_take(arena, n + (size_t)m->size);
    lag_pirk_dense_layout(&s->dense, m, arena);
}

static void restart(void *self, LagMotion *m)
{
    LagPirk *s = self;
    memcpy(s->slope, m->slope + m->n, (size_t)(m->size - m->n) * sizeof *s->slope);
    s->slope_time = m->t;
    s->length = 0;
    s->per = 0;
    s->was_careful = 0;
}

/* -------- sums over stages */

/* Of a table of columns, one for each of the stages that `a` belongs to. */
LAG_UNROLLED LagWide weighed(const double *a, const double *table, int lane)
{
    return lag_wide_weighed(a, table, LAG_ABREAST, LAG_ABREAST, lane);
}

/* Lagrange's polynomials at the stages of a step from t, of length h, in the measure of the known one: by columns. */
static void continuation(const LagPirk *s, double t, double h, double table[LAG_ABREAST][LAG_ABREAST])
{
    const double first = (t - s->begin) / s->length, ratio = h / s->length;
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const LagWide x = first + ratio * lag_wide_read(lag_pirk_node + lane);
        LagWide product = LAG_WIDE_OF(1);
        for (int j = 0; j < LAG_ABREAST; ++j) {
            lag_wide_write(table[j] + lane, product * lag_pirk_basis[j]);
            product *= x - lag_pirk_node[j];
        }
        product = LAG_WIDE_OF(1);
        for (int j = LAG_ABREAST - 1; j >= 0; --j) {
            lag_wide_write(table[j] + lane, product * lag_wide_read(table[j] + lane));
            product *= x - lag_pirk_node[j];
        }
    }
}

/* Accelerations at the stages of a step, as the known polynomial continues, or as they are at the start. Detours were against
 * another reference: they are those of no turn. */
static void foresee(LagPirk *s, const LagMotion *m, double t, double h)
{
    const int all = m->size - m->n;
    double table[LAG_ABREAST][LAG_ABREAST];
    if (s->length > 0)
        continuation(s, t, h, table);
    for (int c = 0; c < all; ++c)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
            const double *known = s->known + c * LAG_ABREAST;
            lag_wide_write(s->a + c * LAG_ABREAST + lane, s->length > 0 ? weighed(known, &table[0][0], lane) : LAG_WIDE_OF(s->slope[c]));
        }
    memset(s->a + all * LAG_ABREAST, 0, (size_t)(LAG_ABREAST * lag_pirk_detours(m)) * sizeof *s->a);
}

/* Positions of attitudes by the detours of the sweep before. */
static void turn(LagPirk *s, const LagMotion *m, double h)
{
    const double *detours = s->a + (m->size - m->n) * LAG_ABREAST;
    for (int k = 0; k < lag_pirk_detours(m); ++k)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
            double *q = s->q + lag_pirk_detour_of(m, k) * LAG_ABREAST + lane;
            lag_wide_write(q, lag_wide_read(q) + h * weighed(detours + k * LAG_ABREAST, &lag_pirk_rate[0][0], lane));
        }
}

/* The states of the stages. */
static void place(LagPirk *s, const LagMotion *m, const double *y, double h)
{
    const int n = m->n;
    for (int c = 0; c < n; ++c)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
            const double *a = s->a + c * LAG_ABREAST;
            const LagWide node = lag_wide_read(lag_pirk_node + lane);
            const LagWide v = y[n + c] + h * weighed(a, &lag_pirk_rate[0][0], lane);
            const LagWide q = y[c] + h * (node * y[n + c] + h * weighed(a, &lag_pirk_place[0][0], lane));
            lag_wide_write(s->q + c * LAG_ABREAST + lane, q);
            lag_wide_write(s->v + c * LAG_ABREAST + lane, v);
        }
    turn(s, m, h);
}

static void find_detours(LagPirk *s, const LagMotion *m)
{
    lag_pirk_find_detours(m, s->q, s->v, s->a + (m->size - m->n) * LAG_ABREAST, LAG_ABREAST);
}

/* What accelerations and powers come to at the end. */
static void conclude(LagPirk *s, int all)
{
    for (int c = 0; c < all; ++c)
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
            lag_wide_write(s->end + c * LAG_ABREAST + lane, weighed(s->a + c * LAG_ABREAST, &lag_pirk_end[0][0], lane));
}

/* What a step of length h from y adds. */
static void displacement(const LagPirk *s, const LagMotion *m, const double *y, double h, double *sum)
{
    const int n = m->n;
    for (int c = 0; c < n; ++c) {
        sum[c] = h * (y[n + c] + h * s->end[c * LAG_ABREAST]);
        sum[n + c] = h * s->end[c * LAG_ABREAST + 1];
    }
    for (int c = n; c < m->size - n; ++c)
        sum[n + c] = h * s->end[c * LAG_ABREAST + 1];
    for (int k = 0; k < lag_pirk_detours(m); ++k)
        sum[lag_pirk_detour_of(m, k)] += h * s->end[(m->size - n + k) * LAG_ABREAST + 1];
}

/* -------- sweeps */

/* Stages one after another. */
static int evaluate_each(LagPirk *s, LagMotion *m)
{
    const int n = m->n, all = m->size - n;
    double *q = s->one, *k = s->one + n;
    for (int i = 0; i < LAG_ABREAST; ++i) {
        for (int c = 0; c < n; ++c) {
            q[c] = s->q[c * LAG_ABREAST + i];
            k[c] = s->v[c * LAG_ABREAST + i];
        }
        if (!lag_motion_slope(m, s->times[i], q, k, k))
            return 0;
        for (int c = 0; c < all; ++c)
            s->a[c * LAG_ABREAST + i] = k[n + c];
    }
    return 1;
}

int lag_pirk_evaluate(LagPirk *s, LagMotion *m)
{
    double *out[] = {s->a, s->a + m->n * LAG_ABREAST, s->rest};
    if (!lag_accelerations_abreast(m->context, s->times, s->q, s->v, s->u, out, s->work))
        return evaluate_each(s, m);
    m->evaluations += LAG_ABREAST;
    return 1;
}

/* How far accelerations `a` are from `b`, if there is one, or from 0, in units of error in the step: root mean square over the stages.
 * Sums are the same whatever registers hold. */
static double distance(const LagPirk *s, const LagMotion *m, const double *a, const double *b)
{
    const int n = m->n, rows = n + lag_pirk_detours(m), skipped = m->size - 2 * n; /* powers lie between */
    double squares[LAG_ABREAST];
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        LagWide sum = LAG_WIDE_OF(0);
        for (int c = 0; c < rows; ++c) {
            const int i = (c < n ? c : c + skipped) * LAG_ABREAST + lane;
            const LagWide far = b ? lag_wide_read(a + i) - lag_wide_read(b + i) : lag_wide_read(a + i);
            const LagWide units = far * LAG_WIDE_OF(s->weight[c]);
            sum += units * units;
        }
        lag_wide_write(squares + lane, sum);
    }
    return sqrt(lag_wide_total(squares) / LAG_ABREAST);
}

static int sweep(LagPirk *s, LagMotion *m, const double *y, double h)
{
    place(s, m, y, h);
    lag_swap(&s->a, &s->tried);
    find_detours(s, m);
    return lag_pirk_evaluate(s, m);
}

static void weigh(LagPirk *s, const LagMotion *m, const LagScale *scale, const double *y, double h)
{
    const int n = m->n;
    for (int i = 0; i < 2 * n; ++i)
        s->unit[i] = lag_scale_unit(scale, i, y, m->other);
    for (int c = 0; c < n; ++c) {
        const double rate = s->unit[n + c] > 0 ? h / s->unit[n + c] : 0, way = s->unit[c] > 0 ? 0.5 * h * h / s->unit[c] : 0;
        s->weight[c] = lag_max(rate, way);
    }
    for (int k = 0; k < lag_pirk_detours(m); ++k) {
        const double unit = s->unit[lag_pirk_detour_of(m, k)];
        s->weight[n + k] = unit > 0 ? h / unit : 0;
    }
}

/* Large coefficients of a series at degrees 7 and 6, 5 and 4, 3 and 2. */
typedef struct { double last, middle, first; } Coefficients;

/* Those of component c, by its weight; returns whether the last ones are larger than before. */
static int note(const LagPirk *s, int c, double weight, Coefficients *most)
{
    const double *end = s->end + c * LAG_ABREAST, last = weight * lag_max(fabs(end[2]), fabs(end[3]));
    const int is_worst = last > most->last;
    most->last = lag_max(last, most->last);
    most->middle = lag_max(weight * lag_max(fabs(end[6]), fabs(end[7])), most->middle);
    most->first = lag_max(weight * lag_max(fabs(end[4]), fabs(end[5])), most->first);
    return is_worst;
}

/* The error of a series. Where the last coefficients do not fall, something jumps: seen by a stage or two it makes all of them alike. */
static double remainder_of(Coefficients most)
{
    const double ratio = most.first > 0 ? lag_min(most.last / most.first, 1) : 1;
    return most.last > JUMPED && most.last > UNLIKE * most.middle ? most.last : most.last * ratio * ratio;
}

/* The same for one that falls as its last coefficients do, whatever the first are of. */
static double slow_remainder_of(Coefficients most)
{
    const double ratio = most.middle > 0 ? lag_min(most.last / most.middle, 1) : 1;
    return most.last * ratio * ratio * ratio * ratio;
}

/* The error of the step, in units. */
static double estimate(LagPirk *s, const LagMotion *m, double h, int *worst)
{
    const LagRun *run = m->context;
    const double energy = run->settings.tolerance * m->energy;
    Coefficients most = {0, 0, 0};
    conclude(s, m->size - m->n + lag_pirk_detours(m));
    for (int c = 0; c < m->n; ++c)
        if (note(s, c, s->weight[c], &most))
            *worst = m->n + c;
    for (int k = 0; k < lag_pirk_detours(m); ++k)
        note(s, m->size - m->n + k, s->weight[m->n + k], &most);
    double error = remainder_of(most);
    s->last = most.last;
    s->is_doubtful = CAUTION * slow_remainder_of(most) > DOUBTED;
    s->is_flat = most.last > FLAT * most.first;
    for (int c = m->n; c < m->size - m->n && energy > 0; ++c) {
        Coefficients work = {0, 0, 0};
        note(s, c, h / energy, &work);
        error = lag_max(remainder_of(work), error);
    }
    return CAUTION * error;
}

void lag_pirk_set_times(LagPirk *s, const LagMotion *m, double t, double h, const double *node)
{
    LagRun *run = m->context;
    const int inputs = run->model->n_inputs;
    for (int i = 0; i < LAG_ABREAST; ++i)
        s->times[i] = t + node[i] * h;
    for (int i = 0; i < LAG_ABREAST && inputs > 0; ++i) {
        lag_inputs_at(&run->inputs, s->times[i], run->u);
        for (int c = 0; c < inputs; ++c)
            s->u[c * LAG_ABREAST + i] = run->u[c];
    }
}

/* Rounding, whose coefficients do not fall, grows with the length of a step itself. The factor by which a sweep comes nearer that is
 * best: its root in the step's length is 1 (rates) or 1/2 (positions). */
static double length_factor(LagPirk *s, double contraction, double error)
{
    const double smooth = SAFETY * lag_rough_power(lag_max(error, 1e-12), -1.0 / 16);
    const double by_error = lag_min(s->is_flat ? lag_max(0.5 / lag_max(error, 1e-12), smooth) : smooth, GROW);
    const double by_sweeps = contraction > BEST ? BEST / contraction : GROW;
    s->limited += by_sweeps < by_error;
    return lag_max(SHRINK, lag_min(by_error, by_sweeps));
}

/* Of what sweeps change when they come no nearer. */
static int is_noise(const LagPirk *s, const LagMotion *m, double moved)
{
    return moved <= NOISE || moved <= ROUNDING * distance(s, m, s->a, NULL);
}

/* Sweeps until the stages of the step from (t, y) are known. Returns its error in units: below 1 only when they are. */
static double iterate(LagPirk *s, LagMotion *m, const double *y, double h, int *worst)
{
    const double known = s->per > 0 ? lag_max(LEAST, lag_min(s->contraction * (h / s->per), MOST)) : UNKNOWN;
    double before = 0, nearer = known, error = INFINITY;
    s->is_told = 0;
    for (int k = 0; k < MOST_SWEEPS; ++k) {
        if (!sweep(s, m, y, h))
            return INFINITY;
        const double moved = distance(s, m, s->a, s->tried);
        if (k > 0)
            nearer = before > 0 ? lag_max(LEAST, moved / before) : LEAST;
        s->foresees = nearer < 1;
        if (k > 0 && before > TOLD) {
            s->contraction = nearer;
            s->per = h;
            s->is_told = 1;
        }
        const int is_slow = nearer > SLOW;
        if ((nearer < 1 && moved * nearer < CONVERGED * (1 - nearer)) || (is_slow && is_noise(s, m, moved))) {
            s->foresees = 1;
            return estimate(s, m, h, worst);
        }
        if (k == EARLY && (error = estimate(s, m, h, worst)) > HOPELESS)
            return error;
        if (k >= PATIENT && is_slow)
            break;
        before = moved;
    }
    return lag_max(estimate(s, m, h, worst), 2);
}

/* The error of a step by what may be narrower than its stages are apart. */
static double look_again(LagPirk *s, LagMotion *m, double t_new)
{
    const double error = lag_pirk_edges(s, m, t_new);
    return error > 1 ? error : lag_max(lag_pirk_second_look(s, m, m->y), error);
}

static double attempt(void *self, LagMotion *m, double t_new, const LagScale *scale, int *worst)
{
    LagPirk *s = self;
    const LagRun *run = m->context;
    const double h = t_new - m->t;
    m->t_old = m->t;
    s->was_careful = run->careful;
    lag_pirk_set_times(s, m, m->t, h, lag_pirk_node);
    foresee(s, m, m->t, h);
    for (int turns = 0; m->n_attitudes > 0 && turns < TURNS; ++turns) {
        place(s, m, m->y, h);
        find_detours(s, m);
    }
    conclude(s, m->size - m->n + lag_pirk_detours(m));
    displacement(s, m, m->y, h, m->sum);
    lag_motion_add(m, m->sum);
    if (scale->is_resting)
        lag_scale_foresee(scale, m->other);
    weigh(s, m, scale, m->y, h);
    double error = iterate(s, m, m->y, h, worst);
    if (!(error < INFINITY)) {
        s->factor = SHRINK;
        return INFINITY;
    }
    displacement(s, m, m->y, h, m->sum);
    lag_motion_add(m, m->sum);
    if (s->foresees) {
        lag_swap(&s->a, &s->known);
        s->begin = m->t;
        s->length = h;
    }
    /* towards singular positions of loops all series fall slowly: these are for lag_attempts_leave */
    const int is_doubtful = s->is_doubtful && run->model->n_multipliers == 0;
    if (error <= 1 && (run->model->may_be_narrow || run->model->n_looks > 0 || is_doubtful))
        error = lag_max(look_again(s, m, t_new), error);
    s->factor = length_factor(s, s->per == h ? s->contraction : 0, error);
    if (error > 1)
        s->factor = lag_min(s->factor, CLEARLY_LESS);
    return error;
}

static int accept(void *self, LagMotion *m, double t_new)
{
    LagPirk *s = self;
    s->dense.is_ready = 0;
    lag_pirk_keep_end(s, m, t_new);
    lag_motion_take(m, t_new);
    return 1;
}

/* Where a loop is singular rounding is magnified, and sweeps run away. */
static int is_clear(const void *self)
{
    const LagPirk *s = self;
    return s->is_told && s->contraction < BEST;
}

static double factor(const void *self) { return ((const LagPirk *)self)->factor; }

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    LagPirk *s = self;
    LagRun *run = m->context;
    const int careful = run->careful;
    run->careful = s->was_careful;
    lag_pirk_dense_read(s, m, t, y);
    run->careful = careful;
}

/* Of the step that was taken. */
static double miss(void *self, LagMotion *m) { return lag_pirk_second_look(self, m, m->other); }

/* Where something jumps inside a step, beyond the place that it is cut at. */
static void take_back(LagRun *run)
{
    ((LagPirk *)run->methods.self)->dense.is_ready = 0;
    lag_motion_take_back(&run->motion);
    --run->statistics.steps;
    ++run->statistics.rejected;
}

/* Costs and lengths as in taylor.c. */
double lag_pirk_cost(const LagModel *model)
{
    static const double SWEEPS = 7, SWEEP = 1250, EVALUATION = 5;
    return SWEEPS * (SWEEP + EVALUATION * model->series_rhs_cost);
}

double lag_pirk_series_cost(const LagModel *model, double tolerance)
{
    static const double LENGTH = 1.9;
    return lag_taylor_pace(model, tolerance) * LENGTH * pow(lag_taylor_eps(tolerance), 1.0 / 16);
}

const LagMethod lag_pirk = {
    .name = "pirk", .order = 16, .layout = layout, .restart = restart, .step = lag_step_adaptive, .attempt = attempt,
    .accept = accept, .interpolate = interpolate, .take_back = take_back, .miss = miss, .is_good_inside = 1, .is_clear = is_clear, .factor = factor, .holds_switches = 1, .stride = 1, .leaves_trouble = 1,
    .weighs_work = 1, .dreads_rows = 1, .record = &lag_pirk_record,
};
