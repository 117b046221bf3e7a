/* Narrow places along the latest step: what stands inside of the functions that make them (compiler: narrow_places.py), g, is 0 there, or
 * turns round. */
#ifndef LAG_NARROW_H
#define LAG_NARROW_H

#include "state/state.h"

/* By what g is told along the step. */
typedef struct {
    const double *(*state)(LagRun *run, double x); /* at a share x of the step, and live switches as they are there */
    double ahead;                                  /* share of the step, by which paces are told */
} LagNarrowView;

/* A part of the step, in shares of it, and g of one place, or its pace, at its ends. */
typedef struct {
    double low, high, before, after;
} LagNarrowPart;

/* g of all places at a share of the step. */
void lag_narrow_ask(LagRun *run, const LagNarrowView *view, double x, double *g);

/* g and its change in a step by its present pace. */
void lag_narrow_look(LagRun *run, const LagNarrowView *view, double x, double *g, double *pace);

/* Halves the part within which g of place i is 0 (or turns, if `turns`) until g changes by less than `fine` in it, 40 times at most. */
void lag_narrow_close_in(LagRun *run, const LagNarrowView *view, int i, int turns, double fine, LagNarrowPart *part);

#endif
