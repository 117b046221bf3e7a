/* The shares of what slides, by how dg/dt jumps with them: one linear system.
 *
 * Friction in the plane whose slip can go one way only (the tip of an arm, what runs on a rail) is dry friction along that way: both of its
 * shares are one unknown, and across it there is no force. Where several together hold the same (two pads under one plate) motion does not
 * tell how they share it: then forces are taken as small as they can be, by what each of them has.
 */
#ifndef LAG_SHARES_H
#define LAG_SHARES_H

#include "model/model.h"
#include "numbers/dense_lu.h"
#include "state/settings.h"

typedef struct {
    int *place;     /* most: the switch of each unknown */
    int *cones;     /* 2 n_cones: unknowns that are components; -1: they are none now */
    int *is_narrow; /* n_cones: whether it can slip one way only */
    double *way;    /* 2 n_cones: unit vector of that */
    double *weight; /* n_cones: of its force, among forces of which motion tells only what all do */
    int n_untold;   /* ways in which forces may change, and nothing else */
    double *untold; /* most x most: these */
    double *plain;  /* most x most: the system as it was */
    double *part;   /* most */
    LagDenseLu normal;
} LagShareSystem;

void lag_shares_layout(LagShareSystem *system, const LagModel *model, int most, LagArena *arena);

/* Forces of what holds together count alike. */
void lag_shares_reset(LagRun *run);

/* Factors sliding.lu, where each unknown is the share of the switch in `place`. */
void lag_shares_factor(LagRun *run);

/* dg/dt of what is at place j; of friction in the plane that goes one way, what is along it. */
double lag_shares_along(const LagRun *run, int j);

/* Changes of dg/dt become those of shares. */
void lag_shares_solve(const LagRun *run, double *change);

/* Of all shares that do the same: those in which friction in the plane has the least forces. */
void lag_shares_spread(LagRun *run, double *share);

/* The same, with weights by which the friction that has least left of it has most: changes them. */
void lag_shares_balance(LagRun *run, double *share);

/* Whether motion does not tell all forces. */
int lag_shares_are_untold(const LagRun *run);

#endif
