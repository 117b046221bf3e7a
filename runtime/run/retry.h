/* Another choice where the one in use gives up, or its energy account misses.
 *
 * Near dead points and where linkages lie flat rounding decides which steps pass. A run with loops whose solver is chosen begins again
 * from a state that was kept some steps before, by the first of the other choices that passes (choice.c), and goes on with that one.
 * Where none does, it is as it was. What is kept is one copy of the run, renewed now and then; a run that has just started is
 * started anew instead. Whoever drives a run knows nothing of it: rows that were told stay, and the present time never lies
 * before that of the last step that was told.
 */
#ifndef LAG_RETRY_H
#define LAG_RETRY_H

#include "base/arena.h"
#include "base/status.h"
#include "model/model.h"
#include "state/settings.h"

typedef struct {
    int from;           /* what to begin again from, of retry.c */
    int tried;          /* bits of LAG_SOLVER_...: what has failed from there, or was in use there */
    int round;          /* how often all of them have */
    int32_t chosen;     /* LAG_SOLVER_...: what has taken over since; AUTO: nothing */
    int64_t steps;      /* of the run, there */
    double t;           /* the present time, there */
    double *given;      /* 2 n: places and rates that the start was given */
    int has_q, has_v;   /* whether it was */
    unsigned char *kept; /* struct, vectors and what is on its way to be read late, one after the other; NULL: none yet */
    size_t room;        /* its bytes */
    double *told;       /* of each guard, as in LagGuards, while the run is started anew */
    int *is_news;       /* likewise */
    int64_t spent;      /* steps by other choices since the run started */
    const volatile int32_t *stop; /* whether its driver wants no more of it; NULL: it never says so */
    double limit;       /* by lag_clock, when its driver wants no more of it; 0: never */
} LagRetry;

void lag_retry_layout(LagRetry *retry, const LagModel *model, LagArena *arena);
void lag_retry_free(LagRetry *retry);

/* A run starts, from these places and rates; NULL: none are given. */
void lag_retry_begin(LagRun *run, const double *q_given, const double *v_given);

/* Something is set, so that what was kept is no longer of this run. */
void lag_retry_forget(LagRun *run);

/* One step, by another choice where need be. LAG_TURNED_OFF where rates turn within a moment and constraints repeat each other: two ways
 * of moving meet. */
LagStatus lag_retry_step(LagRun *run);

/* Whether a row may be another one by another choice: with this status, if the account was open before it. */
int lag_retry_is_due(const LagRun *run, LagStatus status, int was_open);

/* The run again, to the first step that ends at `goal` or behind it, by another choice; where none passes, as it came there before, and with
 * that status. LAG_PAUSED where its driver wants no more of it: it lies somewhere before. */
LagStatus lag_retry(LagRun *run, double goal);

#endif
