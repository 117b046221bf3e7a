/* Every rule by which a method is taken, as rows of one table: of the rows of a moment, from the method in use (at the
 * beginning: from what was asked for), the first that holds decides. */
#ifndef LAG_CHOICE_H
#define LAG_CHOICE_H

#include "model/model.h"
#include "state/facts.h"
#include "state/settings.h"

/* When a row is asked. */
enum {
    LAG_BEGIN,   /* a run begins */
    LAG_BESIDE,  /* the same; what goes on where the method chosen, `from`, cannot */
    LAG_STEP,    /* now and then after a step */
    LAG_ROW,     /* after each step of methods without dense output */
    LAG_TROUBLE  /* a method cannot go on, or need not */
};

typedef struct {
    const char *name;
    const char *why; /* with names of LagFacts in braces */
    int32_t moment;
    int32_t from, to; /* LAG_SOLVER_..., or what choice.c has besides */
    int (*holds)(const LagFacts *facts);
    double (*limit)(const LagFacts *facts); /* what is compared with, for `why`; or NULL */
} LagRule;

/* Row `number`, from 1 on; NULL behind the last. */
LAG_API const LagRule *lag_rule(int32_t number);

/* What is known before a run. */
LagFacts lag_facts(const LagModel *model, const LagSettings *settings);

/* Whether a row decided; then `decision` tells which, and what it took. */
int lag_decide(int32_t moment, int32_t from, const LagFacts *facts, LagDecision *decision);

/* -------- limits of rows, where others ask for them before */

/* Length of steps times spectral radius from which on stability rules the steps of methods that take turns with implicit ones. */
double lag_most_reach(const LagFacts *facts);

/* Whether stability rules steps, as it looks once. */
int lag_is_ruled(const LagFacts *facts);

/* Whether series are expected to give way to iterated collocation where poles of the motion limit them; whether it is time to
 * look. */
int lag_may_find_poles(const LagFacts *facts);
int lag_looks_for_poles(const LagFacts *facts);

#endif
