/* Linear scenes: from row to row by the matrix exponential, exact at any distance. */
#ifndef LAG_LINEAR_METHOD_H
#define LAG_LINEAR_METHOD_H

#include "methods/linear_pace.h"
#include "methods/linear_series.h"
#include "state/method.h"

typedef struct {
    LagLinearSystem system;
    LagLadder ladder;
    LagSeries series;
    LagPace pace;
    int has_ladder; /* small enough for one */
    int is_fresh;   /* the loads are to be set, the equations perhaps built anew */
    int equal_steps; /* of the ladder's base, one after the other in this segment */
    double usual, spent; /* a length of step that comes again and again, and what it has cost without a rung of its own */
    double span;         /* how long these steps are in all */
    int times;           /* how many they are */
    LagDD lag, lag_old; /* how far the state is behind the time, by rounding of times: see move */
    LagDDs x, moved, loads, loads_old;
} LagLinearMethod;

extern const LagMethod lag_linear_method;

#endif
