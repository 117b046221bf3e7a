#include "methods/wide_steps.h"

#include <math.h>

#include "methods/wide_attitudes.h"
#include "numbers/extremes.h"
#include "state/state.h"

void lag_wide_steps_layout(LagWideSteps *s, const LagRun *like, LagArena *arena)
{
    const size_t size = (size_t)like->motion.size * LAG_ABREAST;
    s->model = like->model;
    s->n = like->model->n;
    s->size = like->motion.size;
    lag_wide_scale_layout(&s->scale, &like->scale, arena);
    double **const vectors[] = {&s->y, &s->carry, &s->old, &s->made, &s->made_carry};
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; ++i)
        *vectors[i] = lag_take(arena, size);
    s->reference = lag_take(arena, s->model->n_attitudes > 0 ? (size_t)s->model->n_modes * LAG_ABREAST : 0);
    s->turn_carry = lag_take(arena, 4 * (size_t)s->model->n_attitudes * LAG_ABREAST);
}

void lag_wide_steps_load(LagWideSteps *s, int lane, const LagRun *run)
{
    const LagMotion *m = &run->motion;
    s->longest = run->settings.max_step > 0 ? run->settings.max_step : INFINITY;
    lag_wide_scale_load(&s->scale, lane, &run->scale);
    lag_wide_place(s->y, lane, m->y, s->size);
    lag_wide_place(s->carry, lane, m->carry, s->size);
    lag_wide_place(s->old, lane, m->other, s->size);
    lag_wide_attitudes_load(s, lane, run);
    s->is_fresh = 1;
    s->t[lane] = m->t;
    s->t_old[lane] = m->t_old;
    s->length[lane] = m->t > m->t_old ? m->t - m->t_old : run->step;
    s->moves[lane] = s->taken[lane] = 1;
    s->steps[lane] = (double)run->statistics.steps;
    s->in_vain[lane] = s->missed[lane] = 0;
}

void lag_wide_steps_show(LagWideSteps *s, int lane, LagRun *run, LagShown shown)
{
    LagMotion *m = &run->motion;
    m->t = m->t_end = s->t[lane];
    m->t_old = s->t_old[lane];
    lag_wide_take(s->y, lane, m->y, s->size);
    lag_wide_attitudes_show(s, lane, run);
    const int64_t steps = (int64_t)s->steps[lane];
    run->statistics.steps_by[s->solver] += steps - run->statistics.steps;
    run->statistics.steps = steps;
    run->statistics.tolerance_missed = (int32_t)s->missed[lane];
    if (shown == LAG_SHOWN_STATE)
        return;
    lag_wide_take(s->old, lane, m->other, s->size);
    lag_wide_take(s->carry, lane, m->carry, s->size);
    lag_wide_scale_store(&s->scale, lane, &run->scale);
}
