/* Jumps: how dg/dt of the candidates for sliding (sliding.which) depends on their shares. */
#ifndef LAG_JUMPS_H
#define LAG_JUMPS_H

#include "model/model.h"
#include "state/settings.h"

/* Where they are looked for. What is large and what is rounding is learned at present states alone: stages of steps that are too long may
 * be anywhere. LAG_FIRST: at the present state, with nothing known of it. */
typedef enum { LAG_ELSEWHERE, LAG_PRESENT, LAG_FIRST } LagJumpsAt;

/* The share of the largest jump so far that is none. */
#define LAG_VANISHED 1e-10

/* Shares that a choice among `count` candidates begins with. */
void lag_jumps_begin(LagRun *run, int count);

/* The jumps of all candidates, around the shares in d; of contacts by a force of the size that is needed. */
void lag_jumps_find(LagRun *run, double t, const double *y, int count, LagJumpsAt where);

#endif
