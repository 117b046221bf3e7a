/* All parts, but for those that a definition of the compiler's command line leaves out. */
#include "parts.h"

#include "gauss.h"
#include "islands.h"
#include "linear_method.h"
#include "nystrom.h"

const LagParts lag_parts = {
#ifndef LAG_WITHOUT_LINEAR
    .linear = &lag_linear_method,
#endif
#ifndef LAG_WITHOUT_ISLANDS
    .islands = &lag_islands_method,
    .islands_open = lag_islands_open,
    .islands_close = lag_islands_close,
#endif
#ifndef LAG_WITHOUT_CONSERVATIVE
    .implicit_conservative = &lag_gauss,
    .explicit_conservative = &lag_nystrom,
#endif
#ifndef LAG_WITHOUT_ASSEMBLY
    .assembly_layout = lag_assembly_layout,
    .assemble = lag_assemble,
#endif
};
