/* How large what callers know by heart is here: Python mirrors these structures field by field, and compares when it loads a
 * library. A table by names, ended by NULL. */
#ifndef LAG_LAYOUT_H
#define LAG_LAYOUT_H

#include <stdint.h>

#include "model/model.h"

typedef struct {
    const char *name;
    int32_t size; /* bytes of a structure, or how many numbers an enumeration has */
} LagSize;

LAG_API extern const LagSize lag_sizes[];

#endif
