#include "model/history.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "numbers/extremes.h"

enum { LAST = LAG_HISTORY_NODES - 1, HEAD = 2, MARK = 2, FIRST_ROOM = 64 };

static const double ROUNDING = 1e-9; /* of times */

/* cos(k pi / LAST) */
static const double COSINES[2 * LAST] = {
    1, 0.9396926207859084, 0.766044443118978, 0.5, 0.17364817766693036, -0.17364817766693036, -0.5, -0.766044443118978,
    -0.9396926207859084, -1, -0.9396926207859084, -0.766044443118978, -0.5, -0.17364817766693036, 0.17364817766693036, 0.5,
    0.766044443118978, 0.9396926207859084};

static size_t stride(const LagHistory *h) { return HEAD + (size_t)h->n * LAG_HISTORY_NODES; }

static double *piece(const LagHistory *h, size_t k) { return h->pieces + (h->first + k) * stride(h); }

void lag_history_layout(LagHistory *h, int n, LagArena *arena)
{
    h->n = n;
    h->lag = lag_take(arena, (size_t)n);
    h->low = lag_take(arena, (size_t)n);
    h->high = lag_take(arena, (size_t)n);
    h->largest = lag_take(arena, (size_t)n);
    h->shortest = h->due = INFINITY;
}

void lag_history_free(LagHistory *h)
{
    free(h->pieces);
    free(h->marks);
}

void lag_history_clear(LagHistory *h, double t)
{
    h->first = h->count = h->n_marks = 0;
    h->is_out_of_memory = 0;
    h->known = t;
    h->due = h->shortest = INFINITY;
    h->longest = 0;
    for (int k = 0; k < h->n; ++k) {
        h->shortest = lag_min(h->shortest, h->lag[k]);
        h->longest = lag_max(h->longest, h->lag[k]);
        h->low[k] = -INFINITY;
        h->high[k] = INFINITY;
        h->largest[k] = 0;
    }
}

/* -------- pieces */

double lag_history_node(double begin, double end, int k)
{
    return k == 0 ? end : k == LAST ? begin : (begin + end) / 2 + (end - begin) / 2 * COSINES[k];
}

/* Chebyshev coefficients. */
static void fit(const double *f, double *c)
{
    for (int k = 0; k <= LAST; ++k) {
        double sum = (f[0] + f[LAST] * COSINES[k * LAST % (2 * LAST)]) / 2;
        for (int j = 1; j < LAST; ++j)
            sum += f[j] * COSINES[k * j % (2 * LAST)];
        c[k] = sum / (k == 0 || k == LAST ? LAST : LAST / 2.0);
    }
}

double lag_history_error(const double *values)
{
    double c[LAG_HISTORY_NODES];
    fit(values, c);
    return fabs(c[LAST]) + fabs(c[LAST - 1]);
}

/* Room for one more behind `used` of them, which are moved to the front where half is free there. */
static int make_room(double **place, size_t *first, size_t count, size_t *capacity, size_t width)
{
    if (*first + count < *capacity)
        return 1;
    if (*first > count) {
        memmove(*place, *place + *first * width, count * width * sizeof **place);
        *first = 0;
        return 1;
    }
    const size_t wanted = *capacity > 0 ? 2 * *capacity : FIRST_ROOM;
    double *grown = realloc(*place, wanted * width * sizeof **place);
    if (!grown)
        return 0;
    *place = grown;
    *capacity = wanted;
    return 1;
}

void lag_history_append(LagHistory *h, double end, const double *values)
{
    if (!make_room(&h->pieces, &h->first, h->count, &h->capacity, stride(h))) {
        h->is_out_of_memory = 1;
        return;
    }
    double *now = piece(h, h->count);
    now[0] = h->known;
    now[1] = end;
    memcpy(now + HEAD, values, (stride(h) - HEAD) * sizeof *now);
    ++h->count;
    h->known = end;
}

void lag_history_cut(LagHistory *h, double t)
{
    while (h->count > 1 && piece(h, h->count - 1)[0] >= t)
        --h->count;
    while (h->n_marks > 0 && h->marks[MARK * (h->n_marks - 1)] > t)
        --h->n_marks;
    h->known = lag_min(h->known, t);
}

void lag_history_drop(LagHistory *h, double t)
{
    const double oldest = t - h->longest - ROUNDING * (fabs(t) + h->longest);
    size_t gone = 0;
    while (h->count > 1 && piece(h, 0)[1] < oldest) {
        ++h->first;
        --h->count;
    }
    while (gone < h->n_marks && h->marks[MARK * gone] < oldest)
        ++gone;
    h->n_marks -= gone;
    if (gone > 0)
        memmove(h->marks, h->marks + MARK * gone, MARK * h->n_marks * sizeof *h->marks);
}

/* -------- breaks */

void lag_history_mark(LagHistory *h, double t, int order)
{
    size_t none = 0;
    if (h->n_marks > 0 && h->marks[MARK * (h->n_marks - 1)] == t) {
        h->marks[MARK * h->n_marks - 1] = lag_min(order, h->marks[MARK * h->n_marks - 1]);
        return;
    }
    if (!make_room(&h->marks, &none, h->n_marks, &h->mark_capacity, MARK)) {
        h->is_out_of_memory = 1;
        return;
    }
    h->marks[MARK * h->n_marks] = t;
    h->marks[MARK * h->n_marks + 1] = order;
    ++h->n_marks;
}

void lag_history_enter(LagHistory *h, double t, double resolution)
{
    h->due = INFINITY;
    h->due_order = 0;
    for (int k = 0; k < h->n; ++k) {
        const double from = t - h->lag[k];
        h->low[k] = -INFINITY;
        h->high[k] = INFINITY;
        for (size_t i = 0; i < h->n_marks && h->high[k] == INFINITY; ++i) {
            const double at = h->marks[MARK * i], back = at + h->lag[k];
            const int order = (int)h->marks[MARK * i + 1];
            if (at <= from + resolution)
                h->low[k] = at;
            else
                h->high[k] = at;
            if (at > from + resolution && back <= h->due + resolution) {
                h->due_order = back < h->due - resolution || order < h->due_order ? order : h->due_order;
                h->due = lag_min(back, h->due);
            }
        }
    }
}

/* -------- values */

/* The piece in which a time lies; of two that meet there the later one, or the one before where it is the end of a stretch. */
static const double *find(const LagHistory *h, double s, int is_end)
{
    size_t low = 0, high = h->count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        const double begin = piece(h, middle)[0];
        if (begin < s || (begin == s && !is_end))
            low = middle;
        else
            high = middle;
    }
    return piece(h, low);
}

/* By the barycentric formula (J.-P. Berrut, L.N. Trefethen, 2004), as a difference from the value at the beginning: what sets in there
 * out of nothing has no rounding but its own. `from`: the time since the beginning, in halves of the length. */
static double value_at(const double *f, double from)
{
    double above = 0, below = 0;
    for (int j = 0; j <= LAST; ++j) {
        const double off = j == LAST ? from : from - (1 + COSINES[j]);
        if (off == 0)
            return f[j];
        const double weight = (j % 2 ? -1 : 1) * (j == 0 || j == LAST ? 0.5 : 1) / off;
        above += weight * (f[j] - f[LAST]);
        below += weight;
    }
    return f[LAST] + above / below;
}

/* C.W. Clenshaw, 1955. */
static double sum_of(const double *c, int last, double x)
{
    double a = 0, b = 0;
    for (int k = last; k > 0; --k) {
        const double next = c[k] + 2 * x * a - b;
        b = a;
        a = next;
    }
    return c[0] + x * a - b;
}

static const double *at(const LagHistory *h, int k, double t, double *s)
{
    *s = lag_min(t - h->lag[k], h->known);
    const int is_end = *s >= h->high[k];
    *s = is_end ? h->high[k] : lag_max(*s, h->low[k]);
    return find(h, *s, is_end);
}

void lag_history_at(const LagHistory *h, double t, double *values)
{
    for (int k = 0; k < h->n; ++k) {
        double s;
        const double *now = h->count > 0 ? at(h, k, t, &s) : NULL;
        const double from = now ? 2 * (s - now[0]) / (now[1] - now[0]) : 0;
        values[k] = now ? value_at(now + HEAD + k * LAG_HISTORY_NODES, lag_min(lag_max(from, 0), 2)) : 0;
    }
}

void lag_history_rates(const LagHistory *h, double t, double *rates)
{
    for (int k = 0; k < h->n; ++k) {
        double s, c[LAG_HISTORY_NODES], slopes[LAG_HISTORY_NODES + 1] = {0};
        const double *now = h->count > 0 ? at(h, k, t, &s) : NULL;
        rates[k] = 0;
        if (!now)
            continue;
        fit(now + HEAD + k * LAG_HISTORY_NODES, c);
        for (int i = LAST; i > 0; --i)
            slopes[i - 1] = (i + 1 <= LAST ? slopes[i + 1] : 0) + 2 * i * c[i];
        slopes[0] /= 2;
        rates[k] = sum_of(slopes, LAST - 1, (2 * s - now[0] - now[1]) / (now[1] - now[0])) * 2 / (now[1] - now[0]);
    }
}

/* -------- as numbers */

size_t lag_history_size(const LagHistory *h) { return h->n > 0 ? h->count * stride(h) + MARK * h->n_marks : 0; }

void lag_history_save(const LagHistory *h, void *place)
{
    const size_t size = h->n > 0 ? h->count * stride(h) * sizeof *h->pieces : 0;
    if (size > 0)
        memcpy(place, piece(h, 0), size);
    if (h->n_marks > 0)
        memcpy((unsigned char *)place + size, h->marks, MARK * h->n_marks * sizeof *h->marks);
}

int lag_history_load(LagHistory *h, const LagHistory *saved, const void *place)
{
    const size_t size = saved->count * stride(h), marks = MARK * saved->n_marks;
    double *pieces = size > 0 ? malloc(size * sizeof *pieces) : NULL, *times = marks > 0 ? malloc(marks * sizeof *times) : NULL;
    if ((size > 0 && !pieces) || (marks > 0 && !times)) {
        free(pieces);
        free(times);
        return 0;
    }
    if (size > 0)
        memcpy(pieces, place, size * sizeof *pieces);
    if (marks > 0)
        memcpy(times, (const unsigned char *)place + size * sizeof *pieces, marks * sizeof *times);
    lag_history_free(h);
    h->pieces = pieces;
    h->marks = times;
    h->first = 0;
    h->capacity = h->count = saved->count;
    h->mark_capacity = h->n_marks = saved->n_marks;
    return 1;
}
