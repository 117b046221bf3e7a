/* A step by collocation, as the polynomial it stands for: rates through their values at 0 and at the nodes. */
#ifndef LAG_COLLOCATION_H
#define LAG_COLLOCATION_H

#include "state/motion.h"
#include "methods/radau_tableau.h"

typedef struct {
    const LagRadauTableau *tableau;
    double h;
    double *rate;        /* stages x n: rates minus those at the beginning */
    double *way;         /* stages x n: of attitudes alone, rates of positions minus those at the beginning, where these are the rates */
    double *power;       /* stages x n_power: powers minus those at the beginning */
    double *slope;       /* size: slope at the beginning */
} LagCollocation;

void lag_collocation_layout(LagCollocation *step, const LagMotion *motion, LagArena *arena);

/* Attitudes of a step of length h: their positions at the stages, `place` (stages x n, minus those at the beginning, which are 0), and
 * ways, from the rates. */
void lag_collocation_turn(LagCollocation *step, const LagMotion *motion, double h, double *place);

/* Stage values of the next step, of length h with another tableau perhaps, as this polynomial foresees them: relative to the
 * rates at its own end. */
void lag_collocation_foresee(const LagCollocation *step, int n, const LagRadauTableau *tableau, double h, double *rate);

/* The state at x in [0, 1] of the step that began at y. */
void lag_collocation_at(const LagCollocation *step, const LagMotion *motion, const double *y, double x, double *at);

#endif
