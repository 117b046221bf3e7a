#include "events/loaded.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "model/function.h"
#include "model/schedule.h"
#include "numbers/extremes.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double MOMENT = 1e-6; /* of a span */
static const double MANY = 1024;   /* times what tells times apart */

void lag_loaded_layout(LagLoaded *s, const LagModel *model, int size, LagArena *arena)
{
    const size_t all = model->n_loaded > 0 ? (size_t)model->n_switches : 0, whole = model->n_loaded > 0 ? (size_t)size : 0;
    s->is_loaded = lag_take_ints(arena, (size_t)model->n_whens);
    s->a = lag_take(arena, whole > 0 ? (size_t)model->n : 0);
    s->power = lag_take(arena, whole > 0 ? (size_t)model->n_power : 0);
    s->multipliers = lag_take(arena, whole > 0 ? (size_t)model->n_multipliers : 0);
    s->g = lag_take(arena, (size_t)model->n_loaded);
    s->all = lag_take(arena, all);
    s->rates = lag_take(arena, all);
    s->held = lag_take(arena, all);
    s->state = lag_take(arena, whole);
    s->slope = lag_take(arena, whole);
}

void lag_loaded_reset(LagRun *run)
{
    for (int k = 0; k < run->model->n_whens; ++k)
        run->impacts.loaded.is_loaded[k] = 0;
    for (int j = 0; j < run->model->n_loaded; ++j)
        run->impacts.loaded.is_loaded[run->model->loaded[2 * j]] = 1;
}

void lag_loaded_put(LagRun *run, double t, const double *q, const double *v, double *g)
{
    const LagModel *model = run->model;
    LagLoaded *s = &run->impacts.loaded;
    const double *state[] = {&t, q, v, run->u, run->d, run->c};
    const double *in[] = {&t, q, v, s->a, s->multipliers, run->u, run->d, run->c};
    double *found[] = {s->a, s->power, s->multipliers};
    const int is_told = lag_call(&model->rhs, state, found, run->work) == 0 && lag_call(&model->loads, in, &s->g, run->work) == 0;
    for (int j = 0; j < model->n_loaded; ++j)
        g[lag_when(model, model->loaded[2 * j])] = is_told ? s->g[j] : NAN;
}

void lag_loaded_rates(LagRun *run, double t, const double *y, double span, const double *g, double *rate)
{
    const LagModel *model = run->model;
    LagLoaded *s = &run->impacts.loaded;
    const double moment = lag_max(MOMENT * span, MANY * lag_time_resolution(t));
    double *shares = run->d + model->n_modes;
    const size_t size = (size_t)model->n_switches * sizeof *shares;
    memcpy(s->held, shares, size);
    for (int i = 0; i < 2 * model->n; ++i)
        s->state[i] = y[i] - moment * run->switches.slope[i];
    lag_motion_slope(&run->motion, t - moment, s->state, s->state + model->n, s->slope);
    lag_conditions_by(run, t - moment, s->state, s->state + model->n, s->slope + model->n, s->all, s->rates);
    for (int j = 0; j < model->n_loaded; ++j) {
        const int i = lag_when(model, model->loaded[2 * j]);
        rate[i] = (g[i] - s->all[i]) / moment;
    }
    memcpy(shares, s->held, size);
}

void lag_loaded_enter(LagRun *run)
{
    LagSwitches *s = &run->switches;
    const LagModel *model = run->model;
    if (model->n_loaded == 0)
        return;
    lag_conditions_of_events(run, s->g_inside, s->rate_inside);
    for (int j = 0; j < model->n_loaded; ++j) {
        const int i = lag_when(model, model->loaded[2 * j]), is_true = s->g_inside[i] > 0;
        if (fabs(s->g_inside[i]) <= s->unknown[i] || is_true == (s->held[i] > 0))
            continue;
        if (is_true && !run->started && model->loaded[2 * j + 1])
            lag_conditions_come(run, i);
        else
            lag_conditions_take(run, i, is_true);
    }
}
