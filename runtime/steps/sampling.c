/* An instant is known by its number, floor(a + b t): so none is missed or taken twice, however often a segment begins there. */
#include "steps/sampling.h"

#include <math.h>

#include "model/function.h"
#include "steps/delays.h"
#include "model/schedule.h"

void lag_sampling_layout(LagRun *run, LagArena *arena)
{
    run->fires = lag_take(arena, (size_t)run->model->n_samplers);
    run->sampled = lag_take(arena, (size_t)run->model->n_samplers);
    run->held = lag_take(arena, (size_t)run->model->n_held);
    lag_delays_layout(run, arena);
}

LagStatus lag_sampling_begin(LagRun *run)
{
    const LagModel *model = run->model;
    const double *in[] = {run->p};
    for (int k = 0; k < model->n_samplers; ++k) {
        const double pace = run->event_b[model->samplers[k]];
        run->sampled[k] = -1;
        if (!(pace > 0 && isfinite(pace)))
            return lag_fail(run, LAG_BAD_INTERVAL, k, 0, 1 / pace);
    }
    if (model->n_held > 0)
        lag_call(&model->held_first, in, &run->held, run->work);
    for (int k = 0; k < model->n_held; ++k)
        run->d[model->held[k]] = run->held[k];
    return LAG_OK;
}

int lag_sampling_take(LagRun *run, double t, const double *y)
{
    const LagModel *model = run->model;
    const double *in[] = {&t, y, y + model->n, run->u, run->d, run->p, run->fires};
    int some = 0;
    for (int k = 0; k < model->n_samplers; ++k) {
        const double a = run->event_a[model->samplers[k]], b = run->event_b[model->samplers[k]];
        const double number = floor(a + b * (t + lag_time_resolution(fabs(t) + fabs(a / b))));
        run->fires[k] = number >= 0 && number > run->sampled[k];
        run->sampled[k] = run->fires[k] > 0 ? number : run->sampled[k];
        some |= run->fires[k] > 0;
    }
    if (!some)
        return 0;
    lag_inputs_at(&run->inputs, t, run->u);
    lag_call(&model->samples, in, &run->held, run->work);
    for (int k = 0; k < model->n_held; ++k)
        run->d[model->held[k]] = run->held[k];
    return 1;
}

void lag_sampling_keep(LagRun *run)
{
    for (int k = 0; k < run->model->n_held; ++k)
        run->d[run->model->held[k]] = run->d_before[run->model->held[k]];
}
