/* FMI 3.0: the functions of the standard that this model has no use for. They answer with an error. */
#include "fmi/fmi3_instance.h"

static fmi3Status refuse(fmi3Instance instance, size_t count, const char *name)
{
    if (count == 0 && instance)
        return fmi3OK;
    if (instance)
        lag_instance_log(lag_fmi3_core(instance), LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s: the model has no such variables", name);
    return fmi3Error;
}

#define NO_GET(type) \
    fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3##type values[], \
                             size_t size) \
    { \
        (void)references, (void)values, (void)size; \
        return refuse(instance, count, "fmi3Get" #type); \
    }

#define NO_SET(type) \
    fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference references[], size_t count, \
                             const fmi3##type values[], size_t size) \
    { \
        (void)references, (void)values, (void)size; \
        return refuse(instance, count, "fmi3Set" #type); \
    }

NO_GET(Float32)
NO_GET(Int8)
NO_GET(UInt8)
NO_GET(Int16)
NO_GET(UInt16)
NO_GET(UInt32)
NO_GET(Int64)
NO_GET(UInt64)

NO_SET(Float32)
NO_SET(Int8)
NO_SET(UInt8)
NO_SET(Int16)
NO_SET(UInt16)
NO_SET(UInt32)
NO_SET(Int64)
NO_SET(UInt64)
NO_SET(Int32)
NO_SET(Boolean)
NO_SET(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return refuse(instance, nValueReferences, "fmi3GetBinary");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
{
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return refuse(instance, nValueReferences, "fmi3SetBinary");
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    return refuse(instance, nValueReferences, "fmi3GetClock");
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[])
{
    (void)valueReferences, (void)values;
    return refuse(instance, nValueReferences, "fmi3SetClock");
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                  fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences, (void)intervals, (void)qualifiers;
    return refuse(instance, nValueReferences, "fmi3GetIntervalDecimal");
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                   fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences, (void)counters, (void)resolutions, (void)qualifiers;
    return refuse(instance, nValueReferences, "fmi3GetIntervalFraction");
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                               fmi3Float64 shifts[])
{
    (void)valueReferences, (void)shifts;
    return refuse(instance, nValueReferences, "fmi3GetShiftDecimal");
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)counters, (void)resolutions;
    return refuse(instance, nValueReferences, "fmi3GetShiftFraction");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                  const fmi3Float64 intervals[])
{
    (void)valueReferences, (void)intervals;
    return refuse(instance, nValueReferences, "fmi3SetIntervalDecimal");
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                   const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)counters, (void)resolutions;
    return refuse(instance, nValueReferences, "fmi3SetIntervalFraction");
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                               const fmi3Float64 shifts[])
{
    (void)valueReferences, (void)shifts;
    return refuse(instance, nValueReferences, "fmi3SetShiftDecimal");
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)valueReferences, (void)counters, (void)resolutions;
    return refuse(instance, nValueReferences, "fmi3SetShiftFraction");
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference, fmi3Float64 activationTime)
{
    (void)clockReference, (void)activationTime;
    return refuse(instance, 1, "fmi3ActivateModelPartition");
}
