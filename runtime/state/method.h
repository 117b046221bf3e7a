/* A way of stepping: one file and one constant table each (explicit.c, ...), chosen in choice.c. */
#ifndef LAG_METHOD_H
#define LAG_METHOD_H

#include "state/motion.h"
#include "state/scale.h"
#include "base/status.h"

struct LagRun;

/* What is kept of a step to look into it later: of motions without quadratures. */
typedef struct {
    /* The latest step: at most 2 n LAG_JET_STRIDE numbers of series, LAG_RECORD_HEAD + 2 n LAG_RECORD_ROWS of
     * Runge-Kutta methods. */
    void (*keep)(const void *self, const LagMotion *motion, double *place);

    /* State (q, v) at t in the step that began then and was so long. Methods may write to their scratch, and to `place`. */
    void (*recall)(void *self, LagMotion *motion, double *place, double begin, double length, double t, double *y);
} LagRecord;

typedef struct {
    const char *name;
    int order; /* the error of a step of length h falls as h^order; of methods of fixed step, that of their trial; of Adams' methods,
                * that of their first step */

    /* Takes memory for `self`, the method's own struct, for a motion of the given sizes. */
    void (*layout)(void *self, const LagMotion *motion, LagArena *arena);

    /* The state or the equations changed: forgets earlier steps. motion->slope is that of the present state. */
    void (*restart)(void *self, LagMotion *motion);

    /* Moves on by one step: lag_step_adaptive for methods that estimate their error. */
    LagStatus (*step)(struct LagRun *run);

    /* What lag_step_adaptive calls; NULL for methods with a `step` of their own.
     * Tries a step to t_new; the result is left in motion->other. Returns the error estimate (a step of error <= 1 is good)
     * and the component it is largest in, or infinity when an evaluation is not finite. */
    double (*attempt)(void *self, LagMotion *motion, double t_new, const LagScale *scale, int *worst);

    /* Takes the step just tried (motion->other may have been projected since). Returns 0, and takes nothing, when the slope
     * at its end is not finite. */
    int (*accept)(void *self, LagMotion *motion, double t_new);

    /* The slope at the present state, as it is kept for the next step; NULL where none is. */
    double *(*slope)(void *self);

    /* State y at t in [t_old, t_end]. */
    void (*interpolate)(void *self, LagMotion *motion, double t, double *y);

    /* About the state (q, v) at a share x of the latest step, at no evaluation, and by how much it may be off anywhere in the step (an
     * error of NULL: nobody asks). Returns 0 where stages are no longer known; NULL where dense output costs nothing, either. */
    int (*glimpse)(const void *self, const LagMotion *motion, double x, double *y, double *error);

    /* Takes the latest step back; NULL where dense output is always as good as the ends of steps. */
    void (*take_back)(struct LagRun *run);

    /* What the latest step missed of forces between its stages, in units of error; NULL where its estimate tells. */
    double (*miss)(void *self, LagMotion *motion);
    int is_good_inside; /* dense output is, but where the motion lacks slopes */

    int holds_switches; /* of conditions on the state, through each step */
    int most_sliding;   /* so many forces that jump may hold the motion at their jumps in a step */
    int stride;         /* steps from one look at the state to the next, a power of two: more where they are short and cheap */
    int begins_low;     /* at order 1, which does not find into a motion that has no size yet */
    int weighs_work;    /* errors of the energy quadratures count: in few steps, or at a low order, they are large */
    int leaves_trouble; /* what shorter steps do not mend soon is left to Runge-Kutta methods for a while */
    int is_exact;       /* in steps of any length: there are no units of error */

    /* Whether the step just tried was rejected for what a shorter one mends, and rounding has no part in it; NULL: nobody knows. */
    int (*is_clear)(const void *self);

    /* By what the next step may be longer than the one just tried; NULL where its error and the order tell. */
    double (*factor)(const void *self);

    const LagRecord *record; /* NULL: steps are not kept */
    int ends_at_rows;        /* its steps do: there is no dense output but further steps */
    int dreads_rows;         /* other methods go on where there are many */
} LagMethod;

/* A method with its own struct. */
typedef struct {
    const LagMethod *table;
    void *self;
} LagStepper;

#endif
