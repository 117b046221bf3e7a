/* FMI 2.0: every function of the standard, in terms of instance.h. */
#include "fmi2Functions.h"

#include <stdlib.h>
#include <string.h>

#include "fmi/instance.h"

typedef struct {
    LagInstance *core;
    fmi2CallbackFunctions functions;
    double last_step; /* time reached by the last step */
} Component;

static LagInstance *core(fmi2Component c) { return c ? ((Component *)c)->core : NULL; }

static fmi2Status status(LagAnswer answer) { return (fmi2Status)answer; }

static int allows(fmi2Component c, LagCall call, const char *name) { return lag_instance_allows(core(c), call, name); }

/* Loggers take a format: what it would take for conversions is doubled. */
static void log_message(const LagInstance *instance, LagAnswer answer, const char *category, const char *message)
{
    const Component *c = instance->wrapper;
    char text[2048];
    size_t used = 0;
    for (; *message && used < sizeof text - 2; ++message) {
        text[used++] = *message;
        if (*message == '%')
            text[used++] = '%';
    }
    text[used] = 0;
    if (c->functions.logger)
        c->functions.logger(c->functions.componentEnvironment, instance->name, status(answer), category, text);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories, const fmi2String categories[])
{
    (void)nCategories, (void)categories;
    if (!allows(c, LAG_CALL_LOGGING, "fmi2SetDebugLogging"))
        return fmi2Error;
    core(c)->is_logging = loggingOn != fmi2False;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID, fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)visible;
    Component *c = calloc(1, sizeof *c);
    if (!c)
        return NULL;
    if (functions)
        c->functions = *functions;
    const LagFmuKind kind = fmuType == fmi2ModelExchange ? LAG_MODEL_EXCHANGE : LAG_CO_SIMULATION;
    const LagBirth birth = {kind, instanceName, fmuGUID, fmuResourceLocation, loggingOn != fmi2False, 0};
    c->core = lag_instance_new(&birth, log_message, c);
    if (c->core)
        return c;
    free(c);
    return NULL;
}

void fmi2FreeInstance(fmi2Component c)
{
    lag_instance_free(core(c));
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    if (!allows(c, LAG_CALL_SETUP, "fmi2SetupExperiment"))
        return fmi2Error;
    return status(lag_instance_setup(core(c), toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    if (!allows(c, LAG_CALL_ENTER_INITIALIZATION, "fmi2EnterInitializationMode"))
        return fmi2Error;
    return status(lag_instance_enter_initialization(core(c)));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    if (!allows(c, LAG_CALL_EXIT_INITIALIZATION, "fmi2ExitInitializationMode"))
        return fmi2Error;
    const LagAnswer answer = lag_instance_exit_initialization(core(c));
    ((Component *)c)->last_step = core(c)->vital.t;
    return status(answer);
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    if (!allows(c, LAG_CALL_TERMINATE, "fmi2Terminate"))
        return fmi2Error;
    core(c)->vital.mode = LAG_MODE_TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    if (!allows(c, LAG_CALL_RESET, "fmi2Reset"))
        return fmi2Error;
    return status(lag_instance_reset(core(c)));
}

/* ---------------------------------------------------------------- values */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    if (!allows(c, LAG_CALL_GET, "fmi2GetReal"))
        return fmi2Error;
    return status(lag_instance_get(core(c), vr, nvr, value, nvr));
}

/* Whole numbers, one at a time. */
static fmi2Status get_whole(fmi2Component c, int group, const fmi2ValueReference vr[], size_t nvr, int value[])
{
    LagAnswer answer = LAG_ANSWER_OK;
    for (size_t i = 0; i < nvr && answer == LAG_ANSWER_OK; ++i) {
        double number = 0;
        answer = lag_instance_get_whole(core(c), group, vr ? vr + i : NULL, 1, value ? &number : NULL);
        if (answer == LAG_ANSWER_OK)
            value[i] = (int)number;
    }
    return status(answer);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    return allows(c, LAG_CALL_GET, "fmi2GetInteger") ? get_whole(c, LAG_GROUP_INTEGER, vr, nvr, value) : fmi2Error;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    return allows(c, LAG_CALL_GET, "fmi2GetBoolean") ? get_whole(c, LAG_GROUP_BOOLEAN, vr, nvr, value) : fmi2Error;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    if (!allows(c, LAG_CALL_GET, "fmi2GetString"))
        return fmi2Error;
    return status(lag_instance_get_strings(core(c), vr, nvr, value));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    if (!allows(c, LAG_CALL_SET, "fmi2SetReal"))
        return fmi2Error;
    return status(lag_instance_set(core(c), vr, nvr, value, nvr));
}

static fmi2Status set_nothing(fmi2Component c, size_t nvr, const char *function, const char *type)
{
    return allows(c, LAG_CALL_SET, function) ? status(lag_instance_no_set(core(c), nvr, type)) : fmi2Error;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    (void)vr, (void)value;
    return set_nothing(c, nvr, "fmi2SetInteger", "integer");
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    (void)vr, (void)value;
    return set_nothing(c, nvr, "fmi2SetBoolean", "Boolean");
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)vr, (void)value;
    return set_nothing(c, nvr, "fmi2SetString", "text");
}

/* ---------------------------------------------------------------- states to come back to */

static fmi2Status no_place(fmi2Component c)
{
    return status(lag_instance_log(core(c), LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "an argument is missing"));
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    if (!allows(c, LAG_CALL_SAVE, "fmi2GetFMUstate"))
        return fmi2Error;
    return FMUstate ? status(lag_instance_save(core(c), (LagSaved **)FMUstate)) : no_place(c);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    if (!allows(c, LAG_CALL_SAVE, "fmi2SetFMUstate"))
        return fmi2Error;
    return status(lag_instance_restore(core(c), FMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    if (!allows(c, LAG_CALL_SAVE, "fmi2FreeFMUstate"))
        return fmi2Error;
    if (FMUstate) {
        lag_saved_free(core(c), *FMUstate);
        *FMUstate = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    if (!allows(c, LAG_CALL_SAVE, "fmi2SerializedFMUstateSize"))
        return fmi2Error;
    if (!lag_saved_is_known(core(c), FMUstate) || !size)
        return no_place(c);
    *size = lag_saved_size(FMUstate);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    if (!allows(c, LAG_CALL_SAVE, "fmi2SerializeFMUstate"))
        return fmi2Error;
    if (!lag_saved_is_known(core(c), FMUstate) || !serializedState || size < lag_saved_size(FMUstate))
        return no_place(c);
    lag_saved_write(FMUstate, (unsigned char *)serializedState);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size, fmi2FMUstate *FMUstate)
{
    if (!allows(c, LAG_CALL_SAVE, "fmi2DeSerializeFMUstate"))
        return fmi2Error;
    if (!FMUstate)
        return no_place(c);
    return status(lag_saved_read(core(c), (const unsigned char *)serializedState, size, (LagSaved **)FMUstate));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[])
{
    if (!allows(c, LAG_CALL_DERIVE, "fmi2GetDirectionalDerivative"))
        return fmi2Error;
    const LagVariables unknowns = {vUnknown_ref, nUnknown, nUnknown}, knowns = {vKnown_ref, nKnown, nKnown};
    return status(lag_instance_forward(core(c), unknowns, knowns, dvKnown, dvUnknown));
}

/* ---------------------------------------------------------------- Model Exchange */

static int exchanges(fmi2Component c, LagCall call, const char *name)
{
    if (!allows(c, call, name))
        return 0;
    if (core(c)->kind == LAG_MODEL_EXCHANGE)
        return 1;
    lag_instance_log(core(c), LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s belongs to Model Exchange", name);
    return 0;
}

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    if (!exchanges(c, LAG_CALL_ENTER_EVENT, "fmi2EnterEventMode"))
        return fmi2Error;
    core(c)->vital.mode = LAG_MODE_EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    LagEventInfo info = {0, 0, 0};
    if (!exchanges(c, LAG_CALL_UPDATE_DISCRETE, "fmi2NewDiscreteStates"))
        return fmi2Error;
    if (!eventInfo)
        return no_place(c);
    const LagAnswer answer = lag_instance_update_discrete(core(c), &info);
    eventInfo->newDiscreteStatesNeeded = fmi2False;
    eventInfo->terminateSimulation = core(c)->vital.is_over;
    eventInfo->nominalsOfContinuousStatesChanged = fmi2False;
    eventInfo->valuesOfContinuousStatesChanged = info.values_changed;
    eventInfo->nextEventTimeDefined = info.has_next;
    eventInfo->nextEventTime = info.next;
    return status(answer);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    if (!exchanges(c, LAG_CALL_ENTER_CONTINUOUS, "fmi2EnterContinuousTimeMode"))
        return fmi2Error;
    core(c)->vital.mode = LAG_MODE_CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint, fmi2Boolean *enterEventMode,
                                       fmi2Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!exchanges(c, LAG_CALL_COMPLETED_STEP, "fmi2CompletedIntegratorStep"))
        return fmi2Error;
    if (!enterEventMode || !terminateSimulation)
        return no_place(c);
    const LagAnswer answer = lag_instance_completed_step(core(c), enterEventMode);
    *terminateSimulation = core(c)->vital.is_over;
    return status(answer);
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    if (!exchanges(c, LAG_CALL_SET_CONTINUOUS, "fmi2SetTime"))
        return fmi2Error;
    return status(lag_instance_set_time(core(c), time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    if (!exchanges(c, LAG_CALL_SET_CONTINUOUS, "fmi2SetContinuousStates"))
        return fmi2Error;
    return status(lag_instance_set_states(core(c), x, nx));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    if (!exchanges(c, LAG_CALL_GET_CONTINUOUS, "fmi2GetDerivatives"))
        return fmi2Error;
    return status(lag_instance_get_slopes(core(c), derivatives, nx));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    if (!exchanges(c, LAG_CALL_GET_CONTINUOUS, "fmi2GetEventIndicators"))
        return fmi2Error;
    return status(lag_instance_get_indicators(core(c), eventIndicators, ni));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    if (!exchanges(c, LAG_CALL_GET_CONTINUOUS, "fmi2GetContinuousStates"))
        return fmi2Error;
    return status(lag_instance_get_states(core(c), x, nx));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    if (!exchanges(c, LAG_CALL_NOMINALS, "fmi2GetNominalsOfContinuousStates"))
        return fmi2Error;
    return status(lag_instance_nominals(core(c), x_nominal, nx));
}

/* ---------------------------------------------------------------- Co-Simulation */

static int cosimulates(fmi2Component c, LagCall call, const char *name)
{
    if (!allows(c, call, name))
        return 0;
    if (core(c)->kind == LAG_CO_SIMULATION)
        return 1;
    lag_instance_log(core(c), LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s belongs to Co-Simulation", name);
    return 0;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[],
                                       const fmi2Real value[])
{
    LagAnswer answer = LAG_ANSWER_OK;
    if (!cosimulates(c, LAG_CALL_INPUT_SLOPES, "fmi2SetRealInputDerivatives"))
        return fmi2Error;
    if (nvr > 0 && (!vr || !order || !value))
        return no_place(c);
    for (size_t i = 0; i < nvr && answer == LAG_ANSWER_OK; ++i)
        answer = lag_instance_input_slope(core(c), vr[i], order[i], value[i]);
    return status(answer);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[],
                                        fmi2Real value[])
{
    LagAnswer answer = LAG_ANSWER_OK;
    if (!cosimulates(c, LAG_CALL_OUTPUT_SLOPES, "fmi2GetRealOutputDerivatives"))
        return fmi2Error;
    if (nvr > 0 && (!vr || !order || !value))
        return no_place(c);
    for (size_t i = 0; i < nvr && answer == LAG_ANSWER_OK; ++i)
        answer = lag_instance_output_slope(core(c), vr[i], order[i], value + i);
    return status(answer);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    LagStepResult result;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!cosimulates(c, LAG_CALL_DO_STEP, "fmi2DoStep"))
        return fmi2Error;
    const LagAnswer answer = lag_instance_step(core(c), currentCommunicationPoint, communicationStepSize, &result);
    ((Component *)c)->last_step = result.time;
    return answer <= LAG_ANSWER_WARNING && core(c)->vital.is_over ? fmi2Discard : status(answer);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    if (!cosimulates(c, LAG_CALL_STATUS, "fmi2CancelStep"))
        return fmi2Error;
    return status(lag_instance_log(core(c), LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "no step is pending"));
}

static fmi2Status no_status(fmi2Component c, const char *name)
{
    if (!cosimulates(c, LAG_CALL_STATUS, name))
        return fmi2Error;
    return status(lag_instance_log(core(c), LAG_ANSWER_DISCARD, "logStatusDiscard", "%s: steps are never pending", name));
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    (void)s, (void)value;
    return no_status(c, "fmi2GetStatus");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    if (s != fmi2LastSuccessfulTime || !value)
        return no_status(c, "fmi2GetRealStatus");
    if (!cosimulates(c, LAG_CALL_STATUS, "fmi2GetRealStatus"))
        return fmi2Error;
    *value = ((Component *)c)->last_step;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    (void)s, (void)value;
    return no_status(c, "fmi2GetIntegerStatus");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    if (s != fmi2Terminated || !value)
        return no_status(c, "fmi2GetBooleanStatus");
    if (!cosimulates(c, LAG_CALL_STATUS, "fmi2GetBooleanStatus"))
        return fmi2Error;
    *value = core(c)->vital.is_over;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    (void)s, (void)value;
    return no_status(c, "fmi2GetStringStatus");
}
