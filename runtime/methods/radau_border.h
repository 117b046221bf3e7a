/* The border of implicit matrices: what slides, in implicit steps (sliding.h). */
#ifndef LAG_RADAU_BORDER_H
#define LAG_RADAU_BORDER_H

#include "model/implicit_matrix.h"
#include "state/motion.h"

struct LagRun;

typedef struct {
    double *re, *im; /* im is NULL where they are real */
} LagNumbers;

typedef struct {
    int n, most;     /* so many may slide */
    int count;       /* that do */
    double *way;     /* count x n: change of the accelerations by a share */
    double *by_place, *by_rate, *by_acceleration; /* count x n: derivatives of dg/dt */
    double *probe;   /* size: a state; its slope, and another one */
    double *slope, *slope_without;
    struct {
        double mu_re, mu_im;
        LagNumbers solved; /* count x n: what the ways become in the matrix without border */
        LagDenseLu lu;     /* of the shares */
    } factor[LAG_MOST_SHIFTS];
    LagNumbers change;     /* most: of the shares */
} LagBorder;

/* So many may slide in implicit steps; more are left to explicit ones. */
enum { LAG_MOST_BORDER = 128 };

void lag_border_layout(LagBorder *border, const LagMotion *motion, int pairs, LagArena *arena);

/* What slides at a state. Returns 0 where its derivatives are not finite. */
int lag_border_find(LagBorder *border, struct LagRun *run, double t, const double *y);

/* To factor number `which` of the matrix, which is there already. */
void lag_border_factor(LagBorder *border, LagImplicitMatrix *matrix, int which, double mu_re, double mu_im);

/* lag_implicit_matrix_solve with it: what slides keeps dg/dt at 0. */
void lag_border_solve(LagBorder *border, LagImplicitMatrix *matrix, int which, const double *re, const double *im, const double *s,
                      double *x_re, double *x_im);

#endif
