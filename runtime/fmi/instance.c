/* Birth, life and death of an instance; which calls are allowed when; what is told about errors. */
#include "fmi/instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "state/state.h"

enum {
    ANY_MODE = LAG_MODE_INSTANTIATED | LAG_MODE_CONFIGURATION | LAG_MODE_INITIALIZATION | LAG_MODE_EVENT | LAG_MODE_CONTINUOUS
        | LAG_MODE_STEP | LAG_MODE_INTERMEDIATE | LAG_MODE_TERMINATED | LAG_MODE_ERROR,
    RUNNING = LAG_MODE_EVENT | LAG_MODE_CONTINUOUS | LAG_MODE_STEP,
    KNOWN = LAG_MODE_INITIALIZATION | RUNNING | LAG_MODE_TERMINATED | LAG_MODE_ERROR,
    LONGEST_MESSAGE = 1000,
    LONGEST_NAME = 200
};

static const int ALLOWED[LAG_CALLS] = {
    [LAG_CALL_LOGGING] = ANY_MODE,
    [LAG_CALL_SETUP] = LAG_MODE_INSTANTIATED,
    [LAG_CALL_ENTER_INITIALIZATION] = LAG_MODE_INSTANTIATED,
    [LAG_CALL_EXIT_INITIALIZATION] = LAG_MODE_INITIALIZATION,
    [LAG_CALL_ENTER_EVENT] = LAG_MODE_CONTINUOUS | LAG_MODE_STEP | LAG_MODE_EVENT,
    [LAG_CALL_UPDATE_DISCRETE] = LAG_MODE_EVENT,
    [LAG_CALL_ENTER_CONTINUOUS] = LAG_MODE_EVENT,
    [LAG_CALL_ENTER_STEP] = LAG_MODE_EVENT,
    [LAG_CALL_ENTER_CONFIGURATION] = LAG_MODE_INSTANTIATED | LAG_MODE_EVENT | LAG_MODE_STEP,
    [LAG_CALL_EXIT_CONFIGURATION] = LAG_MODE_CONFIGURATION,
    [LAG_CALL_TERMINATE] = RUNNING | LAG_MODE_ERROR,
    [LAG_CALL_RESET] = ANY_MODE & ~LAG_MODE_INTERMEDIATE,
    [LAG_CALL_GET] = KNOWN | LAG_MODE_INTERMEDIATE,
    [LAG_CALL_SET] = LAG_MODE_INSTANTIATED | LAG_MODE_CONFIGURATION | LAG_MODE_INITIALIZATION | RUNNING | LAG_MODE_INTERMEDIATE,
    [LAG_CALL_SAVE] = ANY_MODE & ~LAG_MODE_INTERMEDIATE,
    [LAG_CALL_DERIVE] = KNOWN & ~LAG_MODE_ERROR,
    [LAG_CALL_SET_CONTINUOUS] = LAG_MODE_CONTINUOUS | LAG_MODE_EVENT,
    [LAG_CALL_GET_CONTINUOUS] = KNOWN,
    [LAG_CALL_NOMINALS] = KNOWN | LAG_MODE_INSTANTIATED,
    [LAG_CALL_COUNTS] = ANY_MODE,
    [LAG_CALL_COMPLETED_STEP] = LAG_MODE_CONTINUOUS,
    [LAG_CALL_INPUT_SLOPES] = LAG_MODE_INSTANTIATED | LAG_MODE_INITIALIZATION | LAG_MODE_STEP,
    [LAG_CALL_OUTPUT_SLOPES] = LAG_MODE_STEP | LAG_MODE_EVENT | LAG_MODE_INTERMEDIATE | LAG_MODE_TERMINATED,
    [LAG_CALL_DO_STEP] = LAG_MODE_STEP,
    [LAG_CALL_STATUS] = ANY_MODE,
};

static const char *mode_name(int mode)
{
    switch (mode) {
    case LAG_MODE_INSTANTIATED: return "instantiated";
    case LAG_MODE_CONFIGURATION: return "configuration mode";
    case LAG_MODE_INITIALIZATION: return "initialization mode";
    case LAG_MODE_EVENT: return "event mode";
    case LAG_MODE_CONTINUOUS: return "continuous-time mode";
    case LAG_MODE_STEP: return "step mode";
    case LAG_MODE_INTERMEDIATE: return "an intermediate update";
    case LAG_MODE_TERMINATED: return "terminated";
    default: return "in error: only reset, the restoring of a state, and free are left";
    }
}

LagAnswer lag_instance_log(const LagInstance *instance, LagAnswer answer, const char *category, const char *format, ...)
{
    char message[LONGEST_MESSAGE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (instance->logger && (instance->is_logging || answer >= LAG_ANSWER_ERROR))
        instance->logger(instance, answer, category, message);
    return answer;
}

int lag_instance_allows(LagInstance *instance, LagCall call, const char *function)
{
    if (!instance)
        return 0;
    if (ALLOWED[call] & instance->vital.mode)
        return 1;
    lag_instance_log(instance, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s is not allowed now: the instance is %s", function,
                     mode_name(instance->vital.mode));
    return 0;
}

static void layout(LagInstance *s, LagArena *arena)
{
    const LagModel *m = s->model;
    const size_t n = (size_t)m->n, inputs = (size_t)m->n_inputs, power = (size_t)m->n_power;
    s->given = lag_take(arena, (size_t)m->n_parameters);
    s->start = lag_take(arena, 2 * n);
    s->u = lag_take(arena, inputs);
    s->u_slope = lag_take(arena, inputs);
    s->x = lag_take(arena, 2 * n);
    s->slope = lag_take(arena, 2 * n);
    s->outputs = lag_take(arena, (size_t)m->n_outputs);
    s->energies = lag_take(arena, LAG_ENERGIES);
    s->power = lag_take(arena, power);
    s->last = lag_take(arena, 2 * n);
    s->last_slope = lag_take(arena, 2 * n);
    s->last_power = lag_take(arena, power);
    s->slack = lag_take(arena, (size_t)m->n_whens);
    s->saved_size = arena->used;
    s->scratch = lag_take(arena, 5 * n);
    s->projected = lag_take(arena, 2 * n + (size_t)m->n_power);
    s->indicators = lag_take(arena, (size_t)m->n_switches);
    s->switches = lag_take(arena, (size_t)m->n_switches);
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
    for (int i = 0; i < 2 * s->model->n; ++i)
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

LagInstance *lag_instance_new(const LagFmu *fmu, LagFmuKind kind, const char *name, LagLogger logger, void *wrapper)
{
    LagInstance *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->fmu = fmu;
    s->model = fmu->model;
    s->kind = kind;
    s->logger = logger;
    s->name = copy_of(name ? name : "");
    if (!s->name || !take_memory(s)) {
        lag_instance_free(s);
        return NULL;
    }
    s->wrapper = wrapper;
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

LagAnswer lag_instance_enter_initialization(LagInstance *s)
{
    const int steps_alone = s->kind == LAG_CO_SIMULATION;
    const LagSettings settings = {.t_start = s->vital.start, .t_stop = s->vital.has_stop && steps_alone ? s->vital.stop : INFINITY,
                                  .tolerance = s->vital.tolerance,
                                  .solver = steps_alone ? LAG_SOLVER_AUTO : LAG_SOLVER_ERK};
    lag_run_free(s->run);
    s->run = lag_run_new(s->model, &settings);
    memset(s->table, 0, 2 * (1 + (size_t)s->model->n_inputs) * sizeof *s->table);
    /* Room for a table of two rows is taken now. */
    if (!s->run || lag_run_set_inputs(s->run, s->table, s->table + 2, 2) != LAG_OK)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "no memory is left");
    s->vital.has_started = 0;
    s->vital.mode = LAG_MODE_INITIALIZATION;
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_exit_initialization(LagInstance *s)
{
    const LagAnswer answer = lag_instance_begin(s);
    if (answer == LAG_ANSWER_OK)
        s->vital.mode = s->kind == LAG_MODEL_EXCHANGE || s->uses_events ? LAG_MODE_EVENT : LAG_MODE_STEP;
    return answer;
}

static const char *name_of(const LagInstance *s, int index, int rate)
{
    const int place = index + (rate ? s->model->n : 0);
    return index >= 0 && place < 2 * s->model->n ? s->fmu->names[1 + place] : "";
}

LagAnswer lag_instance_failed(LagInstance *s, LagStatus status)
{
    const LagFailure *failure = lag_run_failure(s->run);
    const char *about = failure->status == LAG_INITIAL_FAILED ? "" : name_of(s, failure->index, failure->rate);
    const char *text = "the run stopped";
    switch (status) {
    case LAG_INITIAL_FAILED: text = "the initial equations cannot all hold"; break;
    case LAG_NOT_FINITE: text = "the accelerations are not finite: look at the parameters, inputs and start values"; break;
    case LAG_STEP_TOO_SMALL: text = "no step is small enough here: a singularity, or values beyond the range of numbers"; break;
    case LAG_TOO_MANY_STEPS: text = "one communication step took ten million internal steps"; break;
    case LAG_TIME_PASSED: text = "a time was asked for that lies before what is still known"; break;
    case LAG_PAST_STOP: text = "a time was asked for that lies after the stop time"; break;
    case LAG_NO_IMPULSE: text = "contacts and their friction have neither forces nor impulses that go together"; break;
    case LAG_EVENTS_GO_ON: text = "events that reset rates bring each other about without end"; break;
    case LAG_CONSTRAINTS_OPEN: text = "constraints do not close"; break;
    case LAG_NO_PROGRESS: text = "steps are too short to get on"; break;
    case LAG_OUT_OF_MEMORY: text = "no memory is left"; break;
    default: break;
    }
    s->vital.mode = LAG_MODE_ERROR;
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "at t = %.9g s: %s%s%.200s%s", failure->time, text,
                            *about ? " (" : "", about, *about ? ")" : "");
}
