/* Time events: when values that are constant between events change. */
#ifndef LAG_SCHEDULE_H
#define LAG_SCHEDULE_H

#include "model/model.h"

/* The first time after t at which an argument a + b t crosses what its kind says (LAG_EVENT_...);
 * infinity when there is none. */
double lag_schedule_next(const LagModel *model, const double *a, const double *b, double t);

/* Times closer than this cannot be told apart near t. */
double lag_time_resolution(double t);

#endif
