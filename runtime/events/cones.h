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

/* Whether component i is one of a slip that has been torn off within a step of an importer, and has more speed by now than is an error. */
int lag_cones_have_left(LagRun *run, int i);

/* The share of component i, or of the force that there is, where more is asked for: in the same direction. */
double lag_cones_limited(const LagRun *run, int i);

/* Those that switches.turned says have been torn off become candidates: they are held once more, to be let go from. Into
 * sliding.leaves. */
void lag_cones_note_torn(LagRun *run);

/* The component of a slip with which it leaves, against the force that would hold it: less than can be told, and a direction. */
double lag_cones_kick(LagRun *run, int i);

/* Where nothing acts yet, an impulse of what would hold leaves none: those that will be torn off as soon as there is some leave so, by
 * changes of rates. */
void lag_cones_throw(LagRun *run);

/* Those have left: they are not held after all, whatever rounding says of a force that is just enough. */
void lag_cones_note_left(LagRun *run);

/* How far shares of what is so held are from the circle, into g (n_switches) of both. */
void lag_cones_margins(const LagRun *run, double *g);

/* The rates of that: `rate` (n_switches) of both has those of their shares. */
void lag_cones_margin_rates(const LagRun *run, double *rate);

/* A segment begins: nothing depends on the signs of the components of what slips. */
void lag_cones_enter(LagRun *run);

/* At the present state: the time up to which the next step may go, so that none passes the place where a slip stops, into
 * sliding.stops; and into switches.turned, which have stopped but for what cannot be told. Returns whether some have. */
int lag_cones_look(LagRun *run);

/* A state that an importer has come to: slips are measured from their directions there. */
void lag_cones_note(LagRun *run, double t, const double *y);

/* The step of an importer ends where friction is just enough: what is held there is torn off. */
void lag_cones_note_end(LagRun *run);

/* An importer goes on after an event. */
void lag_cones_begin(LagRun *run);

/* How far slips are from turning round since then, and from speeds that differ much from those after the latest event: at slow ones forces
 * change much with rates, and an importer that takes derivatives for others' finds no motion. Into g (n_switches) of the components:
 * `values` are those of the conditions. */
void lag_cones_turns(const LagRun *run, const double *values, double *g);

/* The same of the present state: how far beyond it they have come, by the steps of an importer that does not look for the place, which
 * tells what its errors are. */
void lag_cones_note_beyond(LagRun *run);

/* The rates v[n] at which forces of slips that have turned round since then are evaluated, so that they do not turn round within a step:
 * what has turned is mirrored. `size`[n]: of rates. NULL: none has. */
double *lag_cones_mirrored(LagRun *run, double t, const double *q, const double *v, const double *size);

/* Whether a slip is turned round at a state, since the latest step began. */
int lag_cones_have_turned(LagRun *run, double t, const double *y);

/* Whether a slip turned round in the latest step, which has passed the place where it stops, though no evaluation has. */
int lag_cones_turn_round(LagRun *run);

#endif
