/* What is read late: the past of some signals, as polynomials in time, and the times at which they break.
 *
 * A delayed value of t is the signal at t - lag. The signals of all delays lie in common pieces: [begin, end, values of each at
 * Chebyshev points], one behind the other. Where a signal breaks, the delayed value does so a lag later, one derivative higher: what
 * is smooth between two breaks is read from one side of each (C.A.H. Paul, Developing a delay differential equation solver, 1992).
 */
#ifndef LAG_HISTORY_H
#define LAG_HISTORY_H

#include <stddef.h>

#include "base/arena.h"
#include "base/status.h"

/* Values of a piece of a signal; derivatives up to this order of what breaks matter to methods of any order. */
enum { LAG_HISTORY_NODES = 10, LAG_HISTORY_ORDERS = 9 };

typedef struct {
    int n;               /* signals */
    int rises;           /* whether breaks pass through accelerations, which smooth them, on their way back */
    double *lag;         /* n */
    double *low, *high;  /* n: the stretch without breaks that is in force */
    double *largest;     /* n: of the signals, so far */
    double shortest, longest; /* of the lags; infinity and 0 where there is none */
    double known;        /* the pieces end here */
    double due;          /* when the next break comes back; infinity: none */
    int due_order;
    double *pieces, *marks; /* a mark is a time and an order: the signals have so many derivatives there */
    int is_out_of_memory; /* something could not be kept */
    size_t first, count, capacity, n_marks, mark_capacity; /* in pieces, in marks */
} LagHistory;

void lag_history_layout(LagHistory *history, int n, LagArena *arena);
void lag_history_free(LagHistory *history);

/* Nothing is known yet, until t. */
void lag_history_clear(LagHistory *history, double t);

/* Another piece, from what is known to `end`: values[n x LAG_HISTORY_NODES] at the places of lag_history_node. */
double lag_history_node(double begin, double end, int k);
void lag_history_append(LagHistory *history, double end, const double *values);

/* What the polynomial through values of one signal may miss: the part that its last Chebyshev coefficients have. */
double lag_history_error(const double *values);

/* What is behind t is not so. */
void lag_history_cut(LagHistory *history, double t);

/* What nobody reads from t on is dropped. */
void lag_history_drop(LagHistory *history, double t);

/* The signals have so many derivatives at t; the latest time that was marked may be marked again, with less. */
void lag_history_mark(LagHistory *history, double t, int order);

/* A stretch begins at t: sets low, high, due and due_order. */
void lag_history_enter(LagHistory *history, double t, double resolution);

/* Delayed values at t, and their rates. */
void lag_history_at(const LagHistory *history, double t, double *values);
void lag_history_rates(const LagHistory *history, double t, double *rates);

/* All that memory outside a run's block holds, as so many doubles; those that were saved, taken over (0: no memory). */
size_t lag_history_size(const LagHistory *history);
void lag_history_save(const LagHistory *history, void *place);
int lag_history_load(LagHistory *history, const LagHistory *saved, const void *place);

#endif
