/* Consistent start values: g(q, v) = 0, as near to the guesses as can be. */
#ifndef LAG_ASSEMBLE_H
#define LAG_ASSEMBLE_H

#include "arena.h"
#include "model.h"

typedef struct {
    const LagModel *model;
    double *g, *jacobian; /* n_initial, n_initial x 2 n column-major */
    double *transposed;   /* 2 n x n_initial: scaled */
    double *length;       /* n_initial: size of an equation's scaled gradient */
    double *right, *diagonal;
    double *scale, *step, *trial; /* 2 n; scale 0: this value may not move */
    double *reach, *kept;         /* 2 n: natural size of a value; a state to come back to */
    int *pivot;
    int active;                   /* so many equations are looked at */
} LagAssembly;

void lag_assembly_layout(LagAssembly *assembly, LagArena *arena);

/* Moves x = (q, v), as `fixed` allows. Returns -1, or the equation that is satisfied worst. */
int lag_assemble(LagAssembly *assembly, const double *p, const int *fixed, double *x, double *work);

#endif
