/* Values by reference: read from the state of the instance, worked out when they are asked for. */
#include <limits.h>
#include <math.h>

#include "fmi/instance.h"

/* Parameters; between events, too: some importers do so. */
static const int ANY_TIME = LAG_MODE_INSTANTIATED | LAG_MODE_CONFIGURATION | LAG_MODE_INITIALIZATION | LAG_MODE_EVENT
    | LAG_MODE_CONTINUOUS | LAG_MODE_STEP;

static LagAnswer unknown(const LagInstance *s, unsigned int reference, const char *type)
{
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "there is no %s with the value reference %u", type, reference);
}

size_t lag_instance_extent(const LagInstance *s, unsigned int reference)
{
    int index = 0;
    if (lag_instance_locate(s->fmu, reference, &index) < 0)
        return 0;
    return s->extents ? (size_t)s->extents[reference] : 1;
}

LagAnswer lag_instance_fits(const LagInstance *s, const unsigned int *references, size_t count, size_t size, const char *what)
{
    size_t wanted = 0;
    for (size_t i = 0; i < count; ++i) {
        const size_t extent = lag_instance_extent(s, references[i]);
        if (extent == 0)
            return unknown(s, references[i], what);
        wanted += extent;
    }
    if (wanted == size)
        return LAG_ANSWER_OK;
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "the value references stand for %lu numbers, and there are %lu",
                            (unsigned long)wanted, (unsigned long)size);
}

/* ---------------------------------------------------------------- getting */

/* A discrete variable, which is a state at rest. */
static double kept(const LagInstance *s, int group, int index)
{
    const LagFmu *fmu = s->fmu;
    const int reals = group == LAG_GROUP_KEPT_REAL ? 0 : fmu->n_kept_reals;
    const int first = reals + (group == LAG_GROUP_KEPT_BOOLEAN ? fmu->n_kept_integers : 0);
    return s->x[fmu->kept[first + index]];
}

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
        *value = s->outputs[4 * s->model->n_attitudes + index];
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
    case LAG_GROUP_KEPT_REAL:
    case LAG_GROUP_KEPT_INTEGER:
    case LAG_GROUP_KEPT_BOOLEAN: *value = kept(s, group, index); break;
    default: *value = s->fmu->reals[index]; break;
    }
    return answer;
}

LagAnswer lag_instance_get(LagInstance *s, const unsigned int *references, size_t count, double *values, size_t size)
{
    if (count > 0 && (!references || !values))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "values are asked for with no place to put them");
    LagAnswer worst = lag_instance_fits(s, references, count, size, "number");
    if (worst == LAG_ANSWER_OK)
        worst = lag_instance_settle(s);
    for (size_t i = 0, done = 0; i < count && worst < LAG_ANSWER_ERROR; ++i) {
        int index = 0;
        const int group = lag_instance_locate(s->fmu, references[i], &index), end = index + (int)lag_instance_extent(s, references[i]);
        if (group > LAG_GROUP_REAL)
            return unknown(s, references[i], "number");
        for (; index < end && worst < LAG_ANSWER_ERROR; ++index) {
            const LagAnswer answer = get_from(s, group, index, values + done++);
            worst = answer > worst ? answer : worst;
        }
    }
    return worst;
}

/* Whether a double is a value of the standards' Integer, and said where it is none. */
static LagAnswer as_integer(const LagInstance *s, unsigned int reference, double value)
{
    return value >= INT_MIN && value <= INT_MAX
        ? LAG_ANSWER_OK
        : lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s is %.9g at t = %.9g s, beyond the whole numbers of 32 bits",
                           s->fmu->names[reference], value, s->vital.t);
}

LagAnswer lag_instance_get_whole(LagInstance *s, int group, const unsigned int *references, size_t count, double *values)
{
    const int is_integer = group == LAG_GROUP_INTEGER, changing = is_integer ? LAG_GROUP_KEPT_INTEGER : LAG_GROUP_KEPT_BOOLEAN;
    LagAnswer worst = LAG_ANSWER_OK;
    for (size_t i = 0; i < count && worst < LAG_ANSWER_ERROR; ++i) {
        int index = 0;
        const int found = references && values ? lag_instance_locate(s->fmu, references[i], &index) : -1;
        if (found != group && found != changing && found != LAG_GROUP_OUTPUT)
            return unknown(s, references ? references[i] : 0, is_integer ? "integer" : "Boolean");
        if (found == group) {
            values[i] = is_integer ? s->fmu->integers[index] : s->fmu->booleans[index];
            continue;
        }
        const LagAnswer settled = lag_instance_settle(s), answer = get_from(s, found, index, values + i);
        worst = settled > worst ? settled : worst;
        worst = answer > worst ? answer : worst;
        values[i] = is_integer ? nearbyint(values[i]) : values[i] > 0.5;
        const LagAnswer whole = is_integer && worst < LAG_ANSWER_ERROR ? as_integer(s, references[i], values[i]) : LAG_ANSWER_OK;
        worst = whole > worst ? whole : worst;
    }
    return worst;
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

static int is_early(const LagInstance *s)
{
    return s->vital.mode & (LAG_MODE_INSTANTIATED | LAG_MODE_CONFIGURATION | LAG_MODE_INITIALIZATION);
}

/* Whether one number, by its own reference, which may be that of an element, can be set to this value. */
static LagAnswer may_set(const LagInstance *s, unsigned int reference, double value)
{
    int index = 0;
    const int group = lag_instance_locate(s->fmu, reference, &index);
    if (group > LAG_GROUP_REAL)
        return unknown(s, reference, "number");
    if (!isfinite(value))
        return refuse(s, reference, "the value is not finite");
    if (group == LAG_GROUP_INPUT)
        return LAG_ANSWER_OK;
    if (group == LAG_GROUP_STATE) {
        if (!is_early(s))
            return s->kind == LAG_MODEL_EXCHANGE ? LAG_ANSWER_OK : refuse(s, reference, "it is integrated");
        return s->fmu->state_settable[index] ? LAG_ANSWER_OK : refuse(s, reference, "its start follows from parameters");
    }
    if (group != LAG_GROUP_PARAMETER)
        return refuse(s, reference, "it is computed, or constant");
    if (!s->fmu->parameter_settable[index])
        return refuse(s, reference, "it follows from other parameters");
    if (!(s->vital.mode & ANY_TIME))
        return refuse(s, reference, "not within a step");
    if (!(value >= s->fmu->minimum[index] && value <= s->fmu->maximum[index]))
        return refuse(s, reference, "the value is outside its limits");
    return LAG_ANSWER_OK;
}

static LagAnswer set_state(LagInstance *s, int index, double value)
{
    if (!is_early(s)) {
        const LagAnswer answer = lag_instance_settle(s); /* some importers set states one by one */
        s->x[index] = value;
        lag_instance_forget(s);
        return answer;
    }
    /* Importers write all start values back: what the description says already is nothing new. */
    s->start[index] = value == s->fmu->state_start[index] ? NAN : value;
    s->vital.has_started = 0;
    return LAG_ANSWER_OK;
}

static LagAnswer set_parameter(LagInstance *s, int index, double value)
{
    if (s->given[index] == value)
        return LAG_ANSWER_OK;
    s->given[index] = value;
    s->vital.parameters_changed = 1;
    if (s->vital.mode & LAG_MODE_INITIALIZATION)
        s->vital.has_started = 0;
    return LAG_ANSWER_OK;
}

/* Whether an input goes on with its rates until it is set again. */
static int goes_on(const LagModel *model, int index)
{
    for (int k = 0; k < 4 * model->n_pieces; ++k)
        if (k % 4 < 3 && model->pieces[k] == index && model->pieces[k - k % 4 + 1] >= 0)
            return 1;
    return 0;
}

static LagAnswer set_input(LagInstance *s, int index, double value)
{
    if (!s->vital.has_slopes) /* else it is of the step to come, as this value is */
        s->u_slope[index] = 0;
    if (s->u[index] == value && !goes_on(s->model, index))
        return LAG_ANSWER_OK;
    s->u[index] = value;
    s->vital.inputs_changed = 1;
    if (s->vital.mode & LAG_MODE_CONTINUOUS)
        lag_exchange_widen(s, index);
    if (s->vital.mode & LAG_MODE_INITIALIZATION)
        s->vital.has_started = 0;
    return LAG_ANSWER_OK;
}

static LagAnswer set_number(LagInstance *s, unsigned int reference, double value)
{
    int index = 0;
    switch (lag_instance_locate(s->fmu, reference, &index)) {
    case LAG_GROUP_STATE: return set_state(s, index, value);
    case LAG_GROUP_INPUT: return set_input(s, index, value);
    default: return set_parameter(s, index, value);
    }
}

/* Asks of each number, or sets it, until one is refused. */
static LagAnswer each_number(LagInstance *s, const unsigned int *references, size_t count, const double *values, int is_asked)
{
    LagAnswer answer = LAG_ANSWER_OK;
    for (size_t i = 0, done = 0; i < count && answer == LAG_ANSWER_OK; ++i) {
        const size_t extent = lag_instance_extent(s, references[i]);
        for (size_t k = 0; k < extent && answer == LAG_ANSWER_OK; ++k) {
            const unsigned int reference = references[i] + (unsigned int)k;
            const double value = values[done++];
            answer = is_asked ? may_set(s, reference, value) : set_number(s, reference, value);
        }
    }
    return answer;
}

LagAnswer lag_instance_set(LagInstance *s, const unsigned int *references, size_t count, const double *values, size_t size)
{
    if (count > 0 && (!references || !values))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "values are set with none given");
    LagAnswer answer = lag_instance_fits(s, references, count, size, "number");
    if (answer == LAG_ANSWER_OK) /* all or none */
        answer = each_number(s, references, count, values, 1);
    return answer == LAG_ANSWER_OK ? each_number(s, references, count, values, 0) : answer;
}

LagAnswer lag_instance_no_set(LagInstance *s, size_t count, const char *type)
{
    if (count == 0)
        return LAG_ANSWER_OK;
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "no %s can be set", type);
}
