/* Attitudes (state/attitudes.h) of eight motions at once: references and turns lane by lane, by what serves a motion alone; what
 * every stage asks for in vectors.
 */
#ifndef LAG_WIDE_ATTITUDES_H
#define LAG_WIDE_ATTITUDES_H

#include "methods/wide_steps.h"

/* References of one motion, in and out. */
void lag_wide_attitudes_load(LagWideSteps *steps, int lane, const LagRun *run);
void lag_wide_attitudes_show(const LagWideSteps *steps, int lane, LagRun *run);

/* Steps begin where the latest ones were taken: lag_attitudes_move. */
void lag_wide_attitudes_move(LagWideSteps *steps);

/* The quaternions at states y, that of attitude i from 4 i LAG_ABREAST on. */
void lag_wide_attitudes_present(const LagWideSteps *steps, const double *y, double *quaternions);

/* lag_attitudes_turn_slope of all motions. */
void lag_wide_attitudes_turn_slope(const LagModel *model, const double *q, double *k);

#endif
