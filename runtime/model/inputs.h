/* Inputs as functions of time: one table, linear between its rows, held outside. */
#ifndef LAG_INPUTS_H
#define LAG_INPUTS_H

#include "base/status.h"

typedef struct {
    int version; /* counts how often the table was set */
    int n, rows, capacity;
    double *times;  /* rows, ascending; two equal times are a jump */
    double *values; /* rows x n */
    int left;       /* the present segment lies between rows left and left + 1; -1: before the table */
} LagInputs;

LagStatus lag_inputs_set(LagInputs *inputs, const double *times, const double *values, int rows);
void lag_inputs_free(LagInputs *inputs);

/* Chooses the segment of the table that holds t, which is no corner. */
void lag_inputs_enter(LagInputs *inputs, double t);

/* Values at t by the present segment: at a jump, those of its own side. */
void lag_inputs_at(const LagInputs *inputs, double t, double *u);

/* Slopes in the present segment. */
void lag_inputs_slope(const LagInputs *inputs, double *slope);

/* The first corner after t, or infinity. */
double lag_inputs_next(const LagInputs *inputs, double t);

#endif
