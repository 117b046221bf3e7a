/* Runs in lanes of which nothing is asked but coordinates and rates at their ends, and to which nothing happens but their motion.
 *
 * All that such a run has of its own is a state: eight begin together (wide_starts.h), and the energy accounts of eight that have ended
 * are closed together, by the energies of eight states at once. A LagRun is given to one only where more is to be looked at.
 */
#ifndef LAG_BARE_RUNS_H
#define LAG_BARE_RUNS_H

#include "methods/wide_taylor.h"
#include "run/batch_state.h"

typedef struct {
    const LagBatch *batch;
    const LagWideTaylor *taylor;
    int is_bare[LAG_ABREAST]; /* that in the lane */
    double *start;            /* 2 n, LAG_ABREAST each, as those below: of the runs in lanes */
    int count;                /* runs that have ended, and whose accounts are open: their numbers, steps, and states */
    int64_t ended[LAG_ABREAST];
    double steps[LAG_ABREAST];
    double *first, *last; /* 2 n; as a state, with quadratures */
    double *pair, *u, *row, *work;
} LagBareRuns;

/* Whether those of the batch are such runs, by series in lanes. */
int lag_bare_serve(const LagBatch *batch);

/* `runs` is NULL, or begins with zeros. */
void lag_bare_layout(LagBareRuns *runs, const LagModel *model, int size, LagArena *arena);

/* Where run i begins, (q, v), by the guesses of a run with the same parameters; kept by the batch. */
const double *lag_bare_find_start(const LagBareRuns *runs, int64_t i, const LagRun *like);

/* The motion that has begun in the lane is one of a bare run. */
void lag_bare_begin(LagBareRuns *runs, int lane);

/* Whether its account closes so far, with energies as those of a run like it, as far as steps ask for. */
int lag_bare_closes(LagBareRuns *runs, int lane, const LagRun *like);

/* Run i has ended in the lane: its results are told. Its account is to be closed before more than LAG_ABREAST have. */
void lag_bare_end(LagBareRuns *runs, int lane, int64_t i);

/* The misses of the accounts of those that have ended, relative; NaN where that is more than is explained right away. */
void lag_bare_close(LagBareRuns *runs, const LagRun *like, double *misses);

#endif
