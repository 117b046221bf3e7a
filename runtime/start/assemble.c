/* Positions first, then rates where the positions are.
 *
 * What nobody guessed follows the guesses; where that is enough, they hold. Else a solution is found near by (newton.c), then
 * moved along the solution set to where it is nearest to the guess in the mass metric at the guess: steps of a projected
 * gradient, each brought back to the set, as long as the distance falls. What cannot be solved in the mass metric is tried once
 * more with every value measured by its size, and last with all of them alike: where a guess is far off, moving it little is the
 * long way.
 *
 * Where all equations together lead nowhere, they are solved block by block (blocks.c).
 *
 * Where no solution is found, what nobody guessed is tried elsewhere, at last the guesses, too: a link that points the wrong way
 * may keep its loop from closing although all guesses are near.
 *
 * Where an equation is not finite at the guess, as y/x = 2 where both are 0, the values it speaks of are moved aside first.
 *
 * An assembly may be singular although others are regular: a parallelogram folded flat. Where the guesses leave values open,
 * these are tried elsewhere, and an assembly is preferred in which more of the equations are independent.
 */
#include "start/assemble.h"

#include <math.h>
#include <string.h>

static const double GOLDEN_RATIO = 0.6180339887498949, CLOSE = 1e-7, SHORTEST_LEAN = 0.1, FALL = 1e-13;
static const double SINGULAR = 1e-5, SPREAD = 1, WIDE_SPREAD = 6.283185307179586, NEAR = 0.5, MOVED = 1e-9, BOUNDLESS = 1e100;
static const double STEPS_ASIDE[] = {0.00390625, 1, 0.25, 4, 0.0625, 16, 0.015625, 64};
enum { MOST_ITERATIONS = 100, FEW_ITERATIONS = 30, MOST_PUSHES = 3, MOST_LEANS = 30, MOST_RETURNS = 20, MOST_TRIES = 4,
       FREE_SEARCHES = 12, MOST_SEARCHES = 20, LAST_SEARCHES = 32, MANY = 100, MOST_ASIDE = 32 };

void lag_assembly_layout(LagAssembly *s, LagArena *arena)
{
    const size_t unknowns = s->model->n_initial > 0 ? 2 * (size_t)lag_start_size(s->model) : 0;
    lag_newton_layout(&s->newton, s->model, arena);
    lag_blocks_layout(&s->blocks, s->model, arena);
    lag_known_start_layout(&s->known, s->model, arena);
    s->reach = lag_take(arena, unknowns);
    s->guess = lag_take(arena, unknowns);
    s->found = lag_take(arena, unknowns);
    s->kept = lag_take(arena, unknowns);
    s->best = lag_take(arena, unknowns);
    s->apart = lag_take(arena, unknowns);
    s->lean = lag_take(arena, unknowns);
}

static void copy(const LagAssembly *s, const double *from, double *to)
{
    memcpy(to, from, 2 * (size_t)lag_start_size(s->model) * sizeof *to);
}

static int is_angle(const LagAssembly *s, int j) { return s->model->coordinate_kind[j] == LAG_KIND_ANGLE; }

/* From -0.5 to 0.5, different for each value. */
static double spread(int j, int turn) { return fmod((j + 1) * GOLDEN_RATIO + turn * GOLDEN_RATIO * GOLDEN_RATIO, 1) - 0.5; }

/* The same, the signs of different values independent of each other. */
static double all_ways(int j, int turn) { return fmod((j + 1) * (double)turn * GOLDEN_RATIO, 1) - 0.5; }

/* The largest of its kind. */
static double largest_like(const LagAssembly *s, const double *x, int j)
{
    const int *kind = s->model->coordinate_kind;
    double largest = 0;
    for (int i = 0; i < lag_start_size(s->model); ++i)
        if (kind[i] == kind[j])
            largest = fmax(largest, fabs(x[i]));
    return largest;
}

/* What a radian moves, or the gap if that is larger, where an equation ties other values to angles: raises their reach.
 * Notes in `tied` which ones those are. */
static void reach_by_equation(LagAssembly *s, int i, double *tied)
{
    const int n = lag_start_size(s->model), *values = s->newton.values, end = s->newton.first[i + 1];
    const double *slopes = s->newton.jacobian;
    double turned = 0, shifted = 0;
    for (int k = s->newton.first[i]; k < end && values[k] < n; ++k) {
        double *slope = is_angle(s, values[k]) ? &turned : &shifted;
        *slope = fmax(*slope, fabs(slopes[k]));
    }
    for (int k = s->newton.first[i]; k < end && values[k] < n; ++k) {
        const int j = values[k];
        if (is_angle(s, j) || !(turned > 0) || !(fabs(slopes[k]) > 0))
            continue;
        tied[j] = 1;
        s->reach[j] = fmax(s->reach[j], fmax(turned, fabs(s->newton.g[i])) / shifted);
    }
}

/* An angle is measured by 1; another value by itself and by the lever of the angles it is tied to, else by the largest of its
 * kind. The levers are those of a general position near the guess. Rates are measured by the same, or by what they begin with. */
static void set_reach(LagAssembly *s, const double *p, const double *x, double *work)
{
    const int n = lag_start_size(s->model);
    copy(s, x, s->kept);
    memset(s->lean, 0, (size_t)n * sizeof *s->lean);
    for (int j = 0; j < n; ++j) {
        s->reach[j] = is_angle(s, j) ? 1 : fabs(x[j]);
        s->kept[j] += is_angle(s, j) ? spread(j, 0) : 0;
    }
    if (lag_newton_evaluate(&s->newton, p, s->kept, work) == 0)
        for (int i = 0; i < s->model->n_initial_positions; ++i)
            reach_by_equation(s, i, s->lean);
    for (int j = 0; j < n; ++j) {
        if (!(s->lean[j] > 0) && !is_angle(s, j))
            s->reach[j] = largest_like(s, x, j);
        s->reach[j] = s->reach[j] > 0 && isfinite(s->reach[j]) ? s->reach[j] : 1;
    }
    for (int j = 0; j < n; ++j)
        s->reach[n + j] = fmax(largest_like(s, x + n, j), s->reach[j]);
    lag_newton_survey(&s->newton, s->reach);
}

/* Whether an equation, of those evaluated last, and its slopes are finite: the slope of the direction of a vector that vanishes is
 * not, but for rounding. */
static int is_finite(const LagAssembly *s, int i)
{
    int finite = isfinite(s->newton.g[i]) != 0;
    for (int k = s->newton.first[i]; finite && k < s->newton.first[i + 1]; ++k)
        finite = fabs(s->newton.jacobian[k]) < BOUNDLESS;
    return finite;
}

static int are_finite(const LagAssembly *s)
{
    int finite = 1;
    for (int i = 0; finite && i < s->model->n_initial; ++i)
        finite = is_finite(s, i);
    return finite;
}

/* Whether a value is one that an equation that is not finite speaks of. */
static int is_lost(const LagAssembly *s, int j)
{
    for (int i = 0; i < s->model->n_initial; ++i) {
        if (is_finite(s, i))
            continue;
        for (int k = s->newton.first[i]; k < s->newton.first[i + 1]; ++k)
            if (s->newton.values[k] == j && !(s->newton.jacobian[k] == 0))
                return 1;
    }
    return 0;
}

/* What steps aside, in turn: places that move no mass, places, rates; what is guessed, last. */
enum { ASIDE_LOOSE, ASIDE_PLACES, ASIDE_FREE, ASIDE_GUESSED_PLACES, ASIDE_ALL, ASIDE_ROUNDS };

static int steps_aside(const int *fixed, int n, int j, int round)
{
    const int is_free = fixed[j] >= LAG_START_FREE;
    switch (round) {
    case ASIDE_LOOSE: return is_free && j < n && fixed[n + j] == LAG_START_LOOSE;
    case ASIDE_PLACES: return is_free && j < n;
    case ASIDE_FREE: return is_free;
    case ASIDE_GUESSED_PLACES: return j < n;
    default: return 1;
    }
}

/* Moves the guess x to where all equations are finite, the values that these speak of alone; leaves it where there is no such place. */
static void step_aside(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    const int n = lag_start_size(s->model), widths = (int)(sizeof STEPS_ASIDE / sizeof *STEPS_ASIDE);
    copy(s, x, s->kept);
    lag_newton_evaluate(&s->newton, p, x, work);
    if (are_finite(s))
        return;
    for (int j = 0; j < 2 * n; ++j) {
        const double like = is_angle(s, j % n) ? 0 : largest_like(s, j < n ? x : x + n, j % n);
        s->lean[j] = fixed[j] == LAG_START_FIXED || !is_lost(s, j) ? 0 : like > 0 ? like : 1;
    }
    for (int round = 0; round < ASIDE_ROUNDS; ++round) {
        int moves = 0;
        for (int j = 0; j < 2 * n; ++j)
            moves |= s->lean[j] > 0 && steps_aside(fixed, n, j, round);
        for (int turn = 1; moves && turn <= MOST_ASIDE; ++turn) {
            const double width = STEPS_ASIDE[turn % widths];
            for (int j = 0; j < 2 * n; ++j)
                x[j] += steps_aside(fixed, n, j, round) ? width * s->lean[j] * all_ways(j, turn) : 0;
            if (lag_newton_evaluate(&s->newton, p, x, work) == 0 && are_finite(s))
                return;
            copy(s, s->kept, x);
        }
    }
}

/* Goes from a solution x to the one nearest to the guess. */
static void approach(LagAssembly *s, const double *p, double *x, double *work)
{
    LagNewton *newton = &s->newton;
    const int moved = lag_newton_distance2(newton, s->guess, x) > 0;
    for (int i = 0; moved && i < MOST_LEANS && lag_newton_lean(newton, s->guess, x) > CLOSE; ++i) {
        const double before = lag_newton_distance2(newton, s->guess, x);
        int nearer = 0;
        copy(s, newton->step, s->lean);
        copy(s, x, s->kept);
        for (double part = 1; part > SHORTEST_LEAN && !nearer; part /= 2) {
            for (int j = 0; j < 2 * lag_start_size(s->model); ++j)
                x[j] = s->kept[j] + part * s->lean[j];
            nearer = lag_newton_solve(newton, p, MOST_RETURNS, 0, x, work) < 0
                && lag_newton_distance2(newton, s->guess, x) < (1 - FALL) * before;
        }
        if (!nearer) {
            copy(s, s->kept, x);
            lag_newton_evaluate(newton, p, x, work);
            return;
        }
    }
}

/* Moves what is as free as `least`, all else held, at last block by block. Returns 1 when that is enough; 0 where all or nothing may
 * move; what the blocks reached is `kept`. */
static int follow_by(LagAssembly *s, const double *p, const int *fixed, int least, int way, double *x, double *work)
{
    LagNewton *newton = &s->newton;
    double *scale = s->lean;
    int free = 0, others = 0;
    copy(s, newton->scale, scale);
    copy(s, x, s->kept);
    for (int j = 0; j < 2 * lag_start_size(s->model); ++j) {
        const int is_free = fixed[j] >= least;
        free |= is_free && scale[j] > 0;
        others |= !is_free && scale[j] > 0;
        newton->scale[j] = is_free ? scale[j] : 0;
    }
    int worst = 0;
    if (free && others) {
        lag_newton_measure(newton, p, fixed, x, way, work);
        worst = lag_newton_solve(newton, p, MOST_RETURNS, 0, x, work);
        if (worst >= 0 && lag_blocks_find(&s->blocks, newton) > 1
            && lag_blocks_solve(&s->blocks, newton, p, fixed, way, MOST_RETURNS, 0, s->kept, work) < 0) {
            copy(s, s->kept, x);
            worst = -1;
        }
    }
    copy(s, scale, newton->scale);
    return worst < 0;
}

/* Moves what nobody guessed, the guesses held: first what moves no mass, which alone would follow if the other's mass were huge. */
static int follow(LagAssembly *s, const double *p, const int *fixed, int way, double *x, double *work)
{
    if (follow_by(s, p, fixed, LAG_START_LOOSE, way, x, work))
        return 1;
    copy(s, s->found, x);
    return follow_by(s, p, fixed, LAG_START_FREE, way, x, work);
}

/* Whether a guess is among what may move: elsewhere there may be a place nearer to it than where blocks lead. */
static int guesses_move(const LagAssembly *s, const int *fixed)
{
    for (int j = 0; j < 2 * lag_start_size(s->model); ++j)
        if (fixed[j] == LAG_START_GUESS && s->newton.scale[j] > 0)
            return 1;
    return 0;
}

/* The first `active` equations, and the unknowns first .. last-1 that may move. */
static void choose(LagAssembly *s, const int *fixed, int active, int first, int last)
{
    for (int i = 0; i < s->model->n_initial; ++i)
        s->newton.active[i] = i < active;
    for (int j = 0; j < 2 * lag_start_size(s->model); ++j)
        s->newton.scale[j] = j < first || j >= last || fixed[j] == LAG_START_FIXED ? 0 : s->reach[j];
}

/* Satisfies all equations by what nobody guessed: rates, or where these do not do, positions as well. Returns 1 when that is enough. */
static int follow_guesses(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    const int n = lag_start_size(s->model);
    copy(s, x, s->best);
    for (int first = n; first >= 0; first -= n) {
        choose(s, fixed, s->model->n_initial, first, 2 * n);
        copy(s, x, s->found);
        if (follow(s, p, fixed, first > 0 ? LAG_METRIC_MASS : LAG_METRIC_UNITS, x, work))
            return 1;
        copy(s, s->best, x);
    }
    return 0;
}

/* Satisfies the first `active` equations by moving the unknowns first .. last-1 from x, measured in the ways from `way` on: not from
 * the first one when it is one place of many where a solution is looked for. Returns -1, or the worst equation. */
static int solve(LagAssembly *s, const double *p, const int *fixed, int active, int first, int last, int way, double *x,
                 double *work)
{
    const int is_search = way > 0, iterations = is_search ? FEW_ITERATIONS : MOST_ITERATIONS, pushes = is_search ? 0 : MOST_PUSHES;
    LagNewton *newton = &s->newton;
    choose(s, fixed, active, first, last);
    copy(s, x, s->found);
    if (follow(s, p, fixed, first > 0 ? LAG_METRIC_MASS : LAG_METRIC_UNITS, x, work))
        return -1;
    copy(s, s->kept, s->apart);
    copy(s, first > 0 ? s->found : x, first > 0 ? x : s->found);
    int worst = 0;
    for (int next = way; next < LAG_METRIC_WAYS && worst >= 0; ++next) {
        copy(s, s->found, x);
        lag_newton_measure(newton, p, fixed, first == 0 ? s->guess : x, next, work);
        worst = lag_newton_solve(newton, p, iterations, pushes, x, work);
    }
    for (int next = way; next < LAG_METRIC_WAYS && worst >= 0 && !guesses_move(s, fixed) && lag_blocks_find(&s->blocks, newton) > 1;
         ++next) {
        copy(s, s->apart, x);
        worst = lag_blocks_solve(&s->blocks, newton, p, fixed, next, iterations, pushes, x, work);
        lag_newton_measure(newton, p, fixed, first == 0 ? s->guess : x, next, work);
    }
    if (worst < 0)
        approach(s, p, x, work);
    return worst;
}

/* The number of independent equations of positions at x, their gradients compared with those at a general position. */
static int rank_at(LagAssembly *s, const double *p, const double *x, double *work)
{
    const int n = lag_start_size(s->model), positions = s->model->n_initial_positions;
    LagNewton *newton = &s->newton;
    if (lag_newton_evaluate(newton, p, x, work) != 0)
        return 0;
    lag_newton_begin_matrix(newton, n, positions);
    for (int i = 0; i < positions; ++i) {
        const double length = newton->general_length[i];
        for (int k = newton->first[i]; k < newton->first[i + 1]; ++k)
            if (length > 0 && newton->values[k] < n)
                lag_newton_put(newton, newton->values[k], i, newton->jacobian[k] * s->reach[newton->values[k]] / length);
    }
    return lag_newton_factor(newton, positions, SINGULAR);
}

static int holds(const int *fixed, int n, int kind)
{
    for (int j = 0; j < n; ++j)
        if (fixed[j] == kind)
            return 1;
    return 0;
}

/* Whether the positions are no longer the guesses, and some of them could be guessed otherwise. */
static int is_open(const LagAssembly *s, const int *fixed, const double *x)
{
    const int n = lag_start_size(s->model);
    int moved = 0;
    for (int j = 0; j < n; ++j)
        moved |= fabs(x[j] - s->guess[j]) > MOVED * s->reach[j];
    return moved && holds(fixed, n, LAG_START_FREE);
}

/* The positions from the guesses, values that are as free as `least` elsewhere, by `width` of their sizes. Returns as solve. */
static int solve_elsewhere(LagAssembly *s, const double *p, const int *fixed, int turn, double width, int least, int way,
                           double *x, double *work)
{
    const int n = lag_start_size(s->model);
    copy(s, s->guess, x);
    for (int j = 0; j < n; ++j) {
        const double place = turn <= MOST_SEARCHES ? spread(j, turn) : all_ways(j, turn);
        x[j] += fixed[j] != LAG_START_FIXED && fixed[j] >= least ? width * s->reach[j] * place : 0;
    }
    return solve(s, p, fixed, s->model->n_initial_positions, 0, n, way, x, work);
}

/* From a singular assembly to a regular one, if there is one that the guesses do not speak against. */
static void prefer_regular(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    const int positions = s->model->n_initial_positions, rank = is_open(s, fixed, x) ? rank_at(s, p, x, work) : positions;
    copy(s, x, s->best);
    for (int turn = 1; rank < positions && turn <= MOST_TRIES; ++turn) {
        if (solve_elsewhere(s, p, fixed, turn, SPREAD, LAG_START_FREE, 0, x, work) < 0 && rank_at(s, p, x, work) > rank)
            return;
        copy(s, s->best, x);
    }
}

/* How far guesses are missed, by the largest of all. */
static double missed(const LagAssembly *s, const int *fixed, const double *x)
{
    double largest = 0;
    for (int j = 0; j < lag_start_size(s->model); ++j)
        if (fixed[j] == LAG_START_GUESS)
            largest = fmax(largest, fabs(x[j] - s->guess[j]) / s->reach[j]);
    return largest;
}

/* Whether a place is tried; the last ones where nothing was found at all. */
static int is_tried(const LagAssembly *s, const int *fixed, int turn, double nearest)
{
    const int n = lag_start_size(s->model);
    if (turn > MOST_SEARCHES)
        return isinf(nearest);
    return nearest > NEAR && holds(fixed, n, turn <= FREE_SEARCHES ? LAG_START_FREE : LAG_START_GUESS);
}

/* Positions where they do not follow from the guesses: what nobody guessed is tried elsewhere, at last all that is not fixed. The
 * first solution near the guesses is taken, else the nearest. Returns 1 when there is one; in large scenes nothing is tried. */
static int search(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    double nearest = INFINITY;
    copy(s, x, s->best);
    for (int turn = 1; turn <= LAST_SEARCHES && lag_start_size(s->model) < MANY; ++turn) {
        if (!is_tried(s, fixed, turn, nearest))
            continue;
        const int least = turn <= FREE_SEARCHES ? LAG_START_FREE : LAG_START_GUESS;
        const int is_solved = solve_elsewhere(s, p, fixed, turn, WIDE_SPREAD, least, LAG_METRIC_EVEN, x, work) < 0;
        if (is_solved && missed(s, fixed, x) < nearest) {
            nearest = missed(s, fixed, x);
            copy(s, x, s->best);
        }
    }
    copy(s, s->best, x);
    return nearest < INFINITY;
}

/* Rates that nobody guessed are tried elsewhere, from the positions and rates in `best`, where there are equations for all of
 * them: which direction is meant by fewer, nobody could say. Returns 1 when that is enough. */
static int search_rates(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    const int n = lag_start_size(s->model), equations = s->model->n_initial - s->model->n_initial_positions;
    int open = 0;
    for (int j = n; j < 2 * n; ++j)
        open += fixed[j] >= LAG_START_FREE;
    for (int turn = 1; turn <= FREE_SEARCHES && n < MANY && open > 0 && open <= equations; ++turn) {
        copy(s, s->best, x);
        for (int j = n; j < 2 * n; ++j)
            x[j] += fixed[j] >= LAG_START_FREE ? WIDE_SPREAD * s->reach[j] * all_ways(j, turn) : 0;
        if (solve(s, p, fixed, s->model->n_initial, n, 2 * n, LAG_METRIC_EVEN, x, work) < 0)
            return 1;
    }
    return 0;
}

/* Rates where the positions are are mostly a linear matter, though not those of an energy, whose slopes vanish where they do; all
 * together only when that does not do: rates that are given, and an equation that ties them to positions. Returns as lag_assemble. */
static int assemble(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    const int n = lag_start_size(s->model), all = s->model->n_initial, positions = s->model->n_initial_positions;
    step_aside(s, p, fixed, x, work);
    copy(s, x, s->guess);
    set_reach(s, p, x, work);
    if (positions > 0) {
        const int worst = solve(s, p, fixed, positions, 0, n, 0, x, work);
        if (worst >= 0 && !search(s, p, fixed, x, work))
            return worst;
        prefer_regular(s, p, fixed, x, work);
        if (positions == all)
            return -1;
    } else if (follow_guesses(s, p, fixed, x, work)) {
        return -1;
    }
    copy(s, x, s->best);
    if (solve(s, p, fixed, all, n, 2 * n, 0, x, work) < 0)
        return -1;
    if (search_rates(s, p, fixed, x, work))
        return -1;
    copy(s, s->best, x);
    if (solve(s, p, fixed, all, 0, 2 * n, 0, x, work) < 0)
        return -1;
    copy(s, s->best, x); /* positions close: what fails are rates */
    return solve(s, p, fixed, all, n, 2 * n, 0, x, work);
}

int lag_assemble(LagAssembly *s, const double *p, const int *fixed, double *x, double *work)
{
    if (lag_known_start_recall(&s->known, s->model, p, s->newton.u, fixed, x))
        return -1;
    const int worst = assemble(s, p, fixed, x, work);
    if (worst < 0)
        lag_known_start_keep(&s->known, s->model, x);
    return worst;
}
