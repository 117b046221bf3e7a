/* Numbers are compared bit by bit: -0 is another guess than 0, and what is no number is like itself. */
#include "start/known_start.h"

#include <string.h>

#include "start/metric.h"

static size_t unknowns(const LagModel *model) { return 2 * (size_t)lag_start_size(model); }

void lag_known_start_layout(LagKnownStart *s, const LagModel *model, LagArena *arena)
{
    const size_t size = model->n_initial > 0 ? unknowns(model) : 0;
    s->p = lag_take(arena, size > 0 ? (size_t)model->n_parameters : 0);
    s->u = lag_take(arena, size > 0 ? (size_t)model->n_inputs : 0);
    s->guess = lag_take(arena, size);
    s->found = lag_take(arena, size);
    s->fixed = lag_take_ints(arena, size);
}

/* Takes the values over; returns whether they were these before. */
static int renew(void *known, const void *values, size_t size)
{
    if (size == 0 || memcmp(known, values, size) == 0)
        return 1;
    memcpy(known, values, size);
    return 0;
}

int lag_known_start_recall(LagKnownStart *s, const LagModel *model, const double *p, const double *u, const int *fixed,
                           double *x)
{
    const size_t size = unknowns(model), inputs = u ? (size_t)model->n_inputs : 0;
    int is_same = renew(s->guess, x, size * sizeof *x);
    is_same &= renew(s->p, p, (size_t)model->n_parameters * sizeof *p);
    is_same &= renew(s->u, u, inputs * sizeof *u);
    is_same &= renew(s->fixed, fixed, size * sizeof *fixed);
    s->is_found &= is_same;
    if (s->is_found)
        memcpy(x, s->found, size * sizeof *x);
    return s->is_found;
}

void lag_known_start_keep(LagKnownStart *s, const LagModel *model, const double *x)
{
    memcpy(s->found, x, unknowns(model) * sizeof *x);
    s->is_found = 1;
}
