/* What is read late: noted step by step, known where it is asked for, and exact about the times at which it breaks. */
#ifndef LAG_DELAYS_H
#define LAG_DELAYS_H

#include "state/state.h"

void lag_delays_layout(LagRun *run, LagArena *arena);

/* What was before the start, of which the state and the modes are known. LAG_BAD_DELAY where a delay is not positive. */
LagStatus lag_delays_begin(LagRun *run);

/* A segment begins, which would end at `end`. Returns where it ends for the sake of what is read late. */
double lag_delays_enter(LagRun *run, double end);

/* Around what may change rates, and behind what may change switches, at the beginning of a segment: where they become others, what is
 * read late breaks a lag later, whatever came back at that time. */
void lag_delays_await_kick(LagRun *run);
void lag_delays_look_for_kick(LagRun *run);
int lag_delays_look_for_bend(LagRun *run, int is_bend); /* which it returns */

/* The latest step, whose end may be taken back to a time inside it later. */
LagStatus lag_delays_note(LagRun *run);

/* Whether parameters have become others by which delays would change during a run, which then fails. */
int lag_delays_change(LagRun *run);

#endif
