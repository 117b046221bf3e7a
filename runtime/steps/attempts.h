/* The attempts at one step: what is tried after a rejection. */
#ifndef LAG_ATTEMPTS_H
#define LAG_ATTEMPTS_H

#include "state/state.h"

enum { LAG_WAYS = 8 }; /* lengths at which a step is tried near a singular position */

typedef struct {
    int rejected;
    double planned;          /* length first tried */
    double allowed;          /* error, in units */
    double last;             /* error of the attempt before */
    double early;            /* error of a still shorter attempt before the lengths below; infinity: there was none */
    double errors[LAG_WAYS]; /* of the lengths tried near a singular position; infinity: in vain; set where it gets careful */
    int tries[LAG_WAYS];     /* how often each was tried */
    int way;                 /* the one being tried; -1: another length */
    int depth;               /* halvings of the shortest of them that were tried after all; IN_VAIN near a singular position */
} LagAttempts;

LagAttempts lag_attempts_begin(LagRun *run);

/* Whether the method leaves what is tried to another one, which is in use then, with a length proposed. As lag_attempts_next, before it. */
int lag_attempts_leave(LagRun *run, const LagAttempts *attempts, double h, double error, double shorter);

/* The length to try next, after one of length h was rejected with this error (infinity: it has none); `shorter` is what the
 * error asks for by itself. `rejected` has been counted. */
double lag_attempts_next(LagRun *run, LagAttempts *attempts, double h, double error, double shorter);

/* A step of length h was taken. */
void lag_attempts_end(LagRun *run, const LagAttempts *attempts, double h, double error);

#endif
