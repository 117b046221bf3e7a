/* Rubs: friction that presses with the force of a contact presses with its impulse, too. */
#ifndef LAG_RUBS_H
#define LAG_RUBS_H

#include "model.h"
#include "run.h"

/* Whether switch i is that of friction that presses with the force of a contact, and of nothing else. */
int lag_rubs_alone(const LagModel *model, int i);

/* Whether something rubs at the contacts of impacts.fires. */
int lag_rubs_act(const LagRun *run);

/* Into d, before impulses of impacts.fires: the shares with which friction acts in them. Switches are not live then. */
void lag_rubs_settle(LagRun *run);

/* Into d: nothing rubs. */
void lag_rubs_let_go(LagRun *run);

#endif
