/* The spectral radius by the power method on differences of accelerations, an iteration now and then: B.P. Sommeijer,
 * L.F. Shampine, J.G. Verwer, RKC: an explicit solver for parabolic PDEs, J. Comput. Appl. Math. 88 (1998). Apart for positions
 * and rates, whose units differ: |lambda|^2 <= rate |lambda| + square.
 */
#include "choice/stiffness.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "state/state.h"

/* The share of the limit of steps times spectral radius where stability does not rule by far; relative length of differences. */
static const double FAR = 1 / 3.5, DIFFERENCE = 1e-6;
/* What is seen of damping: the least that steps times spectral radius are said to have reached by it; the share of a change of
 * rates that is against them, and the damping beside the frequency, of which it is said. */
static const double LEAST_REACHED = 0.5, AGAINST = 0.8, CREEPING = 1;
/* The share of steps limited by sweeps below which stability does not rule iterated collocation: sweeps come nearer fast. Scenes
 * that turned out stiff had 0.4 and more, smooth ones up to 0.25. */
static const double SELDOM = 0.3;
/* The first look costs 2 FIRST_ITERATIONS + 1 evaluations: 3 % of those before it. */
enum { FIRST_LOOK = 28, FIRST_LOOK5 = 48, FIRST_LOOK_PIRK = 12, STEPS_OF_ADAMS = 8, FIRST_ITERATIONS = 4, MOST_INTERVAL = 256,
       SUSPICIOUS_INTERVAL = 9 };
/* After an event, steps are short at first. */
enum { TRIAL = 16, TRIAL_AFTER_EVENT = 64, FIRST_WAIT = 64, MOST_WAIT = 1 << 20, STAGES = 12, STAGES5 = 6 };

void lag_stiffness_layout(LagStiffness *s, int n, int size, LagArena *arena)
{
    s->place_way = lag_take(arena, (size_t)n);
    s->rate_way = lag_take(arena, (size_t)n);
    s->point = lag_take(arena, 2 * (size_t)n);
    s->slope = lag_take(arena, (size_t)size);
    s->base = lag_take(arena, (size_t)n);
}

/* -------- the spectral radius */

/* Length by which positions (or rates, from index n on) may be moved along `way`. */
static double reach(const LagRun *run, const double *way, int first)
{
    double length = INFINITY;
    for (int i = 0; i < run->model->n; ++i) {
        const double size = run->scale.floor[first + i];
        if (way[i] != 0 && size > 0)
            length = lag_min(size / fabs(way[i]), length);
    }
    return isfinite(length) ? DIFFERENCE * length : 0;
}

/* One iteration: `way` becomes the change of the accelerations along it, `against` the cosine between it and what it was, turned
 * round. The factor by which it grew, or `before`. */
static double iterate(LagRun *run, double *way, int first, double before)
{
    LagStiffness *s = &run->stiffness;
    const int n = run->model->n;
    const double length = reach(run, way, first);
    double old = 0, new = 0, along = 0;
    s->against = 0;
    if (length == 0)
        return before;
    memcpy(s->point, run->motion.y, 2 * (size_t)n * sizeof *way);
    for (int i = 0; i < n; ++i)
        s->point[first + i] += length * way[i];
    if (!lag_motion_slope(&run->motion, run->motion.t, s->point, s->point + n, s->slope))
        return before;
    for (int i = 0; i < n; ++i) {
        const double change = (s->slope[n + i] - s->base[i]) / length;
        old += way[i] * way[i];
        new += change * change;
        along += way[i] * change;
        s->point[i] = change;
    }
    if (!(new > 0) || !isfinite(new))
        return 0;
    for (int i = 0; i < n; ++i)
        way[i] = s->point[i] / sqrt(new);
    s->against = -along / sqrt(old * new);
    return sqrt(new / old);
}

static double radius(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    const int n = run->model->n, count = s->square < 0 ? FIRST_ITERATIONS : 1;
    if (!lag_motion_slope(&run->motion, run->motion.t, run->motion.y, run->motion.y + n, s->slope))
        return 0;
    memcpy(s->base, s->slope + n, (size_t)n * sizeof *s->base);
    for (int i = 0; i < n && s->square < 0; ++i)
        s->place_way[i] = s->rate_way[i] = 1 + 0.3 * (i % 3);
    for (int i = 0; i < count; ++i) {
        s->square = iterate(run, s->place_way, 0, lag_max(s->square, 0));
        s->rate = iterate(run, s->rate_way, n, s->rate);
    }
    const int dies_out = s->against > AGAINST && s->rate * s->rate > CREEPING * CREEPING * lag_max(s->square, 0);
    s->damped = dies_out ? s->damped + 1 : 0;
    return (s->rate + sqrt(s->rate * s->rate + 4 * s->square)) / 2;
}

/* -------- work */

/* Whether series take turns with implicit steps: they leave what slides to others. */
static int is_series(const LagRun *run) { return run->stiffness.explicit_solver == LAG_SOLVER_TAYLOR && run->sliding.count == 0; }

static int is_adams(const LagRun *run) { return run->methods.solver == LAG_SOLVER_ADAMS; }

static int is_pirk(const LagRun *run) { return run->methods.solver == LAG_SOLVER_PIRK; }

/* Steps of the method in use that stand for one of the others. */
static int steps_for_one(const LagRun *run) { return is_adams(run) ? STEPS_OF_ADAMS : 1; }

static int is_low(const LagRun *run) { return run->methods.explicit_solver == LAG_SOLVER_ERK5; }

static double explicit_step_work(const LagRun *run)
{
    return (is_low(run) ? STAGES5 : STAGES) * (run->model->rhs_cost + 30.0 * run->model->n);
}

/* Operations so far, from what was counted. */
static double work(const LagRun *run)
{
    const LagModel *model = run->model;
    const LagStatistics *statistics = &run->statistics;
    const double size = model->n + model->n_multipliers, fill = model->n_lower + model->n_upper;
    const double solve = model->n_lower > 0 ? 8 * fill : 4 * size * size;
    const double factor = model->n_lower > 0 ? 8 * fill * fill / size : 2 * size * size * size;
    return (double)run->motion.evaluations * (model->rhs_cost + 30.0 * model->n)
        + (double)run->methods.radau.evaluations * (solve + 30.0 * model->n)
        + (double)statistics->jacobians * model->jacobian_cost * 2 + (double)statistics->factorisations * (factor + 20 * size);
}

/* -------- decisions */

/* Whether what changes most is a rate that dies out without swinging; forces of inertia look like it for a while. */
static int is_damped(const LagStiffness *s) { return s->damped > 1; }

/* What decisions go by, but for what is measured for one of them. */
static LagFacts *measured(LagRun *run)
{
    const LagStiffness *s = &run->stiffness;
    LagFacts *f = &run->facts;
    f->solver = run->methods.solver;
    f->explicit_solver = run->methods.explicit_solver;
    f->rows_solver = run->methods.rows_solver;
    f->turns_solver = s->explicit_solver;
    f->next = run->methods.behind.to;
    f->steps = s->steps;
    f->is_series = is_series(run);
    f->order = run->methods.taylor.order;
    f->is_damped = is_damped(s);
    f->row_spacing = run->row_spacing;
    f->holding = run->sliding.count;
    f->looks = 0;
    f->trouble = 0;
    return f;
}

int32_t lag_stiffness_trouble(LagRun *run, int32_t trouble)
{
    const int is_passing = trouble == LAG_TROUBLE_PASS || trouble == LAG_TROUBLE_LEAD || trouble == LAG_TROUBLE_CREEPS;
    LagDecision *decision = is_passing ? &run->passing : &run->decided;
    LagFacts *f = measured(run);
    f->trouble = trouble;
    if (trouble == LAG_TROUBLE_DISTURBED)
        f->turns_solver = run->orbit.solver;
    lag_decide(LAG_TROUBLE, f->solver, f, decision);
    return decision->to;
}

int lag_stiffness_retry(LagRun *run, int32_t tried, LagDecision *decision)
{
    LagFacts *f = measured(run);
    f->trouble = LAG_TROUBLE_LOST;
    f->tried = tried | lag_methods_refused(run->model);
    return lag_decide(LAG_TROUBLE, f->solver, f, decision);
}

static int first_look(const LagRun *run)
{
    return is_pirk(run) ? FIRST_LOOK_PIRK : steps_for_one(run) * (is_low(run) ? FIRST_LOOK5 : FIRST_LOOK);
}

void lag_stiffness_begin(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    s->steps = s->suspicions = 0;
    s->t = run->motion.t;
    s->work = work(run);
    s->events = run->statistics.events;
    run->methods.pirk.limited = 0;
    s->interval = s->look = first_look(run);
}

void lag_stiffness_reset(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    const int solver = run->methods.solver, is_runge_kutta = solver == run->methods.explicit_solver;
    const int is_other = solver == LAG_SOLVER_ERK9 || solver == LAG_SOLVER_TAYLOR || is_adams(run) || is_pirk(run);
    const int is_explicit = is_runge_kutta || is_other;
    s->is_watching = lag_methods_turn(&run->settings) && is_explicit && lag_methods_alternate(run->model, solver);
    s->next = LAG_SOLVER_AUTO;
    s->explicit_solver = is_explicit ? solver : run->methods.explicit_solver;
    s->passes = 0;
    s->relief = LAG_PASSES;
    s->leads = 0;
    s->relieved = -LAG_RECOVERED * LAG_PASSES;
    s->square = -1;
    s->rate = 0;
    s->damped = 0;
    s->reached = lag_most_reach(measured(run));
    s->wait = s->looks = 0;
    s->penalty = FIRST_WAIT;
    lag_stiffness_begin(run);
}

/* Series begin what iterated collocation goes on with if poles of the motion limit their steps, and rows are known to be few. */
static void watch_poles(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    LagFacts *f = measured(run);
    f->step = (run->motion.t - s->t) / s->steps;
    if (!lag_looks_for_poles(f))
        return;
    f->reach = f->step * radius(run);
    if (lag_decide(LAG_STEP, f->solver, f, &run->decided))
        s->next = s->explicit_solver = run->decided.to;
}

/* What is not implicit says next whether implicit steps pay: sweeps that hardly come nearer cost more than Adams' methods,
 * where these serve, or Runge-Kutta methods, which are stable for longer steps than Adams'. */
static void judge(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    if (!lag_decide(LAG_STEP, run->methods.solver, &run->facts, &run->decided))
        return;
    s->next = run->decided.to;
    if (s->next == LAG_SOLVER_IMPLICIT)
        return;
    s->suspicions = 0;
    s->explicit_solver = s->next;
}

/* Whether stability rules, as it looks now. */
static LagFacts *look_closely(LagRun *run, double h)
{
    LagStiffness *s = &run->stiffness;
    const double reached = h * radius(run);
    LagFacts *f = measured(run);
    f->step = h;
    f->reach = reached;
    f->swept = run->methods.pirk.limited;
    s->reached = is_damped(s) ? lag_min(s->reached, lag_max(reached, LEAST_REACHED)) : s->reached;
    f->looks = s->suspicions = lag_is_ruled(f) ? s->suspicions + 1 : 0;
    return f;
}

int lag_stiffness_look(LagRun *run, double h) { return (int)look_closely(run, h)->looks; }

/* Whether sweeps tell that stability does not rule, which saves a look. */
static int comes_near(const LagRun *run)
{
    const LagStiffness *s = &run->stiffness;
    return is_pirk(run) && s->suspicions == 0 && run->methods.pirk.limited < SELDOM * s->steps;
}

static void watch_explicit(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    if (run->methods.may_find_poles && run->methods.solver == LAG_SOLVER_TAYLOR)
        watch_poles(run);
    if (s->steps < s->look || s->steps < s->wait)
        return;
    if (comes_near(run)) {
        lag_stiffness_begin(run);
        return;
    }
    const LagFacts *f = look_closely(run, (run->motion.t - s->t) / s->steps);
    const int is_by_steps = run->methods.solver == LAG_SOLVER_TAYLOR || is_pirk(run); /* evaluations are not what they cost */
    const double spent = is_by_steps ? s->steps * explicit_step_work(run) : work(run) - s->work;
    s->pace = (run->motion.t - s->t) / spent;
    const int suspicious = steps_for_one(run) * SUSPICIOUS_INTERVAL, most = steps_for_one(run) * MOST_INTERVAL;
    s->interval = s->suspicions > 0 ? suspicious : f->reach > FAR * lag_most_reach(f) ? first_look(run) : 2 * s->interval;
    s->interval = s->interval < most ? s->interval : most;
    judge(run);
    const int look = s->interval, suspicions = s->suspicions;
    s->wait = 0;
    lag_stiffness_begin(run); /* the next stretch */
    s->interval = s->look = look;
    s->suspicions = suspicions;
}

static void watch_implicit(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    if (s->steps < (run->statistics.events > s->events ? TRIAL_AFTER_EVENT : TRIAL))
        return;
    const double pace = (run->motion.t - s->t) / (work(run) - s->work), largest = radius(run);
    LagFacts *f = measured(run);
    const double longest = is_damped(s) ? s->reached : lag_most_reach(f);
    f->pace = pace;
    f->pace_before = s->pace;
    f->pace_possible = largest > 0 ? longest / largest / explicit_step_work(run) : INFINITY;
    f->gain = lag_max(f->pace_before, f->pace_possible) / pace;
    if (lag_decide(LAG_STEP, LAG_SOLVER_IMPLICIT, f, &run->decided)) {
        s->next = run->decided.to;
        s->wait = s->penalty;
        s->penalty = s->penalty < MOST_WAIT ? 2 * s->penalty : s->penalty;
    } else {
        s->penalty = FIRST_WAIT; /* it has paid: what comes next is judged anew */
    }
    s->pace = 0;
    lag_stiffness_begin(run);
}

static void watch_rows(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    s->looks = run->motion.t == run->wanted ? s->looks + LAG_LOOK : s->looks - (s->looks > 0);
    LagFacts *f = measured(run);
    f->step = run->step;
    f->rows_apart = run->row_spacing / run->step;
    f->row_looks = s->looks;
    if (lag_decide(LAG_ROW, f->solver, f, &run->decided))
        s->next = s->explicit_solver = run->decided.to;
}

void lag_stiffness_watch(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    const int slides = run->sliding.count > 0;
    if (s->passes > 0 && !slides && --s->passes == 0)
        s->next = s->passed;
    ++s->steps;
    if (!s->is_watching || (s->passes > 0 && !slides))
        return;
    if (run->methods.solver == LAG_SOLVER_IMPLICIT)
        watch_implicit(run);
    else
        watch_explicit(run);
    if (run->methods.table->dreads_rows)
        watch_rows(run);
}
