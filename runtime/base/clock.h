/* Wall time in seconds from an arbitrary origin; never goes backwards. */
#ifndef LAG_CLOCK_H
#define LAG_CLOCK_H

double lag_clock(void);

#endif
