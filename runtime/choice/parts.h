/* What a library may lack: parts that few scenes need, reached through one table. Where a part is left out its entries are NULL,
 * and whoever loads the library sees to it that no model asks for it. */
#ifndef LAG_PARTS_H
#define LAG_PARTS_H

#include "start/assemble.h"
#include "state/method.h"
#include "state/settings.h"

/* What islands.c keeps in the run that they make up. */
typedef struct {
    int count;
    LagRun **runs;
    double *row, *mask, *values; /* scratch: a row; a mask of ones; a state (q, v) */
    double *p;                           /* the parameters that the runs have */
    double *taken, *now;                 /* 2 each run: its {dissipated, work}, in the present state and in the one tried */
    int are_started;                     /* at the start of the present run; the first step may take many calls */
    int inputs_version;                  /* of the table that the runs have */
    int64_t events; /* of all islands, which the whole has counted */
} LagIslands;

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
