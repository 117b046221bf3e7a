/* Walls that jump: what rests at one is carried along, or let go. */
#ifndef LAG_WALLS_H
#define LAG_WALLS_H

#include "state/state.h"

/* Whether the place of contact k is another one now, by its gap; what rested there is let go. */
int lag_walls_have_moved(LagRun *run, int k, double gap);

/* Lets go what rests at contact k, where its place has jumped where the motion came to, as at the edge of a ledge. */
void lag_walls_let_go(LagRun *run, int k);

#endif
