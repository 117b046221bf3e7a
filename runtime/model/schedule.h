/* Time events: when values that are constant between events change. */
#ifndef LAG_SCHEDULE_H
#define LAG_SCHEDULE_H

/* The first time after t at which an argument a + b t crosses zero (LAG_EVENT_ZERO) or an integer (LAG_EVENT_INTEGER);
 * infinity when there is none. */
double lag_schedule_next(int n_events, const int *kind, const double *a, const double *b, double t);

/* Times closer than this cannot be told apart near t. */
double lag_time_resolution(double t);

#endif
