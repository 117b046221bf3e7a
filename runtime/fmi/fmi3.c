/* FMI 3.0: the functions of the standard that mean something here, in terms of instance.h; the others are in fmi3_unused.c. */
#include "fmi/fmi3_instance.h"

#include <stdlib.h>
#include <string.h>

static LagInstance *core(fmi3Instance instance) { return lag_fmi3_core(instance); }

static fmi3Status status(LagAnswer answer) { return (fmi3Status)answer; }

static int allows(fmi3Instance instance, LagCall call, const char *name) { return lag_instance_allows(core(instance), call, name); }

static fmi3Status error(fmi3Instance instance, const char *text)
{
    return status(lag_instance_log(core(instance), LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s", text));
}

static fmi3Status no_place(fmi3Instance instance) { return error(instance, "an argument is missing, or has another size"); }

static void log_message(const LagInstance *instance, LagAnswer answer, const char *category, const char *message)
{
    const Fmi3 *wrapper = instance->wrapper;
    if (wrapper->log_message)
        wrapper->log_message(wrapper->environment, status(answer), category, message);
}

static int intermediate(LagInstance *instance, double t, double *time)
{
    const Fmi3 *wrapper = instance->wrapper;
    fmi3Boolean wants_return = fmi3False;
    fmi3Float64 early = t;
    wrapper->intermediate_update(wrapper->environment, t, instance->model->n_inputs > 0, fmi3True, fmi3True,
                                 instance->may_return_early != 0, &wants_return, &early);
    *time = early;
    return wants_return;
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories, const fmi3String categories[])
{
    (void)nCategories, (void)categories;
    if (!allows(instance, LAG_CALL_LOGGING, "fmi3SetDebugLogging"))
        return fmi3Error;
    core(instance)->is_logging = loggingOn;
    return fmi3OK;
}

/* ---------------------------------------------------------------- birth and death */

static fmi3Instance instantiate(const LagBirth *birth, Fmi3 callbacks)
{
    Fmi3 *wrapper = malloc(sizeof *wrapper);
    if (!wrapper)
        return NULL;
    *wrapper = callbacks;
    wrapper->core = lag_instance_new(birth, log_message, wrapper);
    if (wrapper->core) {
        wrapper->core->intermediate = callbacks.intermediate_update ? intermediate : NULL;
        return wrapper;
    }
    free(wrapper);
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                          fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    (void)visible;
    const LagBirth birth = {LAG_MODEL_EXCHANGE, instanceName, instantiationToken, resourcePath, loggingOn, 1};
    const Fmi3 callbacks = {NULL, instanceEnvironment, logMessage, NULL};
    return instantiate(&birth, callbacks);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                         fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
                                         fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)visible, (void)requiredIntermediateVariables, (void)nRequiredIntermediateVariables;
    const LagBirth birth = {LAG_CO_SIMULATION, instanceName, instantiationToken, resourcePath, loggingOn, 1};
    const Fmi3 callbacks = {NULL, instanceEnvironment, logMessage, intermediateUpdate};
    Fmi3 *wrapper = instantiate(&birth, callbacks);
    if (wrapper) {
        wrapper->core->uses_events = eventModeUsed;
        wrapper->core->may_return_early = earlyReturnAllowed;
    }
    return wrapper;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                               fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                               fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)instanceName, (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, LAG_ERROR_CATEGORY, "there is no Scheduled Execution here");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    lag_instance_free(core(instance));
    free(instance);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    if (!allows(instance, LAG_CALL_ENTER_INITIALIZATION, "fmi3EnterInitializationMode"))
        return fmi3Error;
    LagAnswer answer = lag_instance_setup(core(instance), toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_enter_initialization(core(instance));
    return status(answer);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    if (!allows(instance, LAG_CALL_EXIT_INITIALIZATION, "fmi3ExitInitializationMode"))
        return fmi3Error;
    return status(lag_instance_exit_initialization(core(instance)));
}

static fmi3Status enter(fmi3Instance instance, LagCall call, const char *name, int mode)
{
    if (!allows(instance, call, name))
        return fmi3Error;
    core(instance)->vital.mode = mode;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    if (core(instance) && core(instance)->kind == LAG_CO_SIMULATION && !core(instance)->uses_events)
        return error(instance, "fmi3EnterEventMode: the instance was made without event mode");
    return enter(instance, LAG_CALL_ENTER_EVENT, "fmi3EnterEventMode", LAG_MODE_EVENT);
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    return enter(instance, LAG_CALL_TERMINATE, "fmi3Terminate", LAG_MODE_TERMINATED);
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    return allows(instance, LAG_CALL_RESET, "fmi3Reset") ? status(lag_instance_reset(core(instance))) : fmi3Error;
}

/* ---------------------------------------------------------------- values */

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues)
{
    if (!allows(instance, LAG_CALL_GET, "fmi3GetFloat64"))
        return fmi3Error;
    return status(lag_instance_get(core(instance), valueReferences, nValueReferences, values, nValues));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues)
{
    if (!allows(instance, LAG_CALL_SET, "fmi3SetFloat64"))
        return fmi3Error;
    return status(lag_instance_set(core(instance), valueReferences, nValueReferences, values, nValues));
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int32 values[], size_t nValues)
{
    LagAnswer answer = LAG_ANSWER_OK;
    if (!allows(instance, LAG_CALL_GET, "fmi3GetInt32"))
        return fmi3Error;
    if (nValues != nValueReferences || (nValues > 0 && (!values || !valueReferences)))
        return no_place(instance);
    for (size_t i = 0; i < nValues && answer == LAG_ANSWER_OK; ++i) {
        double value = 0;
        answer = lag_instance_get_whole(core(instance), LAG_GROUP_INTEGER, valueReferences + i, 1, &value);
        if (answer < LAG_ANSWER_ERROR)
            values[i] = (fmi3Int32)value;
    }
    return status(answer);
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Boolean values[], size_t nValues)
{
    LagAnswer answer = LAG_ANSWER_OK;
    if (!allows(instance, LAG_CALL_GET, "fmi3GetBoolean"))
        return fmi3Error;
    if (nValues != nValueReferences || (nValues > 0 && (!values || !valueReferences)))
        return no_place(instance);
    for (size_t i = 0; i < nValues && answer == LAG_ANSWER_OK; ++i) {
        double value = 0;
        answer = lag_instance_get_whole(core(instance), LAG_GROUP_BOOLEAN, valueReferences + i, 1, &value);
        values[i] = value != 0;
    }
    return status(answer);
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         fmi3String values[], size_t nValues)
{
    if (!allows(instance, LAG_CALL_GET, "fmi3GetString"))
        return fmi3Error;
    if (nValues != nValueReferences)
        return no_place(instance);
    return status(lag_instance_get_strings(core(instance), valueReferences, nValueReferences, values));
}

/* ---------------------------------------------------------------- states to come back to */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    if (!allows(instance, LAG_CALL_SAVE, "fmi3GetFMUState"))
        return fmi3Error;
    return FMUState ? status(lag_instance_save(core(instance), (LagSaved **)FMUState)) : no_place(instance);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    return allows(instance, LAG_CALL_SAVE, "fmi3SetFMUState") ? status(lag_instance_restore(core(instance), FMUState)) : fmi3Error;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    if (!allows(instance, LAG_CALL_SAVE, "fmi3FreeFMUState"))
        return fmi3Error;
    if (FMUState) {
        lag_saved_free(core(instance), *FMUState);
        *FMUState = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    if (!allows(instance, LAG_CALL_SAVE, "fmi3SerializedFMUStateSize"))
        return fmi3Error;
    if (!lag_saved_is_known(core(instance), FMUState) || !size)
        return no_place(instance);
    *size = lag_saved_size(FMUState);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    if (!allows(instance, LAG_CALL_SAVE, "fmi3SerializeFMUState"))
        return fmi3Error;
    if (!lag_saved_is_known(core(instance), FMUState) || !serializedState || size < lag_saved_size(FMUState))
        return no_place(instance);
    lag_saved_write(FMUState, serializedState);
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size, fmi3FMUState *FMUState)
{
    if (!allows(instance, LAG_CALL_SAVE, "fmi3DeserializeFMUState"))
        return fmi3Error;
    return FMUState ? status(lag_saved_read(core(instance), serializedState, size, (LagSaved **)FMUState)) : no_place(instance);
}

/* ---------------------------------------------------------------- derivatives */

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity)
{
    if (!allows(instance, LAG_CALL_DERIVE, "fmi3GetDirectionalDerivative"))
        return fmi3Error;
    const LagVariables of = {unknowns, nUnknowns, nSensitivity}, by = {knowns, nKnowns, nSeed};
    return status(lag_instance_forward(core(instance), of, by, seed, sensitivity));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity)
{
    if (!allows(instance, LAG_CALL_DERIVE, "fmi3GetAdjointDerivative"))
        return fmi3Error;
    const LagVariables of = {unknowns, nUnknowns, nSeed}, by = {knowns, nKnowns, nSensitivity};
    return status(lag_instance_adjoint(core(instance), of, by, seed, sensitivity));
}

/* ---------------------------------------------------------------- modes */

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    return allows(instance, LAG_CALL_ENTER_CONFIGURATION, "fmi3EnterConfigurationMode")
        ? error(instance, "fmi3EnterConfigurationMode: there are no structural parameters that could be changed") : fmi3Error;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    return enter(instance, LAG_CALL_EXIT_CONFIGURATION, "fmi3ExitConfigurationMode", LAG_MODE_INSTANTIATED);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    return allows(instance, LAG_CALL_UPDATE_DISCRETE, "fmi3EvaluateDiscreteStates") ? fmi3OK : fmi3Error;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate, fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged, fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime)
{
    LagEventInfo info = {0, 0, 0};
    if (!allows(instance, LAG_CALL_UPDATE_DISCRETE, "fmi3UpdateDiscreteStates"))
        return fmi3Error;
    if (!discreteStatesNeedUpdate || !terminateSimulation || !nominalsOfContinuousStatesChanged || !valuesOfContinuousStatesChanged
        || !nextEventTimeDefined || !nextEventTime)
        return no_place(instance);
    const LagAnswer answer = lag_instance_update_discrete(core(instance), &info);
    *terminateSimulation = core(instance)->vital.is_over != 0;
    *discreteStatesNeedUpdate = *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = info.values_changed != 0;
    *nextEventTimeDefined = info.has_next != 0;
    *nextEventTime = info.next;
    return status(answer);
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    if (core(instance) && core(instance)->kind != LAG_CO_SIMULATION)
        return error(instance, "fmi3EnterStepMode belongs to Co-Simulation");
    return enter(instance, LAG_CALL_ENTER_STEP, "fmi3EnterStepMode", LAG_MODE_STEP);
}

/* ---------------------------------------------------------------- Model Exchange */

static int exchanges(fmi3Instance instance, LagCall call, const char *name)
{
    if (!allows(instance, call, name))
        return 0;
    if (core(instance)->kind == LAG_MODEL_EXCHANGE)
        return 1;
    lag_instance_log(core(instance), LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s belongs to Model Exchange", name);
    return 0;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    if (!exchanges(instance, LAG_CALL_ENTER_CONTINUOUS, "fmi3EnterContinuousTimeMode"))
        return fmi3Error;
    return enter(instance, LAG_CALL_ENTER_CONTINUOUS, "fmi3EnterContinuousTimeMode", LAG_MODE_CONTINUOUS);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    int needs_event = 0;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!exchanges(instance, LAG_CALL_COMPLETED_STEP, "fmi3CompletedIntegratorStep"))
        return fmi3Error;
    if (!enterEventMode || !terminateSimulation)
        return no_place(instance);
    const LagAnswer answer = lag_instance_completed_step(core(instance), &needs_event);
    *enterEventMode = needs_event != 0;
    *terminateSimulation = core(instance)->vital.is_over != 0;
    return status(answer);
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    if (!exchanges(instance, LAG_CALL_SET_CONTINUOUS, "fmi3SetTime"))
        return fmi3Error;
    return status(lag_instance_set_time(core(instance), time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    if (!exchanges(instance, LAG_CALL_SET_CONTINUOUS, "fmi3SetContinuousStates"))
        return fmi3Error;
    return status(lag_instance_set_states(core(instance), continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t nContinuousStates)
{
    if (!exchanges(instance, LAG_CALL_GET_CONTINUOUS, "fmi3GetContinuousStateDerivatives"))
        return fmi3Error;
    return status(lag_instance_get_slopes(core(instance), derivatives, nContinuousStates));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    if (!exchanges(instance, LAG_CALL_GET_CONTINUOUS, "fmi3GetEventIndicators"))
        return fmi3Error;
    return status(lag_instance_get_indicators(core(instance), eventIndicators, nEventIndicators));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    if (!exchanges(instance, LAG_CALL_GET_CONTINUOUS, "fmi3GetContinuousStates"))
        return fmi3Error;
    return status(lag_instance_get_states(core(instance), continuousStates, nContinuousStates));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    if (!exchanges(instance, LAG_CALL_NOMINALS, "fmi3GetNominalsOfContinuousStates"))
        return fmi3Error;
    return status(lag_instance_nominals(core(instance), nominals, nContinuousStates));
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    if (!exchanges(instance, LAG_CALL_COUNTS, "fmi3GetNumberOfEventIndicators"))
        return fmi3Error;
    if (!nEventIndicators)
        return no_place(instance);
    *nEventIndicators = (size_t)lag_fmu_count(core(instance)->fmu, LAG_GROUP_INDICATOR);
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    if (!exchanges(instance, LAG_CALL_COUNTS, "fmi3GetNumberOfContinuousStates"))
        return fmi3Error;
    if (!nContinuousStates)
        return no_place(instance);
    *nContinuousStates = (size_t)lag_fmu_count(core(instance)->fmu, LAG_GROUP_STATE);
    return fmi3OK;
}

/* ---------------------------------------------------------------- Co-Simulation */

static int cosimulates(fmi3Instance instance, LagCall call, const char *name)
{
    if (!allows(instance, call, name))
        return 0;
    if (core(instance)->kind == LAG_CO_SIMULATION)
        return 1;
    lag_instance_log(core(instance), LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s belongs to Co-Simulation", name);
    return 0;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
{
    if (!cosimulates(instance, LAG_CALL_OUTPUT_SLOPES, "fmi3GetOutputDerivatives"))
        return fmi3Error;
    if (nValueReferences > 0 && (!valueReferences || !orders || !values))
        return no_place(instance);
    LagAnswer answer = lag_instance_fits(core(instance), valueReferences, nValueReferences, nValues, "output");
    for (size_t i = 0; i < nValueReferences; ++i) {
        const fmi3ValueReference end = valueReferences[i] + (fmi3ValueReference)lag_instance_extent(core(instance), valueReferences[i]);
        for (fmi3ValueReference one = valueReferences[i]; one < end && answer == LAG_ANSWER_OK; ++one)
            answer = lag_instance_output_slope(core(instance), one, orders[i], values++);
    }
    return status(answer);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    LagStepResult result;
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!cosimulates(instance, LAG_CALL_DO_STEP, "fmi3DoStep"))
        return fmi3Error;
    if (!eventHandlingNeeded || !terminateSimulation || !earlyReturn || !lastSuccessfulTime)
        return no_place(instance);
    const LagAnswer answer = lag_instance_step(core(instance), currentCommunicationPoint, communicationStepSize, &result);
    *eventHandlingNeeded = result.is_event != 0;
    *terminateSimulation = core(instance)->vital.is_over != 0;
    *earlyReturn = result.is_early != 0;
    *lastSuccessfulTime = result.time;
    return status(answer);
}
