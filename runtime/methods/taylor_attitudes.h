/* Attitudes in Taylor steps: their quaternions have series, Q' = Q (0, w)/2, and these tell the positions s (state/attitudes.c). The
 * jets of quaternions follow those of t, q, v and u, four an attitude in the order of the model, and lie once more in fours behind all
 * jets; those of s are not used.
 */
#ifndef LAG_TAYLOR_ATTITUDES_H
#define LAG_TAYLOR_ATTITUDES_H

#include "model/attitude_places.h"
#include "state/state.h"

#define LAG_TAYLOR_MOST_TURN 5.0 /* radians in a step: s tells of less than a whole turn */

/* Whether a position is told by a quaternion. */
static inline int lag_taylor_is_turned(const LagModel *model, int i)
{
    for (int k = 0; k < model->n_attitudes; ++k)
        if (i >= lag_attitude_place(model->attitudes, k) && i < lag_attitude_place(model->attitudes, k) + 3)
            return 1;
    return 0;
}

/* The first coefficients at a state y that is told against the present references. */
void lag_taylor_place_turned(const LagRun *run, const double *y, double *jets);

/* s of the turn from a quaternion r to r + x. */
void lag_taylor_turned_by(const double *r, const double *x, double *s);

/* What a step of length h adds to the positions of attitudes. */
void lag_taylor_turn(const LagModel *model, const double *jets, int order, double h, double *step);

/* Raises *last and *before to the largest of the last coefficients and of those before, in units; the units: at y and `end`. */
void lag_taylor_weigh_turned(LagRun *run, const double *end, double *last, double *before);

/* Whether some attitude turns farther than s tells in a step of length h, by its rates at a state; how long a step may be. */
int lag_taylor_turns_too_far(const LagRun *run, const double *y, double h);
double lag_taylor_longest_turn(const LagRun *run, const double *y);

/* The highest order below `most` that is not 0; 1 where none is. */
int lag_taylor_top_of_turned(const LagModel *model, const double *jets, int most);

#endif
