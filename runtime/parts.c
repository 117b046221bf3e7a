/* What few scenes need, by the names that the others know it by. */
#include "parts.h"

#include "gauss.h"
#include "islands.h"
#include "linear_method.h"
#include "nystrom.h"

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
