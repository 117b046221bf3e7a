/* An instant is known by its number, floor(a + b t): so none is missed or taken twice, however often a segment begins there. */
#include "events/sampling.h"

#include <math.h>

#include "model/function.h"
#include "model/schedule.h"

void lag_sampling_layout(LagRun *run, LagArena *arena)
{
    run->fires = lag_take(arena, (size_t)run->model->n_held);
    run->sampled = lag_take(arena, (size_t)run->model->n_samplers);
    run->is_due = lag_take_ints(arena, (size_t)run->model->n_samplers);
    run->held = lag_take(arena, (size_t)run->model->n_held);
}

/* Held values into the modes, all or those that have just been found. */
static void hold(LagRun *run, int all)
{
    for (int k = 0; k < run->model->n_held; ++k)
        if (all || run->fires[k] > 0)
            run->d[lag_held_mode(run->model, k)] = run->held[k];
}

static void find_first(LagRun *run)
{
    const double *in[] = {run->p};
    if (run->model->n_held > 0)
        lag_call(&run->model->held_first, in, &run->held, run->work);
}

LagStatus lag_sampling_begin(LagRun *run)
{
    const LagModel *model = run->model;
    for (int k = 0; k < model->n_samplers; ++k) {
        const double pace = run->event_b[model->samplers[k]];
        run->sampled[k] = -1;
        run->is_due[k] = 0;
        if (!(pace > 0 && isfinite(pace)))
            return lag_fail(run, LAG_BAD_INTERVAL, k, 0, 1 / pace);
    }
    lag_sampling_put_back(run);
    return LAG_OK;
}

void lag_sampling_put_back(LagRun *run)
{
    find_first(run);
    hold(run, 1);
}

int lag_sampling_meet(LagRun *run, double t)
{
    const LagModel *model = run->model;
    int some = 0;
    for (int k = 0; k < model->n_samplers; ++k) {
        const double a = run->event_a[model->samplers[k]], b = run->event_b[model->samplers[k]];
        const double number = floor(a + b * (t + lag_time_resolution(fabs(t) + fabs(a / b))));
        run->is_due[k] = number >= 0 && number > run->sampled[k];
        run->sampled[k] = run->is_due[k] ? number : run->sampled[k];
        some |= run->is_due[k];
    }
    return some;
}

int lag_sampling_take(LagRun *run, double t, const double *y, int rank)
{
    const LagModel *model = run->model;
    const double *in[] = {&t, y, y + model->n, run->u, run->d, run->p, run->fires};
    int some = 0;
    for (int k = 0; k < model->n_held; ++k) {
        run->fires[k] = lag_held_rank(model, k) == rank && run->is_due[lag_held_sampler(model, k)];
        some |= run->fires[k] > 0;
    }
    if (!some)
        return 0;
    lag_inputs_at(&run->inputs, t, run->u);
    lag_call(&model->samples, in, &run->held, run->work);
    hold(run, 0);
    return 1;
}

int lag_sampling_last_rank(const LagModel *model)
{
    int last = 0;
    for (int k = 0; k < model->n_held; ++k)
        last = lag_held_rank(model, k) > last ? lag_held_rank(model, k) : last;
    return last;
}

void lag_sampling_keep(LagRun *run)
{
    for (int k = 0; k < run->model->n_held; ++k)
        run->d[lag_held_mode(run->model, k)] = run->d_before[lag_held_mode(run->model, k)];
}
