/* Events whose conditions compare several things, of which some may be held: b.v > 0 or c.v > 3, b.s < (if time > 1 then 0.1 else 0). Each
 * comparison is decided by itself: while something is held such conditions are what they are where that is held exactly, places where they
 * were and gaps closed, and where both sides of a comparison are equal but for rounding they say by themselves which it is.
 */
#ifndef LAG_EDGES_H
#define LAG_EDGES_H

#include "events/held_ways.h"

typedef struct {
    int is_in_force; /* while what slides is chosen it is not */
    int is_placed;   /* what was held latest was held where `place` tells */
    int *is_place;  /* most that slide: of what is held also the place is; a contact's gap */
    double *place;  /* n: places, where that began */
    double *state;  /* 2 n */
    double *g, *rate; /* n_switches */
} LagEdges;

void lag_edges_layout(LagEdges *edges, const LagModel *model, LagArena *arena);

/* What slides has been chosen. */
void lag_edges_find(LagRun *run);

/* And all else that is held: such events are true or false from then on as they say; those that come by it: into switches.turned, and the
 * segment is over. */
void lag_edges_enter(LagRun *run);

/* Conditions of such events, and their rates, at a state where all of g was found. */
void lag_edges_decide(LagRun *run, double t, const double *y, const double *a, double *g, double *rate);

/* How much rounding of the present state changes the condition i of one, which is switches.g: what it compares may be other things than where
 * the segment began. */
double lag_edges_unknown(LagRun *run, int i);

/* Whether event k is such a one, and stays what it is where its condition is g. */
int lag_edges_keep(const LagRun *run, int k, double g);

#endif
