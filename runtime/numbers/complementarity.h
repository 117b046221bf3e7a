/* Forces (or impulses) that act only where they are needed, and the accelerations (or rates) that they bring about:  w = r + W x.
 *
 *   BINDS: w = 0 by any force;
 *   PUSHES: w = 0 by x > 0, or x = 0 and w <= 0;
 *   RUBS: w = 0 by 0 < x < limit, or x = 0 and w <= 0, or x = limit and w >= 0, where limit = own + sum_j press_j x_j of those that push.
 *
 * The latter are Coulomb's friction, from mu N against a slip w < 0 (x = 0) to mu N against w > 0: half of its range is in r. This is a
 * linear complementarity problem (C. Glocker, F. Pfeiffer, Multiple impacts with friction in rigid multibody systems, Nonlinear Dynamics
 * 7 (1995)). With friction it can have several solutions, or none (P. Painleve, Sur les lois du frottement de glissement, C. R. Acad.
 * Sci. 121 (1895)): the first is taken, in an order that begins with all that hold. What rubs stands behind all else: of those that push
 * against each other (the walls of a slot) only as many do as have to for what they stop themselves, since friction would let them press
 * with any force.
 */
#ifndef LAG_COMPLEMENTARITY_H
#define LAG_COMPLEMENTARITY_H

#include "numbers/dense_lu.h"

enum { LAG_BINDS, LAG_PUSHES, LAG_RUBS };   /* kinds */
enum { LAG_HOLDS, LAG_NONE, LAG_ALL }; /* states: w = 0; x = 0; x = limit */

typedef struct {
    int size;
    int *kind, *state; /* size */
    double *rate;      /* size: r */
    double *jump;      /* size x size, column-major: W */
    double *own;       /* size: limits where nothing presses */
    double *press;     /* size x size, column-major: what limit i is raised by x_j */
    double *terms;     /* size: of which w is a difference, beside r and those of W x: what tells how much of it is rounding */
    double *force;     /* size: x */
    double *change;    /* size: of those that hold */
    LagDenseLu lu;
} LagComplementarity;

void lag_complementarity_layout(LagComplementarity *problem, int most, LagArena *arena);

/* A problem of so many forces: nothing presses, nothing is known of terms. */
void lag_complementarity_begin(LagComplementarity *problem, int size);

/* Into state and force. Returns 0 where there is no solution. */
int lag_complementarity_solve(LagComplementarity *problem);

/* The forces of the states that are given, right or wrong: into force. */
void lag_complementarity_find_forces(LagComplementarity *problem);

/* The forces that alone make w = 0 of the rates rate[size], whatever r is: into rate. */
void lag_complementarity_find_balance(LagComplementarity *problem, double *rate);

/* What x_i ends at. */
double lag_complementarity_limit(const LagComplementarity *problem, int i);

#endif
