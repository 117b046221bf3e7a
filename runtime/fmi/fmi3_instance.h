/* What FMI 3.0 keeps around an instance. */
#ifndef LAG_FMI3_INSTANCE_H
#define LAG_FMI3_INSTANCE_H

#include "fmi3Functions.h"

#include "fmi/instance.h"

typedef struct {
    LagInstance *core;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log_message;
    fmi3IntermediateUpdateCallback intermediate_update;
} Fmi3;

static inline LagInstance *lag_fmi3_core(fmi3Instance instance) { return instance ? ((Fmi3 *)instance)->core : NULL; }

#endif
