/* Sizes of all that is mirrored outside; a test compares every member's place. */
#include "run/layout.h"

#include "choice/choice.h"
#include "run/batch.h"
#include "run/run.h"
#include "model/jet_tape.h"
#include "model/table.h"
#include "model/tape.h"

#define SIZE_OF(type) {#type, (int32_t)sizeof(type)}
#define COUNT_OF(kinds, last) {kinds, (int32_t)(last) + 1}

const LagSize lag_sizes[] = {
    SIZE_OF(LagTape),
    SIZE_OF(LagTable),
    SIZE_OF(LagFunction),
    SIZE_OF(LagModel),
    SIZE_OF(LagSettings),
    SIZE_OF(LagStatistics),
    SIZE_OF(LagFacts),
    SIZE_OF(LagDecision),
    SIZE_OF(LagRule),
    SIZE_OF(LagFailure),
    SIZE_OF(LagReduction),
    SIZE_OF(LagSweep),
    SIZE_OF(LagOutcome),
    SIZE_OF(LagCycle),
    COUNT_OF("LagStatus", LAG_ENDED),
    COUNT_OF("LAG_SOLVER", LAG_SOLVERS - 1),
    COUNT_OF("LagOp", LAG_OP_COUNT - 1),
    COUNT_OF("LagJetOp", LAG_JET_COUNT - 1),
    COUNT_OF("LAG_REDUCE", LAG_REDUCE_PEAK_AMPLITUDE),
    COUNT_OF("LAG_RUN", LAG_RUN_OPEN),
    {NULL, 0},
};
