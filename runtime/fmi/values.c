/* Values by reference: read from the state of the instance, worked out when they are asked for. */
#include <math.h>
#include <string.h>

#include "fmi/instance.h"

#include "state/evaluate.h"
#include "model/function.h"
#include "steps/segment.h"
#include "state/state.h"

/* Parameters; between events, too: some importers do so. */
static const int ANY_TIME = LAG_MODE_INSTANTIATED | LAG_MODE_CONFIGURATION | LAG_MODE_INITIALIZATION | LAG_MODE_EVENT
    | LAG_MODE_CONTINUOUS | LAG_MODE_STEP;

int lag_fmu_count(const LagFmu *fmu, int group)
{
    const LagModel *m = fmu->model;
    switch (group) {
    case LAG_GROUP_TIME: return 1;
    case LAG_GROUP_STATE:
    case LAG_GROUP_SLOPE: return 2 * m->n;
    case LAG_GROUP_OUTPUT: return m->n_outputs;
    case LAG_GROUP_ENERGY: return LAG_ENERGIES;
    case LAG_GROUP_INPUT: return m->n_inputs;
    case LAG_GROUP_PARAMETER: return m->n_parameters;
    case LAG_GROUP_INDICATOR: return m->n_switches;
    case LAG_GROUP_REAL: return fmu->n_reals;
    case LAG_GROUP_INTEGER: return fmu->n_integers;
    case LAG_GROUP_BOOLEAN: return fmu->n_booleans;
    case LAG_GROUP_STRING: return fmu->n_strings;
    default: return 0;
    }
}

int lag_instance_locate(const LagFmu *fmu, unsigned int reference, int *index)
{
    for (int group = 0; group < LAG_GROUPS; ++group) {
        const unsigned int count = (unsigned int)lag_fmu_count(fmu, group);
        if (reference < count) {
            *index = (int)reference;
            return group;
        }
        reference -= count;
    }
    return -1;
}

static LagAnswer unknown(const LagInstance *s, unsigned int reference, const char *type)
{
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "there is no %s with the value reference %u", type, reference);
}

/* ---------------------------------------------------------------- start values and changes */

/* Inputs held at their present values, or going on with their slopes until t + h. */
static LagStatus set_inputs(LagInstance *s, double t)
{
    const size_t n = (size_t)s->model->n_inputs;
    s->table[0] = t;
    if (n > 0)
        memcpy(s->table + 1, s->u, n * sizeof *s->u);
    return n > 0 ? lag_run_set_inputs(s->run, s->table, s->table + 1, 1) : LAG_OK;
}

static LagAnswer check_parameters(LagInstance *s)
{
    const double *p = lag_run_parameters(s->run);
    const char *const *names = s->fmu->names + 1 + 4 * s->model->n + s->model->n_outputs + LAG_ENERGIES + s->model->n_inputs;
    for (int i = 0; i < s->model->n_parameters; ++i)
        if (!(p[i] >= s->fmu->minimum[i] && p[i] <= s->fmu->maximum[i]))
            return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%.200s is %g, which is not from %g to %g", names[i],
                                    p[i], s->fmu->minimum[i], s->fmu->maximum[i]);
    return LAG_ANSWER_OK;
}

void lag_instance_forget(LagInstance *s)
{
    s->vital.slope_is_current = s->vital.outputs_are_current = s->vital.energies_are_current = 0;
}

LagAnswer lag_instance_begin(LagInstance *s)
{
    LagRun *run = s->run;
    LagVital *vital = &s->vital;
    double energies[3];
    if (vital->has_started)
        return LAG_ANSWER_OK;
    run->started = 0;
    run->motion.t = vital->start; /* where the inputs begin */
    LagStatus status = lag_run_set_parameters(run, s->given, s->mask);
    if (check_parameters(s) != LAG_ANSWER_OK)
        return LAG_ANSWER_ERROR;
    if (status == LAG_OK)
        status = set_inputs(s, vital->start);
    if (status == LAG_OK)
        status = lag_run_start(run, s->start, s->start + s->model->n);
    if (status != LAG_OK) {
        const int mode = vital->mode; /* other values may still be set */
        lag_instance_failed(s, status);
        vital->mode = mode;
        return LAG_ANSWER_ERROR;
    }
    vital->has_started = 1;
    vital->parameters_changed = vital->inputs_changed = 0;
    vital->t = run->motion.t;
    memcpy(s->x, run->motion.y, 2 * (size_t)s->model->n * sizeof *s->x);
    lag_energies(run, vital->t, s->x, energies);
    vital->start_energy = energies[2];
    vital->supports_energy = energies[0] + energies[1] - energies[2];
    vital->dissipated = vital->work = 0;
    lag_instance_forget(s);
    if (s->kind == LAG_CO_SIMULATION) {
        lag_cosimulation_take_row(s);
    } else {
        lag_scale_note(&run->scale, s->fmu->nominal); /* what is 0 at the start: projecting tells errors from rounding by size */
        lag_exchange_note(s);
    }
    return LAG_ANSWER_OK;
}

static double total_energy(LagInstance *s)
{
    double energies[3];
    lag_energies(s->run, s->vital.t, s->x, energies);
    return energies[2];
}

/* In Model Exchange the run only holds what belongs to the parameters and the segment; the state is the importer's. */
static LagStatus settle_exchange(LagInstance *s)
{
    LagRun *run = s->run;
    const double before = total_energy(s);
    LagStatus status = LAG_OK;
    run->motion.t = s->vital.t;
    if (s->vital.parameters_changed) {
        run->started = 0; /* the account is kept here */
        status = lag_run_set_parameters(run, s->given, s->mask);
        run->started = 1;
        lag_segment_enter(run);
    }
    if (status == LAG_OK && s->vital.inputs_changed) {
        run->started = 0;
        status = set_inputs(s, s->vital.t);
        run->started = 1;
    }
    s->vital.work += total_energy(s) - before;
    return status;
}

static LagStatus settle_cosimulation(LagInstance *s)
{
    LagRun *run = s->run;
    LagStatus status = lag_run_cut(run, s->vital.t);
    if (status == LAG_OK && s->vital.parameters_changed)
        status = lag_run_set_parameters(run, s->given, s->mask);
    if (status == LAG_OK && s->vital.inputs_changed)
        status = set_inputs(s, s->vital.t);
    if (status == LAG_OK)
        status = lag_segment_next(run);
    if (status == LAG_OK)
        lag_cosimulation_take_row(s);
    return status;
}

LagAnswer lag_instance_settle(LagInstance *s)
{
    LagVital *vital = &s->vital;
    if (!s->run || (vital->mode & (LAG_MODE_TERMINATED | LAG_MODE_ERROR | LAG_MODE_INTERMEDIATE)))
        return LAG_ANSWER_OK;
    if (!vital->has_started)
        return lag_instance_begin(s);
    if (!vital->parameters_changed && !vital->inputs_changed)
        return LAG_ANSWER_OK;
    const LagStatus status = s->kind == LAG_MODEL_EXCHANGE ? settle_exchange(s) : settle_cosimulation(s);
    if (status != LAG_OK)
        return lag_instance_failed(s, status);
    lag_instance_forget(s);
    vital->outputs_are_current = vital->energies_are_current = s->kind == LAG_CO_SIMULATION;
    if (vital->parameters_changed && check_parameters(s) != LAG_ANSWER_OK)
        return LAG_ANSWER_ERROR;
    vital->parameters_changed = vital->inputs_changed = 0;
    return LAG_ANSWER_OK;
}

/* ---------------------------------------------------------------- getting */

static LagAnswer get_from(LagInstance *s, int group, int index, double *value)
{
    LagAnswer answer = LAG_ANSWER_OK;
    switch (group) {
    case LAG_GROUP_TIME: *value = s->vital.t; break;
    case LAG_GROUP_STATE: *value = s->x[index]; break;
    case LAG_GROUP_SLOPE:
        answer = lag_instance_slope(s);
        *value = s->slope[index];
        break;
    case LAG_GROUP_OUTPUT:
        answer = lag_instance_outputs(s);
        *value = s->outputs[index];
        break;
    case LAG_GROUP_ENERGY:
        answer = lag_instance_energies(s);
        *value = s->energies[index];
        break;
    case LAG_GROUP_INPUT: *value = s->u[index]; break;
    case LAG_GROUP_INDICATOR:
        answer = lag_instance_indicators(s);
        *value = s->indicators[index];
        break;
    case LAG_GROUP_PARAMETER: *value = s->run ? lag_run_parameters(s->run)[index] : s->given[index]; break;
    default: *value = s->fmu->reals[index]; break;
    }
    return answer;
}

LagAnswer lag_instance_get(LagInstance *s, const unsigned int *references, size_t count, double *values)
{
    if (count > 0 && (!references || !values))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "values are asked for with no place to put them");
    LagAnswer worst = lag_instance_settle(s);
    for (size_t i = 0; i < count && worst < LAG_ANSWER_ERROR; ++i) {
        int index = 0;
        const int group = lag_instance_locate(s->fmu, references[i], &index);
        if (group < 0 || group > LAG_GROUP_REAL)
            return unknown(s, references[i], "number");
        const LagAnswer answer = get_from(s, group, index, values + i);
        worst = answer > worst ? answer : worst;
    }
    return worst;
}

LagAnswer lag_instance_get_constants(LagInstance *s, int group, const unsigned int *references, size_t count, double *values)
{
    for (size_t i = 0; i < count; ++i) {
        int index = 0;
        if (!references || !values || lag_instance_locate(s->fmu, references[i], &index) != group)
            return unknown(s, references ? references[i] : 0, group == LAG_GROUP_INTEGER ? "integer" : "Boolean");
        values[i] = group == LAG_GROUP_INTEGER ? s->fmu->integers[index] : s->fmu->booleans[index];
    }
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_get_strings(LagInstance *s, const unsigned int *references, size_t count, const char **values)
{
    for (size_t i = 0; i < count; ++i) {
        int index = 0;
        if (!references || !values || lag_instance_locate(s->fmu, references[i], &index) != LAG_GROUP_STRING)
            return unknown(s, references ? references[i] : 0, "text");
        values[i] = s->fmu->strings[index];
    }
    return LAG_ANSWER_OK;
}

/* ---------------------------------------------------------------- setting */

static LagAnswer refuse(const LagInstance *s, unsigned int reference, const char *why)
{
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%.200s cannot be set: %s", s->fmu->names[reference], why);
}

static LagAnswer set_start(LagInstance *s, unsigned int reference, int index, double value)
{
    const int early = LAG_MODE_INSTANTIATED | LAG_MODE_CONFIGURATION | LAG_MODE_INITIALIZATION;
    if (!(s->vital.mode & early)) {
        if (s->kind != LAG_MODEL_EXCHANGE)
            return refuse(s, reference, "it is integrated");
        const LagAnswer answer = lag_instance_settle(s); /* some importers set states one by one */
        s->x[index] = value;
        lag_instance_forget(s);
        return answer;
    }
    if (!s->fmu->state_settable[index])
        return refuse(s, reference, "its start follows from parameters");
    /* Importers write all start values back: what the description says already is nothing new. */
    s->start[index] = value == s->fmu->state_start[index] ? NAN : value;
    s->vital.has_started = 0;
    return LAG_ANSWER_OK;
}

static LagAnswer set_parameter(LagInstance *s, unsigned int reference, int index, double value)
{
    if (!s->fmu->parameter_settable[index])
        return refuse(s, reference, "it follows from other parameters");
    if (!(s->vital.mode & ANY_TIME))
        return refuse(s, reference, "not within a step");
    if (!(value >= s->fmu->minimum[index] && value <= s->fmu->maximum[index]))
        return refuse(s, reference, "the value is outside its limits");
    if (s->given[index] == value)
        return LAG_ANSWER_OK;
    s->given[index] = value;
    s->vital.parameters_changed = 1;
    if (s->vital.mode & LAG_MODE_INITIALIZATION)
        s->vital.has_started = 0;
    return LAG_ANSWER_OK;
}

static LagAnswer set_input(LagInstance *s, int index, double value)
{
    if (!s->vital.has_slopes) /* else it is of the step to come, as this value is */
        s->u_slope[index] = 0;
    if (s->u[index] == value)
        return LAG_ANSWER_OK;
    s->u[index] = value;
    s->vital.inputs_changed = 1;
    if (s->vital.mode & LAG_MODE_INITIALIZATION)
        s->vital.has_started = 0;
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_set(LagInstance *s, const unsigned int *references, size_t count, const double *values)
{
    if (count > 0 && (!references || !values))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "values are set with none given");
    LagAnswer answer = LAG_ANSWER_OK;
    for (size_t i = 0; i < count && answer == LAG_ANSWER_OK; ++i) {
        int index = 0;
        const int group = lag_instance_locate(s->fmu, references[i], &index);
        if (group < 0 || group > LAG_GROUP_REAL)
            return unknown(s, references[i], "number");
        if (!isfinite(values[i]))
            answer = refuse(s, references[i], "the value is not finite");
        else if (group == LAG_GROUP_STATE)
            answer = set_start(s, references[i], index, values[i]);
        else if (group == LAG_GROUP_INPUT)
            answer = set_input(s, index, values[i]);
        else if (group == LAG_GROUP_PARAMETER)
            answer = set_parameter(s, references[i], index, values[i]);
        else
            answer = refuse(s, references[i], "it is computed, or constant");
    }
    return answer;
}

LagAnswer lag_instance_no_set(LagInstance *s, size_t count, const char *type)
{
    if (count == 0)
        return LAG_ANSWER_OK;
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "no %s can be set", type);
}
