/* Holds: what sticks or lies is a constraint, whose places and rates are put back where they belong after each step. */
#ifndef LAG_HOLDS_H
#define LAG_HOLDS_H

#include "state/settings.h"

/* A segment begins: what is held now moves along the ways of its forces, and has a place of its own or a rate alone. */
void lag_holds_enter(LagRun *run);

/* The state (q, v) at t, which a step from (from, t_from) has led to, into y, and what rounding took from it into carry. Nothing is
 * changed where that goes farther than a good step could have gone astray. */
void lag_holds_project(LagRun *run, double t_from, const double *from, double t, double *y, double *carry);

/* A state inside the latest step. */
void lag_holds_inside(LagRun *run, double t, double *y);

#endif
