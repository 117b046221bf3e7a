/* FMI 3.0: what each number of an array depends on, which modelDescription.xml says of whole arrays alone. */
#include "fmi/fmi3_instance.h"

/* Lists by value reference of scalars: fmu.h. */
typedef struct {
    const int *first, *knowns, *kinds;
} Lists;

static Lists lists_now(const LagInstance *s)
{
    const int is_start = (s->vital.mode & (LAG_MODE_INSTANTIATED | LAG_MODE_CONFIGURATION | LAG_MODE_INITIALIZATION)) != 0;
    const Lists running = {s->fmu->known_first, s->fmu->knowns, s->fmu->known_kinds};
    const Lists starting = {s->fmu->start_first, s->fmu->starts, s->fmu->start_kinds};
    return is_start ? starting : running;
}

/* How many there are of a variable; *answer is an error where that cannot be told. */
static size_t count_of(fmi3Instance instance, fmi3ValueReference reference, const char *name, fmi3Status *answer)
{
    LagInstance *s = lag_fmi3_core(instance);
    *answer = fmi3Error;
    if (!lag_instance_allows(s, LAG_CALL_LOGGING, name))
        return 0;
    const size_t extent = lag_instance_extent(s, reference);
    if (!s->fmu->has_knowns)
        lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s: there are no arrays, modelDescription.xml says it all", name);
    else if (extent == 0)
        lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%s: there is no variable with the value reference %u", name, reference);
    else {
        const int *first = lists_now(s).first + reference;
        *answer = fmi3OK;
        return (size_t)(first[extent] - first[0]);
    }
    return 0;
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference valueReference, size_t *nDependencies)
{
    fmi3Status answer;
    const size_t count = count_of(instance, valueReference, "fmi3GetNumberOfVariableDependencies", &answer);
    if (nDependencies)
        *nDependencies = count;
    return answer;
}

/* The variable that a number is of, and its element, from 1; 0: it is no array. */
static fmi3ValueReference variable_of(const LagInstance *s, int number, size_t *element)
{
    int first = number;
    while (s->fmu->extents[first] == 0)
        --first;
    *element = s->fmu->extents[first] > 1 ? (size_t)(number - first) + 1 : 0;
    return (fmi3ValueReference)first;
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent, size_t elementIndicesOfDependent[],
                                       fmi3ValueReference independents[], size_t elementIndicesOfIndependents[],
                                       fmi3DependencyKind dependencyKinds[], size_t nDependencies)
{
    fmi3Status answer;
    const size_t count = count_of(instance, dependent, "fmi3GetVariableDependencies", &answer);
    if (answer != fmi3OK || count == 0)
        return answer;
    const LagInstance *s = lag_fmi3_core(instance);
    if (nDependencies != count || !elementIndicesOfDependent || !independents || !elementIndicesOfIndependents || !dependencyKinds) {
        lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "fmi3GetVariableDependencies: there are %lu dependencies",
                         (unsigned long)count);
        return fmi3Error;
    }
    const Lists lists = lists_now(s);
    const int end = (int)(dependent + lag_instance_extent(s, dependent));
    size_t done = 0;
    for (int number = (int)dependent; number < end; ++number)
        for (int k = lists.first[number]; k < lists.first[number + 1]; ++k, ++done) {
            variable_of(s, number, elementIndicesOfDependent + done);
            independents[done] = variable_of(s, lists.knowns[k], elementIndicesOfIndependents + done);
            dependencyKinds[done] = (fmi3DependencyKind)lists.kinds[k];
        }
    return fmi3OK;
}
