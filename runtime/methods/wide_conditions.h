/* Conditions of events and of switches (conditions.h), of eight motions at once: whether one of them may have changed within a motion's
 * latest step, for which that motion is to be looked at alone (crossing.h).
 */
#ifndef LAG_WIDE_CONDITIONS_H
#define LAG_WIDE_CONDITIONS_H

#include "methods/wide_taylor.h"

typedef struct {
    const LagModel *model;
    int watched; /* conditions that may change: all but gaps, and rates at contacts */
    int *has_contact; /* n_whens */
    double *g, *rate, *g_old, *rate_old; /* n_switches: at present, and where the latest steps began */
    double *g_inside, *rate_inside;
    double *state, *acceleration; /* 2 n, n: somewhere inside the steps */
    double *time;
    double *sense;   /* n_switches: 1 where a condition is held to be true, -1 where not, 0 where nothing depends on it */
    double *unknown; /* n_switches: how well each is known */
    double *u_slope; /* how much rounding is on the level of what is held: there are no inputs */
    double *d, *c, *work;
    double suspect[LAG_ABREAST]; /* 1: something may have changed in the latest step */
} LagWideConditions;

/* Whether there are no conditions, or they can be looked at by their instructions. */
int lag_wide_conditions_serve(const LagModel *model);

void lag_wide_conditions_layout(LagWideConditions *conditions, const LagModel *model, LagArena *arena);

/* Whether the run goes on as motions in lanes do: nothing is held, stands or has just begun, and nothing was stiff. */
int lag_wide_conditions_suit(const LagRun *run);

/* The motion in the lane is that of the run, and is where that is. */
void lag_wide_conditions_enter(LagWideConditions *conditions, int lane, LagRun *run);

/* After a step in each lane. */
void lag_wide_conditions_look(LagWideConditions *conditions, const LagWideTaylor *taylor);

#endif
