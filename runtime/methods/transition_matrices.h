/* State-transition matrices exp(A h) of a linear scene of few states in doubles, and with them the integrals of its powers.
 *
 * F = exp(A h) - 1 for the lengths h 2^k, each from the one before: F(2h) = 2 F + F F (scaling and squaring; C. Moler, C. Van Loan,
 * SIAM Review 45 (2003)), the first by a polynomial of degree 12 (M.S. Paterson, L.J. Stockmeyer, SIAM J. Comput. 2 (1973)).
 * Without the 1 each doubling keeps the digits of the first. W = int_0^h exp(A s)' Q exp(A s) ds doubles likewise (C. Van Loan,
 * IEEE Trans. Autom. Control 23 (1978)). Matrices lie column by column; columns are padded with zeros to a multiple of four.
 */
#ifndef LAG_TRANSITION_MATRICES_H
#define LAG_TRANSITION_MATRICES_H

#include "base/arena.h"
#include "model/inputs.h"
#include "model/linear_pattern.h"

enum { LAG_TRANSITION_MOST_STATES = 12, LAG_TRANSITION_RUNGS = 32, LAG_TRANSITION_POWERS = 5, LAG_TRANSITION_TERMS = 16 };

typedef struct {
    const LagModel *model;
    LagLinearPattern pattern;
    size_t size, stride; /* of a column */
    double norm;         /* of A, 1/s, in coordinates weighed by masses */
    int n_forms, place[2]; /* powers that are not always 0 */
    int is_planned;      /* lengths of rungs were chosen, in this run; */
    int n_built;         /* those that are known may be of a run before it */
    double length[LAG_TRANSITION_RUNGS];
    double *A, *form[2];
    double *rungs;                         /* of each its F, then its W */
    double *power[LAG_TRANSITION_POWERS];  /* scratch: matrices */
    double *terms;                         /* scratch: LAG_TRANSITION_TERMS columns */
    double *mass, *values, *work;
    double *p; /* the parameters that A belongs to */
    int is_known;
} LagTransitionMatrices;

/* Numbers in a matrix. */
static inline size_t lag_transition_entries(const LagTransitionMatrices *s) { return s->size * s->stride; }

/* What moves: x, the sum of what was added to it, and the integrals of the powers. */
typedef struct {
    double *x, *sum;
    double gain[2];
    double lag;   /* what was ignored */
    int has_rest; /* some of the length was no rung's */
} LagMoving;

/* Whether a model is linear, has few states, and forms for its powers. */
int lag_transition_possible(const LagModel *model);

void lag_transition_layout(LagTransitionMatrices *s, const LagModel *model, LagArena *arena);

/* A at these parameters. Returns 0 when M is not positive definite or A not finite. */
int lag_transition_build(LagTransitionMatrices *s, const double *p, const double *d);

/* The states of loads w at the time t of the present segment; u[n_inputs] is scratch. */
void lag_transition_loads(LagTransitionMatrices *s, const LagInputs *inputs, double t, const double *d, double *u, double *w);

/* Plans rungs such that one of them has the length h. Those of the same lengths are kept. */
void lag_transition_plan(LagTransitionMatrices *s, double h);

/* Moves on by h, but for a rest of at most `ignored`. */
void lag_transition_move(LagTransitionMatrices *s, double h, double ignored, LagMoving *moving);

/* Whether a length is so short that no rung is needed. */
int lag_transition_is_short(const LagTransitionMatrices *s, double h);

#endif
