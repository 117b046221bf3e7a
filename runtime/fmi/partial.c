/* Derivatives of unknowns (slopes, outputs, states) by knowns (time, states, inputs, parameters), exact, along one direction or
 * as the gradient of one combination.
 *
 * What a stop or friction holds is held by shares s that keep its rates R(x, s) at 0: ds = -(dR/ds)^-1 dR/dx dx. So the derivative
 * along a direction is that along (dx, ds); and the gradient of a combination w is that of w and m R, with m = -(dR/ds)^-T dw/ds.
 *
 * R knows the rates of inputs, too, as an input may hold something. In Model Exchange these follow from the inputs themselves between
 * completed steps (exchange_steps.c). */
#include <math.h>
#include <string.h>

#include "fmi/instance.h"

#include "state/evaluate.h"
#include "model/function.h"
#include "state/state.h"

/* Directions of the knowns, then of the unknowns. */
typedef struct {
    double *t, *x, *u, *d, *w, *p, *slope, *y, *rate;
} Directions;

/* Values that directions of d are for: all, where there are switches. */
static int along_d(const LagModel *m) { return m->n_switches > 0 ? m->n_modes + m->n_switches + m->n_resets : 0; }

/* And of rates of inputs, likewise. */
static int along_w(const LagModel *m) { return m->n_switches > 0 ? LAG_N_U(m) : 0; }

size_t lag_partial_size(const LagFmu *fmu)
{
    const LagModel *m = fmu->model;
    return 1 + 2 * (size_t)lag_fmu_states(m) + LAG_N_U(m)
        + (size_t)(m->n_parameters + lag_fmu_outputs(m) + along_d(m) + along_w(m) + m->n_switches);
}

static Directions places(const LagInstance *s)
{
    const LagModel *m = s->model;
    Directions d;
    d.t = s->directions;
    d.x = d.t + 1;
    d.u = d.x + lag_fmu_states(m);
    d.d = d.u + LAG_N_U(m);
    d.w = d.d + along_d(m);
    d.p = d.w + along_w(m);
    d.slope = d.p + m->n_parameters;
    d.y = d.slope + lag_fmu_states(m);
    d.rate = d.y + lag_fmu_outputs(m);
    return d;
}

static Directions clear(LagInstance *s)
{
    memset(s->directions, 0, lag_partial_size(s->fmu) * sizeof *s->directions);
    return places(s);
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

static LagAnswer check(LagInstance *s, LagVariables unknowns, LagVariables knowns, const double *seed, const double *sensitivity)
{
    if ((unknowns.count > 0 && !unknowns.references) || (knowns.count > 0 && !knowns.references)
        || (unknowns.count + knowns.count > 0 && (!seed || !sensitivity)))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "derivatives are asked for without arguments");
    LagAnswer answer = lag_instance_fits(s, unknowns.references, unknowns.count, unknowns.size, "unknown");
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_fits(s, knowns.references, knowns.count, knowns.size, "known");
    if (answer != LAG_ANSWER_OK)
        return answer;
    const Directions d = clear(s);
    for (size_t i = 0; i < unknowns.count; ++i)
        if (!unknown(s, &d, unknowns.references[i]))
            return refuse(s, unknowns.references[i], "unknown");
    for (size_t i = 0; i < knowns.count; ++i)
        if (!known(s, &d, knowns.references[i]))
            return refuse(s, knowns.references[i], "known");
    return lag_instance_settle(s);
}

/* Switches and shares are those of the present state. */
static LagAnswer prepare(LagInstance *s)
{
    if (s->model->n_switches > 0)
        s->vital.slope_is_current = 0;
    const LagAnswer answer = s->model->n_switches > 0 ? lag_instance_slope(s) : LAG_ANSWER_OK;
    lag_inputs_and_rates(s->run, s->vital.t);
    lag_inputs_piece_slopes(&s->run->inputs, s->run->d, s->vital.t, s->run->u_slope);
    return answer;
}

static LagAnswer no_derivative(const LagInstance *s)
{
    return lag_instance_log(s, LAG_ANSWER_DISCARD, "logStatusDiscard", "there is no derivative here");
}

static int call_forward(LagInstance *s, const Directions *d)
{
    const int n = lag_fmu_positions(s->model);
    const double *in[] = {&s->vital.t, s->x, s->x + n, s->run->u, s->run->d, s->run->u_slope, lag_run_parameters(s->run),
                          d->t, d->x, d->x + n, d->u, d->d, d->w, d->p};
    for (int i = 0; i < (along_w(s->model) > 0 ? s->model->n_inputs : 0); ++i)
        d->w[i] = lag_exchange_rate_by_input(s, i) * d->u[i];
    double *out[] = {d->slope, d->y, d->rate};
    return lag_call(&s->fmu->forward, in, out, s->work) == 0;
}

static int call_adjoint(LagInstance *s, const Directions *d)
{
    const int n = lag_fmu_positions(s->model);
    const double *in[] = {&s->vital.t, s->x, s->x + n, s->run->u, s->run->d, s->run->u_slope, lag_run_parameters(s->run), d->slope,
                          d->y, d->rate};
    double *out[] = {d->t, d->x, d->x + n, d->u, d->d, d->w, d->p};
    if (lag_call(&s->fmu->adjoint, in, out, s->work) != 0)
        return 0;
    for (int i = 0; i < (along_w(s->model) > 0 ? s->model->n_inputs : 0); ++i)
        d->u[i] += lag_exchange_rate_by_input(s, i) * d->w[i];
    return 1;
}

/* What holds of all that slides, into `next` of it: not what gives all that it has. Returns how much does. */
static int gather_held(LagInstance *s)
{
    LagSliding *sliding = &s->run->sliding;
    int count = 0;
    for (int k = 0; k < sliding->count; ++k)
        if (!sliding->is_spent[k])
            sliding->next[count++] = sliding->which[k];
    return count;
}

/* Where the share of the k-th that is held stands in d. */
static int place_of_share(const LagInstance *s, int k) { return (int)(lag_share(s->run, s->run->sliding.next[k]) - s->run->d); }

/* dR/ds of so many that are held, or its transpose, factored; the directions are 0 then. */
static int factor_held(LagInstance *s, int count, int is_transposed)
{
    const LagSliding *sliding = &s->run->sliding;
    const Directions d = clear(s);
    int is_known = 1;
    s->held.size = count;
    for (int k = 0; k < count && is_known; ++k) {
        d.d[place_of_share(s, k)] = 1;
        is_known = call_forward(s, &d);
        d.d[place_of_share(s, k)] = 0;
        for (int i = 0; i < count; ++i)
            s->held.re[is_transposed ? k + count * i : i + count * k] = d.rate[sliding->next[i]];
    }
    if (is_known)
        lag_dense_lu_factor(&s->held);
    clear(s);
    return is_known;
}

/* Fills the directions of the knowns. */
typedef void (*Fill)(LagInstance *s, const Directions *d, const void *what);

/* What the directions of the knowns make of those of the unknowns. */
static int find_forward(LagInstance *s, Fill fill, const void *what)
{
    const LagSliding *sliding = &s->run->sliding;
    const int count = gather_held(s);
    if (count > 0 && !factor_held(s, count, 0))
        return 0;
    const Directions d = clear(s);
    fill(s, &d, what);
    if (!call_forward(s, &d))
        return 0;
    if (count == 0)
        return 1;
    for (int k = 0; k < count; ++k)
        s->held_rates[k] = -d.rate[sliding->next[k]];
    lag_dense_lu_solve(&s->held, s->held_rates, NULL);
    for (int k = 0; k < count; ++k)
        d.d[place_of_share(s, k)] = s->held_rates[k];
    return call_forward(s, &d);
}

/* And what weights of the unknowns make of those of the knowns. */
static int find_adjoint(LagInstance *s, Fill fill, const void *what)
{
    const LagSliding *sliding = &s->run->sliding;
    const int count = gather_held(s);
    if (count > 0 && !factor_held(s, count, 1))
        return 0;
    const Directions d = clear(s);
    fill(s, &d, what);
    if (!call_adjoint(s, &d))
        return 0;
    if (count == 0)
        return 1;
    for (int k = 0; k < count; ++k)
        s->held_rates[k] = -d.d[place_of_share(s, k)];
    lag_dense_lu_solve(&s->held, s->held_rates, NULL);
    for (int k = 0; k < count; ++k)
        d.rate[sliding->next[k]] = s->held_rates[k];
    return call_adjoint(s, &d);
}

typedef struct {
    LagVariables of;
    const double *seed;
} Seeds;

typedef double *(*Place)(LagInstance *s, const Directions *d, unsigned int reference);

/* Seeds go where their variables have their places: the elements of an array stand side by side. */
static void sow(LagInstance *s, const Directions *d, const Seeds *seeds, Place place)
{
    const double *seed = seeds->seed;
    for (size_t i = 0; i < seeds->of.count; ++i) {
        const unsigned int reference = seeds->of.references[i];
        const size_t extent = lag_instance_extent(s, reference);
        double *at = place(s, d, reference);
        for (size_t k = 0; k < extent; ++k)
            at[k] += *seed++;
    }
}

/* And what has grown there is taken; 0 where some of it is no number: parameters may have values by which nothing can be derived,
 * as those of an axis that lies along another. */
static int reap(LagInstance *s, LagVariables of, double *values, Place place)
{
    const Directions d = places(s);
    int is_finite = 1;
    for (size_t i = 0; i < of.count; ++i) {
        const size_t extent = lag_instance_extent(s, of.references[i]);
        const double *from = place(s, &d, of.references[i]);
        for (size_t k = 0; k < extent; ++k) {
            values[k] = from[k];
            is_finite = is_finite && isfinite(from[k]);
        }
        values += extent;
    }
    return is_finite;
}

static void fill_knowns(LagInstance *s, const Directions *d, const void *what) { sow(s, d, what, known); }

/* Those of states that are unknowns themselves go past the function. */
static void fill_unknowns(LagInstance *s, const Directions *d, const void *what)
{
    const size_t size = (size_t)lag_fmu_states(s->model) * sizeof *d->x;
    sow(s, d, what, unknown);
    if (size > 0) {
        memcpy(s->scratch, d->x, size);
        memset(d->x, 0, size);
    }
}

LagAnswer lag_instance_forward(LagInstance *s, LagVariables unknowns, LagVariables knowns, const double *seed, double *sensitivity)
{
    LagAnswer answer = check(s, unknowns, knowns, seed, sensitivity);
    if (answer == LAG_ANSWER_OK)
        answer = prepare(s);
    if (answer != LAG_ANSWER_OK)
        return answer;
    const Seeds seeds = {knowns, seed};
    if (!find_forward(s, fill_knowns, &seeds))
        return no_derivative(s);
    return reap(s, unknowns, sensitivity, unknown) ? LAG_ANSWER_OK : no_derivative(s);
}

LagAnswer lag_instance_adjoint(LagInstance *s, LagVariables unknowns, LagVariables knowns, const double *seed, double *sensitivity)
{
    LagAnswer answer = check(s, unknowns, knowns, seed, sensitivity);
    if (answer == LAG_ANSWER_OK)
        answer = prepare(s);
    if (answer != LAG_ANSWER_OK)
        return answer;
    const Seeds seeds = {unknowns, seed};
    if (!find_adjoint(s, fill_unknowns, &seeds))
        return no_derivative(s);
    const Directions d = places(s);
    for (int i = 0; i < lag_fmu_states(s->model); ++i)
        d.x[i] += s->scratch[i];
    return reap(s, knowns, sensitivity, known) ? LAG_ANSWER_OK : no_derivative(s);
}

/* The way of the motion itself. */
static void fill_motion(LagInstance *s, const Directions *d, const void *what)
{
    (void)what;
    *d->t = 1;
    if (s->model->n > 0)
        memcpy(d->x, s->slope, (size_t)lag_fmu_states(s->model) * sizeof *d->x);
    if (s->model->n_inputs > 0)
        memcpy(d->u, s->u_slope, (size_t)s->model->n_inputs * sizeof *d->u);
    for (int k = 0; k < s->model->n_pieces; ++k) {
        const int *places = s->model->pieces + 4 * k;
        if (places[1] >= 0) {
            d->u[places[0]] = s->run->u[places[1]];
            d->u[places[1]] = s->run->u[places[2]];
        }
    }
}

LagAnswer lag_instance_output_slope(LagInstance *s, unsigned int reference, int order, double *value)
{
    int index = 0;
    const int group = lag_instance_locate(s->fmu, reference, &index);
    if ((group != LAG_GROUP_OUTPUT && group != LAG_GROUP_STATE) || order != 1)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "outputs and states have first derivatives, and no others");
    LagAnswer answer = lag_instance_settle(s);
    if (answer == LAG_ANSWER_OK)
        answer = prepare(s);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_slope(s);
    if (answer != LAG_ANSWER_OK)
        return answer;
    if (group == LAG_GROUP_OUTPUT && !find_forward(s, fill_motion, NULL))
        return no_derivative(s);
    *value = group == LAG_GROUP_STATE ? s->slope[index] : places(s).y[index];
    return LAG_ANSWER_OK;
}
