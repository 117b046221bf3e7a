#include "state/evaluate.h"

#include "model/function.h"

const LagFunction *lag_usual_rhs(const LagModel *model) { return lag_present(&model->regular) ? &model->regular : &model->rhs; }

int lag_flow(void *context, LagFlowPart part, const double *q, const double *v_or_p, double *result)
{
    LagRun *run = context;
    const LagModel *model = run->model;
    const LagFunction *const functions[] = {&model->momentum, &model->velocity, &model->force};
    const double *in[] = {q, v_or_p, part == LAG_MOMENTUM ? run->p : run->c};
    return lag_call(functions[part], in, &result, run->work) == 0 && lag_all_finite(result, model->n);
}

void lag_inputs_and_rates(LagRun *run, double t)
{
    if (run->model->n_inputs + run->model->n_delays == 0)
        return;
    lag_inputs_at(&run->inputs, t, run->u);
    if (run->model->n_inputs > 0)
        lag_inputs_slope(&run->inputs, run->u_slope);
    if (run->model->n_delays > 0)
        lag_history_rates(&run->history, t, run->u_slope + run->model->n_inputs);
}

void lag_conditions_of_motion(LagRun *run, double t, const double *q, const double *v, const double *a, double *g, double *rate)
{
    const double *in[] = {&t, q, v, a, run->u, run->u_slope, run->d, run->c};
    double *out[] = {g, rate};
    lag_inputs_and_rates(run, t);
    lag_call(&run->model->switches, in, out, run->work);
}

void lag_energies(LagRun *run, double t, const double *y, double *energies)
{
    const LagModel *model = run->model;
    const double *in[] = {&t, y, y + model->n, run->u, run->d, run->c};
    for (int i = 0; i < 3; ++i)
        energies[i] = 0;
    lag_inputs_at(&run->inputs, t, run->u);
    lag_call(&model->energies, in, &energies, run->work);
}
