#include "methods/wide_roots.h"

#include <string.h>

#include "model/attitude_places.h"
#include "model/function.h"
#include "model/wide_tape.h"
#include "numbers/extremes.h"
#include "state/state.h"
#include "steps/roots.h"

int lag_wide_roots_serve(const LagModel *model) { return model->n_roots == 0 || model->roots.tape; }

void lag_wide_roots_layout(LagWideRoots *s, const LagModel *model, LagArena *arena)
{
    const size_t all = model->n_roots > 0 ? LAG_ABREAST : 0, count = (size_t)model->n_roots * all;
    double **const vectors[] = {&s->g, &s->rate, &s->g_old, &s->rate_old};
    s->model = model;
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
        *vectors[i] = lag_take(arena, count);
    s->u = lag_take(arena, LAG_N_U(model) * all);
    s->d = lag_take(arena, (size_t)model->n_modes * all);
    s->c = lag_take(arena, (size_t)model->n_hoisted * all);
    s->work = lag_take(arena, model->roots.n_work * all);
}

void lag_wide_roots_enter(LagWideRoots *s, int lane, LagRun *run)
{
    const LagModel *model = s->model;
    if (model->n_roots == 0)
        return;
    lag_roots_look(run);
    s->run[lane] = run;
    lag_wide_place(s->g, lane, run->roots.g, model->n_roots);
    lag_wide_place(s->rate, lane, run->roots.rate, model->n_roots);
    lag_wide_place(s->d, lane, run->d, model->n_modes);
    lag_wide_place(s->c, lane, run->c, model->n_hoisted);
}

static int is_some(const double *numbers)
{
    LagWide sum = LAG_WIDE_OF(0);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        sum += lag_wide_read(numbers + lane);
    return lag_wide_is_some(sum);
}

void lag_wide_roots_begin(LagWideRoots *s, const LagWideSteps *steps)
{
    const double *rates = steps->y + (size_t)steps->n * LAG_ABREAST, *in[] = {steps->t, steps->y, rates, s->u, s->d, s->c};
    double doubt[LAG_ABREAST] = {0}, *out[] = {s->g, s->rate, doubt};
    for (int i = 0; i < s->model->n_attitudes; ++i) {
        const size_t mode = (size_t)lag_attitude_mode(s->model->attitudes, i) * LAG_ABREAST;
        memcpy(s->d + mode, steps->reference + mode, 4 * LAG_ABREAST * sizeof *s->d);
    }
    for (int lane = 0; lane < LAG_ABREAST && s->model->n_inputs > 0; ++lane) {
        if (steps->moves[lane] == 0)
            continue;
        lag_inputs_at(&s->run[lane]->inputs, steps->t[lane], s->run[lane]->u);
        lag_wide_place(s->u, lane, s->run[lane]->u, s->model->n_inputs);
    }
    if (s->model->wide_roots)
        s->model->wide_roots(in, out);
    if (!s->model->wide_roots || is_some(doubt)) /* angles are too large for it */
        lag_wide_tape_run(s->model->roots.tape, in, 0, out, s->work);
}

/* As in roots.c: whether a parabola through both ends comes near to 0. */
LAG_UNROLLED LagWide is_near(const LagWideRoots *s, int i, int lane, LagWide h)
{
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1), half = LAG_WIDE_OF(0.5);
    const LagWide a = lag_wide_of(s->g_old, i, lane), b = lag_wide_of(s->g, i, lane);
    const LagWide ra = h * lag_wide_of(s->rate_old, i, lane), rb = h * lag_wide_of(s->rate, i, lane), turn = one / (ra - rb);
    const LagWide least = lag_wide_min(a + half * ra * ra * turn, b + half * rb * rb * turn);
    const LagWide low = LAG_WIDE_SELECT(least < LAG_WIDE_OF(LAG_ROOTS_SUSPECT) * lag_wide_max(a, b), one, zero);
    return LAG_WIDE_SELECT(ra < zero, LAG_WIDE_SELECT(rb > zero, low, zero), zero);
}

void lag_wide_roots_look(LagWideRoots *s, const LagWideSteps *steps)
{
    lag_swap(&s->g, &s->g_old);
    lag_swap(&s->rate, &s->rate_old);
    lag_wide_roots_begin(s, steps);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        const LagWide h = lag_wide_read(steps->t + lane) - lag_wide_read(steps->t_old + lane);
        LagWide found = LAG_WIDE_OF(0);
        for (int i = 0; i < s->model->n_roots; ++i)
            found = lag_wide_max(is_near(s, i, lane, h), found);
        lag_wide_write(s->suspect + lane, found);
    }
}
