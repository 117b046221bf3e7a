/* Taylor steps (taylor.h) of eight motions at once (wide_steps.h): what several motions do in turn, one vector of the processor does for
 * all of them.
 *
 * Steps are those of taylor.c where nothing happens: no events, no constraints, nothing that begins from rest; inputs are linear in each
 * segment, and somebody says when the next one begins. Whether steps pass by what stands under a root (roots.h), or by an event
 * (wide_conditions.h), is asked elsewhere.
 *
 * To the end of a segment that is near lead short steps: where segments are many, of as few orders as make the last terms rounding, or
 * so little that all such steps of a run together make what the rest of the series of one long step may be worth.
 */
#ifndef LAG_WIDE_TAYLOR_H
#define LAG_WIDE_TAYLOR_H

#include "methods/wide_steps.h"
#include "model/wide_jet_tape.h"

typedef struct {
    LagWideSteps lanes;
    int order;                /* the highest */
    double last, before_last; /* the binary logarithms of those in LagTaylor */
    int is_cut;               /* segments end again and again: short steps have orders of their own, which others wait for */
    double faint, rate;       /* units that the last terms of short steps may be worth: so many, or so many over their time */
    LagWideSeries series;     /* its line is that of the states made last */
    int numbers_of[LAG_ABREAST]; /* the parameters that what is constant was made of: LagRun.parameters_version */
    double *weight, *next_weight; /* 2 n: 1 / units of the latest steps that were good, and of those that are tried */
    double entered[LAG_ABREAST]; /* 1: no step has weighed what is there */
    double *slope;            /* of inputs */
    double begins[LAG_ABREAST]; /* LAG_BEGINS..., until what a first step needs is known; 0: no more */
    double first_time, first_stop, first_length; /* of motions that differ in their states alone, at their start; stop: of the segment */
    double *first_u, *first_slope;
    double own[LAG_ABREAST];  /* the orders of the steps that are tried */
    double first[LAG_ABREAST]; /* those that are looked at first */
    int made_to;              /* the highest one of them */
    double reach[LAG_ABREAST]; /* lengths of the next steps, by the last coefficients */
    double limit[LAG_ABREAST]; /* of them: after a step that was no good */
    double wrong[LAG_ABREAST]; /* errors of steps that were no good */
} LagWideTaylor;

/* A motion that a run has begun; of which nobody knows more than its state. */
enum { LAG_BEGINS = 1, LAG_BEGINS_UNSEEN };

/* Whether motions of this model can be stepped so: events and constraints ask for more. */
int lag_wide_taylor_serves(const LagModel *model);

/* The first coefficients of all series, where inputs, modes or motions have come that these are not of yet. */
void lag_wide_taylor_begin(LagWideTaylor *taylor);

/* Times and states (2 n) at a share of the latest steps, of scenes without attitudes. */
void lag_wide_taylor_inside(const LagWideTaylor *taylor, double share, double *t, double *y);

extern const LagWideMethod lag_wide_taylor;

#endif
