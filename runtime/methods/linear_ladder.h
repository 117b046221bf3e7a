/* The exponentials exp(A h 2^k), and with them the integrals of the powers x' Q x over each of these times.
 *
 * Rung 0 is a Taylor series, each rung after it the square of the one before: scaling and squaring (C. Moler,
 * C. Van Loan, SIAM Review 45 (2003)), with all rungs kept. W(h) = int_0^h E(s)' Q E(s) ds (C. Van Loan, IEEE Trans. Autom.
 * Control 23 (1978)) doubles likewise: W(2h) = W(h) + E(h)' W(h) E(h). A step of any length is a sum of rungs and a rest.
 */
#ifndef LAG_LINEAR_LADDER_H
#define LAG_LINEAR_LADDER_H

#include "methods/linear_system.h"

enum { LAG_LADDER_MOST_STATES = 256, LAG_LADDER_MOST_RUNGS = 56 };

typedef struct {
    size_t size, stride;
    int n_forms, n_rungs, built;
    int top;      /* the rung of the step in use, whose length is `base` */
    double base;  /* 0: no ladder yet */
    double length[LAG_LADDER_MOST_RUNGS];
    double norm;  /* of A, in balanced units of the states */
    LagDDs slopes; /* A', row by row */
    LagDDs form[2];
    LagDDs rungs, scratch[2], row;
} LagLadder;

/* Whether a model is small enough for a ladder, and has the forms for it. */
int lag_ladder_possible(const LagModel *model);

void lag_ladder_layout(LagLadder *ladder, const LagLinearSystem *system, LagArena *arena);

/* New numbers in the system: forgets all rungs. */
void lag_ladder_reset(LagLadder *ladder, LagLinearSystem *system);

/* Plans rungs such that one of them is a step of length h; they are built when used. */
void lag_ladder_set_base(LagLadder *ladder, double h);

/* Whether steps of length h take a bounded number of rungs: numbers beyond all measure do not. */
int lag_ladder_reaches(const LagLadder *ladder, double h);

/* The longest rung of at most this length, or of a rounding error more; -1: even rung 0 is longer. */
int lag_ladder_find(const LagLadder *ladder, double h);

/* y = E x, and the integrals of the powers are added to those given. */
void lag_ladder_climb(LagLadder *ladder, int rung, LagDDs x, LagDDs y, LagDD *integrals);

/* The high parts of column j of E, or of a form. */
const double *lag_ladder_row(const LagLadder *ladder, int rung, int part, size_t j);

/* Multiplications of numbers that a base h would cost in all, and that climbing one rung costs. */
double lag_ladder_cost(const LagLadder *ladder, double h);
double lag_ladder_cost_of_rung(const LagLadder *ladder);

#endif
