/* Going over from one method to another; which one, stiffness.c decides. */
#ifndef LAG_TURNS_H
#define LAG_TURNS_H

#include "state/settings.h"

/* Slopes at the present state. Rounding may leave a rate on the other side of 0 than it is held on, where |v|^a has no value: a step
 * without held switches goes on. Returns 0 where they are not finite. */
int lag_turn_evaluate(LagRun *run);

/* Puts the method that was decided on to use, before a step. Returns 0 where its first evaluation is not finite. */
int lag_turn(LagRun *run);

/* The method in use cannot take a step: implicit ones near a singular position or where derivatives are not finite, or where something
 * slides. The explicit method takes some. Returns 0 if it cannot. */
int lag_turn_pass(LagRun *run);

/* A segment begins: where nothing slides any more, the method goes on that was left for it. Returns 0 where its first evaluation is not
 * finite. */
int lag_turn_release(LagRun *run);

/* Slips in the plane that are slow beside what turns them are left to implicit steps. Returns 0 where there is no slope. */
int lag_turn_creep(LagRun *run);

/* A series has no finite coefficients (exp of a large number under a fraction bar), or collocation met a singular position: the
 * explicit method goes on from here. Returns 0 if there is none, or the user asked for the one in use. */
int lag_turn_fall_back(LagRun *run);

#endif
