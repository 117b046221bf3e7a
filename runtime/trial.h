/* What steps of fixed length are measured by: a trial run of explicit steps with error control. */
#ifndef LAG_TRIAL_H
#define LAG_TRIAL_H

#include "run.h"

typedef struct {
    double shortest; /* step */
    double span;     /* time that the trial took the motion through */
} LagTrial;

/* Leaves no trace but the sizes of the motion. */
LagTrial lag_trial(LagRun *run);

#endif
