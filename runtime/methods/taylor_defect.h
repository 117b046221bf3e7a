/* By how much a step of series is wrong: the accelerations at its end, the first coefficients of the next one, tell. */
#ifndef LAG_TAYLOR_DEFECT_H
#define LAG_TAYLOR_DEFECT_H

#include "model/model.h"
#include "numbers/jets.h"
#include "state/state.h"

/* The coefficients of a slot. */
static inline double *lag_taylor_jet(const LagModel *model, double *jets, int slot)
{
    return jets + (model->jet_pitch == 1 ? (size_t)slot * LAG_JET_STRIDE : (size_t)slot);
}

/* By how much the step of length h, to which the series ahead are known, is wrong at its end: an error of the rates in units. *is_jump:
 * whether it is none of rounding, though it does not fall with the power of the order. */
double lag_taylor_defect(LagRun *run, double h, int *is_jump);

#endif
