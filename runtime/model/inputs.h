/* Inputs as functions of time: one table, linear between its rows, held outside.
 *
 * Inputs that stand where functions of time do ("pieces", model.h) are polynomials there, whose coefficients are modes: cubic where
 * their first rates are in the table as well, and of one row alone a parabola, of what the row says of the input and its rates.
 */
#ifndef LAG_INPUTS_H
#define LAG_INPUTS_H

#include "base/status.h"
#include "model/history.h"

typedef struct {
    int version; /* counts how often the table was set */
    int n, rows, capacity;
    double *times;  /* rows, ascending; two equal times are a jump */
    double *values; /* rows x n */
    int left;       /* the present segment lies between rows left and left + 1; -1: before the table */
    const double *rates; /* n: of values that are held here and move on elsewhere; NULL: none do. Pieces go on with theirs */
    int n_pieces;      /* as in the model */
    const int *pieces; /* 4 n_pieces */
    const LagHistory *history; /* of delayed values, which stand behind the inputs */
} LagInputs;

LagStatus lag_inputs_set(LagInputs *inputs, const double *times, const double *values, int rows);
void lag_inputs_free(LagInputs *inputs);

/* Chooses the segment of the table that holds t, which is no corner. */
void lag_inputs_enter(LagInputs *inputs, double t);

/* So many numbers are a piece: its place in time, and the coefficients of its powers of the time since, the constant first. */
enum { LAG_PIECE = 5 };

/* The pieces of the present segment, into modes. */
void lag_inputs_read(const LagInputs *inputs, double *d);

/* The input that places follow and that is somewhere else at t by the modes `after` than by those `before`; -1 where none is. How far,
 * into `jump`. What is set anew (`is_new`) may be as far off as its rates tell: whoever sets it now and then knows no more. */
int lag_inputs_jump(const LagInputs *inputs, const double *before, const double *after, double t, int is_new, double *jump);

/* Values at t by the present segment: at a jump, those of its own side. Rates of pieces are those of the polynomial. */
void lag_inputs_find(const LagInputs *inputs, double t, double *u);

static inline void lag_inputs_at(const LagInputs *inputs, double t, double *u)
{
    if (inputs->n > 0 || inputs->n_pieces > 0 || inputs->history->n > 0)
        lag_inputs_find(inputs, t, u);
}

/* Slopes in the present segment; those of delayed values are lag_history_rates. */
void lag_inputs_slope(const LagInputs *inputs, double *slope);

/* The rates of those that are pieces, whose values are `d`, into their places of `slope`. */
void lag_inputs_piece_slopes(const LagInputs *inputs, const double *d, double t, double *slope);

/* The first corner after t, or infinity. */
double lag_inputs_next(const LagInputs *inputs, double t);

#endif
