/* The motion within the latest step. */
#ifndef LAG_INSIDE_H
#define LAG_INSIDE_H

#include "state/settings.h"

/* The state (q, v, energy quadratures) at t, inside or at the end of the latest step; not yet on the constraints. */
void lag_state_inside(LagRun *run, double t, double *y);

/* The same, with what sticks or lies where it is held. */
void lag_held_state_inside(LagRun *run, double t, double *y);

/* The state at t inside the latest step, brought back to the constraints, becomes the present one. */
void lag_go_back(LagRun *run, double t);

#endif
