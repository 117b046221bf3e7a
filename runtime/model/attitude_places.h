/* Where attitudes stand among positions and modes: LagModel.attitudes, two numbers for each. */
#ifndef LAG_ATTITUDE_PLACES_H
#define LAG_ATTITUDE_PLACES_H

/* The first of the three positions of attitude i. */
static inline int lag_attitude_place(const int *attitudes, int i) { return attitudes[2 * i]; }

/* The first of the four modes that its reference is. */
static inline int lag_attitude_mode(const int *attitudes, int i) { return attitudes[2 * i + 1]; }

#endif
