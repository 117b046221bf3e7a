/* What functions compute of parameters alone, taken out of them: computed once a run. Instructions before and after are as
 * arrange.h has them. compiler/lagrangia/compile/hoisted_tapes.py does the same, where there is no run time; a test compares both.
 */
#ifndef LAG_HOIST_H
#define LAG_HOIST_H

#include "model/arrange.h"

/* `read`: programs one after another, the first of which computes hoisted values of the parameters. Of each: how many
 * instructions (`counts`), and which of its inputs has hoisted values (`arguments`; the first: parameters). The first `settled`
 * of these stay; behind them the parameters stand, in whose place stands what is computed of hoisted values alone.
 * `written` has room for three times as many instructions: the others in their order, then the first; `sizes`: how many there
 * are of each in this order, then how many hoisted values.
 */
LAG_API int lag_hoist(const int32_t *read, const int32_t *counts, const int32_t *arguments, int32_t n_programs, int32_t settled,
                      const int32_t *kinds, int32_t n_kinds, int32_t *written, int32_t *sizes);

#endif
