/* Symplectic steps of fixed length for scenes that keep their energy: Gauss collocation in (q, p). */
#ifndef LAG_GAUSS_H
#define LAG_GAUSS_H

#include "methods/gauss_tableau.h"
#include "state/method.h"

typedef struct {
    double *v[LAG_GAUSS_MOST_STAGES], *force[LAG_GAUSS_MOST_STAGES]; /* slopes of q and p at the stages */
} LagGaussStages;

typedef struct {
    const LagGaussTableau *tableau;
    double h;                          /* length of all steps; 0: not chosen yet */
    double *p, *carry;                 /* momenta and what rounding took from them, as in LagMotion */
    double *other, *other_carry;
    double *q_stage, *p_stage, *v_new, *force_new;
    LagGaussStages step, inside;       /* of the latest step, and of one that ends inside it */
    int stages_known;                  /* those of the step before belong to a step of the same length */
} LagGauss;

extern const LagMethod lag_gauss;

#endif
