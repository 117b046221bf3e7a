/* Adams' methods for q'' = a(t, q, q'), of an order that follows the motion: one evaluation a step. */
#ifndef LAG_ADAMS_H
#define LAG_ADAMS_H

#include "state/method.h"
#include "model/model.h"

/* The most slopes a step is predicted from; differences that this takes, with the one that tells whether one more would be better. */
enum { LAG_ADAMS_ORDER = 12, LAG_ADAMS_ROWS = LAG_ADAMS_ORDER + 2 };

typedef struct {
    int order;       /* the next step is predicted from so many slopes */
    int known;       /* differences */
    int terms;       /* of the polynomial that the latest step has integrated */
    int is_starting; /* the order rises with every step */
    double *difference[LAG_ADAMS_ROWS]; /* of the latest slopes (a, power): the terms of the polynomial through them */
    double reach[LAG_ADAMS_ROWS];       /* from the latest slope back to the one before, to the one before that, ... */

    /* The step being tried */
    double new_reach[LAG_ADAMS_ROWS];
    double stretch[LAG_ADAMS_ROWS]; /* by which differences are larger over this step than over the one before */
    int next_order;
    double factor;           /* by which the next step may be longer */
    int worst, attempts;     /* the component that limits the steps; attempts at steps since the restart */
    double *slope;           /* at the predicted state */
    double *rates, *places;  /* what the prediction adds to (v, energy quadratures) and to q */
    double *missed;          /* the slope less the predicted one */
    double *step, *unit;

    int has_end;
    double *end; /* the state at the end of the latest step, once someone has looked inside */
} LagAdams;

extern const LagMethod lag_adams;

#endif
