/* A row of results, at a time within the latest step. */
#ifndef LAG_ROW_H
#define LAG_ROW_H

#include "state/settings.h"

/* What is found beside coordinates and rates; the rest is NaN. */
enum { LAG_ROW_OUTPUTS = 1, LAG_ROW_ENERGIES = 2, LAG_ROW_WHOLE = 3 };

/* LAG_CONSTRAINTS_OPEN where the state cannot be brought back to its constraints; LAG_STEP_TOO_SMALL where it is not finite. Without
 * energies nothing is brought back. */
LagStatus lag_row_at(LagRun *run, double t, double *row, int parts);

#endif
