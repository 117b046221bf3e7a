/* Taylor steps (taylor.h) of eight motions at once, each at its own time and with steps of its own: what several motions do in turn, one
 * vector of the processor does for all of them. No motion knows of the others, and so none depends on which these are.
 *
 * Steps are those of taylor.c where nothing happens: no events, no constraints, nothing that begins from rest; inputs are linear in each
 * segment, and somebody says when the next one begins. Whether steps pass by what stands under a root (roots.h) is asked elsewhere.
 *
 * To the end of a segment that is near lead short steps, of as few orders as make the rest of the series rounding, or nearly so.
 */
#ifndef LAG_WIDE_TAYLOR_H
#define LAG_WIDE_TAYLOR_H

#include "model/wide_jet_tape.h"
#include "state/settings.h"
#include "state/wide_scale.h"

typedef struct {
    const LagModel *model;
    int n, size;  /* size = 2 n + n_power: what a state has */
    int order;                /* the highest */
    double last, before_last; /* as in LagTaylor */
    double longest;           /* that steps may be */
    double faint;             /* units that the last coefficients of short steps may be worth */
    LagWideScale scale;
    LagWideSeries series;     /* its line is that of the states made last */
    double *y, *carry, *old;       /* present states, and those before the latest steps; `old` without quadratures is what units ask */
    double *made, *made_carry; /* of the steps that are tried */
    double *weight;           /* 2 n: 1 / units */
    double *slope;            /* of inputs */
    double own[LAG_ABREAST];  /* the orders of the steps that are tried */
    double first[LAG_ABREAST]; /* those that are looked at first */
    int made_to;              /* the highest one of them */
    int is_fresh;             /* some motion goes on by other inputs than those of the line */
    double t[LAG_ABREAST], t_old[LAG_ABREAST], stop[LAG_ABREAST];
    double length[LAG_ABREAST]; /* of the latest step */
    double reach[LAG_ABREAST];  /* of the next one, by the last coefficients */
    double limit[LAG_ABREAST];  /* of the next one: after a step that was no good */
    double next[LAG_ABREAST];   /* where the steps that are tried end */
    double wrong[LAG_ABREAST];  /* errors of steps that were no good */
    double energy[LAG_ABREAST]; /* 1 / what counts as a unit of error in quadratures; 0: they do not */
    double moves[LAG_ABREAST];  /* 1: there is a motion in the lane */
    double taken[LAG_ABREAST];  /* 1: the latest step was good */
    double steps[LAG_ABREAST], in_vain[LAG_ABREAST], missed[LAG_ABREAST]; /* taken; no good, since the last one that was; taken though
                                                                           * they were none, for rounding */
} LagWideTaylor;

/* Whether motions of this model can be stepped so: events and constraints ask for more. */
int lag_wide_taylor_serves(const LagModel *model);

void lag_wide_taylor_layout(LagWideTaylor *taylor, const LagRun *like, LagArena *arena);

/* The motion of a run goes on here, or begins. Returns 0 where it cannot: what is at rest has to be set in motion first. */
int lag_wide_taylor_load(LagWideTaylor *taylor, int lane, LagRun *run);

/* The motion in the lane, which is where that of the run is, has come into the segment that the run is in. */
void lag_wide_taylor_enter(LagWideTaylor *taylor, int lane, LagRun *run);

/* The lane's state, and that of its latest step, as if the run had made it; `is_whole`: with what dense output asks for. */
void lag_wide_taylor_show(LagWideTaylor *taylor, int lane, LagRun *run, int is_whole);

/* Tries a step in each lane. */
void lag_wide_taylor_step(LagWideTaylor *taylor);

#endif
