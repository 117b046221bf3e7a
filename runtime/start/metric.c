/* The distance is dx' W dx with W from M = L L' (A. L. Cholesky), the values that nobody guessed taken first: their columns of L
 * are divided by FREE. So the others are measured by the least kinetic energy that leaves these free to follow (a Schur
 * complement), and these by the little that remains. Without `momentum` L is diagonal.
 *
 * M v = momentum(q, v); values are taken in units, and M relative to its largest entry there. Where M is singular, a pivot that
 * vanishes is raised: such a value moves next to freely.
 *
 * Of many equations the blocks of M are factored each for itself, from momenta of one rate of each block at once; few keep the order of
 * their sums.
 */
#include "start/metric.h"

#include <math.h>
#include <string.h>

#include "model/function.h"

static const double FREE = 100, LEAST_PIVOT = 1e-10, NO_MASS = 1e-30;

void lag_metric_layout(LagMetric *s, LagArena *arena)
{
    const size_t n = s->model->n_initial > 0 ? (size_t)lag_start_size(s->model) : 0;
    s->factor = lag_take(arena, n * n);
    s->unit = lag_take(arena, n);
    s->column = lag_take(arena, n);
    s->rates = lag_take(arena, n);
    s->order = lag_take_ints(arena, n);
    s->first = lag_take_ints(arena, n);
    s->start = lag_take_ints(arena, n + 1);
    s->member = lag_take_ints(arena, n);
    s->part = lag_take_ints(arena, n);
    s->touched = lag_take_ints(arena, n);
    s->mark = lag_take_ints(arena, n);
}

static void choose_order(LagMetric *s, const int *fixed, const double *unit, int way)
{
    s->count = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int j = 0; j < lag_start_size(s->model); ++j)
            if (unit[j] > 0 && (fixed[j] >= LAG_START_FREE && way != LAG_METRIC_EVEN) == (pass == 0))
                s->order[s->count++] = j;
        if (pass == 0)
            s->n_free = s->count;
    }
}

static int block_of(const LagMetric *s, int j)
{
    return lag_is_long_start(s->model) && s->model->mass_blocks ? s->model->mass_blocks[j] : 0;
}

static int size_of(const LagMetric *s, int block) { return s->start[block + 1] - s->start[block]; }

static double *row_of(const LagMetric *s, int block, int t) { return s->factor + s->part[block] + t * size_of(s, block); }

/* Sorts the values that may move into blocks. */
static void list_members(LagMetric *s)
{
    const int n = lag_start_size(s->model);
    int *next = s->touched, room = 0;
    memset(s->start, 0, ((size_t)n + 1) * sizeof *s->start);
    memset(s->mark, 0, (size_t)n * sizeof *s->mark);
    s->asked = s->n_blocks = 0;
    for (int k = 0; k < s->count; ++k) {
        const int block = block_of(s, s->order[k]);
        ++s->start[block + 1];
        s->n_blocks = block >= s->n_blocks ? block + 1 : s->n_blocks;
    }
    for (int b = 0; b < s->n_blocks; ++b) {
        const int size = s->start[b + 1];
        s->start[b + 1] += s->start[b];
        next[b] = s->start[b];
        s->part[b] = room;
        room += size * size;
    }
    for (int k = 0; k < s->count; ++k)
        s->member[next[block_of(s, s->order[k])]++] = k;
}

/* The value of a member of a block. */
static int value_of(const LagMetric *s, int block, int t) { return s->order[s->member[s->start[block] + t]]; }

/* Member t of each block has a rate, all others have none: fills column t of the blocks with D M D. Returns 0 where it is no number. */
static int fill_column(LagMetric *s, const double *q, const double *p, int t, double *largest, double *work)
{
    const double *in[] = {q, s->rates, p};
    double probe = 0;
    for (int b = 0; b < s->n_blocks; ++b)
        if (t < size_of(s, b))
            s->rates[value_of(s, b, t)] = s->unit[value_of(s, b, t)];
    lag_call(&s->model->momentum, in, &s->column, work);
    for (int b = 0; b < s->n_blocks; ++b) {
        for (int i = t; i < size_of(s, b); ++i) {
            const int j = value_of(s, b, i);
            row_of(s, b, i)[t] = s->column[j] * s->unit[j];
            probe += 0 * row_of(s, b, i)[t];
        }
        if (t >= size_of(s, b))
            continue;
        *largest = fmax(*largest, row_of(s, b, t)[t]);
        s->rates[value_of(s, b, t)] = 0;
    }
    return probe == 0;
}

/* Fills the lower triangles with D M D. Returns its largest entry; 0: there is no mass, or no number. */
static double fill(LagMetric *s, const double *q, const double *p, double *work)
{
    double largest = 0;
    int columns = 0, is_number = 1;
    memset(s->rates, 0, (size_t)lag_start_size(s->model) * sizeof *s->rates);
    for (int b = 0; b < s->n_blocks; ++b)
        columns = size_of(s, b) > columns ? size_of(s, b) : columns;
    for (int t = 0; t < columns && lag_present(&s->model->momentum); ++t)
        is_number &= fill_column(s, q, p, t, &largest, work);
    return is_number ? largest : 0;
}

static void fill_with_units(LagMetric *s)
{
    for (int b = 0; b < s->n_blocks; ++b) {
        for (int t = 0; t < size_of(s, b); ++t) {
            memset(row_of(s, b, t), 0, (size_t)size_of(s, b) * sizeof *s->factor);
            row_of(s, b, t)[t] = 1;
        }
    }
}

static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; ++i)
        sum += a[i] * b[i];
    return sum;
}

static int max_int(int a, int b) { return a > b ? a : b; }

/* Row by row; a pivot is compared with what the value had before. A row of L begins where that of M does. */
static void factorise(LagMetric *s, int block, double largest)
{
    int *begins = s->first + s->start[block];
    for (int i = 0; i < size_of(s, block); ++i) {
        double *row = row_of(s, block, i);
        int first = 0;
        while (first < i && row[first] == 0)
            ++first;
        begins[i] = first;
        for (int k = first; k < i; ++k) {
            const double *other = row_of(s, block, k);
            const int begin = max_int(first, begins[k]);
            row[k] = (row[k] / largest - dot(row + begin, other + begin, max_int(k - begin, 0))) / other[k];
        }
        const double own = row[i] / largest, floor = LEAST_PIVOT * (own > NO_MASS ? own : 1);
        row[i] = sqrt(fmax(own - dot(row + first, row + first, i - first), floor));
    }
    for (int i = 0; i < size_of(s, block); ++i)
        for (int k = begins[i]; k <= i && s->member[s->start[block] + k] < s->n_free; ++k)
            row_of(s, block, i)[k] /= FREE;
}

void lag_metric_set(LagMetric *s, const double *q, const double *p, const int *fixed, const double *unit, int way,
                    double *work)
{
    memcpy(s->unit, unit, (size_t)lag_start_size(s->model) * sizeof *unit);
    choose_order(s, fixed, unit, way);
    list_members(s);
    const double largest = way == LAG_METRIC_MASS ? fill(s, q, p, work) : 0;
    if (largest == 0)
        fill_with_units(s);
    for (int b = 0; b < s->n_blocks; ++b)
        factorise(s, b, largest == 0 ? 1 : largest);
}

/* z = L^-1 D g of a block; before the first slope it is 0. Returns the number of places that are listed. */
static int solve_block(const LagMetric *s, int block, const double *g, double *z, int *places)
{
    const int *member = s->member + s->start[block], *begins = s->first + s->start[block];
    const int size = size_of(s, block);
    int first = 0;
    while (first < size && g[s->order[member[first]]] == 0)
        ++first;
    for (int i = first; i < size; ++i) {
        const double *row = row_of(s, block, i);
        const int j = s->order[member[i]];
        double sum = 0;
        for (int k = max_int(first, begins[i]); k < i; ++k)
            sum += row[k] * z[member[k]];
        z[member[i]] = (g[j] * s->unit[j] - sum) / row[i];
        places[i - first] = member[i];
    }
    return size - first;
}

int lag_metric_of_gradient(LagMetric *s, const double *g, const int *values, int n_values, double *z, int *places)
{
    int count = 0;
    ++s->asked;
    for (int k = 0; k < n_values; ++k) {
        const int block = block_of(s, values[k] - s->offset);
        if (block >= s->n_blocks || s->mark[block] == s->asked)
            continue;
        s->mark[block] = s->asked;
        count += solve_block(s, block, g, z, places + count);
    }
    return count;
}

/* dx = D L'^-1 z */
void lag_metric_to_step(const LagMetric *s, const double *z, double *dx)
{
    double *rest = s->column;
    memcpy(rest, z, (size_t)s->count * sizeof *z);
    memset(dx, 0, (size_t)lag_start_size(s->model) * sizeof *dx);
    for (int b = 0; b < s->n_blocks; ++b) {
        const int *member = s->member + s->start[b], *begins = s->first + s->start[b];
        for (int i = size_of(s, b) - 1; i >= 0; --i) {
            const double *row = row_of(s, b, i), x = rest[member[i]] / row[i];
            dx[s->order[member[i]]] = x * s->unit[s->order[member[i]]];
            for (int k = begins[i]; k < i; ++k)
                rest[member[k]] -= row[k] * x;
        }
    }
}

/* z = L' D^-1 dx */
void lag_metric_from_step(const LagMetric *s, const double *dx, double *z)
{
    memset(z, 0, (size_t)s->count * sizeof *z);
    for (int b = 0; b < s->n_blocks; ++b) {
        const int *member = s->member + s->start[b], *begins = s->first + s->start[b];
        for (int i = 0; i < size_of(s, b); ++i) {
            const double *row = row_of(s, b, i), x = dx[s->order[member[i]]] / s->unit[s->order[member[i]]];
            for (int k = begins[i]; k <= i; ++k)
                z[member[k]] += row[k] * x;
        }
    }
}
