/* What is inside a step of iterated collocation, to the digits of its end. */
#ifndef LAG_PIRK_DENSE_H
#define LAG_PIRK_DENSE_H

#include "state/method.h"
#include "state/motion.h"
#include "numbers/wide.h"

struct LagPirk;

enum { LAG_PIRK_DENSE = 2 * LAG_ABREAST };

typedef struct {
    int has_tables, is_ready; /* for this run; for the latest step */
    /* By nodes, and by degrees of Legendre's polynomials: what an acceleration at a node adds to a coefficient, of 8 nodes and of 16;
     * by degrees, and by nodes: integrals of the polynomials, and integrals of these. */
    double coarse[LAG_ABREAST][LAG_ABREAST], fine[LAG_PIRK_DENSE][LAG_PIRK_DENSE];
    double rate[LAG_PIRK_DENSE][LAG_PIRK_DENSE], place[LAG_PIRK_DENSE][LAG_PIRK_DENSE];
    double *a, *coefficient; /* 16 (n + n_power): accelerations and powers at the nodes; their coefficients */
} LagPirkDense;

void lag_pirk_dense_layout(LagPirkDense *dense, const LagMotion *motion, LagArena *arena);

/* By how many units the end of the step just tried, whose stages are known, is another one by twice as many stages. */
double lag_pirk_second_look(struct LagPirk *pirk, LagMotion *motion, const double *y);

/* State y at t in the latest step. */
void lag_pirk_dense_read(struct LagPirk *pirk, LagMotion *motion, double t, double *y);

/* Of motions without attitudes: 1 + 19 n numbers a step. */
extern const LagRecord lag_pirk_record;

#endif
