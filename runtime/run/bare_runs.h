/* Runs in lanes of which nothing is asked but coordinates and rates at their ends, or in rows from one to the next of which inputs are
 * held, and to which nothing else happens but their motion.
 *
 * All that such a run has of its own is a state: eight begin together (wide_starts.h), and the energy accounts of eight that have ended
 * are closed together, by the energies of eight states at once. A LagRun is given to one only where more is to be looked at.
 */
#ifndef LAG_BARE_RUNS_H
#define LAG_BARE_RUNS_H

#include "methods/wide_taylor.h"
#include "run/batch_state.h"

enum { LAG_BARE_ENERGIES = 3 }; /* T, V, H */

typedef struct {
    const LagBatch *batch;
    LagWideTaylor *taylor;
    int is_bare[LAG_ABREAST]; /* that in the lane */
    int next_row[LAG_ABREAST]; /* what its run comes to */
    double energies[LAG_BARE_ENERGIES * LAG_ABREAST]; /* where lag_bare_look has looked */
    double seen[LAG_ABREAST]; /* the largest that errors of work are weighed by, where powers are integrated */
    double *start, *start_u;  /* 2 n and inputs, LAG_ABREAST each, as those below: of the runs in lanes */
    int count;                /* runs that have ended, and whose accounts are open: their numbers, steps, and states */
    int64_t ended[LAG_ABREAST];
    double steps[LAG_ABREAST];
    double *first, *first_u, *last, *last_u; /* 2 n; as a state, with quadratures */
    double *pair, *pair_u, *row, *work;
} LagBareRuns;

/* Whether those of the batch are such runs, by series in lanes; those with rows in calls that tell what inputs are held. */
int lag_bare_serve(const LagBatch *batch);

/* `runs` is NULL, or begins with zeros. */
void lag_bare_layout(LagBareRuns *runs, const LagModel *model, int size, LagArena *arena);

/* Where run i begins, (q, v), by the guesses of a run with the same parameters; kept by the batch. */
const double *lag_bare_find_start(const LagBareRuns *runs, int64_t i, const LagRun *like);

/* Run i has been put into the lane at its start: the inputs that it begins with. `run`, here and below: the lane's own, of which nothing
 * is asked but outputs at rows. */
void lag_bare_place(LagBareRuns *runs, int lane, int64_t i, LagRun *run);

/* Energies of the present states in all lanes, with those of a run like theirs: before some begin. */
void lag_bare_look(LagBareRuns *runs, const LagRun *like);

/* The motion that has begun in the lane is that of the bare run i. */
void lag_bare_begin(LagBareRuns *runs, int lane, int64_t i, LagRun *run);

/* Run i has come to a row in the lane, which is told; other inputs are held from there on. */
void lag_bare_pass(LagBareRuns *runs, int lane, int64_t i, LagRun *run);

/* Whether the account of that in the lane closes so far, with energies as those of a run like it, as far as steps ask for. */
int lag_bare_closes(LagBareRuns *runs, int lane, const LagRun *like);

/* Run i has ended in the lane: its results are told. Its account is to be closed before more than LAG_ABREAST have. */
void lag_bare_end(LagBareRuns *runs, int lane, int64_t i, LagRun *run);

/* The misses of the accounts of those that have ended, relative; NaN where that is more than is explained right away. */
void lag_bare_close(LagBareRuns *runs, const LagRun *like, double *misses);

#endif
