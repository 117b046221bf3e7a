/* A row of many loops closes loop by loop: all together are cut as the worst one is, and halved until the sum of all falls.
 *
 * A block takes the equation with the fewest values that no block before it owns; these it owns, and with it go all equations
 * that speak of nothing else. Where those are more than its values, it grows by the next equation. So an equation speaks of values
 * of its own block and of earlier ones alone (a block triangular form): what has been solved stays solved.
 */
#include "start/blocks.h"

#include <string.h>

void lag_blocks_layout(LagBlocks *s, const LagModel *model, LagArena *arena)
{
    const size_t equations = (size_t)model->n_initial, unknowns = equations > 0 ? 2 * (size_t)lag_start_size(model) : 0;
    s->block = (int *)lag_take(arena, equations);
    s->owner = (int *)lag_take(arena, unknowns);
    s->open = lag_take_ints(arena, equations);
    s->moved = lag_take_ints(arena, equations);
    s->first = lag_take_ints(arena, unknowns + 1);
    s->equations = lag_take_ints(arena, equations > 0 ? (size_t)model->initial_pattern[equations] : 0);
    s->scale = lag_take(arena, unknowns);
}

/* Whether an equation speaks of a value that may move, by its slope k at the general position. */
static int speaks(const LagNewton *newton, int k) { return newton->scale[newton->values[k]] > 0 && newton->general[k] != 0; }

/* Fills `open` and `moved` while nobody owns anything. */
static void count_values(LagBlocks *s, const LagNewton *newton)
{
    for (int i = 0; i < newton->model->n_initial; ++i) {
        s->open[i] = 0;
        for (int k = newton->first[i]; k < newton->first[i + 1]; ++k)
            s->open[i] += speaks(newton, k);
        s->moved[i] = s->open[i] > 0;
    }
}

/* Which equations speak of a value. */
static void list_equations(LagBlocks *s, const LagNewton *newton)
{
    const int equations = newton->model->n_initial, unknowns = 2 * lag_start_size(newton->model);
    int *next = s->first + 1; /* of each value; in the end that of the one behind it */
    memset(s->first, 0, ((size_t)unknowns + 1) * sizeof *s->first);
    for (int k = 0; k < newton->first[equations]; ++k)
        next[newton->values[k]] += speaks(newton, k);
    for (int j = 0, before = 0; j < unknowns; ++j) {
        const int count = next[j];
        next[j] = before;
        before += count;
    }
    for (int i = 0; i < equations; ++i)
        for (int k = newton->first[i]; k < newton->first[i + 1]; ++k)
            if (speaks(newton, k))
                s->equations[next[newton->values[k]]++] = i;
}

/* The equation without a block that speaks of the fewest values that nobody owns; -1 where all have one. */
static int next_equation(const LagBlocks *s, const LagNewton *newton)
{
    int next = -1;
    for (int i = 0; i < newton->model->n_initial; ++i)
        if (newton->active[i] && s->block[i] < 0 && (next < 0 || s->open[i] < s->open[next]))
            next = i;
    return next;
}

/* Gives the block the values of equation i that nobody owns. Returns their number. */
static int take_values(LagBlocks *s, const LagNewton *newton, int i)
{
    int count = 0;
    for (int k = newton->first[i]; k < newton->first[i + 1]; ++k) {
        const int j = newton->values[k];
        if (!speaks(newton, k) || s->owner[j] >= 0)
            continue;
        s->owner[j] = s->count;
        ++count;
        for (int e = s->first[j]; e < s->first[j + 1]; ++e)
            --s->open[s->equations[e]];
    }
    return count;
}

/* Gives the block all equations that speak of owned values alone. Returns the number of those that anything moves. */
static int take_equations(LagBlocks *s, const LagNewton *newton)
{
    int count = 0;
    for (int i = 0; i < newton->model->n_initial; ++i) {
        if (!newton->active[i] || s->block[i] >= 0 || s->open[i] > 0)
            continue;
        s->block[i] = s->count;
        count += s->moved[i];
    }
    return count;
}

int lag_blocks_find(LagBlocks *s, const LagNewton *newton)
{
    int values = 0, equations = 0;
    s->count = 0;
    for (int i = 0; i < newton->model->n_initial; ++i)
        s->block[i] = -1;
    for (int j = 0; j < 2 * lag_start_size(newton->model); ++j)
        s->owner[j] = -1;
    count_values(s, newton);
    list_equations(s, newton);
    for (int i = next_equation(s, newton); i >= 0; i = next_equation(s, newton)) {
        values += take_values(s, newton, i);
        equations += take_equations(s, newton);
        if (equations > values)
            continue;
        ++s->count;
        values = equations = 0;
    }
    s->count += equations > 0;
    return s->count;
}

/* The equations and values of a block alone. */
static void choose(const LagBlocks *s, LagNewton *newton, int block)
{
    for (int i = 0; i < newton->model->n_initial; ++i)
        newton->active[i] = s->block[i] == block;
    for (int j = 0; j < 2 * lag_start_size(newton->model); ++j)
        newton->scale[j] = s->owner[j] == block ? s->scale[j] : 0;
}

int lag_blocks_solve(LagBlocks *s, LagNewton *newton, const double *p, const int *fixed, int way, int most_iterations,
                     int most_pushes, double *x, double *work)
{
    const size_t size = 2 * (size_t)lag_start_size(newton->model) * sizeof *s->scale;
    int failed = -1;
    memcpy(s->scale, newton->scale, size);
    for (int block = 0; block < s->count; ++block) {
        choose(s, newton, block);
        lag_newton_measure(newton, p, fixed, x, way, work);
        const int worst = lag_newton_solve(newton, p, most_iterations, most_pushes, x, work);
        failed = failed < 0 ? worst : failed;
    }
    for (int i = 0; i < newton->model->n_initial; ++i)
        newton->active[i] = s->block[i] >= 0;
    memcpy(newton->scale, s->scale, size);
    if (failed >= 0)
        return failed;
    lag_newton_measure(newton, p, fixed, x, way, work);
    return lag_newton_solve(newton, p, most_iterations, 0, x, work);
}
