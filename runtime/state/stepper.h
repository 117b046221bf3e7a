/* The method in use. */
#ifndef LAG_STEPPER_H
#define LAG_STEPPER_H

#include "state/method.h"
#include "state/settings.h"

/* That of a number LAG_SOLVER_... */
LagStepper lag_stepper_of(const LagRun *run, int32_t solver);

/* Puts a method to use; it must be restarted. */
void lag_stepper_choose(LagRun *run, int32_t solver);

/* A step of the explicit method, which is to be restarted, leads to where the motion has a size that the one in use needs. */
void lag_stepper_lead(LagRun *run);

#endif
