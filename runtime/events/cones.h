/* Cones: friction in the plane holds both components of a slip, as long as their shares lie in a circle. */
#ifndef LAG_CONES_H
#define LAG_CONES_H

#include "model/model.h"
#include "state/settings.h"

/* Whether switch i is a component of a slip in the plane. */
int lag_cones_have(const LagRun *run, int i);

/* The other component; -1: it is none. */
int lag_cones_partner(const LagRun *run, int i);

/* The same, of which both are held. */
int lag_cones_hold(const LagRun *run, int i);

/* Whether it is a component of a slip for which there is not enough that holds, or that has been torn off. */
int lag_cones_break(const LagRun *run, int i);

/* Those that switches.turned says have been torn off become candidates: they are held once more, to be let go from. Into
 * sliding.leaves. */
void lag_cones_note_torn(LagRun *run);

/* The component of a slip with which it leaves, against the force that would hold it: less than can be told, and a direction. */
double lag_cones_kick(LagRun *run, int i);

/* How far shares of what is so held are from the circle, into g (n_switches) of both. */
void lag_cones_margins(const LagRun *run, double *g);

/* The rates of that: `rate` (n_switches) of both has those of their shares. */
void lag_cones_margin_rates(const LagRun *run, double *rate);

/* A segment begins: nothing depends on the signs of the components of what slips. */
void lag_cones_enter(LagRun *run);

/* At the present state: the time up to which the next step may go, so that none passes the place where a slip stops, into
 * sliding.stops; and into switches.turned, which have stopped but for what cannot be told. Returns whether some have. */
int lag_cones_look(LagRun *run);

/* Whether a slip turned round in the latest step, which has passed the place where it stops, though no evaluation has. */
int lag_cones_turn_round(LagRun *run);

#endif
