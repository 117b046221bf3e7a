/* What few scenes need, by the names that the others know it by. */
#include "choice/parts.h"

#include "methods/gauss.h"
#include "run/islands.h"
#include "methods/linear_method.h"
#include "methods/nystrom.h"

const LagParts lag_parts = {
    .linear = &lag_linear_method,
    .islands = &lag_islands_method,
    .islands_open = lag_islands_open,
    .islands_close = lag_islands_close,
    .implicit_conservative = &lag_gauss,
    .explicit_conservative = &lag_nystrom,
    .assembly_layout = lag_assembly_layout,
    .assemble = lag_assemble,
};
