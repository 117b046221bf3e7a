/* Steps of explicit Runge-Kutta pairs (explicit.h) of eight motions at once (wide_steps.h): where equations are too long for series.
 *
 * Steps are those of adaptive.c where nothing happens. A motion for which the usual equations are in doubt, or that shorter steps do not
 * help, is left to steps of its own. Where loops close, slopes are those of eight motions, and each is projected by its run, which has
 * to know where it is. Nobody chooses these pairs there: iterated collocation makes so small errors in loops that steps of the same error
 * take as long, eight at a time (a slider-crank).
 */
#ifndef LAG_WIDE_EXPLICIT_H
#define LAG_WIDE_EXPLICIT_H

#include "methods/explicit.h"
#include "methods/wide_steps.h"

typedef struct {
    LagWideSteps lanes;
    const LagTableau *tableau;
    double caution;             /* multiplies errors */
    int order;
    LagRun *run[LAG_ABREAST];
    double *k[LAG_MOST_SLOPES]; /* slopes, as in LagExplicit */
    double *point, *time;       /* where slopes are evaluated: positions, times */
    double *u, *u_first, *u_slope; /* inputs: there; when the present segments began, and their slopes since */
    double *c;                  /* what follows from the parameters of each motion */
    double *rest, *work;        /* of evaluations */
    double *lost;               /* 2 n_power: errors of quadratures, squared, of the steps that are tried, and so far */
    double entered[LAG_ABREAST]; /* when the present segments began */
    double is_new[LAG_ABREAST]; /* 1: the motion has just begun, or goes on by other inputs */
    double step[LAG_ABREAST];   /* lengths planned for the next steps */
    double grows[LAG_ABREAST];  /* by which the next step may be longer */
    double error[LAG_ABREAST];  /* of the steps that are tried, squared */
    double doubt[LAG_ABREAST];  /* not 0: some evaluation did not hold */
} LagWideExplicit;

/* Whether motions of this model can be stepped so. */
int lag_wide_explicit_serves(const LagModel *model);

/* By Verner's pair, whose steps end at rows; by those of Dormand and Prince and of Tsitouras, which tell what is between. */
extern const LagWideMethod lag_wide_verner9, lag_wide_dop853, lag_wide_tsit5;

#endif
