/* Birth, life and death of an instance. */
#include "fmi/instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "fmi/opening.h"
#include "state/state.h"

enum { LONGEST_NAME = 200 };

/* What states of an FMU keep. */
static void layout_saved(LagInstance *s, LagArena *arena)
{
    const LagModel *m = s->model;
    const size_t states = (size_t)lag_fmu_states(m), inputs = (size_t)m->n_inputs, power = (size_t)m->n_power;
    s->given = lag_take(arena, (size_t)m->n_parameters);
    s->start = lag_take(arena, states);
    s->u = lag_take(arena, inputs);
    s->u_slope = lag_take(arena, inputs);
    s->x = lag_take(arena, states);
    s->slope = lag_take(arena, states);
    s->outputs = lag_take(arena, (size_t)m->n_outputs);
    s->energies = lag_take(arena, LAG_ENERGIES);
    s->power = lag_take(arena, power);
    s->last = lag_take(arena, states);
    s->last_slope = lag_take(arena, states);
    s->last_power = lag_take(arena, power);
    s->last_u = lag_take(arena, 3 * inputs);
    s->last_rate = s->last_u + inputs;
    s->earlier_u = s->last_rate + inputs;
    s->before_jump = lag_take(arena, 3 * inputs);
    s->least_u = lag_take(arena, inputs);
    s->most_u = lag_take(arena, inputs);
    s->rate = lag_take(arena, inputs);
    s->slack = lag_take(arena, (size_t)m->n_whens);
}

static void layout(LagInstance *s, LagArena *arena)
{
    const LagModel *m = s->model;
    const size_t n = (size_t)m->n, states = (size_t)lag_fmu_states(m), inputs = (size_t)m->n_inputs;
    layout_saved(s, arena);
    s->saved_size = arena->used;
    s->scratch = lag_take(arena, 2 * states + n);
    s->projected = lag_take(arena, 2 * n + (size_t)m->n_power);
    s->plain = lag_take(arena, 2 * n);
    s->told = lag_take(arena, states);
    s->indicators = lag_take(arena, (size_t)m->n_switches);
    s->modes = lag_take(arena, (size_t)m->n_modes);
    s->switches = lag_take(arena, 2 * (size_t)m->n_switches);
    s->row = lag_take(arena, (size_t)lag_run_row_width(m));
    s->mask = lag_take(arena, (size_t)m->n_parameters);
    s->table = lag_take(arena, 2 * (1 + inputs));
    s->directions = lag_take(arena, lag_partial_size(s->fmu));
    s->held_rates = lag_take(arena, (size_t)lag_sliding_most(m));
    lag_dense_lu_layout(&s->held, lag_sliding_most(m), 0, arena);
    const size_t forward = s->fmu->forward.n_work, adjoint = s->fmu->adjoint.n_work;
    s->work = lag_take(arena, forward > adjoint ? forward : adjoint);
}

static int take_memory(LagInstance *s)
{
    LagArena arena = {NULL, 0};
    layout(s, &arena);
    s->memory = calloc(arena.used + 1, sizeof *s->memory);
    if (!s->memory)
        return 0;
    arena.base = s->memory;
    arena.used = 0;
    layout(s, &arena);
    return 1;
}

/* As it was when it was made. */
static void set_defaults(LagInstance *s)
{
    const LagVital fresh = {.mode = LAG_MODE_INSTANTIATED, .t = s->fmu->start, .start = s->fmu->start,
                            .tolerance = s->fmu->tolerance};
    s->vital = fresh;
    memset(s->memory, 0, s->saved_size * sizeof *s->memory);
    for (int i = 0; i < lag_fmu_states(s->model); ++i)
        s->start[i] = NAN;
    for (int i = 0; i < s->model->n_inputs; ++i)
        s->u[i] = s->fmu->input_start[i];
    for (int i = 0; i < s->model->n_parameters; ++i) {
        s->given[i] = s->fmu->parameter_start[i];
        s->mask[i] = s->fmu->parameter_settable[i];
    }
}

static char *copy_of(const char *text)
{
    size_t size = 0;
    while (text[size] && size < LONGEST_NAME)
        ++size;
    char *copy = malloc(size + 1);
    if (copy) {
        memcpy(copy, text, size);
        copy[size] = 0;
    }
    return copy;
}

/* 0: it is logged. */
static int find_model(LagInstance *s, const LagBirth *birth)
{
    char why[700];
    s->fmu = lag_fmu_open(birth->resources, &s->fmu_memory, why, sizeof why);
    if (!s->fmu) {
        lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s", why);
        return 0;
    }
    s->model = s->fmu->model;
    if (s->kind == LAG_MODEL_EXCHANGE && s->model->n_delays > 0) {
        lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "what acts late has its past in Co-Simulation alone");
        return 0;
    }
    s->extents = birth->has_arrays ? s->fmu->extents : NULL;
    if (birth->token && strcmp(birth->token, s->fmu->token) == 0 && *s->name)
        return 1;
    lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "an instance needs a name and the token (FMI 2: guid) %s",
                     s->fmu->token);
    return 0;
}

LagInstance *lag_instance_new(const LagBirth *birth, LagLogger logger, void *wrapper)
{
    LagInstance *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->kind = birth->kind;
    s->is_logging = birth->is_logging;
    s->logger = logger;
    s->wrapper = wrapper;
    s->name = copy_of(birth->name ? birth->name : "");
    if (!s->name || !find_model(s, birth) || !take_memory(s)) {
        lag_instance_free(s);
        return NULL;
    }
    set_defaults(s);
    return s;
}

void lag_instance_free(LagInstance *instance)
{
    if (!instance)
        return;
    while (instance->states)
        lag_saved_free(instance, instance->states);
    lag_run_free(instance->run);
    free(instance->memory);
    free(instance->fmu_memory);
    free(instance->name);
    free(instance);
}

LagAnswer lag_instance_reset(LagInstance *instance)
{
    lag_run_free(instance->run);
    instance->run = NULL;
    set_defaults(instance);
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_setup(LagInstance *s, int has_tolerance, double tolerance, double start, int has_stop, double stop)
{
    if (!isfinite(start) || (has_stop && !(isfinite(stop) && stop >= start)))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "from %g to %g s is no time to simulate", start, stop);
    if (has_tolerance && !(tolerance > 0 && tolerance < 1))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "a tolerance of %g cannot be kept", tolerance);
    s->vital.t = s->vital.start = start;
    s->vital.has_stop = has_stop;
    s->vital.stop = has_stop ? stop : INFINITY;
    if (has_tolerance)
        s->vital.tolerance = tolerance;
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_exit_initialization(LagInstance *s)
{
    const LagAnswer answer = lag_instance_begin(s);
    if (answer == LAG_ANSWER_OK)
        s->vital.mode = s->kind == LAG_MODEL_EXCHANGE || s->uses_events ? LAG_MODE_EVENT : LAG_MODE_STEP;
    return answer;
}
