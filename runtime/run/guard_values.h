/* What five values of a guard, at even distances of time, tell of it between them. */
#ifndef LAG_GUARD_VALUES_H
#define LAG_GUARD_VALUES_H

enum { LAG_GUARD_VALUES = 5 };

/* The largest less the least; values that are none do not count. */
double lag_guard_values_change(const double *g);

/* Whether the least of them is above 0 by more than they change, and `more` besides. */
int lag_guard_values_are_far(const double *g, double more);

/* Whether a parabola through three of them tells of the others, and does not dip below 0 between them. */
int lag_guard_values_are_smooth(const double *g);

#endif
