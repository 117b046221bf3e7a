/* The methods of a run: memory for those its model can use, and the one in use. */
#ifndef LAG_METHODS_H
#define LAG_METHODS_H

#include "choice/choice.h"
#include "methods/adams.h"
#include "methods/explicit.h"
#include "methods/gauss.h"
#include "methods/linear_method.h"
#include "methods/nystrom.h"
#include "choice/parts.h"
#include "methods/pirk.h"
#include "methods/radau.h"
#include "state/settings.h"
#include "methods/taylor.h"
#include "methods/transition.h"

typedef struct {
    int32_t solver;         /* LAG_SOLVER_...: in use */
    const LagMethod *table; /* its functions */
    void *self;             /* its own struct, one of those below */
    int32_t explicit_solver; /* erk or erk5 */
    int32_t rows_solver;     /* what goes on where iterated collocation meets many rows: erk, erk5, adams or taylor */
    int may_find_poles;      /* that goes on where series find the motion limited by poles */
    LagStepper steppers[LAG_SOLVERS]; /* by their numbers */
    LagDecision first;       /* what runs begin with */
    LagDecision behind;      /* the same, or what they go on with where these are transition matrices and cannot serve */
    LagExplicit dop853, tsit5, verner9;
    LagPirk pirk;
    LagAdams adams;
    LagLinearMethod linear;
    LagIslands islands;
    LagRadau radau;
    LagGauss gauss;
    LagNystrom nystrom;
    int is_separable; /* of the two conservative ones nystrom serves */
    LagTaylor taylor;
    LagTransition transition;
} LagMethods;

/* What to begin with, and what comes behind transition matrices, should they not serve. */
void lag_methods_begin(const LagModel *model, const LagSettings *settings, LagDecision *first, LagDecision *behind);

/* What it is called outside: transition matrices are a way of the linear solver. */
int32_t lag_methods_way(int32_t solver);

/* Whether the model can be run by it. */
int lag_methods_permit(const LagModel *model, int32_t solver);

/* Whether a run with these settings goes over to another solver where that is cheaper. */
int lag_methods_turn(const LagSettings *settings);

/* Whether a run with these settings begins again by another choice where one is lost, as near dead points of loops; bits of
 * LAG_SOLVER_...: those of these choices that cannot run the model. */
int lag_methods_may_retry(const LagModel *model, const LagSettings *settings);
int32_t lag_methods_refused(const LagModel *model);

/* Whether a run that begins with this solver may go on with explicit or implicit steps, whichever serve. */
int lag_methods_alternate(const LagModel *model, int32_t solver);

/* The methods that a run with these settings may use take their memory. */
void lag_methods_layout(LagMethods *methods, const LagSettings *settings, const LagModel *model, const LagMotion *motion,
                        LagArena *arena);

#endif
