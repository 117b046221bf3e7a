/* A row of results, at a time within the latest step. */
#ifndef LAG_ROW_H
#define LAG_ROW_H

#include "state/settings.h"

/* LAG_CONSTRAINTS_OPEN where the state cannot be brought back to its constraints; LAG_STEP_TOO_SMALL where it is not finite. Energies
 * that nobody asks for are NaN: then nothing is brought back. */
LagStatus lag_row_at(LagRun *run, double t, double *row, int has_energies);

#endif
