/* Rubs: friction that presses with the force of a contact presses with its impulse, too. */
#ifndef LAG_CONTACT_FRICTION_H
#define LAG_CONTACT_FRICTION_H

#include "model/model.h"
#include "state/settings.h"

/* Whether switch i is that of friction that presses with the force of a contact, and of nothing else. */
int lag_rubs_alone(const LagModel *model, int i);

/* Whether it is, and nothing rests at those contacts, of `candidates` (n_switches: 1). */
int lag_rubs_nowhere(const LagModel *model, int i, const int *candidates);

/* Whether something rubs at the contacts of impacts.fires. */
int lag_rubs_act(const LagRun *run);

/* Impulses of the `count` resets of impacts.which and what rubs there: the rates after them into impacts.after, and the shares with
 * which friction acts in them into d. Switches are not live then. `presses`: contacts that do not approach take what stops the slip that
 * would press them further and further. Returns 0 where there are no such impulses. */
int lag_rubs_solve(LagRun *run, int count, int presses);

/* Whether something rests at a contact that presses the friction of switch i. */
int lag_rubs_on_what_rests(const LagRun *run, int i);

/* Into d: nothing rubs. */
void lag_rubs_let_go(LagRun *run);

#endif
