#include "methods/linear_pace.h"

#include <string.h>

#include "numbers/extremes.h"

static const double ALLOWED = 1e-13; /* of the largest position, rate or integral, before or after LAG_PACE_STEPS steps */

void lag_pace_layout(LagPace *p, const LagLadder *ladder, LagArena *arena)
{
    p->size = ladder->size;
    p->n_forms = ladder->n_forms;
    p->stride = ladder->stride * (size_t)(1 + ladder->n_forms);
    p->columns = lag_take(arena, p->size * p->stride);
    p->x = lag_take(arena, p->size);
    p->image = lag_take(arena, p->stride);
    p->anchor = lag_dds_take(arena, ladder->stride);
    p->state = lag_dds_take(arena, ladder->stride);
    p->spare = lag_dds_take(arena, ladder->stride);
}

void lag_pace_set(LagPace *p, LagDDs x)
{
    lag_dds_copy(x, p->anchor, p->size);
    memcpy(p->x, x.hi, p->size * sizeof *p->x);
    p->count = 0;
    p->sum[0] = p->sum[1] = 0;
}

void lag_pace_step(LagPace *p, double *gain)
{
    const size_t part = p->stride / (size_t)(1 + p->n_forms);
    memset(p->image, 0, p->stride * sizeof *p->image);
    for (size_t j = 0; j < p->size; ++j)
        if (p->x[j] != 0)
            lag_add_multiple(p->x[j], p->columns + j * p->stride, p->image, p->stride);
    for (int f = 0; f < p->n_forms; ++f) {
        const double *image = p->image + (size_t)(f + 1) * part;
        gain[f] = 0;
        for (size_t j = 0; j < p->size; ++j)
            gain[f] += p->x[j] * image[j];
        p->sum[f] += gain[f];
    }
    memcpy(p->x, p->image, p->size * sizeof *p->x);
    ++p->count;
}

void lag_pace_settle(LagPace *p, LagLadder *ladder, LagDD *integrals)
{
    integrals[0] = integrals[1] = lag_dd(0);
    lag_dds_copy(p->anchor, p->state, p->size);
    for (int k = 0; p->count >> k > 0; ++k)
        if (p->count >> k & 1) {
            const LagDDs before = p->state;
            lag_ladder_climb(ladder, ladder->top + k, before, p->spare, integrals);
            p->state = p->spare;
            p->spare = before;
        }
}

static int close(const double *x, const double *exact, const double *before, size_t count)
{
    const double size = fmax(lag_largest(exact, count), lag_largest(before, count));
    double difference = 0;
    for (size_t i = 0; i < count; ++i)
        difference = fmax(difference, fabs(x[i] - exact[i]));
    return difference <= ALLOWED * size;
}

int lag_pace_agrees(const LagPace *p, size_t n, const LagDD *integrals)
{
    int agrees = close(p->x, p->state.hi, p->anchor.hi, n)
        && close(p->x + n, p->state.hi + n, p->anchor.hi + n, n);
    for (int f = 0; f < p->n_forms; ++f)
        agrees = agrees && close(&p->sum[f], &integrals[f].hi, &p->sum[f], 1);
    return agrees;
}

static void read_columns(LagPace *p, const LagLadder *ladder)
{
    for (int f = 0; f <= p->n_forms; ++f)
        for (size_t j = 0; j < p->size; ++j)
            memcpy(p->columns + j * p->stride + (size_t)f * ladder->stride, lag_ladder_row(ladder, ladder->top, f, j),
                   ladder->stride * sizeof *p->columns);
}

void lag_pace_try(LagPace *p, LagLadder *ladder, size_t n, LagDDs x)
{
    LagDD integrals[2];
    double gain[2];
    p->is_trusted = 0;
    if (ladder->top + LAG_PACE_RUNGS >= ladder->n_rungs)
        return;
    lag_pace_set(p, x);
    p->count = LAG_PACE_STEPS;
    lag_pace_settle(p, ladder, integrals);
    read_columns(p, ladder);
    for (p->count = 0; p->count < LAG_PACE_STEPS;)
        lag_pace_step(p, gain);
    p->is_trusted = lag_pace_agrees(p, n, integrals);
    p->count = 0;
}
