/* Consistent start values: g(q, v) = 0, as near to the guesses as can be. */
#ifndef LAG_ASSEMBLE_H
#define LAG_ASSEMBLE_H

#include "base/arena.h"
#include "model/model.h"
#include "start/blocks.h"
#include "start/known_start.h"
#include "start/newton.h"

typedef struct {
    const LagModel *model;
    LagNewton newton;
    LagBlocks blocks;
    LagKnownStart known;
    double *reach;                /* n, here and in newton.h, is lag_start_size; 2 n: natural size of a value */
    double *guess;                /* 2 n */
    double *found, *kept, *best;  /* 2 n: states to come back to: of a solution, of a step, of an assembly */
    double *apart;                /* 2 n: where blocks of equations have come to, each by itself, guesses held */
    double *lean;                 /* 2 n: a step */
} LagAssembly;

void lag_assembly_layout(LagAssembly *assembly, LagArena *arena);

/* Moves x = (q, v), as `fixed` allows. Returns -1, or the equation that is satisfied worst. */
int lag_assemble(LagAssembly *assembly, const double *p, const int *fixed, double *x, double *work);

#endif
