/* Taylor coefficients of eight motions at once, by the instructions of jet_tape.h: each serves eight, and so costs little more than
 * the sums of products that it asks for.
 */
#ifndef LAG_WIDE_JET_TAPE_H
#define LAG_WIDE_JET_TAPE_H

#include "base/arena.h"
#include "model/jet_tape.h"

typedef struct {
    const LagModel *model;
    int n_sums;
    int *sums;       /* 2 n_sums: the jets whose products are summed, in the order of the instructions that ask for them */
    double *between; /* n_sums, LAG_ABREAST each: the sums of the present order without their ends */
    double *numbers; /* what is constant in a step, LAG_ABREAST each */
    double *jets;    /* LAG_WIDE_JET each */
    double *line;    /* the coefficients of order 0, or those of the present order, of all slots, LAG_ABREAST each */
} LagWideSeries;

/* The first of the four slots of the quaternion of attitude i. */
static inline int lag_wide_quaternion(const LagModel *model, int i) { return 1 + 2 * model->n + model->n_inputs + 4 * i; }

void lag_wide_series_layout(LagWideSeries *series, const LagModel *model, LagArena *arena);

/* The coefficients of order 0 in the line, from those of what is known (t, q, v, u, quaternions), which stand there. */
void lag_wide_series_begin(LagWideSeries *series);

/* The coefficients of the orders from `first` > 0 to before `end`, and those of q, v and quaternions of order `end`, from those of
 * lower order, and of order 1 of what is known. */
void lag_wide_series_go_on(LagWideSeries *series, int first, int end);

/* The coefficients of order k + 1 of quaternions, from those of lower order. */
void lag_wide_series_turn(LagWideSeries *series, int k);

#endif
