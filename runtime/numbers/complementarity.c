/* All states are tried, one after the other, where they are few enough: sizes are those of what touches at one moment. Before that, and
 * where they are more, what is most wrong is changed, one at a time.
 */
#include "numbers/complementarity.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"

enum { MOST_STATES = 100000, MOST_CHANGES = 4 }; /* of all that is tried; in a walk, by the number of forces */
static const double RIGHT = 1e-12, NEARLY_RIGHT = 1e-9; /* what is missing of a solution, by its terms */
static const double DEPENDENT[] = {1e-9, LAG_DEPENDENT}; /* pivots of those that hold the same; of what only looks so */

void lag_complementarity_layout(LagComplementarity *p, int most, LagArena *arena)
{
    const size_t n = (size_t)most;
    p->size = most;
    p->kind = lag_take_ints(arena, n);
    p->state = lag_take_ints(arena, n);
    p->rate = lag_take(arena, n);
    p->jump = lag_take(arena, n * n);
    p->own = lag_take(arena, n);
    p->press = lag_take(arena, n * n);
    p->terms = lag_take(arena, n);
    p->force = lag_take(arena, n);
    p->change = lag_take(arena, n);
    lag_dense_lu_layout(&p->lu, most, 0, arena);
}

void lag_complementarity_begin(LagComplementarity *p, int size)
{
    const size_t n = (size_t)size;
    p->size = size;
    memset(p->own, 0, n * sizeof *p->own);
    memset(p->press, 0, n * n * sizeof *p->press);
    memset(p->terms, 0, n * sizeof *p->terms);
}

double lag_complementarity_limit(const LagComplementarity *p, int i)
{
    double limit = p->own[i];
    if (p->kind[i] != LAG_RUBS)
        return INFINITY;
    for (int j = 0; j < p->size; ++j)
        if (p->kind[j] == LAG_PUSHES)
            limit += p->press[i + j * p->size] * p->force[j];
    return limit;
}

/* What a force x_j of one that holds does to w_i, with the friction that it raises. */
static double effect(const LagComplementarity *p, int i, int j)
{
    double by = p->jump[i + j * p->size];
    for (int k = 0; k < p->size && p->kind[j] == LAG_PUSHES; ++k)
        if (p->state[k] == LAG_ALL)
            by += p->jump[i + k * p->size] * p->press[k + j * p->size];
    return by;
}

/* w_i without those that hold. */
static double rate_without(const LagComplementarity *p, int i)
{
    double rate = p->rate[i];
    for (int k = 0; k < p->size; ++k)
        if (p->state[k] == LAG_ALL)
            rate += p->jump[i + k * p->size] * p->own[k];
    return rate;
}

void lag_complementarity_find_forces(LagComplementarity *p)
{
    const int n = p->size;
    int free = 0, row = 0;
    p->lu.apart = 0;
    for (int i = 0; i < n; ++i) {
        free += p->state[i] == LAG_HOLDS;
        p->lu.apart += p->state[i] == LAG_HOLDS && p->kind[i] != LAG_RUBS;
    }
    p->lu.size = free;
    for (int i = 0; i < n; ++i) {
        if (p->state[i] != LAG_HOLDS)
            continue;
        p->change[row] = -rate_without(p, i);
        for (int j = 0, column = 0; j < n; ++j)
            if (p->state[j] == LAG_HOLDS)
                p->lu.re[row + free * column++] = effect(p, i, j);
        ++row;
    }
    lag_dense_lu_factor(&p->lu);
    lag_dense_lu_solve(&p->lu, p->change, NULL);
    row = 0;
    for (int i = 0; i < n; ++i)
        p->force[i] = p->state[i] == LAG_HOLDS ? p->change[row++] : 0;
    for (int i = 0; i < n; ++i)
        p->force[i] = p->state[i] == LAG_ALL ? lag_complementarity_limit(p, i) : p->force[i];
}

void lag_complementarity_find_balance(LagComplementarity *p, double *rate)
{
    p->lu.size = p->size;
    p->lu.apart = 0;
    memcpy(p->lu.re, p->jump, (size_t)p->size * (size_t)p->size * sizeof *p->jump);
    for (int i = 0; i < p->size; ++i)
        rate[i] = -rate[i];
    lag_dense_lu_factor(&p->lu);
    lag_dense_lu_solve(&p->lu, rate, NULL);
}

/* How far state i is from being right, by the terms of w_i; not finite where there are no forces. `better`: what it should be. */
static double wrong(const LagComplementarity *p, int i, int *better)
{
    double rate = p->rate[i], terms = fabs(rate) + p->terms[i];
    const double limit = lag_complementarity_limit(p, i), own = fabs(p->jump[i + i * p->size]);
    for (int j = 0; j < p->size; ++j) {
        rate += p->jump[i + j * p->size] * p->force[j];
        terms += fabs(p->jump[i + j * p->size] * p->force[j]);
    }
    const double missing = p->kind[i] == LAG_BINDS ? 0 : -p->force[i] * own, excess = (p->force[i] - limit) * own;
    *better = LAG_HOLDS;
    if (p->state[i] == LAG_NONE)
        return limit > 0 && rate > 0 ? rate / terms : 0;
    if (p->state[i] == LAG_ALL)
        return limit > 0 && rate < 0 ? -rate / terms : 0;
    *better = excess > missing ? LAG_ALL : LAG_NONE;
    return terms > 0 ? lag_max(fabs(rate), lag_max(missing, excess)) / terms : rate;
}

/* The forces of these states, and what is most wrong with them. `worst`: which, `better`: its state instead. */
static double try_states(LagComplementarity *p, int *worst, int *better)
{
    double most = 0;
    lag_complementarity_find_forces(p);
    for (int i = 0; i < p->size; ++i) {
        int instead;
        const double here = wrong(p, i, &instead);
        if (!(here <= most)) {
            most = here;
            *worst = i;
            *better = instead;
        }
    }
    return most;
}

/* From all that hold. Returns whether it ends at a solution. */
static int walk(LagComplementarity *p)
{
    int worst = 0, better = LAG_HOLDS;
    for (int i = 0; i < p->size; ++i)
        p->state[i] = LAG_HOLDS;
    for (int turn = 0; turn <= MOST_CHANGES * p->size; ++turn) {
        const double here = try_states(p, &worst, &better);
        if (here <= RIGHT)
            return 1;
        if (p->kind[worst] == LAG_BINDS || !(here < INFINITY))
            return 0;
        p->state[worst] = better;
    }
    return 0;
}

/* The next states, the last force first. Returns 0 after the last ones. */
static int advance(LagComplementarity *p)
{
    for (int i = p->size - 1; i >= 0; --i) {
        const int last = p->kind[i] == LAG_BINDS ? LAG_HOLDS : p->kind[i] == LAG_PUSHES ? LAG_NONE : LAG_ALL;
        if (p->state[i] < last) {
            ++p->state[i];
            return 1;
        }
        p->state[i] = LAG_HOLDS;
    }
    return 0;
}

/* Whether something rubs that nothing presses: its states are all the same. */
static int is_idle(const LagComplementarity *p, int i)
{
    double limit = p->own[i];
    for (int j = 0; j < p->size; ++j)
        if (p->kind[j] == LAG_PUSHES && p->state[j] == LAG_HOLDS)
            limit += p->press[i + j * p->size];
    return p->kind[i] == LAG_RUBS && !(limit > 0) && p->state[i] != LAG_NONE;
}

/* The first of all states that are right but for `enough`. */
static int search(LagComplementarity *p, double enough)
{
    int worst, better, turn = 0;
    for (int i = 0; i < p->size; ++i)
        p->state[i] = LAG_HOLDS;
    do {
        int idle = 0;
        for (int i = 0; i < p->size; ++i)
            idle |= is_idle(p, i);
        if (!idle && try_states(p, &worst, &better) <= enough)
            return 1;
    } while (++turn < MOST_STATES && advance(p));
    return 0;
}

int lag_complementarity_solve(LagComplementarity *p)
{
    for (int k = 0; k < 2; ++k) {
        p->lu.dependent = DEPENDENT[k];
        if (walk(p) || search(p, RIGHT))
            return 1;
    }
    return search(p, NEARLY_RIGHT);
}
