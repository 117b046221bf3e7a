/* Attitudes in space: three positions each, against a reference that is moved along from step to step. */
#ifndef LAG_ATTITUDES_H
#define LAG_ATTITUDES_H

#include "state/motion.h"
#include "state/settings.h"

/* Rates of the three positions s, which turn with the angular velocity w (3, rad/s, in the turned axes). */
void lag_attitude_rates(const double *s, const double *w, double *rates);

/* In a slope k at the positions q, what stands where angular velocities are copied to become rates of positions. */
void lag_attitudes_turn_slope(const LagMotion *motion, const double *q, double *k);

/* Starts q_given that were given, as s against the axes that are not turned, become s against the references that parameters say. */
void lag_attitudes_guess(LagRun *run, const double *q_given);

/* s of the turn from one unit quaternion to another, the shorter way. */
void lag_attitude_between(const double *reference, const double *quaternion, double *s);

/* The product of two quaternions. */
void lag_quaternion_product(const double *a, const double *b, double *product);

/* A reference turned on by s. */
void lag_attitude_present(const double *reference, const double *s, double *quaternion);

/* A reference turns on by s; `carry` (4): what rounding took from it. */
void lag_attitude_turn_on(const double *s, double *reference, double *carry);

/* References as parameters say, with what start values turned on, or as they were given, at the start of a run; and the size
 * that angles have by themselves: after lag_scale_size. */
void lag_attitudes_begin(LagRun *run, const double *q_given);

/* Where modes were worked out anew, references stay as they are. */
void lag_attitudes_keep(LagRun *run);

/* The present state is told against its own attitudes from now on: a step begins. States within the step before are no longer
 * understood. */
void lag_attitudes_move(LagRun *run);

#endif
