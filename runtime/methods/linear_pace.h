/* Many equal steps in plain doubles, between states that the ladder gives.
 *
 * Where nothing is stiff, some dozens of products with exp(A h) in doubles lose no more than a few units of the last place; where
 * slow motion lies beside stiff springs they lose all of it. So the pace is tried on the present state, over as many steps
 * as it shall hold, and taken only when it ends where the ladder ends; every LAG_PACE_STEPS steps the ladder sets it
 * right, and it is dropped when it had gone astray.
 */
#ifndef LAG_LINEAR_PACE_H
#define LAG_LINEAR_PACE_H

#include "methods/linear_ladder.h"

enum { LAG_PACE_RUNGS = 6, LAG_PACE_STEPS = 1 << LAG_PACE_RUNGS };

typedef struct {
    size_t size, stride; /* of a column: E, then the forms */
    int n_forms;
    int is_trusted, count; /* steps since the anchor */
    double *columns, *x, *image;
    double sum[2];         /* integrals since the anchor */
    LagDDs anchor, state, spare;
} LagPace;

void lag_pace_layout(LagPace *pace, const LagLadder *ladder, LagArena *arena);

/* Takes the rung `top` for a step, tries it from the state x on. `n`: positions, and as many rates. */
void lag_pace_try(LagPace *pace, LagLadder *ladder, size_t n, LagDDs x);

/* The state from which the next steps go. */
void lag_pace_set(LagPace *pace, LagDDs x);

/* One step of pace->x; the integrals grow by `gain`. */
void lag_pace_step(LagPace *pace, double *gain);

/* The state, and the integrals since the anchor, by the ladder: in pace->state. */
void lag_pace_settle(LagPace *pace, LagLadder *ladder, LagDD *integrals);

/* Whether pace->x and its integrals agree with those settled. */
int lag_pace_agrees(const LagPace *pace, size_t n, const LagDD *integrals);

#endif
