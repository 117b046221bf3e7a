/* Groups of coordinates that do not interact, each moved by a run of its own: with its own method, steps and events. */
#ifndef LAG_ISLANDS_H
#define LAG_ISLANDS_H

#include "method.h"
#include "run.h"

typedef struct {
    int count;
    LagRun **runs;
    double *row, *mask, *values; /* scratch: a row; a mask of ones; a state (q, v) */
    double *p;                           /* the parameters that the runs have */
    double *taken, *now;                 /* 2 each run: its {dissipated, work}, in the present state and in the one tried */
    int are_started;                     /* at the start of the present run; the first step may take many calls */
    int inputs_version;                  /* of the table that the runs have */
} LagIslands;

extern const LagMethod lag_islands_method;

/* The runs of a model's islands. Returns 0 when there is no memory. */
int lag_islands_open(LagIslands *islands, const LagModel *model, const LagSettings *settings);
void lag_islands_close(LagIslands *islands);

#endif
