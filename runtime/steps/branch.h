/* Whether rates have become others within next to no time: near a singular position, the motion has gone over to another way of moving. */
#ifndef LAG_BRANCH_H
#define LAG_BRANCH_H

#include "base/arena.h"
#include "model/model.h"
#include "state/settings.h"

typedef struct {
    double *rate;      /* n: rates after the latest step of usual length */
    double step, time; /* its length and its end; 0: none since something happened */
    int turned;        /* the coordinate whose rate has become another one within next to no time; -1: none */
} LagBranch;

void lag_branch_layout(LagBranch *branch, const LagModel *model, LagArena *arena);

/* Something has happened: rates may be others. */
void lag_branch_forget(LagRun *run);

/* Takes notice of a step. */
void lag_branch_watch(LagRun *run);

#endif
