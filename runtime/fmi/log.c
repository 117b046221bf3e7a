/* Which calls are allowed when, and what is told about those that are not and about runs that stopped. */
#include <stdarg.h>
#include <stdio.h>

#include "fmi/instance.h"

#include "run/guards.h"

enum {
    ANY_MODE = LAG_MODE_INSTANTIATED | LAG_MODE_CONFIGURATION | LAG_MODE_INITIALIZATION | LAG_MODE_EVENT | LAG_MODE_CONTINUOUS
        | LAG_MODE_STEP | LAG_MODE_INTERMEDIATE | LAG_MODE_TERMINATED | LAG_MODE_ERROR,
    RUNNING = LAG_MODE_EVENT | LAG_MODE_CONTINUOUS | LAG_MODE_STEP,
    KNOWN = LAG_MODE_INITIALIZATION | RUNNING | LAG_MODE_TERMINATED | LAG_MODE_ERROR,
    LONGEST_MESSAGE = 1000
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
    if (instance->logger && (instance->is_logging || answer >= LAG_ANSWER_ERROR || answer == LAG_ANSWER_WARNING))
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

static const char *name_of(const LagInstance *s, LagStatus status, int index, int rate)
{
    const LagModel *m = s->model;
    if (status == LAG_BAD_INTERVAL || status == LAG_BAD_DELAY)
        return "";
    if (status == LAG_ASSERTED)
        return s->fmu->guards[index];
    if (status == LAG_INPUT_JUMPS)
        return s->fmu->names[lag_fmu_first(s->fmu, LAG_GROUP_INPUT) + index];
    const int place = index + (rate ? m->n : 0);
    return index >= 0 && place < 2 * m->n ? s->fmu->names[1 + lag_fmu_place(m, place)] : "";
}

/* Rates are others at once. */
static void tell_jam(LagInstance *s)
{
    const LagStatistics *statistics = lag_run_statistics(s->run);
    if (!statistics->jammed || s->vital.is_told_jam)
        return;
    s->vital.is_told_jam = 1;
    lag_instance_log(s, LAG_ANSWER_WARNING, "logStatusWarning",
                     "at t = %.9g s friction presses further what slides, and no force holds it (Painleve's paradox): an impulse without "
                     "a collision stops the slip", statistics->jam_time);
}

void lag_instance_warn(LagInstance *s)
{
    double t = 0;
    tell_jam(s);
    for (int i; (i = lag_run_warning(s->run, &t)) > 0;)
        lag_instance_log(s, LAG_ANSWER_WARNING, "logStatusWarning", "at t = %.9g s: an assertion does not hold (%.600s)", t,
                         s->fmu->guards[i - 1]);
}

void lag_instance_end(LagInstance *s)
{
    const LagFailure *end = lag_run_failure(s->run);
    s->vital.is_over = 1;
    lag_instance_log(s, LAG_ANSWER_WARNING, "logStatusWarning", "at t = %.9g s the simulation ends: %.600s", end->time,
                     s->fmu->guards[end->index]);
}

LagAnswer lag_instance_failed(LagInstance *s, LagStatus status)
{
    const LagFailure *failure = lag_run_failure(s->run);
    const char *about = failure->status == LAG_INITIAL_FAILED ? "" : name_of(s, status, failure->index, failure->rate);
    const char *text = "the run stopped";
    switch (status) {
    case LAG_INITIAL_FAILED: text = "the initial equations cannot all hold"; break;
    case LAG_NOT_FINITE: text = "the accelerations are not finite: look at the parameters (masses of 0), inputs and start values"; break;
    case LAG_STEP_TOO_SMALL: text = "no step is small enough here: a singularity, or values beyond the range of numbers"; break;
    case LAG_TOO_MANY_STEPS: text = "one communication step took ten million internal steps"; break;
    case LAG_TIME_PASSED: text = "a time was asked for that lies before what is still known"; break;
    case LAG_PAST_STOP: text = "a time was asked for that lies after the stop time"; break;
    case LAG_NO_IMPULSE:
        text = failure->rate ? "what a contact sets does not turn back what approaches (e < 0)"
                             : "contacts and their friction have neither forces nor impulses that go together";
        break;
    case LAG_EVENTS_GO_ON: text = "events that reset rates bring each other about without end"; break;
    case LAG_CONSTRAINTS_OPEN: text = "constraints do not close"; break;
    case LAG_NO_PROGRESS: text = "steps are too short to get on"; break;
    case LAG_TABLE_ENDED: text = "a table ends here, and says nothing beyond its ends"; break;
    case LAG_INPUT_JUMPS: text = "an input that moves a support jumps: set the inputs that are its rates, too"; break;
    case LAG_TURNED_OFF: text = "at a singular position the motion went over to another way of moving"; break;
    case LAG_BAD_INTERVAL: text = "the interval between the instants of a sampled value is not positive"; break;
    case LAG_BAD_DELAY: text = "a delay is not positive, or was to change during the run"; break;
    case LAG_ASSERTED: text = "an assertion does not hold"; break;
    case LAG_OUT_OF_MEMORY: text = "no memory is left"; break;
    default: break;
    }
    s->vital.mode = LAG_MODE_ERROR;
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "at t = %.9g s: %s%s%.600s%s", failure->time, text,
                            *about ? " (" : "", about, *about ? ")" : "");
}
