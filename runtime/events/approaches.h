/* Which contacts are struck in a round of impacts: those that approach. */
#ifndef LAG_APPROACHES_H
#define LAG_APPROACHES_H

#include "events/impacts.h"

/* Whether contact k came where all else came true while it was passed already: its resets are those of any event. */
int lag_approaches_passed(const LagRun *run, int k);

/* Whether contact k is closed, but for what cannot be told. */
int lag_approaches_touch(const LagRun *run, int k);

/* Contact k is struck where it approaches, or is stopped though it is passed: into impacts.fires. What an impact has stopped
 * stays together in those that it brings about, unless these part it. Returns whether there is anything new in that. */
int lag_approaches_find(LagRun *run, int k);

/* Contacts of a rank that approach by rounding of what others do wait for these, and stay in impacts.comes if they came: what lies
 * on a body that a wall strikes is struck next, not with it. No other contact comes any more. */
void lag_approaches_let_wait(LagRun *run, int rank);

#endif
