#include "evaluate.h"

#include "function.h"

/* A LagRhs. 0 * x is 0 for finite x and NaN for others: one sum tells about all. */
int lag_accelerations(void *context, double t, const double *q, const double *v, double *a, double *power)
{
    LagRun *run = context;
    const LagModel *model = run->model;
    const double *in[] = {&t, q, v, run->u, run->d, run->c};
    double *out[] = {a, power, run->multipliers}, probe = 0;
    lag_inputs_at(&run->inputs, t, run->u);
    if (lag_call(&model->rhs, in, out, run->work) != 0)
        return 0;
    for (int i = 0; i < model->n; ++i)
        probe += 0 * a[i];
    for (int i = 0; i < model->n_power; ++i)
        probe += 0 * power[i];
    return probe == 0;
}

void lag_outputs(LagRun *run, double t, const double *y, double *outputs)
{
    const LagModel *model = run->model;
    const double *q = y, *v = y + model->n;
    const double *in[] = {&t, q, v, run->acceleration, run->multipliers, run->u, run->d, run->c};
    if (model->n_outputs == 0)
        return;
    lag_inputs_at(&run->inputs, t, run->u);
    if (model->outputs_need_acceleration) {
        lag_accelerations(run, t, q, v, run->acceleration, run->power);
        ++run->solver.evaluations;
    }
    lag_call(&model->outputs, in, &outputs, run->work);
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
