/* Steps of one length, as methods need that keep the energy by taking them: how long, and the taking of one. */
#ifndef LAG_EQUAL_STEPS_H
#define LAG_EQUAL_STEPS_H

#include "state/settings.h"

typedef struct {
    double shortest; /* step */
    double span;     /* time that the trial took the motion through */
    double steps;    /* and in how many */
    int bends;       /* forces do in it: equal steps, which cross such places, are no good there, however short they are */
} LagTrial;

/* Explicit steps with error control from the present state on. Leaves no trace but the sizes of the motion. */
LagTrial lag_trial(LagRun *run);

/* The length next to `wish` that the settings allow and that divides what is left of the run. */
double lag_equal_length(const LagRun *run, double wish);

/* Tries a step of length h, which `is_cut` where it ends early; the new state is left in motion->other. Returns 0 when there is
 * none. */
typedef int (*LagTry)(LagRun *run, double h, int is_cut);

/* Whether equal steps of length h are so many more than those of the trial that something bends or jumps: *steps: how many. */
int lag_equal_never_ends(const LagRun *run, const LagTrial *trial, double h, double *steps);

/* Takes a step of length *h, or of what is left until the segment ends; halves *h until one can be taken. */
LagStatus lag_equal_step(LagRun *run, double *h, LagTry attempt);

#endif
