/* Candidates for sliding (the first `count` of sliding.which): their states, and what rates are by them. */
#ifndef LAG_CANDIDATES_H
#define LAG_CANDIDATES_H

#include "events/sliding.h"
#include "state/settings.h"

/* What sliding.state says of each; given: it does not act on its own g. */
enum { LAG_LOW, LAG_HIGH, LAG_SLIDES, LAG_GIVEN };

/* The place of switch i among them; -1: it is none. */
int lag_candidates_place(const LagSliding *s, int count, int i);

/* dg/dt of candidate k by those that do not slide alone, or by all. */
double lag_candidates_rate(const LagSliding *s, int count, int k, int by_all);

/* The size of its terms, which tells what of it is rounding: of both components of a slip in the plane, the larger one. */
double lag_candidates_size(const LagSliding *s, int count, int k);

/* How near the share of candidate k is to an end that it is taken for: where its jump moves no mass, but a first-order state that is to
 * stay beside the motion (the slip of a spring in a row with friction). Rounding of such a share would end it again and again. */
double lag_candidates_tie(const LagSliding *s, int count, int k, double rounding);

/* Shares of those that slide. */
void lag_candidates_solve(LagRun *run, int count);

/* Shares that motion does not tell, so that all that can hold does. */
void lag_candidates_balance(LagRun *run, int count);

/* Shares into d. */
void lag_candidates_set(const LagRun *run, int count);

#endif
