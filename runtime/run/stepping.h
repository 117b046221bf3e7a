/* A run that somebody else's clock drives: inputs are set, held over a step of a given length, and looked at after it. */
#ifndef LAG_STEPPING_H
#define LAG_STEPPING_H

#include "run/run.h"

/* From the present on the inputs are these. */
LagStatus lag_run_hold(LagRun *run, const double *u);

/* The `steps` steps of length dt (s) that follow `first` ones since the time `begin`, up to the present: over each the inputs are
 * those of its row of u[steps * n_inputs] (NULL: as they are), and at its end a row of results is written. *done rows are valid whatever is returned. seconds: wall time, 0: no limit. No step of the
 * method goes past the end of one of these. */
LAG_API LagStatus lag_run_steps(LagRun *run, double begin, double dt, int64_t first, int steps, const double *u, double *rows,
                                int *done, double seconds);

#endif
