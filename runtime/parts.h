/* What a library may lack: parts that few scenes need, reached through one table. Where a part is left out its entries are NULL,
 * and whoever loads the library sees to it that no model asks for it. */
#ifndef LAG_PARTS_H
#define LAG_PARTS_H

#include "assemble.h"
#include "islands.h"

typedef struct {
    const LagMethod *linear, *islands;
    const LagMethod *implicit_conservative, *explicit_conservative;
    int (*islands_open)(LagIslands *islands, const LagModel *model, const LagSettings *settings);
    void (*islands_close)(LagIslands *islands);
    void (*assembly_layout)(LagAssembly *assembly, LagArena *arena);
    int (*assemble)(LagAssembly *assembly, const double *p, const int *fixed, double *x, double *work);
} LagParts;

extern const LagParts lag_parts;

#endif
