/* Explicit symplectic steps of fixed length, for scenes whose accelerations follow from positions alone. */
#ifndef LAG_NYSTROM_H
#define LAG_NYSTROM_H

#include "state/method.h"

typedef struct {
    double h;                /* length of all steps; 0: not chosen yet */
    double *a;               /* accelerations where the step under way is */
    double *taken;           /* those at the present state */
    int is_known;            /* whether they are */
} LagNystrom;

extern const LagMethod lag_nystrom;

#endif
