/* Derivatives of unknowns (slopes, outputs, states) by knowns (time, states, inputs, parameters), exact, along one direction or
 * as the gradient of one combination. */
#include <string.h>

#include "instance.h"

#include "evaluate.h"
#include "function.h"
#include "state.h"

/* Directions of the knowns, then of the unknowns. */
typedef struct {
    double *t, *x, *u, *p, *slope, *y;
} Directions;

size_t lag_partial_size(const LagFmu *fmu)
{
    const LagModel *m = fmu->model;
    return 1 + 4 * (size_t)m->n + (size_t)(m->n_inputs + m->n_parameters + m->n_outputs);
}

static Directions clear(LagInstance *s)
{
    const LagModel *m = s->model;
    Directions d;
    memset(s->directions, 0, lag_partial_size(s->fmu) * sizeof *s->directions);
    d.t = s->directions;
    d.x = d.t + 1;
    d.u = d.x + 2 * m->n;
    d.p = d.u + m->n_inputs;
    d.slope = d.p + m->n_parameters;
    d.y = d.slope + 2 * m->n;
    return d;
}

/* Where a known's direction is kept; NULL: it is no known. */
static double *known(LagInstance *s, const Directions *d, unsigned int reference)
{
    int i = 0;
    switch (lag_instance_locate(s->fmu, reference, &i)) {
    case LAG_GROUP_TIME: return d->t;
    case LAG_GROUP_STATE: return d->x + i;
    case LAG_GROUP_INPUT: return d->u + i;
    case LAG_GROUP_PARAMETER: return s->fmu->parameter_settable[i] ? d->p + i : NULL;
    default: return NULL;
    }
}

/* A state depends on itself. */
static double *unknown(LagInstance *s, const Directions *d, unsigned int reference)
{
    int i = 0;
    switch (lag_instance_locate(s->fmu, reference, &i)) {
    case LAG_GROUP_STATE: return d->x + i;
    case LAG_GROUP_SLOPE: return d->slope + i;
    case LAG_GROUP_OUTPUT: return d->y + i;
    default: return NULL;
    }
}

static LagAnswer refuse(const LagInstance *s, unsigned int reference, const char *what)
{
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "the value reference %u is no %s of a derivative", reference, what);
}

static LagAnswer check(LagInstance *s, const unsigned int *unknowns, size_t n_unknowns, const unsigned int *knowns, size_t n_knowns,
                       const double *seed, const double *sensitivity)
{
    if ((n_unknowns > 0 && !unknowns) || (n_knowns > 0 && !knowns) || (n_unknowns + n_knowns > 0 && (!seed || !sensitivity)))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "derivatives are asked for without arguments");
    const Directions d = clear(s);
    for (size_t i = 0; i < n_unknowns; ++i)
        if (!unknown(s, &d, unknowns[i]))
            return refuse(s, unknowns[i], "unknown");
    for (size_t i = 0; i < n_knowns; ++i)
        if (!known(s, &d, knowns[i]))
            return refuse(s, knowns[i], "known");
    return lag_instance_settle(s);
}

LagAnswer lag_instance_forward(LagInstance *s, const unsigned int *unknowns, size_t n_unknowns,
                               const unsigned int *knowns, size_t n_knowns, const double *seed, double *sensitivity)
{
    LagAnswer answer = check(s, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity);
    if (answer != LAG_ANSWER_OK)
        return answer;
    const Directions d = clear(s);
    const int n = s->model->n;
    for (size_t i = 0; i < n_knowns; ++i)
        *known(s, &d, knowns[i]) += seed[i];
    lag_inputs_at(&s->run->inputs, s->vital.t, s->run->u);
    const double *in[] = {&s->vital.t, s->x, s->x + n, s->run->u, s->run->d, lag_run_parameters(s->run),
                          d.t, d.x, d.x + n, d.u, d.p};
    double *out[] = {d.slope, d.y};
    if (lag_call(&s->fmu->forward, in, out, s->work) != 0)
        return lag_instance_log(s, LAG_ANSWER_DISCARD, "logStatusDiscard", "there is no derivative here");
    for (size_t i = 0; i < n_unknowns; ++i)
        sensitivity[i] = *unknown(s, &d, unknowns[i]);
    return LAG_ANSWER_OK;
}

/* Weights of the states that are unknowns themselves go past the function. */
LagAnswer lag_instance_adjoint(LagInstance *s, const unsigned int *unknowns, size_t n_unknowns,
                               const unsigned int *knowns, size_t n_knowns, const double *seed, double *sensitivity)
{
    LagAnswer answer = check(s, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity);
    if (answer != LAG_ANSWER_OK)
        return answer;
    const Directions d = clear(s);
    const int n = s->model->n;
    for (size_t i = 0; i < n_unknowns; ++i)
        *unknown(s, &d, unknowns[i]) += seed[i];
    memcpy(s->scratch, d.x, 2 * (size_t)n * sizeof *d.x);
    lag_inputs_at(&s->run->inputs, s->vital.t, s->run->u);
    const double *in[] = {&s->vital.t, s->x, s->x + n, s->run->u, s->run->d, lag_run_parameters(s->run), d.slope, d.y};
    double *out[] = {d.t, d.x, d.x + n, d.u, d.p};
    if (lag_call(&s->fmu->adjoint, in, out, s->work) != 0)
        return lag_instance_log(s, LAG_ANSWER_DISCARD, "logStatusDiscard", "there is no derivative here");
    for (int i = 0; i < 2 * n; ++i)
        d.x[i] += s->scratch[i];
    for (size_t i = 0; i < n_knowns; ++i)
        sensitivity[i] = *known(s, &d, knowns[i]);
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_output_slope(LagInstance *s, unsigned int reference, int order, double *value)
{
    int index = 0;
    const int group = lag_instance_locate(s->fmu, reference, &index), n = s->model->n;
    if ((group != LAG_GROUP_OUTPUT && group != LAG_GROUP_STATE) || order != 1)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "outputs and states have first derivatives, and no others");
    LagAnswer answer = lag_instance_settle(s);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_slope(s);
    if (answer != LAG_ANSWER_OK)
        return answer;
    if (group == LAG_GROUP_STATE) {
        *value = s->slope[index];
        return LAG_ANSWER_OK;
    }
    const Directions d = clear(s);
    *d.t = 1;
    memcpy(d.x, s->slope, 2 * (size_t)n * sizeof *d.x);
    if (s->model->n_inputs > 0)
        memcpy(d.u, s->u_slope, (size_t)s->model->n_inputs * sizeof *d.u);
    lag_inputs_at(&s->run->inputs, s->vital.t, s->run->u);
    const double *in[] = {&s->vital.t, s->x, s->x + n, s->run->u, s->run->d, lag_run_parameters(s->run),
                          d.t, d.x, d.x + n, d.u, d.p};
    double *out[] = {d.slope, d.y};
    if (lag_call(&s->fmu->forward, in, out, s->work) != 0)
        return LAG_ANSWER_DISCARD;
    *value = d.y[index];
    return LAG_ANSWER_OK;
}
