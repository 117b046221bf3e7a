/* Walls that jump: what rests at one is carried along, or let go. */
#ifndef LAG_WALLS_H
#define LAG_WALLS_H

#include "state/state.h"

/* At a state and a time, before inputs that are set anew come into force and after lag_impacts_await_jump: into impacts.carried, how
 * far those with rates move the place of each contact. It is what their rates leave open (lag_inputs_jump), and no jump. */
void lag_walls_await_inputs(LagRun *run, double t, const double *y);

/* After the same, where an importer integrates: what rests at a contact is off by its errors, and by what the inputs that it has set
 * since the last event and their rates say differently (tables, linear in between). */
void lag_walls_await_errors(LagRun *run);

/* Whether the place of contact k is another one now, by its gap; what rested there is let go. */
int lag_walls_have_moved(LagRun *run, int k, double gap);

/* Lets go what rests at contact k, where its place has jumped where the motion came to, as at the edge of a ledge. */
void lag_walls_let_go(LagRun *run, int k);

#endif
