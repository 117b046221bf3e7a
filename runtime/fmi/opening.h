/* Where an instance has its model from: compiled into the library (compiled.c), or from a file among the FMU's resources
 * (stored.c), by one library for all scenes. */
#ifndef LAG_FMI_OPENING_H
#define LAG_FMI_OPENING_H

#include <stddef.h>

#include "fmi/fmu.h"

/* `resources`: FMI 2's URI or FMI 3's path of the folder; `memory` is freed with the instance. NULL: `why` says what is wrong. */
const LagFmu *lag_fmu_open(const char *resources, void **memory, char *why, size_t room);

#endif
