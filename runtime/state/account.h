/* The energy account: H - H(0) + dissipated - work = 0 along every true motion. */
#ifndef LAG_ACCOUNT_H
#define LAG_ACCOUNT_H

#include "state/state.h"

enum { LAG_ACCOUNT_SIZE = 5 };

/* A run starts at the present state. */
void lag_account_start(LagRun *run);

/* Completes the {T, V, H, dissipated, work} of a state at t whose {T, V, H} are known; notes residual and scale in the statistics, and
 * whether the tolerance explains by how much it misses. */
void lag_account_note(LagRun *run, double t, const double *y, double *entries);

/* By how much, relative to the energies {T, V, H} that it had first and has now (dissipated, work: quadratures), a motion misses after so
 * many steps in which nothing else has happened; NaN where that is more than the tolerance explains (`is_short`), or more than
 * steps may go on with. */
double lag_account_between(const LagRun *like, const double *first, const double *last, const double *quadratures, double steps,
                           int is_short);

/* Whether prescribed motion may bring energy to what has none. */
int lag_account_may_carry(const LagModel *model);

/* Whether it misses at the present state by more than the tolerance explains; nothing is noted. */
int lag_account_misses(LagRun *run);

/* What errors of the quadratures in an attempt at a step of length h, in units, count of them: nothing from where on they are those of
 * rounding, of stiff forces or of a jump, which shorter steps do not make as much smaller as the order says, until the next segment. */
double lag_account_count(LagMotion *motion, double h, double error);

/* Notes how large the energies are in the present state: rows may all lie where there is none. */
void lag_account_glance(LagRun *run);

/* The same of loops, where rates have risen since: energies may come and go within a few steps. */
void lag_account_rise(LagRun *run);

/* A segment begins: what energies it will have where there are none yet, and whether errors of work count in it. */
void lag_account_begin(LagRun *run);

/* The unit of errors of the energy quadratures in series; 0: they do not count. */
double lag_account_unit(const LagRun *run);

/* Where friction holds what supports draw at, the work of these alone tells how long steps may be; and methods that begin at a low
 * order, or make long steps, make much larger errors of work than of the motion: whether errors of it count now. */
void lag_account_weigh(LagRun *run);

/* To be called before and after modes, inputs or parameters change at the present state. The jump of H is work done by
 * whoever changes them. */
void lag_account_open(LagRun *run);
void lag_account_close(LagRun *run);

/* The same at an event: energies that jump in time may do so a moment before or after it. */
void lag_account_come(LagRun *run);
void lag_account_leave(LagRun *run);

#endif
