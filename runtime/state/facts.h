/* What the choice of a method rests on: counted or measured, and compared in choice/choice.c. Python mirrors it, and tells the
 * reasons with these numbers in them. */
#ifndef LAG_FACTS_H
#define LAG_FACTS_H

#include <stdint.h>

typedef struct {
    /* of the model and what is asked for */
    double tolerance;
    double coordinates, constraints; /* constraints: multipliers */
    double islands;                  /* 0: it is one */
    double rhs_cost;                 /* operations of an evaluation */
    double erk_cost, series_cost;    /* 0.1 ns: a step of erk, and series over the time of one; infinity: there are no series */
    double series_share;             /* of the two */
    double pirk_cost, poles_cost;    /* 0.1 ns: a step of iterated collocation, and series over the time of one; 0: there are none */
    /* of a run under way */
    double reach;                    /* length of steps times the spectral radius, by the last look */
    double looks;                    /* in a row at which stability ruled */
    double swept;                    /* steps that were limited by sweeps of iterated collocation */
    double pace, pace_before, pace_possible; /* s an operation: of implicit steps; of others before them, and now */
    double gain;                     /* the larger one of these by that of implicit steps */
    double step, row_spacing;        /* s; row_spacing is 0 where nobody knows it */
    double rows_apart;               /* steps from row to row */
    double row_looks;                /* of rows into steps, of late */
    double holding;                  /* forces that jump and hold the motion at their jumps */
    double limit;                    /* what the row compares with */
    int32_t asked;                   /* LAG_SOLVER_...: by the user, or by the model; AUTO, STEPWISE: by none */
    int32_t is_named;                /* by the model */
    int32_t solver;                  /* in use */
    int32_t explicit_solver;         /* what goes on where others cannot */
    int32_t rows_solver;             /* what goes on where rows are many */
    int32_t turns_solver;            /* what takes turns with implicit steps */
    int32_t next;                    /* what comes behind transition matrices */
    int32_t steps;                   /* since the method in use began */
    int32_t is_series, order;        /* whether series take turns with implicit steps; their order */
    int32_t trouble;                 /* LAG_TROUBLE_... */
    int32_t tried;                   /* bits of LAG_SOLVER_...: what was lost, too, or cannot run the model */
    int32_t is_damped;               /* what changes most is a rate that dies out without swinging */
    int32_t fits_transition, has_jacobian, has_conditions, has_corners, has_modes, has_inputs, is_swing, may_hide,
        has_attitudes, rolls;
} LagFacts;

/* What a method cannot do, or need not. */
enum {
    LAG_TROUBLE_PASS = 1, /* some steps are another's */
    LAG_TROUBLE_LEAVE,    /* all that come are */
    LAG_TROUBLE_LEAD,     /* the first one is */
    LAG_TROUBLE_CROSSED,  /* a condition changed in steps of equal length */
    LAG_TROUBLE_HORIZON,  /* transition matrices would lose digits */
    LAG_TROUBLE_SWING,    /* the motion comes back the way it went */
    LAG_TROUBLE_DISTURBED, /* it does no more */
    LAG_TROUBLE_CREEPS,   /* a slip in the plane is stiff across */
    LAG_TROUBLE_LOST      /* it gave up, or its energy account misses */
};

/* The last row that decided, and what it went by. */
typedef struct {
    LagFacts facts;
    int32_t rule; /* a number of lag_rule; 0: none yet */
    int32_t to;   /* LAG_SOLVER_...: what it took */
} LagDecision;

#endif
